//! A noise ready to be evaluated, and the loops over lanes that the kinds share.

// Loops over lanes and axes index several arrays at once.
#![allow(clippy::needless_range_loop)]

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

/// Lanes that are computed at a time.
pub(super) const TILE: usize = 64;
/// The lanes of a tile are computed in groups as wide as the widest vector.
pub(super) const WIDTH: usize = 16;

/// The points of a tile. The lanes after the last one hold finite numbers.
#[derive(Clone, Copy)]
pub(super) struct Tile<'a, const D: usize> {
    /// A row for each coordinate.
    pub p: [&'a [f32; TILE]; D],
    /// How many lanes are asked for.
    pub lanes: usize,
}

impl<const D: usize> Tile<'_, D> {
    /// How many lanes to compute: whole groups of [`WIDTH`].
    #[inline(always)]
    pub fn work(&self) -> usize {
        self.lanes.next_multiple_of(WIDTH).min(TILE)
    }
}

/// An algorithm that computes a tile at a time. Its functions must be `#[inline(always)]`. The compiler does not know that
/// `out` does not overlap with what is read, so loops should not write to it more than once.
pub(super) trait Tiled<const D: usize>: Send + Sync {
    /// What the tiles of a call use one after another.
    type Scratch;
    /// Makes it.
    fn scratch(&self) -> Self::Scratch;
    /// The noise in each lane.
    fn values(&self, scratch: &mut Self::Scratch, tile: Tile<'_, D>, out: &mut [f32; TILE]);
    /// Its derivative along each coordinate.
    fn slopes(&self, scratch: &mut Self::Scratch, tile: Tile<'_, D>, out: &mut [[f32; TILE]; D]);
}

/// The field of an algorithm that computes tiles.
pub(super) struct ByTiles<A, const D: usize>(pub A);

impl<A: Tiled<D>, const D: usize> Field for ByTiles<A, D> {
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

/// The tiles of so many lanes, as ranges.
#[inline(always)]
pub(super) fn tiles(lanes: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..lanes.div_ceil(TILE)).map(move |tile| (tile * TILE, ((tile + 1) * TILE).min(lanes)))
}

/// The tile of these lanes. A tile that is not full is copied to `padded`.
#[inline(always)]
pub(super) fn load<'a, const D: usize>(
    p: &[&'a [f32]; D],
    (start, end): (usize, usize),
    padded: &'a mut [[f32; TILE]; D],
) -> Tile<'a, D> {
    let lanes = end - start;
    if lanes < TILE {
        for k in 0..D {
            padded[k][..lanes].copy_from_slice(&p[k][start..end]);
        }
    }
    let padded = &*padded;
    let row = |k: usize| p[k][start..end].try_into().unwrap_or(&padded[k]);
    Tile { p: array(row), lanes }
}

/// A row for these lanes of `out`, or where they are no whole row, `spare`, of which [`finish`] copies the lanes.
#[inline(always)]
fn row<'a>(
    out: &'a mut [f32],
    (start, end): (usize, usize),
    spare: &'a mut [f32; TILE],
) -> &'a mut [f32; TILE] {
    if end - start == TILE { (&mut out[start..end]).try_into().expect("a row") } else { spare }
}

/// Copies the lanes of a row that is not whole.
#[inline(always)]
fn finish(out: &mut [f32], (start, end): (usize, usize), spare: &[f32; TILE]) {
    if end - start < TILE {
        out[start..end].copy_from_slice(&spare[..end - start]);
    }
}

struct Values<'a, A, const D: usize> {
    algorithm: &'a A,
    p: [&'a [f32]; D],
    out: &'a mut [f32],
}

impl<A: Tiled<D>, const D: usize> Kernel for Values<'_, A, D> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let (mut padded, mut values) = ([[0.0; TILE]; D], [0.0; TILE]);
        let mut scratch = self.algorithm.scratch();
        for lanes in tiles(self.out.len()) {
            let tile = load(&self.p, lanes, &mut padded);
            self.algorithm.values(&mut scratch, tile, row(self.out, lanes, &mut values));
            finish(self.out, lanes, &values);
        }
    }
}

struct Derivatives<'a, 'b, A, const D: usize> {
    algorithm: &'a A,
    p: [&'a [f32]; D],
    out: &'a mut [&'b mut [f32]],
}

impl<A: Tiled<D>, const D: usize> Kernel for Derivatives<'_, '_, A, D> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let (mut padded, mut slopes) = ([[0.0; TILE]; D], [[0.0; TILE]; D]);
        let mut scratch = self.algorithm.scratch();
        for lanes in tiles(self.p[0].len()) {
            let tile = load(&self.p, lanes, &mut padded);
            self.algorithm.slopes(&mut scratch, tile, &mut slopes);
            for k in 0..D {
                self.out[k][lanes.0..lanes.1].copy_from_slice(&slopes[k][..lanes.1 - lanes.0]);
            }
        }
    }
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

/// A pointwise algorithm, tile by tile.
pub(super) struct Each<A>(pub A);

/// The lanes of a row from `first` on, as many as a group has.
#[inline(always)]
pub(super) fn group(row: &[f32; TILE], first: usize) -> &[f32; WIDTH] {
    row[first..first + WIDTH].try_into().expect("a group")
}

/// The same, to write to.
#[inline(always)]
pub(super) fn group_mut(row: &mut [f32; TILE], first: usize) -> &mut [f32; WIDTH] {
    (&mut row[first..first + WIDTH]).try_into().expect("a group")
}

impl<A: Pointwise<D>, const D: usize> Tiled<D> for Each<A> {
    type Scratch = ();
    #[inline(always)]
    fn scratch(&self) {}

    #[inline(always)]
    fn values(&self, (): &mut (), tile: Tile<'_, D>, out: &mut [f32; TILE]) {
        let mut first = 0;
        while first < tile.work() {
            let p: [&[f32; WIDTH]; D] = array(|k| group(tile.p[k], first));
            let mut values = [0.0; WIDTH];
            for i in 0..WIDTH {
                values[i] = self.0.value(array(|k| p[k][i]));
            }
            *group_mut(out, first) = values;
            first += WIDTH;
        }
    }

    #[inline(always)]
    fn slopes(&self, (): &mut (), tile: Tile<'_, D>, out: &mut [[f32; TILE]; D]) {
        let mut first = 0;
        while first < tile.work() {
            let p: [&[f32; WIDTH]; D] = array(|k| group(tile.p[k], first));
            let mut slopes = [[0.0; WIDTH]; D];
            for i in 0..WIDTH {
                let jet = self.0.jet(array(|k| p[k][i]));
                for k in 0..D {
                    slopes[k][i] = jet.gradient[k];
                }
            }
            for k in 0..D {
                *group_mut(&mut out[k], first) = slopes[k];
            }
            first += WIDTH;
        }
    }
}
