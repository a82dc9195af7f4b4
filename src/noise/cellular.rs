//! Cellular noise: Worley, "A Cellular Texture Basis Function", SIGGRAPH 96.
//!
//! Feature points are scattered through space. Noise tells of the one nearest to a point: its distance F1;
//! that of the second nearest, F2; the difference of the two, which is 0 where the regions of two feature
//! points meet; or a random number for each such region. Worley scatters a Poisson number of feature points
//! over each unit cell. Here each cell has one, anywhere in it or, with `jitter` below 1, in a smaller cube
//! about its middle; so no cell is crowded and none is empty.
//!
//! - Cells are cut by `floor`, and positions are relative to a cell: no digits are lost far out.
//! - From ±2^23 on every f32 is a corner of cells; from ±2^24 on neighbouring cells cannot be told apart.
//! - NaN and infinities give NaN.

// Loops over lanes index several arrays at once.
#![allow(clippy::needless_range_loop)]

mod cells;
mod metric;
mod search;
#[cfg(test)]
mod tests;

use super::field::{Field, TILE, coordinates, tiles};
use super::hash;
use super::kind::{Contract, Kind, Made, Smoothness};
use super::options::{Opt, Params};
use crate::lanes::{Isa, Kernel, array};
use cells::{Cells, Points};
use metric::{Chebyshev, Euclidean, Manhattan, Metric};
use search::{NONE, Nearest, nearest};
use std::marker::PhantomData;
use std::sync::Arc;

/// Cellular noise, 1996.
pub static KIND: Kind = Kind {
    name: "cellular",
    brief: "distances to scattered points: cells, stones, scales",
    dimensions: 1..=4,
    options: &[Opt::Period, Opt::Feature, Opt::Metric, Opt::Jitter],
    contract: Contract {
        // A point's own cell has a feature point, at most the diagonal √D away. That far it is from a corner
        // of cells that all have their feature points in the corners opposite.
        bounds: &[[0.0, 1.0], [0.0, 1.4143], [0.0, 1.7321], [0.0, 2.0]],
        mean: 0.520,
        deviation: 0.172,
        lattice: "a distance as elsewhere, of mean 0.54",
        smoothness: Smoothness::C0,
        cost: 3.5,
        source: "Worley 1996",
        remarks: "One feature point a cell, and the search for the nearest is exact. Mean and standard \
            deviation (never below 0, so the mean is not 0):\n\n\
            | feature | metric | 2-D | 3-D | up to, in D dimensions |\n\
            |---|---|---|---|---|\n\
            | F1 | euclidean | 0.430, 0.190 | 0.520, 0.172 | √D |\n\
            | F1 | manhattan | 0.541, 0.241 | 0.765, 0.256 | D |\n\
            | F1 | chebyshev | 0.382, 0.169 | 0.421, 0.140 | 1 |\n\
            | F2 | euclidean | 0.699, 0.176 | 0.717, 0.143 | 1.5, √2.5, √3, 2 |\n\
            | F2 | manhattan | 0.876, 0.223 | 1.051, 0.213 | 1.5, 2, 3, 4 |\n\
            | F2 | chebyshev | 0.621, 0.160 | 0.579, 0.117 | 1.5 |\n\
            | F2-F1 | euclidean | 0.269, 0.201 | 0.197, 0.158 | as F2 |\n\
            | F2-F1 | manhattan | 0.336, 0.251 | 0.287, 0.232 | as F2 |\n\
            | F2-F1 | chebyshev | 0.240, 0.180 | 0.158, 0.128 | as F2 |\n\
            | id | any | 0.5, 0.289 | 0.5, 0.289 | 1, exclusive |\n\n\
            Of 12 million points all had an F1 below 1.25 (euclidean, 2 to 4 dimensions). A step changes F1 \
            and F2 by its length at most, in the metric. At a feature point their derivative is 0; that of id \
            is 0, though it jumps between regions. Manhattan has to search farther: F1 takes twice as long, \
            F2 five times.",
    },
    make: |dimensions, params| match dimensions {
        1 => make::<1>(params),
        2 => make::<2>(params),
        3 => make::<3>(params),
        _ => make::<4>(params),
    },
};

fn make<const D: usize>(params: &Params) -> Made {
    let cells = Cells::<D>::new(params)?;
    let feature = [Feature::F1, Feature::F2, Feature::Difference, Feature::Id][params.choice(Opt::Feature)];
    Ok(match params.choice(Opt::Metric) {
        0 => Arc::new(Cellular::<Euclidean, D> { cells, feature, metric: PhantomData }),
        1 => Arc::new(Cellular::<Manhattan, D> { cells, feature, metric: PhantomData }),
        _ => Arc::new(Cellular::<Chebyshev, D> { cells, feature, metric: PhantomData }),
    })
}

/// What is told of the feature points.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Feature {
    F1,
    F2,
    Difference,
    Id,
}

/// A field of cellular noise. It is made of small kernels: a large one for each metric, feature and number of
/// dimensions would be much code.
struct Cellular<M, const D: usize> {
    cells: Cells<D>,
    feature: Feature,
    metric: PhantomData<M>,
}

impl<M: Metric, const D: usize> Field for Cellular<M, D> {
    fn noise(&self, isa: Isa, p: &[&[f32]], out: &mut [f32]) {
        let p = coordinates(p);
        let mut points = Points::none();
        for (start, end) in tiles(out.len()) {
            points.load(isa, &self.cells, &p, start, end);
            let (feature, second) = (self.feature, matches!(self.feature, Feature::F2 | Feature::Difference));
            let nearest = nearest::<M, D>(isa, &self.cells, &points, second, feature == Feature::Id);
            let values = match feature {
                Feature::Id => {
                    let hashes = self.cells.recall(isa, &points, &nearest.first_cell).0;
                    isa.run(Ids { nearest: &nearest, hashes: &hashes })
                }
                _ => isa.run(Lengths::<M> { nearest: &nearest, feature, metric: PhantomData }),
            };
            out[start..end].copy_from_slice(&values[..end - start]);
        }
    }

    fn derivative(&self, isa: Isa, p: &[&[f32]], out: &mut [&mut [f32]]) {
        assert_eq!(out.len(), D, "derivatives of {D} coordinates");
        let p = coordinates(p);
        // The distance shrinks along the way to a feature point.
        let (first, second) = match self.feature {
            Feature::F1 => (-1.0, 0.0),
            Feature::F2 => (0.0, -1.0),
            Feature::Difference => (1.0, -1.0),
            Feature::Id => (0.0, 0.0),
        };
        let mut points = Points::none();
        for (start, end) in tiles(p[0].len()) {
            points.load(isa, &self.cells, &p, start, end);
            let nearest = nearest::<M, D>(isa, &self.cells, &points, second != 0.0, true);
            let mut slopes = [[0.0; TILE]; D];
            for (factor, cells) in [(first, &nearest.first_cell), (second, &nearest.second_cell)] {
                if factor != 0.0 {
                    let away = &self.cells.recall(isa, &points, cells).1;
                    slopes = isa.run(Slopes::<M, D> { slopes, away, factor, metric: PhantomData });
                }
            }
            for (out, slopes) in out.iter_mut().zip(&slopes) {
                let slopes = isa.run(Unless { nearest: &nearest, values: slopes });
                out[start..end].copy_from_slice(&slopes[..end - start]);
            }
        }
    }
}

/// Values of the features that are lengths.
struct Lengths<'a, M> {
    nearest: &'a Nearest<[i32; TILE]>,
    feature: Feature,
    metric: PhantomData<M>,
}

impl<M: Metric> Kernel for Lengths<'_, M> {
    type Output = [f32; TILE];
    #[inline(always)]
    fn run(self) -> [f32; TILE] {
        let mut values = [0.0; TILE];
        for i in 0..TILE {
            let first = M::length(f32::from_bits(self.nearest.first[i] as u32));
            let second = M::length(f32::from_bits(self.nearest.second[i] as u32));
            values[i] = match self.feature {
                Feature::F1 => first,
                Feature::F2 => second,
                _ => second - first,
            };
        }
        Unless { nearest: self.nearest, values: &values }.run()
    }
}

/// Random numbers of cells with these hashes.
struct Ids<'a> {
    nearest: &'a Nearest<[i32; TILE]>,
    hashes: &'a [u32; TILE],
}

impl Kernel for Ids<'_> {
    type Output = [f32; TILE];
    #[inline(always)]
    fn run(self) -> [f32; TILE] {
        let mut values = [0.0; TILE];
        for i in 0..TILE {
            // 24 bits, all that an f32 below 1 can tell apart.
            values[i] = (hash::mix(self.hashes[i]) >> 8) as f32 * (1.0 / (1 << 24) as f32);
        }
        Unless { nearest: self.nearest, values: &values }.run()
    }
}

/// Adds the derivatives of lengths, times a factor.
struct Slopes<'a, M, const D: usize> {
    slopes: [[f32; TILE]; D],
    away: &'a [[f32; TILE]; D],
    factor: f32,
    metric: PhantomData<M>,
}

impl<M: Metric, const D: usize> Kernel for Slopes<'_, M, D> {
    type Output = [[f32; TILE]; D];
    #[inline(always)]
    fn run(self) -> [[f32; TILE]; D] {
        let mut slopes = self.slopes;
        for i in 0..TILE {
            let slope = M::slope::<D>(array(|k| self.away[k][i]));
            for k in 0..D {
                slopes[k][i] += self.factor * slope[k];
            }
        }
        slopes
    }
}

/// Values, or NaN where there is no nearest feature point.
struct Unless<'a> {
    nearest: &'a Nearest<[i32; TILE]>,
    values: &'a [f32; TILE],
}

impl Kernel for Unless<'_> {
    type Output = [f32; TILE];
    #[inline(always)]
    fn run(self) -> [f32; TILE] {
        let mut values = [0.0; TILE];
        for i in 0..TILE {
            values[i] = if self.nearest.first[i] < NONE { self.values[i] } else { f32::NAN };
        }
        values
    }
}
