//! The look-up of a [`Table`]: the tensor product of cubic B-splines, 4 coefficients along each axis.
//!
//! - Coordinates are cut by `floor`, and cells and periods are powers of two, so that the point's place in
//!   its cell is found without rounding, and noise repeats exactly, as far out as there are f32. (Only a
//!   point so little below a whole number that its distance to the next one below is rounded to 1 counts as
//!   that number.)
//! - From ±2^23 on every f32 is a whole number, and noise is what it is at the same number modulo the period.
//! - NaN and infinities give NaN.

// Loops over axes and lanes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::field::{TILE, Tile, Tiled};
use super::table::{CELLS, Table, period, size, stride};

/// How many coefficients count along an axis: 4, or 1 along those that there are not.
const fn across(dimensions: usize, axis: usize) -> usize {
    if axis < dimensions { 4 } else { 1 }
}

/// From the first of a cell's coefficients to behind the last.
const fn span(dimensions: usize) -> usize {
    let mut span = 1;
    let mut axis = 0;
    while axis < dimensions {
        span += 3 * stride(dimensions, axis);
        axis += 1;
    }
    span
}

/// Where the points of a tile lie. What is the same for all of them is done for whole vectors of lanes; what
/// takes coefficients goes lane by lane, by vectors of 4 that follow each other in the table.
pub(super) struct Places<const D: usize> {
    /// Where in the table the coefficients of a point's cell begin.
    first: [u32; TILE],
    /// The weights of the 4 coefficients along each axis, times 6.
    weights: [[[f32; TILE]; 4]; D],
    /// The derivatives of the weights by the coordinate.
    slopes: [[[f32; TILE]; 4]; D],
}

impl<const D: usize> Places<D> {
    #[inline(always)]
    fn new() -> Places<D> {
        Places { first: [0; TILE], weights: [[[0.0; TILE]; 4]; D], slopes: [[[0.0; TILE]; 4]; D] }
    }

    /// Finds the points' cells, and tells how far along each axis of its cell each is, 0 to 1.
    #[inline(always)]
    fn find(&mut self, p: [&[f32; TILE]; D], work: usize) -> [[f32; TILE]; D] {
        let (mut along, mut first) = ([[0.0; TILE]; D], [0; TILE]);
        for k in 0..D {
            for i in 0..work {
                let low = p[k][i].floor();
                let cells = (p[k][i] - low) * CELLS as f32;
                let within = cells.floor();
                along[k][i] = cells - within;
                // The period is a power of two, so all of this is exact.
                let rest = low - (low * (1.0 / period(D) as f32)).floor() * period(D) as f32;
                // The lowest bits of a sum with 2^23 are those of the whole number. Those of NaN are at least
                // a number of a cell.
                let cell = rest * CELLS as f32 + within + (1 << 23) as f32;
                first[i] += (cell.to_bits() & (size(D) as u32 - 1)) * stride(D, k) as u32;
            }
        }
        self.first = first;
        along
    }

    #[inline(always)]
    fn weigh(&mut self, along: &[[f32; TILE]; D], work: usize) {
        for k in 0..D {
            let [a, b, c, d] = &mut self.weights[k];
            for i in 0..work {
                let t = along[k][i];
                let s = 1.0 - t;
                a[i] = s * s * s;
                b[i] = (3.0 * t - 6.0) * t * t + 4.0;
                c[i] = (3.0 * s - 6.0) * s * s + 4.0;
                d[i] = t * t * t;
            }
        }
    }

    #[inline(always)]
    fn slope(&mut self, along: &[[f32; TILE]; D], work: usize) {
        const U: f32 = CELLS as f32;
        for k in 0..D {
            let [a, b, c, d] = &mut self.slopes[k];
            for i in 0..work {
                let t = along[k][i];
                let s = 1.0 - t;
                a[i] = -3.0 * U * s * s;
                b[i] = (9.0 * U * t - 12.0 * U) * t;
                c[i] = (12.0 * U - 9.0 * U * s) * s;
                d[i] = 3.0 * U * t * t;
            }
        }
    }

    /// The coefficients of a point's cell, from first to last, and what lies between.
    #[inline(always)]
    fn window<'a>(&self, table: &'a Table<D>, i: usize) -> &'a [f32] {
        &table.coefficients[self.first[i] as usize..][..span(D)]
    }
}

/// Four numbers, one for each coefficient along x.
pub(super) type Line = [f32; 4];

/// The b-th line of the c-th plane.
#[inline(always)]
fn line<const D: usize>(window: &[f32], b: usize, c: usize) -> Line {
    let at = b * stride(D, 1) + c * stride(D, 2);
    let line = &window[at..at + 4];
    [line[0], line[1], line[2], line[3]]
}

/// Adds a line, weighted.
#[inline(always)]
fn add(sum: &mut Line, weight: f32, line: Line) {
    for j in 0..4 {
        sum[j] += weight * line[j];
    }
}

/// In the end, the sums along x.
#[inline(always)]
fn along_x(lines: &[Line; TILE], weights: &[[f32; TILE]; 4], out: &mut [f32; TILE], work: usize) {
    for i in 0..work {
        let [a, b, c, d] = lines[i];
        out[i] = (a * weights[0][i] + b * weights[1][i]) + (c * weights[2][i] + d * weights[3][i]);
    }
}

impl<const D: usize> Tiled<D> for Table<D> {
    /// Where the points of a tile lie, and lines for the derivative along each axis: sums over y and z, with slopes
    /// along that axis.
    type Scratch = (Places<D>, [[Line; TILE]; D]);
    #[inline(always)]
    fn scratch(&self) -> Self::Scratch {
        (Places::new(), [[[0.0; 4]; TILE]; D])
    }

    #[inline(always)]
    fn values(&self, (places, lines): &mut Self::Scratch, tile: Tile<'_, D>, out: &mut [f32; TILE]) {
        let along = places.find(tile.p, tile.work());
        places.weigh(&along, tile.work());
        let (y, z) = (&places.weights[1 % D], &places.weights[2 % D]);
        for i in 0..tile.lanes.min(TILE) {
            let window = places.window(self, i);
            let mut sum = [0.0; 4];
            for c in 0..across(D, 2) {
                let mut plane = [0.0; 4];
                for b in 0..across(D, 1) {
                    add(&mut plane, if D > 1 { y[b][i] } else { 1.0 }, line::<D>(window, b, c));
                }
                add(&mut sum, if D > 2 { z[c][i] } else { 1.0 }, plane);
            }
            lines[0][i] = sum;
        }
        along_x(&lines[0], &places.weights[0], out, tile.work());
    }

    #[inline(always)]
    fn slopes(&self, (places, lines): &mut Self::Scratch, tile: Tile<'_, D>, out: &mut [[f32; TILE]; D]) {
        let along = places.find(tile.p, tile.work());
        places.weigh(&along, tile.work());
        places.slope(&along, tile.work());
        let (y, z) = (&places.weights[1 % D], &places.weights[2 % D]);
        let (dy, dz) = (&places.slopes[1 % D], &places.slopes[2 % D]);
        for i in 0..tile.lanes.min(TILE) {
            let window = places.window(self, i);
            let mut sums = [[0.0; 4]; D];
            for c in 0..across(D, 2) {
                let (mut plane, mut sloping) = ([0.0; 4], [0.0; 4]);
                for b in 0..across(D, 1) {
                    let line = line::<D>(window, b, c);
                    add(&mut plane, if D > 1 { y[b][i] } else { 1.0 }, line);
                    if D > 1 {
                        add(&mut sloping, dy[b][i], line);
                    }
                }
                let weight = if D > 2 { z[c][i] } else { 1.0 };
                add(&mut sums[0], weight, plane);
                if D > 1 {
                    add(&mut sums[1 % D], weight, sloping);
                }
                if D > 2 {
                    add(&mut sums[2 % D], dz[c][i], plane);
                }
            }
            for k in 0..D {
                lines[k][i] = sums[k];
            }
        }
        for k in 0..D {
            let weights = if k == 0 { &places.slopes[0] } else { &places.weights[0] };
            along_x(&lines[k], weights, &mut out[k], tile.work());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::field::{ByTiles, Field};
    use super::super::hash;
    use super::super::table::{gaussian, place};
    use super::*;
    use crate::lanes::Isa;

    fn table<const D: usize>() -> ByTiles<Table<D>, D> {
        let n = size(D).pow(D as u32) as u32;
        ByTiles(Table::smoothed(&(0..n).map(|i| gaussian(hash::mix(i))[0]).collect::<Vec<f64>>()))
    }

    /// Points with no more than 6 binary digits, in -size … size.
    fn points<const D: usize>(n: u32, size: u32) -> Vec<Vec<f32>> {
        let number = |i: u32| (hash::mix(i) % (128 * size)) as f32 / 64.0 - size as f32;
        (0..D as u32).map(|k| (0..n).map(|i| number(i * 4 + k)).collect()).collect()
    }

    fn slices(p: &[Vec<f32>]) -> Vec<&[f32]> {
        p.iter().map(Vec::as_slice).collect()
    }

    fn values<const D: usize>(table: &ByTiles<Table<D>, D>, isa: Isa, p: &[&[f32]]) -> Vec<f32> {
        let mut out = vec![0.0; p[0].len()];
        table.noise(isa, p, &mut out);
        out
    }

    fn gradients<const D: usize>(table: &ByTiles<Table<D>, D>, isa: Isa, p: &[&[f32]]) -> Vec<Vec<f32>> {
        let mut out = vec![vec![0.0; p[0].len()]; D];
        let mut planes: Vec<&mut [f32]> = out.iter_mut().map(Vec::as_mut_slice).collect();
        table.derivative(isa, p, &mut planes);
        out
    }

    fn bits(x: &[f32]) -> Vec<u32> {
        x.iter().map(|x| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() }).collect()
    }

    /// The B-spline about 0 and its derivative.
    fn bump(x: f64) -> [f64; 2] {
        let (a, sign) = (x.abs(), x.signum());
        match a {
            0.0..1.0 => [2.0 / 3.0 - a * a + a * a * a / 2.0, sign * (1.5 * a * a - 2.0 * a)],
            1.0..2.0 => [(2.0 - a) * (2.0 - a) * (2.0 - a) / 6.0, -sign * (2.0 - a) * (2.0 - a) / 2.0],
            _ => [0.0, 0.0],
        }
    }

    /// Value and derivative by their definition: the sum of all bumps.
    fn known<const D: usize>(table: &Table<D>, p: [f32; D]) -> [f64; 4] {
        let mut sums = [0.0; 4];
        let distance = |k: usize, point: usize| {
            let d = (f64::from(p[k]) * CELLS as f64 - point as f64).rem_euclid(size(D) as f64);
            if d > 2.0 { d - size(D) as f64 } else { d }
        };
        let near: [Vec<(usize, [f64; 2])>; D] = std::array::from_fn(|k| {
            (0..size(D)).map(|i| (i, bump(distance(k, i)))).filter(|(_, b)| *b != [0.0; 2]).collect()
        });
        for n in 0..near.iter().map(Vec::len).product() {
            let mut rest = n;
            let (mut at, mut products) = (0, [1.0; 4]);
            for k in 0..D {
                let (point, [bump, slope]) = near[k][rest % near[k].len()];
                rest /= near[k].len();
                at += (point + 1) % size(D) * stride(D, k);
                for (j, product) in products.iter_mut().enumerate() {
                    *product *= if j == k + 1 { slope * CELLS as f64 } else { bump };
                }
            }
            let coefficient = f64::from(table.coefficients[at]) * [6.0, 36.0, 216.0][D - 1];
            for j in 0..4 {
                sums[j] += coefficient * products[j];
            }
        }
        sums
    }

    fn check<const D: usize>() {
        let table = table::<D>();
        let p = points::<D>(300, 5000);
        let value = values(&table, Isa::detect(), &slices(&p));
        let gradient = gradients(&table, Isa::detect(), &slices(&p));
        for i in 0..300 {
            let known = known(&table.0, std::array::from_fn(|k| p[k][i]));
            assert!((f64::from(value[i]) - known[0]).abs() < 2e-6, "{D}-D: {} {}", value[i], known[0]);
            for k in 0..D {
                let error = (f64::from(gradient[k][i]) - known[k + 1]).abs();
                assert!(error < 1e-5, "{D}-D axis {k}: {} {}", gradient[k][i], known[k + 1]);
            }
        }
        // The same bits with any instruction set and number of lanes, and a period away.
        let mut p = p;
        for (i, x) in [f32::NAN, f32::INFINITY, -f32::INFINITY, 8_388_609.0, f32::MAX, -1e-45, -0.0, -1e-9]
            .into_iter()
            .enumerate()
        {
            p[i % D][i * 30 + 3] = x;
        }
        let p = slices(&p);
        let (value, gradient) = (values(&table, Isa::baseline(), &p), gradients(&table, Isa::baseline(), &p));
        for lanes in [1, 7, 64, 65, 299] {
            let cut: Vec<&[f32]> = p.iter().map(|p| &p[300 - lanes..]).collect();
            for isa in Isa::all() {
                assert_eq!(bits(&values(&table, isa, &cut)), bits(&value[300 - lanes..]));
                for (some, all) in gradients(&table, isa, &cut).iter().zip(&gradient) {
                    assert_eq!(bits(some), bits(&all[300 - lanes..]));
                }
            }
        }
        for i in 0..300 {
            let fit = p.iter().all(|p| p[i].is_finite());
            assert_eq!(value[i].is_finite(), fit);
            assert!(fit || value[i].is_nan() && gradient.iter().all(|g| g[i].is_nan()));
        }
        for periods in [1.0, -3.0, 64.0] {
            let moved: Vec<Vec<f32>> =
                p.iter().map(|p| p.iter().map(|x| x + periods * period(D) as f32).collect()).collect();
            let there = values(&table, Isa::detect(), &slices(&moved));
            // But for those points that the addition moved.
            let same = (0..300).filter(|&i| bits(&[value[i]]) == bits(&[there[i]])).count();
            assert!(same >= 290, "{D}-D: {same}");
        }
    }

    #[test]
    fn is_the_spline_of_its_definition() {
        check::<1>();
        check::<2>();
        check::<3>();
    }

    #[test]
    fn far_out_it_is_what_it_is_near() {
        let table = table::<3>();
        let of = |x: f32| values(&table, Isa::detect(), &[&[x], &[0.25], &[-7.5]])[0];
        for (far, near) in [
            (8_388_609.0, 1.0),
            (-8_388_609.0, 31.0),
            (1_048_576.5, 0.5),
            (-4_194_303.5, 0.5),
            (134_217_744.0, 16.0),
            (1e20, 0.0),
            (f32::MAX, 0.0),
            (f32::MIN, 0.0),
        ] {
            assert_eq!(of(far), of(near), "{far}");
        }
        assert_eq!(place::<3>(64 * 64 + 2), [2, 0, 1]);
    }
}
