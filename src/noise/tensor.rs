//! What is made of more lattice points than the corners of a cell: of the 4^D about a point.
//!
//! They are gone through row by row, a row being the four in a line along x, and for each row the lanes of a
//! tile. (Straight code for all of them, as for the corners of a cell, is slower and three times as long.)
//! Coordinates are cut and hashed as in `lattice`, where it says what comes of large and of infinite ones.

// Loops over axes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::field::{TILE, Tile, Tiled};
use super::hash;
use super::lattice::{Lattice, Wrap};
use crate::lanes::array;

/// An algorithm that adds up what each row of lattice points gives. Its functions must be
/// `#[inline(always)]`.
pub(super) trait Rows<const D: usize>: Send + Sync {
    /// Which lattice points are the same.
    type Wrap: Wrap<D>;
    /// The lattice.
    fn lattice(&self) -> &Lattice<Self::Wrap, D>;
    /// What the sum is multiplied by in the end.
    const SCALE: f32;
    /// What is asked, along one axis, of the lattice points at -1, 0, 1 and 2 for a point at 0 ≤ t < 1: their
    /// weights, say. It is computed beforehand rather than for each row.
    fn factors(t: f32) -> [f32; 4];
    /// What the derivative needs beside them.
    fn slopes(t: f32) -> [f32; 4];
    /// Whether rows that have corners of the cell in them give something else.
    const CORNERS: bool = false;
    /// What a row gives. Its points 1 and 2 are corners of the cell if `CORNERS`, which is never so if the
    /// constant above is false.
    fn part<const CORNERS: bool>(&self, row: &Row<D>) -> f32;
    /// Its derivative.
    fn derivative<const CORNERS: bool>(&self, row: &Row<D>) -> [f32; D];
}

/// Four lattice points in a line along x, as seen from a point.
pub(super) struct Row<const D: usize> {
    /// The line's place along the axes but the first, as seen from the lower corner: -1 to 2.
    pub place: [f32; D],
    /// Where in its cell the point is.
    pub t: [f32; D],
    /// The points' hashes.
    pub hashes: [u32; 4],
    /// The [`Rows::factors`] along x.
    pub factors: [f32; 4],
    /// The [`Rows::slopes`] along x.
    pub slopes: [f32; 4],
    /// The line's factors along the axes but the first.
    pub line_factors: [f32; D],
    /// And its slopes.
    pub line_slopes: [f32; D],
}

/// Such an algorithm, tile by tile.
pub(super) struct ByRows<A>(pub A);

/// What the lanes of a tile know of the four lattice points along each axis.
pub(super) struct Axes<const D: usize> {
    /// Where in its cell the point is.
    t: [[f32; TILE]; D],
    keys: [[[u32; TILE]; 4]; D],
    factors: [[[f32; TILE]; 4]; D],
    slopes: [[[f32; TILE]; 4]; D],
}

impl<const D: usize> Axes<D> {
    #[inline(always)]
    fn new() -> Axes<D> {
        Axes {
            t: [[0.0; TILE]; D],
            keys: [[[0; TILE]; 4]; D],
            factors: [[[0.0; TILE]; 4]; D],
            slopes: [[[0.0; TILE]; 4]; D],
        }
    }

    /// Fills the first lanes for these points.
    #[inline(always)]
    fn fill<A: Rows<D>, const SLOPES: bool>(&mut self, algorithm: &A, p: [&[f32; TILE]; D], work: usize) {
        // Axis by axis as code, not as a loop: what differs between axes is then known to the compiler.
        self.fill_axis::<A, SLOPES>(0, algorithm, p, work);
        if D > 1 {
            self.fill_axis::<A, SLOPES>(1, algorithm, p, work);
        }
        if D > 2 {
            self.fill_axis::<A, SLOPES>(2, algorithm, p, work);
        }
        if D > 3 {
            self.fill_axis::<A, SLOPES>(3, algorithm, p, work);
        }
    }

    #[inline(always)]
    fn fill_axis<A: Rows<D>, const SLOPES: bool>(
        &mut self,
        k: usize,
        algorithm: &A,
        p: [&[f32; TILE]; D],
        work: usize,
    ) {
        let lattice = algorithm.lattice();
        for i in 0..work {
            let low = p[k][i].floor();
            let t = p[k][i] - low;
            self.t[k][i] = t;
            self.keys[k][0][i] = lattice.key(k, low - 1.0);
            self.keys[k][1][i] = lattice.key(k, low);
            self.keys[k][2][i] = lattice.key(k, low + 1.0);
            self.keys[k][3][i] = lattice.key(k, low + 2.0);
            let [a, b, c, d] = A::factors(t);
            self.factors[k][0][i] = a;
            self.factors[k][1][i] = b;
            self.factors[k][2][i] = c;
            self.factors[k][3][i] = d;
            if SLOPES {
                let [a, b, c, d] = A::slopes(t);
                self.slopes[k][0][i] = a;
                self.slopes[k][1][i] = b;
                self.slopes[k][2][i] = c;
                self.slopes[k][3][i] = d;
            }
        }
    }

    /// What a lane sees of the row at a place.
    #[inline(always)]
    fn row(&self, place: [usize; D], i: usize) -> Row<D> {
        let mut line = 0;
        let (mut line_factors, mut line_slopes) = ([0.0; D], [0.0; D]);
        for k in 1..D {
            line ^= self.keys[k][place[k]][i];
            line_factors[k] = self.factors[k][place[k]][i];
            line_slopes[k] = self.slopes[k][place[k]][i];
        }
        let [a, b, c, d] = &self.keys[0];
        let hash = |key: u32| hash::point(key ^ line);
        let four = |[a, b, c, d]: &[[f32; TILE]; 4]| [a[i], b[i], c[i], d[i]];
        Row {
            place: array(|k| place[k] as f32 - 1.0),
            t: array(|k| self.t[k][i]),
            hashes: [hash(a[i]), hash(b[i]), hash(c[i]), hash(d[i])],
            factors: four(&self.factors[0]),
            slopes: four(&self.slopes[0]),
            line_factors,
            line_slopes,
        }
    }
}

/// The places of all rows, and whether each has corners of the cell in it.
#[inline(always)]
fn rows<const D: usize>() -> impl Iterator<Item = ([usize; D], bool)> {
    (0..1_usize << (2 * (D - 1))).map(|row| {
        let mut place = [0; D];
        let mut corners = true;
        for k in 1..D {
            // Below 4, as the compiler sees.
            place[k] = row >> (2 * (k - 1)) & 3;
            corners &= place[k] == 1 || place[k] == 2;
        }
        (place, corners)
    })
}

impl<A: Rows<D>, const D: usize> Tiled<D> for ByRows<A> {
    type Scratch = Axes<D>;
    #[inline(always)]
    fn scratch(&self) -> Axes<D> {
        Axes::new()
    }

    #[inline(always)]
    fn values(&self, axes: &mut Axes<D>, tile: Tile<'_, D>, out: &mut [f32; TILE]) {
        let work = tile.work();
        axes.fill::<A, false>(&self.0, tile.p, work);
        let mut sums = [0.0; TILE];
        for (place, corners) in rows() {
            if A::CORNERS && corners {
                for i in 0..work {
                    sums[i] += self.0.part::<true>(&axes.row(place, i));
                }
            } else {
                for i in 0..work {
                    sums[i] += self.0.part::<false>(&axes.row(place, i));
                }
            }
        }
        for i in 0..TILE {
            out[i] = sums[i] * A::SCALE;
        }
    }

    #[inline(always)]
    fn slopes(&self, axes: &mut Axes<D>, tile: Tile<'_, D>, out: &mut [[f32; TILE]; D]) {
        let work = tile.work();
        axes.fill::<A, true>(&self.0, tile.p, work);
        let mut sums = [[0.0; TILE]; D];
        for (place, corners) in rows() {
            if A::CORNERS && corners {
                for i in 0..work {
                    let part = self.0.derivative::<true>(&axes.row(place, i));
                    for k in 0..D {
                        sums[k][i] += part[k];
                    }
                }
            } else {
                for i in 0..work {
                    let part = self.0.derivative::<false>(&axes.row(place, i));
                    for k in 0..D {
                        sums[k][i] += part[k];
                    }
                }
            }
        }
        for k in 0..D {
            for i in 0..TILE {
                out[k][i] = sums[k][i] * A::SCALE;
            }
        }
    }
}

/// The weights of four values in a row, for a point at 0 ≤ t ≤ 1 between the inner two, in the Catmull-Rom
/// spline: the cubic through those two whose slope at each is half the difference of its neighbours.
#[inline(always)]
pub(super) fn catmull_rom(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [-0.5 * t * s * s, 1.0 + t * t * (1.5 * t - 2.5), t * (0.5 + t * (2.0 - 1.5 * t)), -0.5 * t * t * s]
}

/// The derivatives of the weights.
#[inline(always)]
pub(super) fn catmull_rom_slopes(t: f32) -> [f32; 4] {
    [t * (2.0 - 1.5 * t) - 0.5, t * (4.5 * t - 5.0), 0.5 + t * (4.0 - 4.5 * t), t * (1.5 * t - 1.0)]
}

/// The sum of products.
#[inline(always)]
pub(super) fn dot(a: [f32; 4], b: [f32; 4]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
}

impl<const D: usize> Row<D> {
    /// What the row gives to a tensor product whose weights are the factors, with a value for each point of
    /// it.
    #[inline(always)]
    pub(super) fn weigh(&self, values: [f32; 4]) -> f32 {
        (1..D).fold(dot(self.factors, values), |sum, k| sum * self.line_factors[k])
    }

    /// The derivative of that, the slopes being those of the factors.
    #[inline(always)]
    pub(super) fn weigh_slopes(&self, values: [f32; 4]) -> [f32; D] {
        let mut gradient = [dot(self.factors, values); D];
        gradient[0] = dot(self.slopes, values);
        for k in 1..D {
            for axis in 0..D {
                gradient[axis] *= if axis == k { self.line_slopes[k] } else { self.line_factors[k] };
            }
        }
        gradient
    }
}
