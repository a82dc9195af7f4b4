//! The cells, their feature points, and the points of lanes within them.

// Loops over axes and lanes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::metric::lesser;
use crate::lanes::{Isa, Kernel, array};
use crate::noise::field::{TILE, load};
use crate::noise::lattice::{Endless, Lattice, Periodic};
use crate::noise::{Opt, Params, Unfit, hash, related_seed};

/// So that it has not the hashes of the other kinds of that seed.
const SALT: u32 = 0x4345_4C4C;

/// The cells and their feature points.
#[derive(Clone, Copy)]
pub struct Cells<const D: usize> {
    endless: Lattice<Endless, D>,
    periodic: Option<Lattice<Periodic<D>, D>>,
    /// The jitter, as a factor for signed integers.
    spread: f32,
    /// How deep within its cell's faces every feature point is.
    pub margin: f32,
}

/// A cell as seen from the point's own: four bits for each axis, where this is none off.
pub const OWN: i32 = 8;

/// How many cells off along an axis.
#[inline(always)]
fn off(cell: i32, axis: usize) -> f32 {
    ((cell >> (4 * axis) & 15) - OWN) as f32
}

impl<const D: usize> Cells<D> {
    /// Those of a user's seed, period and jitter.
    pub fn new(params: &Params) -> Result<Cells<D>, Unfit> {
        let jitter = params.number(Opt::Jitter, 1.0, 0.0..=1.0)?;
        let seed = related_seed(params.seed, SALT);
        Ok(Cells {
            endless: Lattice::new(seed, Endless),
            periodic: params.period::<D>()?.map(|period| Lattice::new(seed, Periodic(period))),
            spread: jitter / (1_u64 << 32) as f32,
            margin: 0.5 - 0.5 * jitter,
        })
    }

    /// The hash of a cell's coordinate, for [`hash::point`] together with those of the other axes.
    #[inline(always)]
    pub fn key(&self, axis: usize, at: f32) -> u32 {
        match &self.periodic {
            None => self.endless.key(axis, at),
            Some(lattice) => lattice.key(axis, at),
        }
    }

    /// [`Cells::key`] of each lane.
    #[inline(always)]
    fn keys(&self, axis: usize, at: &[f32; TILE]) -> [u32; TILE] {
        let mut keys = [0; TILE];
        // A loop each, that both be straight.
        match &self.periodic {
            None => (0..TILE).for_each(|i| keys[i] = self.endless.key(axis, at[i])),
            Some(lattice) => (0..TILE).for_each(|i| keys[i] = lattice.key(axis, at[i])),
        }
        keys
    }

    /// From a point to the feature point of the cell with this hash whose middle is `middle` away.
    #[inline(always)]
    pub fn away(&self, hash: u32, mut middle: [f32; D]) -> [f32; D] {
        let more = hash::more(hash);
        let bits = [hash, hash << 16, more, more << 16];
        for k in 0..D {
            middle[k] += bits[k] as i32 as f32 * self.spread;
        }
        middle
    }

    /// The hash of a cell of each lane, and the way to its feature point.
    pub fn recall(
        &self,
        isa: Isa,
        points: &Points<D>,
        cell: &[i32; TILE],
    ) -> ([u32; TILE], [[f32; TILE]; D]) {
        isa.run(Recall { cells: self, points, cell })
    }
}

struct Recall<'a, const D: usize> {
    cells: &'a Cells<D>,
    points: &'a Points<D>,
    cell: &'a [i32; TILE],
}

impl<const D: usize> Kernel for Recall<'_, D> {
    type Output = ([u32; TILE], [[f32; TILE]; D]);
    #[inline(always)]
    fn run(self) -> Self::Output {
        let mut hashes = [0; TILE];
        for k in 0..D {
            let at = array(|i| self.points.low[k][i] + off(self.cell[i], k));
            let keys = self.cells.keys(k, &at);
            for i in 0..TILE {
                hashes[i] ^= keys[i];
            }
        }
        let mut away = [[0.0; TILE]; D];
        for i in 0..TILE {
            hashes[i] = hash::point(hashes[i]);
            let middle = array(|k| (off(self.cell[i], k) + 0.5) - self.points.rest[k][i]);
            let vector = self.cells.away(hashes[i], middle);
            for k in 0..D {
                away[k][i] = vector[k];
            }
        }
        (hashes, away)
    }
}

/// The points of some lanes.
#[derive(Clone)]
pub struct Points<const D: usize> {
    /// Their cells.
    pub low: [[f32; TILE]; D],
    /// Where they are in these.
    pub rest: [[f32; TILE]; D],
    /// [`Cells::key`] of the cells before, at and after theirs along each axis.
    pub keys: [[[u32; TILE]; 3]; D],
    /// How many lanes to work on.
    pub work: usize,
}

impl<const D: usize> Points<D> {
    /// To be loaded.
    pub fn none() -> Points<D> {
        Points { low: [[0.0; TILE]; D], rest: [[0.0; TILE]; D], keys: [[[0; TILE]; 3]; D], work: 0 }
    }

    /// Takes up to [`TILE`] lanes, from lane `start`.
    pub fn load(&mut self, isa: Isa, cells: &Cells<D>, p: &[&[f32]; D], start: usize, end: usize) {
        isa.run(Load { points: self, cells, p, start, end });
    }

    /// How far the nearest face of its cell is from a point.
    #[inline(always)]
    pub fn to_face(&self, i: usize) -> f32 {
        let mut least = 0.5;
        for k in 0..D {
            least = lesser(least, lesser(self.rest[k][i], 1.0 - self.rest[k][i]));
        }
        least
    }
}

struct Load<'a, const D: usize> {
    points: &'a mut Points<D>,
    cells: &'a Cells<D>,
    p: &'a [&'a [f32]; D],
    start: usize,
    end: usize,
}

impl<const D: usize> Kernel for Load<'_, D> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let mut padded = [[0.0; TILE]; D];
        let tile = load(self.p, (self.start, self.end), &mut padded);
        let (mut low, mut rest) = ([[0.0; TILE]; D], [[0.0; TILE]; D]);
        for i in 0..TILE {
            let mut poison = 0.0;
            for k in 0..D {
                let x = tile.p[k][i];
                low[k][i] = x.floor();
                rest[k][i] = x - low[k][i];
                poison += rest[k][i] * 0.0;
            }
            // A NaN along one axis is one along all.
            for k in 0..D {
                rest[k][i] += poison;
            }
        }
        for k in 0..D {
            for (side, step) in [-1.0, 0.0, 1.0].into_iter().enumerate() {
                self.points.keys[k][side] = self.cells.keys(k, &array(|i| low[k][i] + step));
            }
        }
        (self.points.low, self.points.rest, self.points.work) = (low, rest, tile.work());
    }
}
