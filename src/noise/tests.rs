//! The two noises of Perlin, 1985 and 1992, and what is built on them; every kind is measured in `tests/noise`.

// Loops over lanes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::*;
use crate::lanes::Isa;
use std::sync::Arc;

fn kinds() -> [&'static Kind; 2] {
    ["perlin1985", "gradient"].map(|name| Kind::from_name(name).unwrap())
}

fn perlin1985() -> &'static Kind {
    kinds()[0]
}

fn gradient() -> &'static Kind {
    kinds()[1]
}

fn field(kind: &'static Kind, dimensions: usize) -> Arc<dyn Field> {
    kind.field(dimensions, &Params::default()).unwrap()
}

/// Even numbers in -size … size, from a linear congruence.
struct Random(u64);

impl Random {
    fn within(&mut self, size: f32) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as f32 / (1_u32 << 30) as f32 - 1.0) * size
    }

    fn points(&mut self, n: usize, size: f32) -> [Vec<f32>; 4] {
        std::array::from_fn(|_| (0..n).map(|_| self.within(size)).collect())
    }
}

fn slices(p: &[Vec<f32>]) -> Vec<&[f32]> {
    p.iter().map(Vec::as_slice).collect()
}

fn noise_at(kind: &'static Kind, p: &[Vec<f32>]) -> Vec<f32> {
    let mut out = vec![0.0; p[0].len()];
    field(kind, p.len()).noise(Isa::detect(), &slices(p), &mut out);
    out
}

fn dnoise_with(kind: &'static Kind, isa: Isa, p: &[&[f32]]) -> Vec<Vec<f32>> {
    let mut out = vec![vec![0.0; p[0].len()]; p.len()];
    let mut planes: Vec<&mut [f32]> = out.iter_mut().map(Vec::as_mut_slice).collect();
    field(kind, p.len()).derivative(isa, p, &mut planes);
    out
}

fn one(kind: &'static Kind, p: &[f32]) -> f32 {
    noise_at(kind, &p.iter().map(|&x| vec![x]).collect::<Vec<_>>())[0]
}

fn mean(x: &[f32]) -> f64 {
    x.iter().map(|&x| f64::from(x)).sum::<f64>() / x.len() as f64
}

fn std(x: &[f32]) -> f64 {
    let m = mean(x);
    (x.iter().map(|&x| (f64::from(x) - m) * (f64::from(x) - m)).sum::<f64>() / x.len() as f64).sqrt()
}

fn correlation(a: &[f32], b: &[f32]) -> f64 {
    let (ma, mb) = (mean(a), mean(b));
    let products = a.iter().zip(b).map(|(&a, &b)| (f64::from(a) - ma) * (f64::from(b) - mb));
    products.sum::<f64>() / a.len() as f64 / (std(a) * std(b))
}

/// The length of a lane's vector.
fn length(planes: &[Vec<f32>], lane: usize) -> f32 {
    planes.iter().map(|plane| plane[lane] * plane[lane]).sum::<f32>().sqrt()
}

fn bits(x: &[f32]) -> Vec<u32> {
    x.iter().map(|x| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() }).collect()
}

#[test]
fn known_values() {
    // Pinned: a change of these changes every picture.
    let p = [0.5, 1.25, -2.75, 100.125];
    let got: Vec<f32> = kinds().iter().flat_map(|&kind| (1..=4).map(move |d| one(kind, &p[..d]))).collect();
    let known = [
        0xbcbc_3480,
        0xbeb6_69cc,
        0x3e42_29ff,
        0x3c96_dabb,
        0xbe04_c1ea,
        0xbf06_b8d0,
        0x3e42_1510,
        0x3da4_8bc2,
    ];
    assert_eq!(bits(&got), known, "{got:?}");
}

#[test]
fn lattice_points_have_their_values() {
    let mut random = Random(1);
    let p = random.points(4000, 1000.0).map(|p| p.iter().map(|x| x.floor()).collect::<Vec<_>>());
    assert!(noise_at(gradient(), &p[..3]).iter().all(|&n| n == 0.0));
    let values = noise_at(perlin1985(), &p[..3]);
    assert!(values.iter().all(|v| v.abs() <= 0.5));
    assert!(mean(&values).abs() < 0.03 && (std(&values) - 0.5 / 3.0_f64.sqrt()).abs() < 0.01);
    // Gradients fill a cube, and no axis is preferred.
    for (kind, steepness) in [(perlin1985(), 1.0), (gradient(), 1.5)] {
        let g = dnoise_with(kind, Isa::detect(), &slices(&p[..3]));
        assert!(g.iter().flatten().all(|g| g.abs() <= steepness));
        for (k, g) in g.iter().enumerate() {
            assert!(mean(g).abs() < 0.04 * f64::from(steepness), "axis {k}: {}", mean(g));
            assert!((std(g) - f64::from(steepness) / 3.0_f64.sqrt()).abs() < 0.02 * f64::from(steepness));
            assert!(correlation(g, &values).abs() < 0.05);
        }
        assert!(correlation(&g[0], &g[1]).abs() < 0.05 && correlation(&g[1], &g[2]).abs() < 0.05);
    }
}

#[test]
fn they_are_what_the_formula_says() {
    use super::checks::{cubic, is_sum_over_planes, usual};
    for (kind, scale, share) in [(perlin1985(), 1.0, 0.5), (gradient(), 1.5, 0.0)] {
        is_sum_over_planes(kind, &Params::seeded(9), |value, gradient, offset| {
            let height: f64 = gradient.iter().zip(offset).map(|(g, x)| g * x).sum();
            scale * (share * value + height) * offset.iter().map(|&x| cubic(x)).product::<f64>()
        });
        usual(kind, &Params::seeded(3));
    }
}

#[test]
fn fewer_coordinates_are_zeros() {
    let p = Random(2).points(300, 50.0);
    let zero = vec![0.0; 300];
    for kind in kinds() {
        let (x, y) = (p[0].clone(), p[1].clone());
        assert_eq!(noise_at(kind, &p[..1]), noise_at(kind, &[x.clone(), zero.clone(), zero.clone()]));
        assert_eq!(noise_at(kind, &p[..2]), noise_at(kind, &[x, y, zero.clone()]));
    }
}

#[test]
fn shifts_are_unrelated() {
    let p = Random(7).points(20_000, 100.0);
    for kind in kinds() {
        let here = noise_at(kind, &p[..3]);
        for shift in [4.0, 5.0, 16.0, 100.0, 255.0, 256.0, 257.0, 4096.0, 65536.0] {
            for axes in 1..8 {
                let mut q = p[..3].to_vec();
                for k in 0..3 {
                    if axes >> k & 1 == 1 {
                        q[k].iter_mut().for_each(|x| *x += shift);
                    }
                }
                let c = correlation(&here, &noise_at(kind, &q));
                assert!(c.abs() < 0.04, "{kind:?} by {shift} along {axes:b}: {c}");
            }
        }
        let mut seeded = vec![0.0; here.len()];
        kind.field(3, &Params::seeded(1)).unwrap().noise(Isa::detect(), &slices(&p[..3]), &mut seeded);
        assert!(correlation(&here, &seeded).abs() < 0.04);
    }
}

#[test]
fn widely_spaced_derivatives_point_everywhere() {
    // The corona's centres of Perlin 1985: direction(Dnoise(i * [100 0 0])).
    for kind in kinds() {
        let x: Vec<f32> = (0..20).map(|i| 100.0 * i as f32).collect();
        let zero = vec![0.0; 20];
        let g = dnoise_with(kind, Isa::detect(), &[&x, &zero, &zero]);
        let unit = |i: usize| {
            let l = length(&g, i);
            [g[0][i] / l, g[1][i] / l, g[2][i] / l]
        };
        for i in 0..20 {
            for j in 0..i {
                let cosine: f32 = (0..3).map(|k| unit(i)[k] * unit(j)[k]).sum();
                assert!(cosine < 0.9999, "{kind:?} {i} {j}");
            }
        }
    }
}

#[test]
fn turbulence_is_the_sum_of_its_octaves() {
    let n = 700;
    let p = Random(10).points(n, 20.0);
    let highs: Vec<f32> =
        (0..n).map(|i| [3.3, 100.0, 1.0, -1.0, f32::NAN, 2.0, f32::INFINITY][i % 7]).collect();
    let all = |x: f32| vec![x; n];
    let (one_, two, half, many, none) = (all(1.0), all(2.0), all(0.5), all(99.0), all(0.0));
    for kind in kinds() {
        let sum = sums::Sum {
            form: sums::Form::Turbulence,
            fields: &[field(kind, 3)],
            low: &one_,
            high: &highs,
            fade: &none,
            size: &one_,
            octaves: &many,
            lacunarity: &two,
            gain: &half,
            offset: &none,
        };
        let (mut out, mut same) = (all(0.0), all(0.0));
        sum.run(Isa::detect(), &slices(&p[..3]), &mut out);
        sum.run(Isa::baseline(), &slices(&p[..3]), &mut same);
        assert_eq!(bits(&out), bits(&same));
        let mut faded = all(0.0);
        sums::Sum { fade: &one_, ..sum }.run(Isa::detect(), &slices(&p[..3]), &mut faded);
        for i in 0..n {
            let (mut known, mut known_faded, mut frequency, mut octaves) = (0.0, 0.0, 1.0, 0);
            while frequency < highs[i] && octaves < sums::OCTAVES {
                let octave =
                    one(kind, &[p[0][i] * frequency, p[1][i] * frequency, p[2][i] * frequency]).abs();
                known += octave / frequency;
                let share = (2.0 - 2.0 * frequency / highs[i]).clamp(0.0, 1.0);
                known_faded += octave / frequency * if highs[i].is_infinite() { 1.0 } else { share };
                frequency *= 2.0;
                octaves += 1;
            }
            assert_eq!(out[i], known, "lane {i}, up to {}", highs[i]);
            assert!((faded[i] - known_faded).abs() < 1e-6, "lane {i}, up to {}", highs[i]);
        }
    }
}

#[test]
fn random_numbers_are_even_and_tell_all_floats_apart() {
    let n = 100_000;
    let bits_of = |start: u32| (0..n).map(|i| f32::from_bits(start + i as u32)).collect::<Vec<f32>>();
    for start in [0, 0x3f80_0000, 0xc0a0_0000] {
        let mut out = vec![0.0; n];
        random::random(Isa::detect(), &[&bits_of(start)], 0, &mut out);
        let mut same = vec![0.0; n];
        random::random(Isa::baseline(), &[&bits_of(start)], 0, &mut same);
        assert_eq!(bits(&out), bits(&same));
        assert!(out.iter().all(|r| (0.0..1.0).contains(r)));
        assert!((mean(&out) - 0.5).abs() < 0.005 && (std(&out) - 0.2887).abs() < 0.003);
        assert!(correlation(&out[1..], &out[..n - 1]).abs() < 0.015);
        assert!(out.windows(2).filter(|w| w[0] == w[1]).count() < 3);
    }
    let of = |p: &[f32]| {
        let mut out = [0.0];
        random::random(Isa::detect(), &p.iter().map(std::slice::from_ref).collect::<Vec<_>>(), 0, &mut out);
        out[0]
    };
    assert!(of(&[f32::NAN]).is_nan() && of(&[1.0, f32::NAN]).is_nan() && of(&[f32::INFINITY]) < 1.0);
    assert!(of(&[0.0]) == of(&[-0.0]) && of(&[1.0, 2.0]) != of(&[2.0, 1.0]) && of(&[1.0]) != of(&[1.0, 0.0]));
}
