//! What the tests of the lattice kinds share: a plain reference in f64, and what is to hold for each of them.

use super::direction::direction;
use super::kind::Kind;
use super::lattice::{Endless, Lattice};
use super::{Field, Opt, Params, hash};
use crate::lanes::Isa;

/// Even numbers in -size … size.
pub fn numbers(seed: u64, n: usize, size: f64) -> Vec<f32> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) as f64 / f64::from(1_u32 << 30) - 1.0) * size
    };
    (0..n).map(|_| next() as f32).collect()
}

/// Points, a vector a coordinate.
pub fn points(dimensions: usize, n: usize, size: f64) -> Vec<Vec<f32>> {
    (0..dimensions).map(|k| numbers(k as u64 + 11, n, size)).collect()
}

fn slices(p: &[Vec<f32>], lanes: std::ops::Range<usize>) -> Vec<&[f32]> {
    p.iter().map(|p| &p[lanes.clone()]).collect()
}

fn values_in(field: &dyn Field, isa: Isa, p: &[Vec<f32>], lanes: std::ops::Range<usize>) -> Vec<f32> {
    let mut out = vec![0.0; lanes.len()];
    field.noise(isa, &slices(p, lanes), &mut out);
    out
}

fn slopes_in(field: &dyn Field, isa: Isa, p: &[Vec<f32>], lanes: std::ops::Range<usize>) -> Vec<Vec<f32>> {
    let mut out = vec![vec![0.0; lanes.len()]; p.len()];
    let mut planes: Vec<&mut [f32]> = out.iter_mut().map(Vec::as_mut_slice).collect();
    field.derivative(isa, &slices(p, lanes), &mut planes);
    out
}

/// The noise of a kind.
pub fn noise(kind: &'static Kind, params: &Params, p: &[Vec<f32>]) -> Vec<f32> {
    values_in(&*kind.field(p.len(), params).unwrap(), Isa::detect(), p, 0..p[0].len())
}

/// Its derivative.
pub fn derivative(kind: &'static Kind, params: &Params, p: &[Vec<f32>]) -> Vec<Vec<f32>> {
    slopes_in(&*kind.field(p.len(), params).unwrap(), Isa::detect(), p, 0..p[0].len())
}

/// The bits; of a NaN only that it is one.
pub fn bits(x: &[f32]) -> Vec<u32> {
    x.iter().map(|x| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() }).collect()
}

/// Bits that are not to change, for each number of dimensions.
pub fn pinned(kind: &'static Kind, params: &Params) -> Vec<u32> {
    let p = [0.5, 1.25, -2.75, 100.125].map(|x| vec![x]);
    let got: Vec<f32> = kind.dimensions.clone().flat_map(|d| noise(kind, params, &p[..d])).collect();
    bits(&got)
}

/// The hash of a lattice point.
pub fn hash_at(seed: u32, point: &[f64]) -> u32 {
    let lattice = Lattice::<Endless, 4>::new(seed, Endless);
    hash::point(point.iter().enumerate().fold(0, |joined, (k, &x)| joined ^ lattice.key(k, x as f32)))
}

/// A random value in -1 … 1 of a hash.
pub fn value_of(hash: u32) -> f64 {
    f64::from(hash as i32) / f64::from(1_u32 << 31)
}

/// A random vector of length 1 of a hash, for so many coordinates.
pub fn gradient_of(hash: u32, dimensions: usize) -> Vec<f64> {
    let g: &[f32] = if dimensions == 4 { &direction::<4>(hash) } else { &direction::<3>(hash) };
    g[..dimensions].iter().map(|&g| f64::from(g) / f64::from(super::direction::LENGTH)).collect()
}

/// The cubic that falls from 1 to 0 over a unit, with slopes 0 at both.
pub fn cubic(x: f64) -> f64 {
    let r = x.abs();
    if r < 1.0 { 1.0 - r * r * (3.0 - 2.0 * r) } else { 0.0 }
}

/// The Catmull-Rom spline's kernel.
pub fn catmull_rom(x: f64) -> f64 {
    let r = x.abs();
    match r {
        ..1.0 => 1.0 - 2.5 * r * r + 1.5 * r * r * r,
        ..2.0 => 2.0 - 4.0 * r + 2.5 * r * r - 0.5 * r * r * r,
        _ => 0.0,
    }
}

/// The random value, in -1 … 1, and gradient, its components in -1 … 1 too, of a lattice point of the noises of linear functions.
pub fn plane_at(seed: u32, point: &[f64]) -> (f64, Vec<f64>) {
    let lattice = Lattice::<Endless, 4>::new(seed, Endless);
    let key = |axis: usize| {
        let whole = hash::whole(point.get(axis).copied().unwrap_or(0.0) as f32);
        hash::key(whole, axis).wrapping_add(lattice.seed(axis))
    };
    let last = if point.len() == 4 { key(2) ^ key(3) } else { key(2) };
    let hash = hash::column(key(0) ^ key(1)).wrapping_mul(hash::stack(last));
    let (bits, size) = if point.len() == 4 { (8, 0.75_f64.sqrt()) } else { (11, 1.0) };
    let gradient = (0..point.len()).map(|k| value_of(hash << (bits * k)) * size).collect();
    (value_of(hash.wrapping_mul(hash::FURTHER)), gradient)
}

/// A noise is the sum over lattice points, of what a kernel makes of the point's hash and the offset from it:
/// so it is for all points, up to rounding, and its derivative too.
pub fn is_sum_over_lattice(kind: &'static Kind, params: &Params, kernel: impl Fn(u32, &[f64]) -> f64) {
    is_sum(kind, params, |at, offset| kernel(hash_at(params.seed, at), offset));
}

/// The like, of what a kernel makes of [`plane_at`] and the offset.
pub fn is_sum_over_planes(kind: &'static Kind, params: &Params, kernel: impl Fn(f64, &[f64], &[f64]) -> f64) {
    is_sum(kind, params, |at, offset| {
        let (value, gradient) = plane_at(params.seed, at);
        kernel(value, &gradient, offset)
    });
}

fn is_sum(kind: &'static Kind, params: &Params, kernel: impl Fn(&[f64], &[f64]) -> f64) {
    is(kind, params, |p| {
        let mut sum = 0.0;
        for number in 0..1 << (2 * p.len()) {
            let at: Vec<f64> =
                (0..p.len()).map(|k| p[k].floor() + f64::from(number >> (2 * k) & 3) - 1.0).collect();
            let offset: Vec<f64> = (0..p.len()).map(|k| p[k] - at[k]).collect();
            sum += kernel(&at, &offset);
        }
        sum
    });
}

/// A noise is a function, up to rounding, and its derivative is the function's.
pub fn is(kind: &'static Kind, params: &Params, known: impl Fn(&[f64]) -> f64) {
    const STEP: f64 = 1e-5;
    for d in kind.dimensions.clone() {
        let p = points(d, 300, 60.0);
        let (values, slopes) = (noise(kind, params, &p), derivative(kind, params, &p));
        for i in 0..300 {
            let p: Vec<f64> = p.iter().map(|p| f64::from(p[i])).collect();
            let (found, exact) = (f64::from(values[i]), known(&p));
            assert!((found - exact).abs() < 5e-6, "{} at {p:?}: {found}, not {exact}", kind.name);
            for k in 0..d {
                let moved = |step: f64| {
                    let mut p = p.clone();
                    p[k] += step;
                    known(&p)
                };
                let (found, exact) = (f64::from(slopes[k][i]), (moved(STEP) - moved(-STEP)) / (2.0 * STEP));
                let message = || format!("{} along {k} at {p:?}: {found}, not {exact}", kind.name);
                assert!((found - exact).abs() < 1e-4, "{}", message());
            }
        }
    }
}

/// What is to hold for every kind and all its parameters.
pub fn usual(kind: &'static Kind, params: &Params) {
    for d in kind.dimensions.clone() {
        same_bits(kind, params, d);
        awkward_points(kind, params, d);
        periods(kind, params, d);
        // Another seed is unrelated.
        let p = points(d, 5000, if d == 1 { 4000.0 } else { 90.0 });
        let (a, b) = (noise(kind, params, &p), noise(kind, &params.clone().reseeded(params.seed + 1), &p));
        let product = |a: &[f32], b: &[f32]| -> f64 {
            a.iter().zip(b).map(|(a, b)| f64::from(a * b)).sum::<f64>() / a.len() as f64
        };
        let correlation = product(&a, &b) / (product(&a, &a) * product(&b, &b)).sqrt();
        assert!(correlation.abs() < 0.16, "{} {d}-D: {correlation}", kind.name);
    }
}

/// Every instruction set, number of lanes and neighbourhood gives the same bits.
fn same_bits(kind: &'static Kind, params: &Params, d: usize) {
    const N: usize = 141;
    let mut p = points(d, N, 1000.0);
    let odd = [f32::NAN, f32::INFINITY, 1e30, -1e30, 8_388_608.0, -0.0, 1e-45, -1e-10];
    for (i, x) in odd.into_iter().enumerate() {
        p[i % d][i * 17 + 3] = x;
    }
    let field = kind.field(d, params).unwrap();
    let (base, best) = (Isa::baseline(), Isa::detect());
    let values = values_in(&*field, base, &p, 0..N);
    let slopes = slopes_in(&*field, base, &p, 0..N);
    for isa in Isa::all() {
        for n in [1, 7, 64, 65, N] {
            let lanes = N - n..N;
            assert_eq!(bits(&values_in(&*field, isa, &p, lanes.clone())), bits(&values[lanes.clone()]));
            for (slope, known) in slopes_in(&*field, isa, &p, lanes.clone()).iter().zip(&slopes) {
                assert_eq!(bits(slope), bits(&known[lanes.clone()]));
            }
        }
    }
    for i in 0..N {
        assert_eq!(bits(&values_in(&*field, best, &p, i..i + 1)), bits(&values[i..=i]));
    }
}

/// What is no number gives none; what is far gives numbers within bounds.
fn awkward_points(kind: &'static Kind, params: &Params, d: usize) {
    for k in 0..d {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let mut p = vec![vec![0.375]; d];
            p[k][0] = bad;
            assert!(noise(kind, params, &p)[0].is_nan(), "{} {d}-D {p:?}", kind.name);
            assert!(derivative(kind, params, &p).iter().any(|g| g[0].is_nan()), "{} {d}-D {p:?}", kind.name);
        }
        let bound = if params.given().next().is_none() { kind.bounds(d)[1] } else { 10.0 };
        for far in [8_388_609.0, -8_388_607.5, -1e20, f32::MAX, f32::MIN] {
            let mut p = vec![vec![0.375]; d];
            p[k][0] = far;
            let value = noise(kind, params, &p)[0];
            assert!(value.abs() <= bound, "{} {d}-D {p:?}: {value}", kind.name);
            assert!(derivative(kind, params, &p).iter().all(|g| g[0].is_finite()));
        }
    }
}

/// Moved by a period it is the same, and only along the axes that have one.
fn periods(kind: &'static Kind, params: &Params, d: usize) {
    let period = &[3.0, 5.0, 0.0, 2.0][4 - d..];
    let params = params.clone().with(Opt::Period, period);
    let p: Vec<Vec<f32>> = points(d, 400, 16.0)
        .iter()
        .map(|p| p.iter().map(|x| (x * 256.0).floor() * (1.0 / 256.0)).collect())
        .collect();
    let (values, slopes) = (noise(kind, &params, &p), derivative(kind, &params, &p));
    for k in 0..d {
        let mut moved = p.clone();
        moved[k].iter_mut().for_each(|x| *x += if period[k] == 0.0 { 2.0 } else { period[k] });
        let same = bits(&noise(kind, &params, &moved)) == bits(&values)
            && derivative(kind, &params, &moved).iter().zip(&slopes).all(|(a, b)| bits(a) == bits(b));
        assert_eq!(same, period[k] != 0.0, "{} {d}-D along {k}", kind.name);
    }
}
