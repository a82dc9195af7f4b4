//! What lattice noises share: the cell about a point, its corners' hashes and the cubic interpolation.
//!
//! A lattice noise gives each lattice point a linear function, value + gradient · (p − point), and blends
//! those of the corners of the cell about p, first in x, then in y, then in z (Perlin 1985, "Noise()").
//! Fewer coordinates than three are the same noise with the others 0, bit for bit.
//!
//! - Coordinates are cut by `floor`, so cells are of the same size on both sides of zero.
//! - From ±2^23 on every f32 is an integer, so the point is a lattice point and noise is its value.
//! - NaN and infinities give NaN.

// Loops over axes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::direction::direction;
use super::hash;
use crate::lanes::{Isa, Kernel};

/// Lanes that are worked on at a time: their inputs and outputs lie on the stack, where the compiler
/// knows that they do not overlap.
pub(super) const TILE: usize = 64;
/// A tile is filled up to a multiple of the widest vector, so that no lane runs alone.
const WIDTH: usize = 8;

/// The linear functions of one algorithm. Their gradients are [`direction`]s.
pub trait Planes: Copy {
    /// What the whole is multiplied by, once in the end.
    const SCALE: f32;
    /// The value, at an offset from it, of the linear function of the lattice point with this hash.
    fn height<const D: usize>(hash: u32, offset: [f32; D]) -> f32;
}

/// A point within its cell.
#[derive(Clone, Copy)]
pub(super) struct Cell<const D: usize> {
    /// Hashes of the lower and the upper corner, by axis; those of the first axis with the seed.
    keys: [[u32; 2]; D],
    /// The point as seen from the lower and from the upper corner.
    offset: [[f32; 2]; D],
    /// The weight of the upper corner.
    weight: [f32; D],
    /// The derivative of the weight.
    slope: [f32; D],
}

/// The weighted mean.
#[inline(always)]
fn lerp(w: f32, a: f32, b: f32) -> f32 {
    a + w * (b - a)
}

impl<const D: usize> Cell<D> {
    /// Finds the cell of a point. `seed` must be mixed.
    #[inline(always)]
    pub(super) fn new(p: [f32; D], seed: u32) -> Cell<D> {
        let mut cell = Cell { keys: [[0; 2]; D], offset: [[0.0; 2]; D], weight: [0.0; D], slope: [0.0; D] };
        for k in 0..D {
            // The key of an integer is its own bit pattern: exact at any size, and no conversion can overflow.
            // Adding zero makes one of the two zeros.
            let low = p[k].floor() + 0.0;
            let high = low + 1.0;
            let seed = if k == 0 { seed } else { 0 };
            cell.keys[k] = [low, high].map(|key| hash::axis(key.to_bits(), k) ^ seed);
            let t = p[k] - low;
            cell.offset[k] = [t, t - 1.0];
            // 3t² - 2t³: 0 and 1 at the ends, with slopes 0.
            cell.weight[k] = t * t * (3.0 - 2.0 * t);
            cell.slope[k] = 6.0 * t * (1.0 - t);
        }
        cell
    }

    /// Hash and offset of a corner; bit k of its number tells which end of axis k it is at.
    #[inline(always)]
    fn corner(&self, corner: usize) -> (u32, [f32; D]) {
        // An axis that is not given counts as 0, whose hash is 0.
        let mut joined = 0;
        let mut offset = [0.0; D];
        for k in 0..D {
            joined ^= self.keys[k][corner >> k & 1];
            offset[k] = self.offset[k][corner >> k & 1];
        }
        (hash::point(joined), offset)
    }

    #[inline(always)]
    fn corner_value<P: Planes>(&self, corner: usize) -> f32 {
        let (hash, offset) = self.corner(corner);
        P::height(hash, offset)
    }

    // The blends of one more axis each. Straight code rather than loops over corners: a loop within
    // the loop over lanes would keep the latter from being vectorised.

    #[inline(always)]
    fn along_x<P: Planes>(&self, base: usize) -> f32 {
        lerp(self.weight[0], self.corner_value::<P>(base), self.corner_value::<P>(base + 1))
    }

    #[inline(always)]
    fn along_y<P: Planes>(&self, base: usize) -> f32 {
        lerp(self.weight[1 % D], self.along_x::<P>(base), self.along_x::<P>(base + 2))
    }

    #[inline(always)]
    fn along_z<P: Planes>(&self, base: usize) -> f32 {
        lerp(self.weight[2 % D], self.along_y::<P>(base), self.along_y::<P>(base + 4))
    }

    /// The noise at the point.
    #[inline(always)]
    pub(super) fn value<P: Planes>(&self) -> f32 {
        let sum = match D {
            1 => self.along_x::<P>(0),
            2 => self.along_y::<P>(0),
            3 => self.along_z::<P>(0),
            _ => lerp(self.weight[3 % D], self.along_z::<P>(0), self.along_z::<P>(8)),
        };
        sum * P::SCALE
    }

    #[inline(always)]
    fn corner_jet<P: Planes>(&self, corner: usize) -> Jet<D> {
        let (hash, offset) = self.corner(corner);
        Jet { value: P::height(hash, offset), gradient: direction(hash) }
    }

    /// Blends along an axis: to its own derivative the change of the weight adds.
    #[inline(always)]
    fn blend(&self, axis: usize, a: Jet<D>, b: Jet<D>) -> Jet<D> {
        let axis = axis % D;
        let w = self.weight[axis];
        let mut gradient = [0.0; D];
        for k in 0..D {
            gradient[k] = lerp(w, a.gradient[k], b.gradient[k]);
        }
        let step = b.value - a.value;
        gradient[axis] += self.slope[axis] * step;
        Jet { value: a.value + w * step, gradient }
    }

    #[inline(always)]
    fn jet_x<P: Planes>(&self, base: usize) -> Jet<D> {
        self.blend(0, self.corner_jet::<P>(base), self.corner_jet::<P>(base + 1))
    }

    #[inline(always)]
    fn jet_y<P: Planes>(&self, base: usize) -> Jet<D> {
        self.blend(1, self.jet_x::<P>(base), self.jet_x::<P>(base + 2))
    }

    #[inline(always)]
    fn jet_z<P: Planes>(&self, base: usize) -> Jet<D> {
        self.blend(2, self.jet_y::<P>(base), self.jet_y::<P>(base + 4))
    }

    /// The derivative of the noise at the point.
    #[inline(always)]
    fn gradient<P: Planes>(&self) -> [f32; D] {
        let jet = match D {
            1 => self.jet_x::<P>(0),
            2 => self.jet_y::<P>(0),
            3 => self.jet_z::<P>(0),
            _ => self.blend(3, self.jet_z::<P>(0), self.jet_z::<P>(8)),
        };
        jet.gradient.map(|g| g * P::SCALE)
    }
}

/// A value and its derivatives.
#[derive(Clone, Copy)]
struct Jet<const D: usize> {
    value: f32,
    gradient: [f32; D],
}

/// Copies up to [`TILE`] lanes of each coordinate, from lane `start`, and tells how many to work on.
#[inline(always)]
pub(super) fn load<const D: usize>(p: &[&[f32]; D], start: usize, end: usize) -> ([[f32; TILE]; D], usize) {
    let mut tile = [[0.0; TILE]; D];
    for (tile, p) in tile.iter_mut().zip(p) {
        tile[..end - start].copy_from_slice(&p[start..end]);
    }
    (tile, (end - start).next_multiple_of(WIDTH).min(TILE))
}

/// The tiles of so many lanes, as ranges.
#[inline(always)]
pub(super) fn tiles(lanes: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..lanes).step_by(TILE).map(move |start| (start, (start + TILE).min(lanes)))
}

/// The noise of D coordinates in each lane; all slices of one length.
///
/// # Panics
/// If the lengths differ.
pub fn noise<P: Planes, const D: usize>(isa: Isa, p: [&[f32]; D], seed: u32, out: &mut [f32]) {
    isa.run(Noise::<P, D> { p, seed: hash::seed(seed), out, planes: std::marker::PhantomData });
}

struct Noise<'a, P, const D: usize> {
    p: [&'a [f32]; D],
    seed: u32,
    out: &'a mut [f32],
    planes: std::marker::PhantomData<P>,
}

impl<P: Planes, const D: usize> Kernel for Noise<'_, P, D> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        for (start, end) in tiles(self.out.len()) {
            let (p, work) = load(&self.p, start, end);
            let mut values = [0.0; TILE];
            for i in 0..work {
                values[i] = Cell::<D>::new(std::array::from_fn(|k| p[k][i]), self.seed).value::<P>();
            }
            self.out[start..end].copy_from_slice(&values[..end - start]);
        }
    }
}

/// The derivative of [`noise`] along each of its D coordinates, in each lane; exact, not by differences.
///
/// # Panics
/// If the lengths differ.
pub fn gradient<P: Planes, const D: usize>(isa: Isa, p: [&[f32]; D], seed: u32, out: [&mut [f32]; D]) {
    isa.run(Gradient::<P, D> { p, seed: hash::seed(seed), out, planes: std::marker::PhantomData });
}

struct Gradient<'a, P, const D: usize> {
    p: [&'a [f32]; D],
    seed: u32,
    out: [&'a mut [f32]; D],
    planes: std::marker::PhantomData<P>,
}

impl<P: Planes, const D: usize> Kernel for Gradient<'_, P, D> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        for (start, end) in tiles(self.out[0].len()) {
            let (p, work) = load(&self.p, start, end);
            let mut gradients = [[0.0; TILE]; D];
            for i in 0..work {
                let gradient = Cell::<D>::new(std::array::from_fn(|k| p[k][i]), self.seed).gradient::<P>();
                for k in 0..D {
                    gradients[k][i] = gradient[k];
                }
            }
            for k in 0..D {
                self.out[k][start..end].copy_from_slice(&gradients[k][..end - start]);
            }
        }
    }
}
