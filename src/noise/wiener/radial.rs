//! Interpolation by any covariance over distance: C⁻¹η once a cell, then a sum of one covariance a neighbour.

// Loops over axes and neighbours index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::super::field::{TILE, Tile, Tiled, WIDTH};
use super::super::lattice::Lattice;
use super::cells::{Period, all_keys, differing, locate, value};
use super::solved::{Solved, along};
use super::table::Table;

/// The field, of `D` dimensions; `SIDE` is 2^D, `COUNT` 4^D.
pub(super) struct Radial<const D: usize, const SIDE: usize, const COUNT: usize> {
    pub lattice: Lattice<Period<D>, D>,
    pub solved: Solved<D, SIDE, COUNT>,
    /// What values are multiplied by.
    pub unit: f32,
}

/// What stands in the table for each lane: the polynomials, and the places in them.
struct Found {
    numbers: [u32; TILE],
    places: [f32; TILE],
    pieces: [[f32; 4]; TILE],
}

impl Found {
    #[inline(always)]
    fn nothing() -> Found {
        Found { numbers: [0; TILE], places: [0.0; TILE], pieces: [[0.0; 4]; TILE] }
    }
}

impl<const D: usize, const SIDE: usize, const COUNT: usize> Solved<D, SIDE, COUNT> {
    /// Finds the polynomials that tell the covariance of places in the cell with a neighbour.
    #[inline(always)]
    fn look_up(&self, n: usize, places: &[[f32; TILE]; D], work: usize, found: &mut Found) {
        for i in 0..work.min(TILE) {
            let mut square = 0.0;
            for axis in 0..D {
                let offset = places[axis][i] - self.places[axis][n];
                square += offset * offset;
            }
            (found.numbers[i], found.places[i]) = Table::entry(square * self.table.scale);
        }
        // One load each; apart from the arithmetic, which can then be that of vectors.
        for i in 0..work.min(TILE) {
            found.pieces[i] = *self.table.piece(found.numbers[i]);
        }
    }

    /// The covariances between places and neighbours.
    #[inline(always)]
    pub(super) fn covariances(&self, places: &[[f32; TILE]; D], work: usize, out: &mut [[f32; TILE]; COUNT]) {
        let mut found = Found::nothing();
        // Dummies must be finite, since they are multiplied by 0.
        *out = [[0.0; TILE]; COUNT];
        for &n in &self.neighbours {
            self.look_up(n, places, work, &mut found);
            for i in 0..work.min(TILE) {
                let ([a, b, c, d], x) = (found.pieces[i], found.places[i]);
                out[n][i] = a + x * (b + x * (c + x * d));
            }
        }
    }

    /// Adds up covariances times factors, which lanes share by cells.
    #[inline(always)]
    pub(super) fn sum(
        &self,
        factors: &[[f32; TILE]; COUNT],
        cells: &[u32; TILE],
        places: &[[f32; TILE]; D],
        work: usize,
        out: &mut [f32; TILE],
    ) {
        let mut found = Found::nothing();
        for &n in &self.neighbours {
            self.look_up(n, places, work, &mut found);
            for i in 0..work.min(TILE) {
                let ([a, b, c, d], x) = (found.pieces[i], found.places[i]);
                out[i] += factors[n][cells[i] as usize % TILE] * (a + x * (b + x * (c + x * d)));
            }
        }
    }

    /// Adds up the derivatives.
    #[inline(always)]
    pub(super) fn slopes(
        &self,
        factors: &[[f32; TILE]; COUNT],
        cells: &[u32; TILE],
        places: &[[f32; TILE]; D],
        work: usize,
        out: &mut [[f32; TILE]; D],
    ) {
        let mut found = Found::nothing();
        for &n in &self.neighbours {
            self.look_up(n, places, work, &mut found);
            for i in 0..work.min(TILE) {
                let ([_, b, c, d], x) = (found.pieces[i], found.places[i]);
                // The square's derivative is twice the offset.
                let slope = (b + x * (2.0 * c + x * (3.0 * d))) * (2.0 * self.table.scale);
                let slope = factors[n][cells[i] as usize % TILE] * slope;
                for axis in 0..D {
                    out[axis][i] += slope * (places[axis][i] - self.places[axis][n]);
                }
            }
        }
    }
}

/// Lanes in their cells, with C⁻¹η of each.
pub(super) struct Lanes<const D: usize, const COUNT: usize> {
    places: [[f32; TILE]; D],
    /// Which of the solutions is a lane's.
    cells: [u32; TILE],
    solutions: [[f32; TILE]; COUNT],
}

impl<const D: usize, const COUNT: usize> Lanes<D, COUNT> {
    #[inline(always)]
    fn new() -> Lanes<D, COUNT> {
        Lanes { places: [[0.0; TILE]; D], cells: [0; TILE], solutions: [[0.0; TILE]; COUNT] }
    }

    /// Finds the cells of points, and solves what they ask for, once for neighbouring lanes in one cell.
    #[inline(always)]
    fn find<const SIDE: usize>(&mut self, field: &Radial<D, SIDE, COUNT>, p: [&[f32; TILE]; D], work: usize) {
        let points = field.solved.points;
        let mut bases = [[0.0; TILE]; D];
        for axis in 0..D {
            for i in 0..work.min(TILE) {
                (bases[axis][i], self.places[axis][i]) = locate(points == 3, p[axis][i]);
            }
        }
        let mut count = 0;
        let differing = differing(&bases);
        for i in 0..work.min(TILE) {
            count += usize::from(i > 0 && differing[i] != 0);
            self.cells[i] = count as u32;
            // In place: no cell comes after its first lane.
            for axis in 0..D {
                bases[axis][count] = bases[axis][i];
            }
        }
        let count = (count + 1).next_multiple_of(WIDTH);
        let keys = all_keys(&field.lattice, &bases, count);
        for n in 0..COUNT {
            for i in 0..count.min(TILE) {
                let mut joined = 0;
                for axis in 0..D {
                    joined ^= keys[axis][along::<D>(points, n, axis)][i];
                }
                self.solutions[n][i] = value(joined) * field.unit;
            }
        }
        field.solved.solve(&mut self.solutions, count);
    }
}

impl<const D: usize, const SIDE: usize, const COUNT: usize> Tiled<D> for Radial<D, SIDE, COUNT> {
    type Scratch = Lanes<D, COUNT>;
    #[inline(always)]
    fn scratch(&self) -> Lanes<D, COUNT> {
        Lanes::new()
    }

    #[inline(always)]
    fn values(&self, lanes: &mut Lanes<D, COUNT>, tile: Tile<'_, D>, out: &mut [f32; TILE]) {
        lanes.find(self, tile.p, tile.work());
        let mut values = [0.0; TILE];
        self.solved.sum(&lanes.solutions, &lanes.cells, &lanes.places, tile.work(), &mut values);
        *out = values;
    }

    #[inline(always)]
    fn slopes(&self, lanes: &mut Lanes<D, COUNT>, tile: Tile<'_, D>, out: &mut [[f32; TILE]; D]) {
        lanes.find(self, tile.p, tile.work());
        *out = [[0.0; TILE]; D];
        self.solved.slopes(&lanes.solutions, &lanes.cells, &lanes.places, tile.work(), out);
    }
}
