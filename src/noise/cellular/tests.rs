// Loops over axes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::search::further;
use super::*;

const METRICS: [&str; 3] = ["euclidean", "manhattan", "chebyshev"];
const FEATURES: [&str; 4] = ["F1", "F2", "F2-F1", "id"];

fn params(metric: usize, feature: &str) -> Params {
    Params::seeded(9).with_choice(Opt::Metric, METRICS[metric]).with_choice(Opt::Feature, feature)
}

fn noise(isa: Isa, params: &Params, p: &[Vec<f32>]) -> Vec<f32> {
    let mut out = vec![0.0; p[0].len()];
    let field = KIND.field(p.len(), params).unwrap();
    field.noise(isa, &p.iter().map(Vec::as_slice).collect::<Vec<_>>(), &mut out);
    out
}

fn slopes(isa: Isa, params: &Params, p: &[Vec<f32>]) -> Vec<Vec<f32>> {
    let mut out = vec![vec![0.0; p[0].len()]; p.len()];
    let mut planes: Vec<&mut [f32]> = out.iter_mut().map(Vec::as_mut_slice).collect();
    let field = KIND.field(p.len(), params).unwrap();
    field.derivative(isa, &p.iter().map(Vec::as_slice).collect::<Vec<_>>(), &mut planes);
    out
}

/// Even numbers within `size` of 0.
fn random(i: usize, size: f32) -> f32 {
    hash::mix(i as u32 + 99) as i32 as f32 / (1_u32 << 31) as f32 * size
}

fn points(d: usize, n: usize, size: f32) -> Vec<Vec<f32>> {
    (0..d).map(|k| (0..n).map(|i| random(k * n + i, size)).collect()).collect()
}

fn bits(x: &[f32]) -> Vec<u32> {
    x.iter().map(|x| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() }).collect()
}

fn length(metric: usize, v: &[f64]) -> f64 {
    match metric {
        0 => v.iter().map(|v| v * v).sum::<f64>().sqrt(),
        1 => v.iter().map(|v| v.abs()).sum(),
        _ => v.iter().fold(0.0, |most, v| most.max(v.abs())),
    }
}

/// All feature points in the 7^D cells about a point: the distance, the hash of the cell, and the way there.
fn all<const D: usize>(params: &Params, metric: usize, p: [f32; D]) -> Vec<(f64, u32, [f64; D])> {
    let cells = Cells::<D>::new(params).unwrap();
    let jitter = f64::from(params.number(Opt::Jitter, 1.0, 0.0..=1.0).unwrap());
    let one = |number: usize| {
        let (mut joined, mut left, mut way) = (0, number, [0.0; D]);
        for k in 0..D {
            let at = p[k].floor() + (left % 7) as f32 - 3.0;
            left /= 7;
            joined ^= cells.key(k, at);
            way[k] = f64::from(at) + 0.5 - f64::from(p[k]);
        }
        let hash = hash::point(joined);
        let bits = [hash, hash << 16, hash::more(hash), hash::more(hash) << 16];
        for k in 0..D {
            way[k] += jitter * f64::from(bits[k] as i32) / 4_294_967_296.0;
        }
        (length(metric, &way), hash, way)
    };
    let mut all: Vec<_> = (0..7_usize.pow(D as u32)).map(one).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all
}

/// Tells for how many points the nearest 3^D cells did not do, for F1 and for F2.
fn is_exact<const D: usize>(n: usize, metric: usize, options: impl Fn(Params) -> Params) -> [usize; 2] {
    let p = points(D, n, 40.0);
    let of = |feature: &str| noise(Isa::detect(), &options(params(metric, feature)), &p);
    let slopes_of = |feature: &str| slopes(Isa::detect(), &options(params(metric, feature)), &p);
    let values = FEATURES.map(of);
    let [f1_slopes, f2_slopes, difference_slopes, id_slopes] = FEATURES.map(slopes_of);
    let mut beyond = [0; 2];
    for i in 0..n {
        let at: [f32; D] = std::array::from_fn(|k| p[k][i]);
        let all = all(&options(params(metric, "F1")), metric, at);
        let [first, second, third] = [all[0], all[1], all[2]];
        let face = at.iter().map(|x| (x - x.floor()).min(x.floor() + 1.0 - x)).fold(0.5, f32::min);
        for (beyond, f) in beyond.iter_mut().zip([first.0, second.0]) {
            *beyond += usize::from(f > f64::from(face) + 1.0);
        }
        let near = |a: f32, b: f64| (f64::from(a) - b).abs() < 1e-6;
        let of = format!("{} {D}-D at {at:?}", METRICS[metric]);
        assert!(near(values[0][i], first.0), "{of}: {} {}", values[0][i], first.0);
        assert!(near(values[1][i], second.0), "{of}: {} {}", values[1][i], second.0);
        assert_eq!(values[2][i], values[1][i] - values[0][i]);
        if second.0 - first.0 < 1e-5 || third.0 - second.0 < 1e-5 {
            continue; // which of them is nearer is a matter of rounding
        }
        assert_eq!(values[3][i], (hash::mix(first.1) >> 8) as f32 / 16_777_216.0);
        let slope = |way: [f64; D]| -> [f64; D] {
            let h = 1e-7;
            std::array::from_fn(|k| {
                let (mut before, mut after) = (way, way);
                (before[k], after[k]) = (way[k] + h, way[k] - h);
                (length(metric, &after) - length(metric, &before)) / (2.0 * h)
            })
        };
        let (f1, f2) = (slope(first.2), slope(second.2));
        for k in 0..D {
            // (Where the vector turns fast, or is on an edge of the metric, the difference is not exact.)
            let rough = |way: [f64; D]| way.iter().any(|w| w.abs() < 1e-3) || edge(&way);
            if !rough(first.2) && !rough(second.2) {
                assert!((f64::from(f1_slopes[k][i]) - f1[k]).abs() < 2e-4, "{of}: {f1:?}");
                assert!((f64::from(f2_slopes[k][i]) - f2[k]).abs() < 2e-4, "{of}: {f2:?}");
            }
            assert_eq!(difference_slopes[k][i], f2_slopes[k][i] - f1_slopes[k][i]);
            assert_eq!(id_slopes[k][i], 0.0);
        }
    }
    beyond
}

/// Are the two longest components about equal?
fn edge(way: &[f64]) -> bool {
    let mut sizes: Vec<f64> = way.iter().map(|w| w.abs()).collect();
    sizes.sort_by(|a, b| b.total_cmp(a));
    sizes.len() > 1 && sizes[0] - sizes[1] < 1e-5
}

#[test]
fn the_search_is_exact() {
    let mut beyond = Vec::new();
    for metric in 0..3 {
        beyond.push(is_exact::<1>(1000, metric, |p| p));
        beyond.push(is_exact::<2>(8000, metric, |p| p));
        beyond.push(is_exact::<3>(3000, metric, |p| p));
        beyond.push(is_exact::<4>(150, metric, |p| p));
        is_exact::<2>(500, metric, |p| p.with(Opt::Jitter, &[0.6]));
        is_exact::<3>(200, metric, |p| p.with(Opt::Period, &[3.0, 0.0, 1.0]));
    }
    println!("{beyond:?}");
    // The second pass was needed, but never in one dimension or for the greatest coordinate.
    assert!(beyond[1][0] > 0 && beyond[1][1] > 10 && beyond[2][1] > 0 && beyond[5][0] > 10);
    assert_eq!([beyond[0][1], beyond[8][1], beyond[9][1], beyond[10][1]], [0; 4]);
}

/// The second pass alone finds the same as both.
fn shells_agree<M: Metric, const D: usize>() {
    let cells = Cells::<D>::new(&Params::seeded(9)).unwrap();
    let p = points(D, TILE, 30.0);
    let p: Vec<&[f32]> = p.iter().map(Vec::as_slice).collect();
    let mut tile = Points::none();
    tile.load(Isa::detect(), &cells, &coordinates(&p), 0, TILE);
    let both = nearest::<M, D>(Isa::detect(), &cells, &tile, true, true);
    let none = Nearest { first: NONE, second: NONE, first_cell: 0, second_cell: 0 };
    for i in 0..TILE {
        let shells = further::<M, D>(&cells, &tile, i, -1, true, none);
        assert_eq!([shells.first, shells.second], [both.first[i], both.second[i]]);
        assert_eq!([shells.first_cell, shells.second_cell], [both.first_cell[i], both.second_cell[i]]);
    }
}

#[test]
fn shells_find_what_the_nearest_cells_have() {
    shells_agree::<Euclidean, 1>();
    shells_agree::<Euclidean, 2>();
    shells_agree::<Euclidean, 3>();
    shells_agree::<Manhattan, 3>();
    shells_agree::<Manhattan, 4>();
    shells_agree::<Chebyshev, 2>();
    shells_agree::<Chebyshev, 3>();
}

#[test]
fn no_steeper_than_the_distance() {
    // Continuous, then, wherever the two points of a pair lie.
    for metric in 0..3 {
        for d in 1..=3 {
            let p = points(d, 20_000, 3.0);
            let step = |i: usize| random(i, 1e-3);
            let q: Vec<Vec<f32>> = p
                .iter()
                .enumerate()
                .map(|(k, p)| p.iter().enumerate().map(|(i, x)| x + step(k * 50_000 + i)).collect())
                .collect();
            for feature in ["F1", "F2"] {
                let of = params(metric, feature);
                let (here, there) = (noise(Isa::detect(), &of, &p), noise(Isa::detect(), &of, &q));
                for i in 0..p[0].len() {
                    let way: Vec<f64> = (0..d).map(|k| f64::from(p[k][i]) - f64::from(q[k][i])).collect();
                    let change = f64::from((here[i] - there[i]).abs());
                    assert!(change <= length(metric, &way) + 1e-6, "{of:?} {d}-D");
                }
            }
        }
    }
}

#[test]
fn repeats_with_its_period() {
    for d in 1..=4 {
        let period = [3.0, 5.0, 1.0, 2.0];
        let p: Vec<Vec<f32>> = points(d, 300, 20.0)
            .iter()
            .map(|p| p.iter().map(|x| (x * 64.0).floor() / 64.0).collect())
            .collect();
        let q: Vec<Vec<f32>> = (0..d).map(|k| p[k].iter().map(|x| x - 4.0 * period[k]).collect()).collect();
        for feature in FEATURES {
            let of = params(0, feature).with(Opt::Period, &period[..d]);
            assert_eq!(noise(Isa::detect(), &of, &p), noise(Isa::detect(), &of, &q), "{d}-D {feature}");
            assert_ne!(noise(Isa::detect(), &params(0, feature), &p), noise(Isa::detect(), &of, &p));
        }
    }
}

#[test]
fn without_jitter_points_are_the_middles() {
    let p = [vec![0.5, 3.0, 2.25, -7.5], vec![0.5, 4.0, -0.5, 9.5], vec![0.5, 1.0, 0.5, -0.5]];
    for (metric, corner) in [(0, 0.75_f32.sqrt()), (1, 1.5), (2, 0.5)] {
        let of = params(metric, "F1").with(Opt::Jitter, &[0.0]);
        assert_eq!(noise(Isa::detect(), &of, &p), [0.0, corner, 0.25, 0.0]);
        let slopes = slopes(Isa::detect(), &of, &p);
        for k in 0..3 {
            assert_eq!([slopes[k][0], slopes[k][3]], [0.0; 2], "at a feature point");
        }
        assert_eq!([slopes[0][2], slopes[1][2], slopes[2][2]], [-1.0, 0.0, 0.0]);
        let f2 = params(metric, "F2").with(Opt::Jitter, &[0.0]);
        assert_eq!(noise(Isa::detect(), &f2, &p), [1.0, corner, 0.75, 1.0]);
    }
}

#[test]
fn wrong_options_are_told() {
    let message = |params: Params| KIND.field(2, &params).err().unwrap().message;
    assert_eq!(message(Params::default().with(Opt::Jitter, &[1.5])), "jitter must be from 0 to 1, found 1.5");
    assert_eq!(
        message(Params::default().with(Opt::Jitter, &[0.5, 0.5])),
        "jitter is a number, found a vector of 2"
    );
    assert!(
        message(Params::default().with(Opt::Period, &[2.5])).starts_with("period must be a whole number")
    );
    assert_eq!(message(Params::default().with(Opt::Width, &[1.0])), "`cellular` noise takes no width");
}

#[test]
fn awkward_points() {
    for metric in 0..3 {
        for feature in FEATURES {
            let of = params(metric, feature);
            for d in 1..=4 {
                for bad in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                    for k in 0..d {
                        let mut p = vec![vec![0.3]; d];
                        p[k][0] = bad;
                        assert!(noise(Isa::detect(), &of, &p)[0].is_nan());
                        assert!(slopes(Isa::detect(), &of, &p).iter().all(|s| s[0].is_nan()), "{of:?} {d}");
                    }
                }
                for huge in [8_388_609.0, -16_777_216.0, 1e20, f32::MAX, f32::MIN] {
                    let n = noise(Isa::detect(), &of, &vec![vec![huge]; d])[0];
                    assert!((0.0..=4.0).contains(&n), "{n}");
                }
            }
        }
    }
}

#[test]
fn the_same_bits_always() {
    let known = |feature: &str| -> Vec<u32> {
        let p = [0.5, 1.25, -2.75, 100.125];
        (1..=4)
            .map(|d| {
                noise(
                    Isa::baseline(),
                    &params(0, feature),
                    &p[..d].iter().map(|&x| vec![x]).collect::<Vec<_>>(),
                )[0]
                .to_bits()
            })
            .collect()
    };
    assert_eq!(known("F1"), [0x3e62_c2a5, 0x3e85_b2e7, 0x3f40_38e0, 0x3f39_3a56], "{:x?}", known("F1"));
    assert_eq!(known("id"), [0x3f1c_85d7, 0x3d09_5ff0, 0x3f72_44bb, 0x3f40_e478], "{:x?}", known("id"));
    for metric in 0..3 {
        for (feature, d) in FEATURES.into_iter().zip([3, 2, 4, 1]) {
            let of = params(metric, feature);
            let mut p = points(d, 203, 1e3);
            p[0][150] = f32::NAN;
            p[d - 1][170] = 1e30;
            let (whole, whole_slopes) = (noise(Isa::detect(), &of, &p), slopes(Isa::detect(), &of, &p));
            for n in [1, 7, 64, 65, 203] {
                let cut: Vec<Vec<f32>> = p.iter().map(|p| p[203 - n..].to_vec()).collect();
                assert_eq!(bits(&noise(Isa::baseline(), &of, &cut)), bits(&whole[203 - n..]));
                for (k, slope) in slopes(Isa::baseline(), &of, &cut).iter().enumerate() {
                    assert_eq!(bits(slope), bits(&whole_slopes[k][203 - n..]));
                }
            }
        }
    }
}
