//! Where points lie, and the random values of the lattice points about them.

// Loops over axes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::super::field::TILE;
use super::super::hash;
use super::super::lattice::{Lattice, Periodic, Wrap};

/// A period or none. (Cells are new seldom enough to ask each time, and code for each would be twice as long.)
#[derive(Clone, Copy)]
pub(super) struct Period<const D: usize>(pub Option<[f32; D]>);

impl<const D: usize> Wrap<D> for Period<D> {
    #[inline(always)]
    fn wrap(&self, low: f32, axis: usize) -> f32 {
        match self.0 {
            None => low,
            Some(period) => Periodic(period).wrap(low, axis),
        }
    }
}

/// The lattice point that a coordinate is seen from, and the place relative to it: the one below and
/// 0 … 1, as four neighbours take it, or the nearest one and -½ … ½, as three. (A 1 is there too: what a tiny
/// negative number rounds to.)
#[inline(always)]
pub(super) fn locate(nearest: bool, x: f32) -> (f32, f32) {
    let low = x.floor();
    let t = x - low;
    // Not floor(x + ½): half of the sums beyond 2^22 would be rounded.
    let upper = nearest & (t >= 0.5);
    (if upper { low + 1.0 } else { low }, if upper { t - 1.0 } else { t })
}

/// The standard deviation of [`value`].
pub(super) const VALUE_DEVIATION: f64 = 37_837.227_234; // √((2^32 - 1) / 3)
/// The largest [`value`], and with the other sign the least.
pub(super) const VALUE_MOST: f64 = 131_070.0;

/// The value of a lattice point: the sum of four even numbers of 16 bits, which is nearly gaussian (the fourth
/// moment is 2.7 instead of 3 squared variances), less its mean.
#[inline(always)]
pub(super) fn value(joined: u32) -> f32 {
    let h = hash::point(joined);
    let m = hash::more(h);
    let sum = (h >> 16) + (h & 0xffff) + (m >> 16) + (m & 0xffff);
    sum as i32 as f32 - VALUE_MOST as f32
}

/// The keys of the neighbours of a lattice point along an axis, from -1 on.
#[inline(always)]
pub(super) fn keys<const D: usize>(lattice: &Lattice<Period<D>, D>, axis: usize, base: f32) -> [u32; 4] {
    let mut keys = [0; 4];
    for i in 0..4 {
        keys[i] = lattice.key(axis, base + (i as f32 - 1.0));
    }
    keys
}

/// For each axis, and each neighbour along it, something a lane.
pub(super) type Along<T, const D: usize> = [[[T; TILE]; 4]; D];

/// The keys of the neighbours of the lattice point of each lane.
#[inline(always)]
pub(super) fn all_keys<const D: usize>(
    lattice: &Lattice<Period<D>, D>,
    bases: &[[f32; TILE]; D],
    work: usize,
) -> Along<u32, D> {
    let mut all = [[[0; TILE]; 4]; D];
    for axis in 0..D {
        for k in 0..4 {
            for i in 0..work.min(TILE) {
                all[axis][k][i] = lattice.key(axis, bases[axis][i] + (k as f32 - 1.0));
            }
        }
    }
    all
}

/// For each lane but the first, 0 if it lies in the cell of the lane before. (Of the two zeros one is another cell,
/// which does no harm.)
#[inline(always)]
pub(super) fn differing<const D: usize>(bases: &[[f32; TILE]; D]) -> [u32; TILE] {
    let mut differing = [0; TILE];
    for axis in 0..D {
        for i in 1..TILE {
            differing[i] |= bases[axis][i].to_bits() ^ bases[axis][i - 1].to_bits();
        }
    }
    differing
}

/// Neighbouring lanes of a tile that lie in one cell.
pub(super) struct Runs {
    /// Where each begins; then where the last one ends.
    starts: [u8; TILE + 1],
    count: usize,
}

impl Runs {
    /// Finds those of so many lanes.
    #[inline(always)]
    pub(super) fn new<const D: usize>(bases: &[[f32; TILE]; D], lanes: usize) -> Runs {
        let differing = differing(bases);
        let (mut starts, mut count) = ([0; TILE + 1], 1);
        for i in 1..lanes.min(TILE) {
            starts[count] = i as u8;
            count += usize::from(differing[i] != 0);
        }
        starts[count] = lanes as u8;
        Runs { starts, count }
    }

    /// Are there so few that it is worth while to treat each on its own?
    #[inline(always)]
    pub(super) fn are_long(&self) -> bool {
        4 * self.count <= usize::from(self.starts[self.count])
    }

    /// Each, from the first lane to before the last.
    #[inline(always)]
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, usize)> {
        self.starts[..=self.count].windows(2).map(|run| (usize::from(run[0]), usize::from(run[1])))
    }
}

/// The coordinates of a lane.
#[inline(always)]
pub(super) fn point<const D: usize>(coordinates: &[[f32; TILE]; D], lane: usize) -> [f32; D] {
    let mut point = [0.0; D];
    for axis in 0..D {
        point[axis] = coordinates[axis][lane];
    }
    point
}
