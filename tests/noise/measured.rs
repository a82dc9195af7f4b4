//! What is measured of every kind: once, with its default options, for all tests and for the table of docs/noise.md.

use pse::internal::lanes::Isa;
use pse::measure::{Moments, Random, Section, Spectrum, correlation};
use pse::noise::{Field, KINDS, Kind, Params, Smoothness};
use rayon::prelude::*;
use std::sync::{Arc, OnceLock};

/// Coordinates of points, a list each.
pub type Points = Vec<Vec<f32>>;

pub fn slices(p: &[Vec<f32>]) -> Vec<&[f32]> {
    p.iter().map(Vec::as_slice).collect()
}

pub fn field(kind: &'static Kind, dimensions: usize, params: &Params) -> Arc<dyn Field> {
    kind.field(dimensions, params).unwrap_or_else(|e| panic!("{kind:?} in {dimensions}-D: {e:?}"))
}

/// The values of a field at points.
pub fn values(field: &dyn Field, p: &[Vec<f32>]) -> Vec<f32> {
    let mut out = vec![0.0; p[0].len()];
    field.noise(Isa::detect(), &slices(p), &mut out);
    out
}

/// Its derivatives at points, along each axis.
pub fn slopes(field: &dyn Field, p: &[Vec<f32>]) -> Points {
    let mut out = vec![vec![0.0; p[0].len()]; p.len()];
    let mut planes: Vec<&mut [f32]> = out.iter_mut().map(Vec::as_mut_slice).collect();
    field.derivative(Isa::detect(), &slices(p), &mut planes);
    out
}

/// The points moved by a distance along a direction.
pub fn moved(p: &[Vec<f32>], direction: &[f64], distance: f64) -> Points {
    let along = |(x, u): (&Vec<f32>, &f64)| x.iter().map(|x| x + (u * distance) as f32).collect();
    p.iter().zip(direction).map(along).collect()
}

/// The derivative along a direction.
fn along(slopes: &[Vec<f32>], direction: &[f64]) -> Vec<f64> {
    let lane = |i: usize| slopes.iter().zip(direction).map(|(s, u)| f64::from(s[i]) * u).sum();
    (0..slopes[0].len()).map(lane).collect()
}

/// The numbers of a kind in its usual dimensions. Its deviation is the unit of values, its rms slope that of slopes.
#[derive(Debug)]
pub struct Measured {
    pub kind: &'static Kind,
    pub moments: Moments,
    /// The least and the most value that was found, in each of its dimensions.
    pub ranges: Vec<[f32; 2]>,
    /// Shares of the power of plane sections: below 0.3 cycles a unit, from there to 0.7, and above 1.
    pub below: f64,
    pub band: f64,
    pub above: f64,
    /// The largest steps, across the faces of unit cells, of the value and of the derivatives.
    pub value_jump: f64,
    pub slope_jump: f64,
    /// The root mean square of those of the derivative across.
    pub usual_slope_jump: f64,
    /// How many derivatives are continuous along lines; not more than two are looked at.
    pub smoothness: Smoothness,
    /// The largest step of the second derivative across faces, over its rms.
    pub bend_jump: f64,
    /// The largest ratio between directions of the mean squared change over a distance.
    pub isotropy: f64,
    /// The largest ratio of the variances of plane sections that are turned differently.
    pub planes: f64,
    /// The deviation about 10⁶, over that about 0.
    pub far: f64,
    /// The largest correlation, in size, with itself moved by 4 … 65536.
    pub shift: f64,
    /// The largest correlation, in size, between two seeds.
    pub seeds: f64,
    /// The rms difference of the derivative from differences.
    pub derivative: f64,
}

/// All kinds, measured.
pub fn all() -> &'static [Measured] {
    static ALL: OnceLock<Vec<Measured>> = OnceLock::new();
    ALL.get_or_init(|| KINDS.par_iter().map(|kind| measure(kind)).collect())
}

/// One of them; `None` if there is no such kind.
pub fn one(name: &str) -> Option<&'static Measured> {
    all().iter().find(|m| m.kind.name == name)
}

/// How large something is that may be 0, as its measure may.
fn ratio(size: f64, measure: f64) -> f64 {
    if size == 0.0 { 0.0 } else { size / measure }
}

fn measure(kind: &'static Kind) -> Measured {
    let d = kind.usual_dimensions();
    let noise = &*field(kind, d, &Params::default());
    let moments = Moments::of(&values(noise, &Random::new(1).points(d, 1 << 20, 500.0, 1.0 / 4096.0)));
    let rms_slope = {
        let slopes = slopes(noise, &Random::new(2).points(d, 1 << 14, 500.0, 1.0 / 4096.0));
        // Along an axis, the mean of all.
        Moments::of(&slopes.concat()).rms()
    };
    let spectrum = spectrum(|p, out| noise.noise(Isa::detect(), p, out), d);
    let [value_jump, slope_jump, usual_slope_jump, bend_jump] = jumps(noise, d);
    Measured {
        kind,
        moments,
        ranges: kind.dimensions.clone().map(|d| range(&*field(kind, d, &Params::default()), d)).collect(),
        below: spectrum.share(0.0, 0.3),
        band: spectrum.share(0.3, 0.7),
        above: spectrum.share(1.0, f64::INFINITY),
        value_jump: value_jump / moments.deviation,
        slope_jump: ratio(slope_jump, rms_slope),
        usual_slope_jump: ratio(usual_slope_jump, rms_slope),
        bend_jump: ratio(bend_jump, rms_bend(noise, d)),
        smoothness: smoothness(noise, d),
        isotropy: isotropy(noise, d),
        planes: planes(noise, d),
        far: far(noise, d),
        shift: shift(noise, d),
        seeds: seeds(kind, d),
        derivative: ratio(derivative_error(noise, d, kind.contract.smoothness), rms_slope),
    }
}

/// The mean spectrum of randomly turned plane sections.
pub fn spectrum(mut noise: impl FnMut(&[&[f32]], &mut [f32]), d: usize) -> Spectrum {
    const SIDE: usize = 256;
    const SPACING: f64 = 1.0 / 8.0;
    let mut random = Random::new(3);
    let mut spectrum = Spectrum::new(SIDE, SPACING);
    for _ in 0..8 {
        let section = Section::tilted(&mut random, d, SIDE, SPACING, 300.0);
        spectrum.add(&section.sample(&mut noise));
    }
    spectrum
}

/// The least and the most value that is found: the extremes of many points, and from there up and down hill.
fn range(noise: &dyn Field, d: usize) -> [f32; 2] {
    let points = Random::new(4).points(d, 1 << 18, 500.0, 1.0 / 4096.0);
    let found = values(noise, &points);
    let mut order: Vec<usize> = (0..found.len()).collect();
    order.sort_by(|&a, &b| found[a].total_cmp(&found[b]));
    let climb = |lanes: &[usize], sign: f32| {
        let mut p: Points = points.iter().map(|x| lanes.iter().map(|&i| x[i]).collect()).collect();
        let mut best: Vec<f32> = lanes.iter().map(|&i| sign * found[i]).collect();
        let mut step = vec![1.0 / 16.0_f32; lanes.len()];
        for _ in 0..40 {
            let slopes = slopes(noise, &p);
            let mut next = p.clone();
            for i in 0..lanes.len() {
                let length = slopes.iter().map(|s| s[i] * s[i]).sum::<f32>().sqrt();
                for (x, s) in next.iter_mut().zip(&slopes) {
                    x[i] += if length > 0.0 { sign * step[i] * s[i] / length } else { 0.0 };
                }
            }
            for (i, value) in values(noise, &next).iter().enumerate() {
                if sign * value > best[i] {
                    best[i] = sign * value;
                    p.iter_mut().zip(&next).for_each(|(p, next)| p[i] = next[i]);
                } else {
                    step[i] *= 0.5;
                }
            }
        }
        sign * best.iter().fold(f32::NEG_INFINITY, |m, x| m.max(*x))
    };
    [climb(&order[..64], -1.0), climb(&order[found.len() - 64..], 1.0)]
}

/// The steps across faces of cells: the largest of the value and of the derivatives, the rms of the derivative across, the
/// largest of the second derivative across.
fn jumps(noise: &dyn Field, d: usize) -> [f64; 4] {
    const FACES: usize = 1 << 12;
    let near = 1.0 / 16384.0;
    let wide = 1.0 / 512.0;
    let (mut value, mut slope, mut across, mut bend) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    for k in 0..d {
        // Near the origin, so that coordinates are exact so close to a face.
        let mut faces = Random::new(5 + k as u64).points(d, FACES, 30.0, 1.0 / 16384.0);
        faces[k].iter_mut().for_each(|x| *x = x.round());
        let mut axis = vec![0.0; d];
        axis[k] = 1.0;
        let at = |distance: f64| values(noise, &moved(&faces, &axis, distance));
        let sloping = |distance: f64| slopes(noise, &moved(&faces, &axis, distance));
        // From either side the value on the face, as if the slope were constant.
        let [a, b, c, e] = [-2.0, -1.0, 1.0, 2.0].map(|i| at(i * near));
        let [before, after] = [-near, near].map(sloping);
        // The same of the derivative along this axis, as if its slope were linear: the second derivative on the face.
        let bend_from = |side: f64| {
            let [a, b, c] = [1.0, 2.0, 3.0].map(|i| sloping(side * i * wide).swap_remove(k));
            let of = |i: usize| {
                let sum = -2.5 * f64::from(a[i]) + 4.0 * f64::from(b[i]) - 1.5 * f64::from(c[i]);
                sum / (side * wide)
            };
            (0..FACES).map(of).collect::<Vec<f64>>()
        };
        let (left, right) = (bend_from(-1.0), bend_from(1.0));
        for i in 0..FACES {
            let wide = |x: &[f32]| f64::from(x[i]);
            value = value.max(((2.0 * wide(&b) - wide(&a)) - (2.0 * wide(&c) - wide(&e))).abs());
            for (before, after) in before.iter().zip(&after) {
                slope = slope.max((wide(before) - wide(after)).abs());
            }
            across += (wide(&before[k]) - wide(&after[k])) * (wide(&before[k]) - wide(&after[k]));
            bend = bend.max((left[i] - right[i]).abs());
        }
    }
    [value, slope, (across / (FACES * d) as f64).sqrt(), bend]
}

/// The rms second derivative along an axis.
fn rms_bend(noise: &dyn Field, d: usize) -> f64 {
    let step = 1.0 / 512.0;
    let points = Random::new(7).points(d, 1 << 14, 30.0, 1.0 / 16384.0);
    let bends = (0..d).flat_map(|k| {
        let axis: Vec<f64> = (0..d).map(|i| f64::from(i == k)).collect();
        let at = |by: f64| slopes(noise, &moved(&points, &axis, by)).swap_remove(k);
        let (up, down) = (at(step), at(-step));
        up.iter().zip(&down).map(|(b, a)| (b - a) / (2.0 * step as f32)).collect::<Vec<f32>>()
    });
    Moments::of(&bends.collect::<Vec<f32>>()).rms()
}

/// How many derivatives are continuous along lines: the largest step between neighbouring samples is halved with
/// their distance, but where there is a jump.
fn smoothness(noise: &dyn Field, d: usize) -> Smoothness {
    const STEP: f64 = 1.0 / 256.0;
    let mut random = Random::new(8);
    // Of the value, the slope and the bend: over a step, and over two.
    let mut most = [[0.0_f64; 2]; 3];
    for _ in 0..24 {
        let origin: Vec<f64> = (0..d).map(|_| random.within(8.0)).collect();
        let direction = random.direction(d);
        let points = Section::line(&origin, &direction, 2048, STEP).points();
        let value: Vec<f64> = values(noise, &points).iter().map(|&x| f64::from(x)).collect();
        let slope = along(&slopes(noise, &points), &direction);
        for (wide, step) in [1, 2].into_iter().enumerate() {
            let change = |x: &[f64]| x.windows(step + 1).map(|w| (w[step] - w[0]).abs()).fold(0.0, f64::max);
            let turn = slope.windows(2 * step + 1).map(|w| (w[2 * step] - 2.0 * w[step] + w[0]).abs());
            let turn = turn.fold(0.0, f64::max) / step as f64;
            for (most, found) in most.iter_mut().zip([change(&value), change(&slope), turn]) {
                most[wide] = most[wide].max(found);
            }
        }
    }
    // Of a jump a step shows all, but of a kink two thirds of what two steps show, if it is half-way between samples.
    let limits = [0.75, 0.75, 0.6];
    let continuous: [bool; 3] = std::array::from_fn(|i| most[i][0] < limits[i] * most[i][1]);
    match continuous {
        [false, ..] => Smoothness::Discontinuous,
        [true, false, _] => Smoothness::C0,
        [true, true, false] => Smoothness::C1,
        [true, true, true] => Smoothness::C2,
    }
}

/// Directions that differ in how they lie to the axes.
fn directions(d: usize) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = (0..d).map(|k| (0..d).map(|i| f64::from(i == k)).collect()).collect();
    if d > 1 {
        all.push((0..d).map(|i| f64::from(i < 2)).collect());
        all.push((0..d).map(|i| [1.0, -1.0][(i + d) % 2]).collect());
    }
    if d > 2 {
        all.push(vec![1.0; d]);
        all.push((0..d).map(|i| f64::from(i != 1)).collect());
    }
    for v in &mut all {
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v.iter_mut().for_each(|x| *x /= length);
    }
    all
}

fn isotropy(noise: &dyn Field, d: usize) -> f64 {
    let points = Random::new(9).points(d, 50_000, 300.0, 1.0 / 4096.0);
    let here = values(noise, &points);
    let change = |direction: &[f64], distance: f64| {
        let there = values(noise, &moved(&points, direction, distance));
        let squares = here.iter().zip(&there).map(|(a, b)| f64::from(a - b) * f64::from(a - b));
        squares.sum::<f64>()
    };
    let ratio = |distance: f64| {
        let changes: Vec<f64> = directions(d).iter().map(|u| change(u, distance)).collect();
        changes.iter().fold(0.0, |m: f64, x| m.max(*x)) / changes.iter().fold(f64::INFINITY, |m, x| m.min(*x))
    };
    [0.25, 0.5, 0.75].into_iter().map(ratio).fold(1.0, f64::max)
}

fn planes(noise: &dyn Field, d: usize) -> f64 {
    if d == 1 {
        return 1.0;
    }
    let all = directions(d);
    let mut variances = Vec::new();
    // Rows along an axis or along a diagonal; columns at right angles to them.
    for (a, b) in (0..all.len()).flat_map(|a| (0..a).map(move |b| (a, b))) {
        let common: f64 = all[a].iter().zip(&all[b]).map(|(x, y)| x * y).sum();
        if common.abs() > 1e-9 {
            continue;
        }
        let mut random = Random::new(10);
        let (along, across) = (all[a].clone(), all[b].clone());
        let mut sum = 0.0;
        for _ in 0..24 {
            let origin = (0..d).map(|_| random.within(300.0)).collect();
            let (along, across) = (along.clone(), across.clone());
            let section = Section { origin, along, across, columns: 48, rows: 48, spacing: 0.25 };
            let m = Moments::of(&section.sample(|p, out| noise.noise(Isa::detect(), p, out)));
            sum += m.deviation * m.deviation;
        }
        variances.push(sum);
    }
    variances.iter().fold(0.0, |m: f64, x| m.max(*x)) / variances.iter().fold(f64::INFINITY, |m, x| m.min(*x))
}

fn far(noise: &dyn Field, d: usize) -> f64 {
    // About 10⁶ the numbers are 1/16 apart, so let them be so here too.
    let near = Random::new(11).points(d, 1 << 16, 400.0, 1.0 / 16.0);
    let far: Points = near.iter().map(|x| x.iter().map(|x| x + 1e6).collect()).collect();
    Moments::of(&values(noise, &far)).deviation / Moments::of(&values(noise, &near)).deviation
}

fn shift(noise: &dyn Field, d: usize) -> f64 {
    let points = Random::new(12).points(d, 20_000, 100.0, 1.0 / 64.0);
    let here = values(noise, &points);
    let mut most = 0.0_f64;
    for distance in [4.0, 16.0, 64.0, 256.0, 1024.0, 4096.0, 65536.0] {
        // Along each axis, and along the diagonal of all.
        for axes in (0..d).map(|k| 1 << k).chain((d > 1).then_some((1 << d) - 1)) {
            let by: Vec<f64> = (0..d).map(|k| f64::from(axes >> k & 1)).collect();
            most = most.max(correlation(&here, &values(noise, &moved(&points, &by, distance))).abs());
        }
    }
    most
}

fn seeds(kind: &'static Kind, d: usize) -> f64 {
    let points = Random::new(14).points(d, 20_000, 500.0, 1.0 / 64.0);
    // As programs give them: the bits of the numbers 0, 1, 2 … -1; and whole numbers as they are.
    let numbers = (-1..16).map(|i| (i as f32 + 0.0).to_bits());
    let seeds: Vec<u32> = numbers.chain([1, 2, 3, 1 << 31, u32::MAX]).collect();
    let all: Vec<Vec<f32>> =
        seeds.iter().map(|seed| values(&*field(kind, d, &Params::seeded(*seed)), &points)).collect();
    let pairs = (0..seeds.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
    pairs.map(|(a, b)| correlation(&all[a], &all[b]).abs()).fold(0.0, f64::max)
}

/// The rms difference of the derivatives from central differences.
pub fn derivative_error(noise: &dyn Field, d: usize, smoothness: Smoothness) -> f64 {
    let step = 1.0 / 512.0;
    let points = Random::new(13).points(d, 1 << 14, 16.0, 1.0 / 4096.0);
    let exact = slopes(noise, &points);
    let mut worst = 0.0_f64;
    for (k, exact) in exact.iter().enumerate() {
        let axis: Vec<f64> = (0..d).map(|i| f64::from(i == k)).collect();
        let (up, down) =
            (values(noise, &moved(&points, &axis, step)), values(noise, &moved(&points, &axis, -step)));
        let difference =
            |i: usize| (f64::from(up[i]) - f64::from(down[i])) / (2.0 * step) - f64::from(exact[i]);
        let mut squares: Vec<f64> = (0..exact.len()).map(|i| difference(i) * difference(i)).collect();
        if smoothness == Smoothness::C0 {
            // Some of the differences go across a kink, where there is no derivative.
            squares.sort_by(f64::total_cmp);
            squares.truncate(exact.len() * 95 / 100);
        }
        worst = worst.max((squares.iter().sum::<f64>() / squares.len() as f64).sqrt());
    }
    worst
}
