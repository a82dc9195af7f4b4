//! The contracts of the noises.

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
    let known =
        [0x3e013081, 0xbe3a59ef, 0xbe234fa0, 0x3e793952, 0x3ef192de, 0xbdc29aa4, 0xbeefaec7, 0x3ef327f0];
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
    // All gradients are as long as the contract says, and no axis is preferred.
    for (kind, steepness) in [(perlin1985(), 1.0), (gradient(), 1.5)] {
        let g = dnoise_with(kind, Isa::detect(), &slices(&p[..3]));
        for i in 0..4000 {
            let l = length(&g, i);
            assert!((l / steepness - 1.0).abs() < 3e-4, "{l}");
        }
        for (k, g) in g.iter().enumerate() {
            assert!(mean(g).abs() < 0.04 * f64::from(steepness), "axis {k}: {}", mean(g));
            assert!((std(g) - f64::from(steepness) / 3.0_f64.sqrt()).abs() < 0.02 * f64::from(steepness));
            assert!(correlation(g, &values).abs() < 0.05);
        }
        assert!(correlation(&g[0], &g[1]).abs() < 0.05 && correlation(&g[1], &g[2]).abs() < 0.05);
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
fn range_mean_and_deviation() {
    for (kind, bound, deviation) in [(perlin1985(), 1.37, 0.26), (gradient(), 1.30, 0.274)] {
        let p = Random(3).points(1_000_000, 500.0);
        let n = noise_at(kind, &p[..3]);
        let most = n.iter().fold(0.0_f32, |m, n| m.max(n.abs()));
        println!("{}: mean {:.5} std {:.4} most {most}", kind.name, mean(&n), std(&n));
        assert!(most > 0.85 && most <= bound);
        assert!(mean(&n).abs() < 0.01 * deviation && (std(&n) - deviation).abs() < 0.005);
        let n = noise_at(kind, &p);
        assert!(n.iter().all(|n| n.abs() <= 1.501));
    }
}

#[test]
fn continuous_over_cell_faces_and_zero() {
    let mut random = Random(4);
    for kind in kinds() {
        for _ in 0..2000 {
            let mut p = [random.within(20.0), random.within(20.0), random.within(20.0)];
            let axis = (random.within(1.4).abs() * 2.0) as usize;
            let face = p[axis].round() + 0.0;
            p[axis] = face - 1e-5 * face.abs().max(1.0);
            let before = one(kind, &p);
            p[axis] = face + 1e-5 * face.abs().max(1.0);
            assert!((before - one(kind, &p)).abs() < 2e-3, "{kind:?} {p:?}");
        }
    }
}

#[test]
fn dnoise_is_the_derivative() {
    let p = Random(5).points(20_000, 10.0);
    let h = 1.0 / 128.0;
    for kind in kinds() {
        for d in 1..=4 {
            let exact = dnoise_with(kind, Isa::detect(), &slices(&p[..d]));
            for k in 0..d {
                let (mut up, mut down) = (p[..d].to_vec(), p[..d].to_vec());
                up[k].iter_mut().for_each(|x| *x += h);
                down[k].iter_mut().for_each(|x| *x -= h);
                let (up, down) = (noise_at(kind, &up), noise_at(kind, &down));
                let errors: Vec<f32> =
                    (0..p[0].len()).map(|i| (up[i] - down[i]) / (2.0 * h) - exact[k][i]).collect();
                let rms = mean(&errors.iter().map(|e| e * e).collect::<Vec<_>>()).sqrt();
                assert!(rms < 0.01, "{kind:?} {d}-D axis {k}: {rms}");
            }
        }
    }
}

#[test]
fn the_same_after_rotation() {
    // The mean squared change over a distance, along an axis and along diagonals.
    let p = Random(6).points(200_000, 300.0);
    let (half, third) = (0.5_f32.sqrt(), 3.0_f32.sqrt().recip());
    for kind in kinds() {
        let here = noise_at(kind, &p[..3]);
        for distance in [0.25, 0.5, 0.75] {
            let change = |u: [f32; 3]| {
                let moved = |k: usize| p[k].iter().map(|x| x + u[k] * distance).collect::<Vec<_>>();
                let there = noise_at(kind, &[moved(0), moved(1), moved(2)]);
                {
                    let s = std(&here.iter().zip(&there).map(|(a, b)| a - b).collect::<Vec<_>>());
                    s * s
                }
            };
            let straight = change([0.0, 1.0, 0.0]);
            for turned in [change([half, 0.0, half]), change([third; 3]), change([third, -third, third])] {
                let ratio = (straight / turned).max(turned / straight);
                assert!(ratio < 1.25, "{kind:?} over {distance}: {ratio}");
            }
        }
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
fn every_instruction_set_and_length_gives_the_same_bits() {
    let mut p = Random(8).points(257, 1000.0);
    for (i, x) in
        [f32::NAN, f32::INFINITY, 1e30, -1e30, 8_388_608.0, -0.0, 1e-45, -1e-10].into_iter().enumerate()
    {
        p[i % 4][i * 30 + 3] = x;
    }
    let lone = [Isa::baseline(), Isa::detect()];
    for kind in kinds() {
        for d in 1..=4 {
            let singles: Vec<f32> =
                (0..257).map(|i| one(kind, &p[..d].iter().map(|p| p[i]).collect::<Vec<_>>())).collect();
            let slopes = dnoise_with(kind, Isa::baseline(), &slices(&p[..d]));
            for isa in lone {
                for n in [1, 7, 255, 256, 257] {
                    let cut: Vec<&[f32]> = p[..d].iter().map(|p| &p[257 - n..]).collect();
                    let mut out = vec![0.0; n];
                    field(kind, d).noise(isa, &cut, &mut out);
                    assert_eq!(bits(&out), bits(&singles[257 - n..]));
                    for (slope, known) in dnoise_with(kind, isa, &cut).iter().zip(&slopes) {
                        assert_eq!(bits(slope), bits(&known[257 - n..]));
                    }
                }
            }
        }
    }
}

#[test]
fn awkward_inputs() {
    for kind in kinds() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert!(one(kind, &[bad, 0.5, 0.5]).is_nan() && one(kind, &[0.5, 0.5, bad]).is_nan());
        }
        for huge in [8_388_609.0, -8_388_609.0, 1e20, f32::MAX] {
            let bound = if kind.name == "gradient" { 0.0 } else { 0.5 };
            assert!(one(kind, &[huge, huge, -huge]).abs() <= bound);
        }
    }
}

#[test]
fn energy_lies_in_its_band() {
    // A direct transform of sections of 64² samples, 1/4 unit apart, on turned planes.
    const N: usize = 64;
    let mut random = Random(9);
    for (kind, low, band) in [(perlin1985(), 0.15..0.45, 0.48), (gradient(), 0.0..0.26, 0.58)] {
        let (mut below, mut within, mut all) = (0.0, 0.0, 0.0);
        for _ in 0..12 {
            let o = [random.within(300.0), random.within(300.0), random.within(300.0)];
            let (u, v) = ([0.48, 0.64, 0.6], [0.8, -0.6, 0.0_f32]);
            let at = |k: usize| {
                let step = move |i: usize| ((i % N) as f32 * u[k] + (i / N) as f32 * v[k]) * 0.25 + o[k];
                (0..N * N).map(step).collect::<Vec<f32>>()
            };
            let section = noise_at(kind, &[at(0), at(1), at(2)]);
            let m = mean(&section);
            let turn = |i: usize| 2.0 * std::f64::consts::PI * i as f64 / N as f64;
            let window = |i: usize| 0.5 - 0.5 * libm::cos(turn(i));
            // Rows, then columns.
            let mut rows = vec![(0.0, 0.0); N * N];
            for j in 0..N {
                for f in 0..N {
                    for i in 0..N {
                        let s = (f64::from(section[j * N + i]) - m) * window(i) * window(j);
                        rows[j * N + f].0 += s * libm::cos(turn(i * f % N));
                        rows[j * N + f].1 -= s * libm::sin(turn(i * f % N));
                    }
                }
            }
            for f in 0..N {
                for g in 0..N {
                    let (mut re, mut im) = (0.0, 0.0);
                    for j in 0..N {
                        let (c, s) = (libm::cos(turn(j * g % N)), libm::sin(turn(j * g % N)));
                        let (a, b) = rows[j * N + f];
                        re += a * c + b * s;
                        im += b * c - a * s;
                    }
                    let cycles = |f: usize| (f.min(N - f)) as f64 / (N as f64 * 0.25);
                    let (frequency, energy) = (cycles(f).hypot(cycles(g)), re * re + im * im);
                    all += energy;
                    below += if frequency < 0.3 { energy } else { 0.0 };
                    within += if (0.3..0.7).contains(&frequency) { energy } else { 0.0 };
                }
            }
        }
        println!("{}: below {:.3} within {:.3}", kind.name, below / all, within / all);
        assert!(low.contains(&(below / all)) && within / all >= band);
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
