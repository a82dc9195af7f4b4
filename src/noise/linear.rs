//! The noise of linear functions on a lattice.
//!
//! The noises of Perlin give each lattice point a linear function, value + gradient · (p − point), and blend
//! those of the corners of the cell about p (Perlin 1985, "Noise()"). Fewer coordinates than three are the same
//! noise with the others 0, bit for bit.
//!
//! The components of a gradient are bit fields of the lattice point's hash, each even in -1 … 1: gradients are even
//! in a cube. Their mean square is that of directions even on a sphere, the same along every line, and a spectrum
//! depends on nothing else of them; but they need neither a square root nor a sine.
//!
//! - Coordinates are cut by `floor`, so cells are of the same size on both sides of zero.
//! - From ±2^22 on, where an f32 knows halves of a cell at most, cells need not join, and two neighbouring lattice
//!   points may be alike. From ±2^23 on every f32 is an integer, so the point is a lattice point and noise is its
//!   value.
//! - NaN and infinities give NaN.

// Loops over axes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::field::{Jet, TILE, Tile, Tiled, WIDTH};
use super::hash;
use super::lattice::{Lattice, Wrap};
use crate::lanes::array;

/// What the noises differ in. Its functions must be `#[inline(always)]`.
pub(super) trait Planes: Copy + Send + Sync {
    /// What the whole is multiplied by, components of gradients being even in -1 … 1.
    const SCALE: f32;
    /// Values of lattice points are even in -VALUE … VALUE.
    const VALUE: f32;
    /// Whether [`Planes::offsets`] have other derivatives than 1.
    const STRETCHES: bool = false;
    /// The weight of the upper corner along an axis, at t from the lower one, and its derivative.
    #[inline(always)]
    fn weight(t: f32) -> (f32, f32) {
        // 3t² - 2t³: 0 and 1 at the ends, with slopes 0.
        (t * t * (3.0 - (t + t)), 6.0 * t * (1.0 - t))
    }
    /// The offsets along an axis from the lower and the upper corner that the linear functions are taken at.
    #[inline(always)]
    fn offsets(t: f32) -> [f32; 2] {
        [t, t - 1.0]
    }
    /// The derivatives of the offsets.
    #[inline(always)]
    fn stretches(_: f32) -> [f32; 2] {
        [1.0; 2]
    }
}

/// A noise of linear functions on a lattice.
#[derive(Clone, Copy)]
pub(super) struct Linear<P, W, const D: usize> {
    wrap: W,
    /// What the seed adds to the keys along each axis.
    seeds: [u32; 4],
    planes: std::marker::PhantomData<P>,
}

/// What the corners of a cell need to know of a point in it.
struct Cell<const D: usize> {
    /// The factors of the corners' hashes: of both ends along x and y, and of both along z and w.
    columns: [u32; 4],
    stacks: [u32; 4],
    /// The point as seen from the lower corner.
    t: [f32; D],
}

/// The cells of a tile. They are found in a loop of their own: in one loop with the corners the chain of operations
/// from point to noise is too long for the processor to work on several of them at once.
#[repr(align(64))]
pub(super) struct Cells<const D: usize> {
    columns: [[u32; TILE]; 4],
    stacks: [[u32; TILE]; 4],
    t: [[f32; TILE]; D],
}

impl<const D: usize> Cells<D> {
    #[inline(always)]
    fn set(&mut self, i: usize, cell: Cell<D>) {
        for c in 0..Cell::<D>::COLUMNS {
            self.columns[c][i] = cell.columns[c];
        }
        for c in 0..Cell::<D>::STACKS {
            self.stacks[c][i] = cell.stacks[c];
        }
        for k in 0..D {
            self.t[k][i] = cell.t[k];
        }
    }

    #[inline(always)]
    fn get(&self, i: usize) -> Cell<D> {
        Cell {
            columns: array(|c| self.columns[c & (Cell::<D>::COLUMNS - 1)][i]),
            stacks: array(|c| self.stacks[c & (Cell::<D>::STACKS - 1)][i]),
            t: array(|k| self.t[k][i]),
        }
    }
}

impl<P: Planes, W: Wrap<D>, const D: usize> Linear<P, W, D> {
    /// What components of gradients are multiplied by: of four each is shorter, so that gradients are as long as in three
    /// dimensions.
    const LENGTH: f32 = if D == 4 { 0.866_025_4 } else { 1.0 };
    /// What the sum over corners is multiplied by in the end: random numbers stay integers until then.
    const SCALE: f32 = P::SCALE * Self::LENGTH / (1_u32 << 31) as f32;
    /// What the values of lattice points are multiplied by before.
    const VALUE: f32 = P::VALUE / Self::LENGTH;

    /// On this lattice.
    pub(super) fn new(lattice: Lattice<W, D>) -> Self {
        let seeds = std::array::from_fn(|axis| lattice.seed(axis));
        Linear { wrap: lattice.wrapping(), seeds, planes: std::marker::PhantomData }
    }

    /// The keys of the lower and of the upper corner along an axis; of one that is not given, which counts as 0, both
    /// are the same.
    #[inline(always)]
    fn keys(&self, low: &[f32; D], axis: usize) -> [u32; 2] {
        let ends = if axis < D { self.wrap.ends(low[axis % D], axis) } else { [hash::whole(0.0); 2] };
        array(|end| hash::key(ends[end], axis).wrapping_add(self.seeds[axis]))
    }

    #[inline(always)]
    fn cell(&self, p: [f32; D]) -> Cell<D> {
        let low: [f32; D] = array(|k| p[k].floor());
        let t: [f32; D] = array(|k| p[k] - low[k]);
        let (x, y, z) = (self.keys(&low, 0), self.keys(&low, 1), self.keys(&low, 2));
        let w = if D > 3 { self.keys(&low, 3) } else { [0; 2] };
        Cell {
            columns: array(|c| hash::column(x[c & 1] ^ y[c >> 1])),
            stacks: array(|c| hash::stack(z[c & 1] ^ w[c >> 1])),
            t,
        }
    }
}

/// A random integer as a number.
#[inline(always)]
fn number(bits: u32) -> f32 {
    bits as i32 as f32
}

impl<const D: usize> Cell<D> {
    /// How many columns and stacks differ.
    const COLUMNS: usize = if D == 1 { 2 } else { 4 };
    const STACKS: usize = [1, 1, 1, 2, 4][D];

    /// The hash of a corner. Bit k of the corner's number is its end along axis k.
    #[inline(always)]
    fn hash(&self, corner: usize) -> u32 {
        self.columns[corner & 3].wrapping_mul(self.stacks[corner >> 2])
    }

    /// Blends what the corners give, axis after axis.
    #[inline(always)]
    fn blended<T>(&self, corner: impl Fn(usize) -> T, blend: impl Fn(usize, T, T) -> T) -> T {
        let line = |c: usize| blend(0, corner(c), corner(c + 1));
        let square = |c: usize| if D > 1 { blend(1 % D, line(c), line(c + 2)) } else { line(c) };
        let cube = |c: usize| if D > 2 { blend(2 % D, square(c), square(c + 4)) } else { square(c) };
        if D > 3 { blend(3 % D, cube(0), cube(8)) } else { cube(0) }
    }
}

/// The weighted mean.
#[inline(always)]
fn lerp(w: f32, a: f32, b: f32) -> f32 {
    a + w * (b - a)
}

/// The gradient of a lattice point: bit fields of its hash. Those after the first begin where the one before has its
/// eleventh bit, in four dimensions its eighth.
#[inline(always)]
fn gradient<const D: usize>(hash: u32) -> [f32; D] {
    let bits = if D == 4 { 8 } else { 11 };
    array(|k| number(hash << (bits * k)))
}

/// The value of a lattice point.
#[inline(always)]
fn value(hash: u32) -> f32 {
    number(hash.wrapping_mul(hash::FURTHER))
}

impl<P: Planes, W: Wrap<D>, const D: usize> Linear<P, W, D> {
    #[inline(always)]
    fn find(&self, cells: &mut Cells<D>, tile: Tile<'_, D>) {
        let mut first = 0;
        while first < tile.work() {
            for i in first..first + WIDTH {
                cells.set(i % TILE, self.cell(array(|k| tile.p[k][i % TILE])));
            }
            first += WIDTH;
        }
    }

    #[inline(always)]
    fn value(cell: Cell<D>) -> f32 {
        let offsets: [[f32; 2]; D] = array(|k| P::offsets(cell.t[k]));
        let weights: [f32; D] = array(|k| P::weight(cell.t[k]).0);
        let height = |c: usize| {
            let hash = cell.hash(c);
            let gradient = gradient::<D>(hash);
            let mut sum = gradient[0] * offsets[0][c & 1];
            for k in 1..D {
                sum += gradient[k] * offsets[k][c >> k & 1];
            }
            if Self::VALUE == 0.0 { sum } else { sum + value(hash) * Self::VALUE }
        };
        cell.blended(height, |k, a, b| lerp(weights[k], a, b))
    }

    #[inline(always)]
    fn jet(cell: Cell<D>) -> Jet<D> {
        let offsets: [[f32; 2]; D] = array(|k| P::offsets(cell.t[k]));
        let stretches: [[f32; 2]; D] = array(|k| P::stretches(cell.t[k]));
        let weights: [(f32, f32); D] = array(|k| P::weight(cell.t[k]));
        let corner = |c: usize| {
            let hash = cell.hash(c);
            let mut gradient = gradient::<D>(hash);
            let mut sum = gradient[0] * offsets[0][c & 1];
            for k in 1..D {
                sum += gradient[k] * offsets[k][c >> k & 1];
            }
            if Self::VALUE != 0.0 {
                sum += value(hash) * Self::VALUE;
            }
            if P::STRETCHES {
                for k in 0..D {
                    gradient[k] *= stretches[k][c >> k & 1];
                }
            }
            Jet { value: sum, gradient }
        };
        // To the derivative along the axis of a blend the change of the weight adds.
        let blend = |k: usize, a: Jet<D>, b: Jet<D>| {
            let (weight, slope) = weights[k];
            let mut gradient: [f32; D] = array(|j| lerp(weight, a.gradient[j], b.gradient[j]));
            let step = b.value - a.value;
            gradient[k] += slope * step;
            Jet { value: a.value + weight * step, gradient }
        };
        cell.blended(corner, blend)
    }
}

impl<P: Planes, W: Wrap<D>, const D: usize> Tiled<D> for Linear<P, W, D> {
    type Scratch = Cells<D>;
    #[inline(always)]
    fn scratch(&self) -> Cells<D> {
        Cells { columns: [[0; TILE]; 4], stacks: [[0; TILE]; 4], t: [[0.0; TILE]; D] }
    }

    #[inline(always)]
    fn values(&self, cells: &mut Cells<D>, tile: Tile<'_, D>, out: &mut [f32; TILE]) {
        self.find(cells, tile);
        let (mut values, mut first) = ([0.0; TILE], 0);
        while first < tile.work() {
            for i in first..first + WIDTH {
                values[i % TILE] = Self::value(cells.get(i % TILE));
            }
            first += WIDTH;
        }
        for i in 0..TILE {
            out[i] = values[i] * Self::SCALE;
        }
    }

    #[inline(always)]
    fn slopes(&self, cells: &mut Cells<D>, tile: Tile<'_, D>, out: &mut [[f32; TILE]; D]) {
        self.find(cells, tile);
        let (mut slopes, mut first) = ([[0.0; TILE]; D], 0);
        while first < tile.work() {
            for i in first..first + WIDTH {
                let jet = Self::jet(cells.get(i % TILE));
                for k in 0..D {
                    slopes[k][i % TILE] = jet.gradient[k];
                }
            }
            first += WIDTH;
        }
        for k in 0..D {
            for i in 0..TILE {
                out[k][i] = slopes[k][i] * Self::SCALE;
            }
        }
    }
}
