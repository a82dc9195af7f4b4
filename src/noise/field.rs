//! A noise ready to be evaluated, and the loop over lanes that most kinds share.

use crate::lanes::{Isa, Kernel, array};

/// An algorithm with its parameters, for points of some number of coordinates.
///
/// A lane's result depends on its own point only, and is the same bits on every instruction set and for any
/// number of lanes.
pub trait Field: Send + Sync {
    /// The noise at the point of each lane: a slice a coordinate.
    ///
    /// # Panics
    /// If there are not as many coordinates as the field was made for, or if lengths differ.
    fn noise(&self, isa: Isa, p: &[&[f32]], out: &mut [f32]);

    /// The derivative of [`Field::noise`] along each coordinate, in each lane.
    ///
    /// # Panics
    /// If there are not as many coordinates, or outputs, as the field was made for, or if lengths differ.
    fn derivative(&self, isa: Isa, p: &[&[f32]], out: &mut [&mut [f32]]);
}

/// A value and its derivative along each coordinate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jet<const D: usize> {
    pub value: f32,
    pub gradient: [f32; D],
}

/// An algorithm that treats one point like any other: straight code, which the compiler can run for a
/// vector of lanes at once. Its functions must be `#[inline(always)]`.
pub(super) trait Pointwise<const D: usize>: Send + Sync {
    /// The noise at a point.
    fn value(&self, p: [f32; D]) -> f32;
    /// The noise and its derivative at a point. (Where only one of the two is used, the compiler drops the
    /// other.)
    fn jet(&self, p: [f32; D]) -> Jet<D>;
}

/// The field of a pointwise algorithm.
pub(super) struct Each<A, const D: usize>(pub A);

impl<A: Pointwise<D>, const D: usize> Field for Each<A, D> {
    fn noise(&self, isa: Isa, p: &[&[f32]], out: &mut [f32]) {
        isa.run(Values { algorithm: &self.0, p: coordinates(p), out });
    }

    fn derivative(&self, isa: Isa, p: &[&[f32]], out: &mut [&mut [f32]]) {
        assert_eq!(out.len(), D, "derivatives of {D} coordinates");
        isa.run(Derivatives { algorithm: &self.0, p: coordinates(p), out });
    }
}

/// The coordinates of points, as many as a field was made for.
///
/// # Panics
/// If there are more or fewer.
pub(super) fn coordinates<'a, const D: usize>(p: &[&'a [f32]]) -> [&'a [f32]; D] {
    p.try_into().unwrap_or_else(|_| panic!("{} coordinates for a field of {D}", p.len()))
}

/// Lanes that are worked on at a time: their inputs and outputs lie on the stack, where the compiler
/// knows that they do not overlap.
pub(super) const TILE: usize = 64;
/// A tile is filled up to a multiple of the widest vector, so that no lane runs alone.
pub(super) const WIDTH: usize = 16;

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

struct Values<'a, A, const D: usize> {
    algorithm: &'a A,
    p: [&'a [f32]; D],
    out: &'a mut [f32],
}

impl<A: Pointwise<D>, const D: usize> Kernel for Values<'_, A, D> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        for (start, end) in tiles(self.out.len()) {
            let (p, work) = load(&self.p, start, end);
            let mut values = [0.0; TILE];
            for i in 0..work {
                values[i] = self.algorithm.value(array(|k| p[k][i]));
            }
            self.out[start..end].copy_from_slice(&values[..end - start]);
        }
    }
}

struct Derivatives<'a, 'b, A, const D: usize> {
    algorithm: &'a A,
    p: [&'a [f32]; D],
    out: &'a mut [&'b mut [f32]],
}

impl<A: Pointwise<D>, const D: usize> Kernel for Derivatives<'_, '_, A, D> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        for (start, end) in tiles(self.p[0].len()) {
            let (p, work) = load(&self.p, start, end);
            let mut gradients = [[0.0; TILE]; D];
            for i in 0..work {
                let jet = self.algorithm.jet(array(|k| p[k][i]));
                for (gradients, gradient) in gradients.iter_mut().zip(jet.gradient) {
                    gradients[i] = gradient;
                }
            }
            for (out, gradient) in self.out.iter_mut().zip(&gradients) {
                out[start..end].copy_from_slice(&gradient[..end - start]);
            }
        }
    }
}
