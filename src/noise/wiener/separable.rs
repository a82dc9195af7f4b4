//! Interpolation by a covariance that is a product over axes: weights are products of one weight an axis.

// Loops over axes and lanes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::super::field::{TILE, Tile, Tiled};
use super::super::lattice::Lattice;
use super::cells::{self, Along, Period, Runs, keys, locate, value};
use super::weights::Weights;

/// The field, of `N` neighbours along each of `D` axes; `ROWS` is 4^(D-1).
pub(super) struct Separable<const D: usize, const ROWS: usize, const N: usize> {
    pub lattice: Lattice<Period<D>, D>,
    pub weights: Weights,
    /// What values are multiplied by.
    pub unit: f32,
}

/// Where the lanes of a tile lie, the weights of their neighbours, and how those change.
pub(super) struct Scratch<const D: usize> {
    bases: [[f32; TILE]; D],
    weights: Along<f32, D>,
    falls: Along<f32, D>,
}

/// Of a row of neighbours along the first axis, the place along another.
#[inline(always)]
fn place(row: usize, axis: usize) -> usize {
    row >> (2 * (axis - 1)) & 3
}

/// Where the values of neighbours come from. Whichever it is, values are the same, and so is what is made of them.
trait Source {
    /// That of the neighbour at a place of a row, in a lane.
    fn value(&self, row: usize, place: usize, lane: usize) -> f32;
}

/// The values about one cell, in which all lanes lie.
struct Known<const ROWS: usize>([[f32; 4]; ROWS]);

impl<const ROWS: usize> Source for Known<ROWS> {
    #[inline(always)]
    fn value(&self, row: usize, place: usize, _: usize) -> f32 {
        self.0[row][place]
    }
}

/// The keys of lanes in any cells, and what values are multiplied by.
struct Scattered<const D: usize> {
    keys: Along<u32, D>,
    unit: f32,
}

impl<const D: usize> Source for Scattered<D> {
    #[inline(always)]
    fn value(&self, row: usize, at: usize, lane: usize) -> f32 {
        let mut joined = 0;
        for axis in 1..D {
            joined ^= self.keys[axis][place(row, axis)][lane];
        }
        value(joined ^ self.keys[0][at][lane]) * self.unit
    }
}

/// Adds up values times weights.
#[inline(always)]
fn sum<S: Source, const D: usize, const ROWS: usize, const N: usize>(
    source: &S,
    w: &Along<f32, D>,
    (start, end): (usize, usize),
    out: &mut [f32; TILE],
) {
    for row in 0..ROWS {
        if (1..D).any(|axis| place(row, axis) >= N) {
            continue;
        }
        for i in start..end.min(TILE) {
            let mut sum = source.value(row, 0, i) * w[0][0][i];
            for k in 1..N {
                sum += source.value(row, k, i) * w[0][k][i];
            }
            for axis in 1..D {
                sum *= w[axis][place(row, axis)][i];
            }
            out[i] += sum;
        }
    }
}

/// Adds up their derivatives: along its own axis a weight gives way to its slope.
#[inline(always)]
fn slopes<S: Source, const D: usize, const ROWS: usize, const N: usize>(
    source: &S,
    w: &Along<f32, D>,
    s: &Along<f32, D>,
    (start, end): (usize, usize),
    out: &mut [[f32; TILE]; D],
) {
    for row in 0..ROWS {
        if (1..D).any(|axis| place(row, axis) >= N) {
            continue;
        }
        for i in start..end.min(TILE) {
            let first = source.value(row, 0, i);
            let (mut sum, mut slope) = (first * w[0][0][i], first * s[0][0][i]);
            for k in 1..N {
                let value = source.value(row, k, i);
                sum += value * w[0][k][i];
                slope += value * s[0][k][i];
            }
            let mut slopes = [sum; D];
            slopes[0] = slope;
            for axis in 1..D {
                let (weight, slope) = (w[axis][place(row, axis)][i], s[axis][place(row, axis)][i]);
                for k in 0..D {
                    slopes[k] *= if k == axis { slope } else { weight };
                }
            }
            for k in 0..D {
                out[k][i] += slopes[k];
            }
        }
    }
}

impl<const D: usize, const ROWS: usize, const N: usize> Separable<D, ROWS, N> {
    /// The values about a cell.
    #[inline(always)]
    fn about(&self, base: [f32; D]) -> Known<ROWS> {
        let mut along = [[0; 4]; D];
        for axis in 0..D {
            along[axis] = keys(&self.lattice, axis, base[axis]);
        }
        let mut joined = [[0; 4]; ROWS];
        for row in 0..ROWS {
            let mut others = 0;
            for axis in 1..D {
                others ^= along[axis][place(row, axis)];
            }
            for k in 0..4 {
                joined[row][k] = along[0][k] ^ others;
            }
        }
        let mut values = [[0.0; 4]; ROWS];
        for (values, joined) in values.as_flattened_mut().iter_mut().zip(joined.as_flattened()) {
            *values = value(*joined) * self.unit;
        }
        Known(values)
    }

    /// The keys of lanes.
    #[inline(always)]
    fn scattered(&self, bases: &[[f32; TILE]; D], work: usize) -> Scattered<D> {
        Scattered { keys: cells::all_keys(&self.lattice, bases, work), unit: self.unit }
    }

    /// Finds cells and weights.
    #[inline(always)]
    fn find(
        &self,
        p: [&[f32; TILE]; D],
        work: usize,
        bases: &mut [[f32; TILE]; D],
        weights: &mut Along<f32, D>,
    ) {
        for axis in 0..D {
            for i in 0..work {
                let (base, t) = locate(N == 3, p[axis][i]);
                bases[axis][i] = base;
                let w = self.weights.at::<N>(t);
                for k in 0..4 {
                    weights[axis][k][i] = w[k];
                }
            }
        }
    }
}

impl<const D: usize, const ROWS: usize, const N: usize> Tiled<D> for Separable<D, ROWS, N> {
    type Scratch = Scratch<D>;
    #[inline(always)]
    fn scratch(&self) -> Scratch<D> {
        let along = [[[0.0; TILE]; 4]; D];
        Scratch { bases: [[0.0; TILE]; D], weights: along, falls: along }
    }

    #[inline(always)]
    fn values(&self, scratch: &mut Scratch<D>, tile: Tile<'_, D>, out: &mut [f32; TILE]) {
        let Scratch { bases, weights, .. } = scratch;
        self.find(tile.p, tile.work(), bases, weights);
        let mut values = [0.0; TILE];
        let runs = Runs::new(bases, tile.lanes);
        if runs.are_long() {
            for run in runs.iter() {
                let known = self.about(cells::point(bases, run.0));
                sum::<_, D, ROWS, N>(&known, weights, run, &mut values);
            }
        } else {
            let scattered = self.scattered(bases, tile.work());
            sum::<_, D, ROWS, N>(&scattered, weights, (0, tile.work()), &mut values);
        }
        *out = values;
    }

    #[inline(always)]
    fn slopes(&self, scratch: &mut Scratch<D>, tile: Tile<'_, D>, out: &mut [[f32; TILE]; D]) {
        let Scratch { bases, weights, falls } = scratch;
        self.find(tile.p, tile.work(), bases, weights);
        for axis in 0..D {
            for i in 0..tile.work() {
                let s = self.weights.slopes::<N>(locate(N == 3, tile.p[axis][i]).1);
                for k in 0..4 {
                    falls[axis][k][i] = s[k];
                }
            }
        }
        *out = [[0.0; TILE]; D];
        let runs = Runs::new(bases, tile.lanes);
        if runs.are_long() {
            for run in runs.iter() {
                let known = self.about(cells::point(bases, run.0));
                slopes::<_, D, ROWS, N>(&known, weights, falls, run, out);
            }
        } else {
            let scattered = self.scattered(bases, tile.work());
            slopes::<_, D, ROWS, N>(&scattered, weights, falls, (0, tile.work()), out);
        }
    }
}
