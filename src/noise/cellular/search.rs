//! The search for the feature points nearest to a point.
//!
//! It is exact. First it takes the 3^D cells about the point's own, many lanes at a time. All others are
//! behind the closest outer face of those, 1 … 1½ away; where what is sought is farther, which is seldom,
//! further cells follow, shell after shell, until the next is out of reach.

// Loops over axes and lanes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::cells::{Cells, OWN, Points};
use super::metric::{Metric, greater, lesser};
use crate::lanes::{Isa, Kernel, array};
use crate::noise::field::TILE;
use crate::noise::hash;
use std::marker::PhantomData;

/// The nearest feature points: bits of the measures of the distance to them, and their cells. The bits of
/// numbers not below 0 are in the order of the numbers, and those of a NaN without its sign come last. (As
/// integers they are compared in fewer steps.)
#[derive(Clone, Copy)]
pub struct Nearest<T> {
    pub first: T,
    pub second: T,
    pub first_cell: T,
    pub second_cell: T,
}

/// The bits of infinity: no feature point.
pub const NONE: i32 = 0x7F80_0000;

impl Nearest<i32> {
    /// Takes one more feature point into account. Of equally near ones, the one met first is the nearer.
    #[inline(always)]
    pub fn meet<const SECOND: bool, const WHICH: bool>(&mut self, measure: f32, cell: i32) {
        let measure = measure.abs().to_bits() as i32;
        if WHICH {
            if SECOND {
                let other = if measure < self.second { cell } else { self.second_cell };
                self.second_cell = if measure < self.first { self.first_cell } else { other };
            }
            self.first_cell = if measure < self.first { cell } else { self.first_cell };
        }
        if SECOND {
            self.second = self.second.min(self.first.max(measure));
        }
        self.first = self.first.min(measure);
    }

    /// The measure that is sought.
    #[inline(always)]
    fn sought(&self, second: bool) -> f32 {
        f32::from_bits(if second { self.second } else { self.first } as u32)
    }
}

impl Nearest<[i32; TILE]> {
    #[inline(always)]
    fn get(&self, i: usize) -> Nearest<i32> {
        Nearest {
            first: self.first[i],
            second: self.second[i],
            first_cell: self.first_cell[i],
            second_cell: self.second_cell[i],
        }
    }

    #[inline(always)]
    fn set<const SECOND: bool, const WHICH: bool>(&mut self, i: usize, lane: Nearest<i32>) {
        self.first[i] = lane.first;
        if SECOND {
            self.second[i] = lane.second;
        }
        if WHICH {
            self.first_cell[i] = lane.first_cell;
        }
        if SECOND && WHICH {
            self.second_cell[i] = lane.second_cell;
        }
    }
}

/// The feature points nearest to each lane: the second ones too if `second`, and their cells if `which`.
pub fn nearest<M: Metric, const D: usize>(
    isa: Isa,
    cells: &Cells<D>,
    points: &Points<D>,
    second: bool,
    which: bool,
) -> Nearest<[i32; TILE]> {
    let (mut nearest, unsure) = match (second, which) {
        (false, false) => isa.run(Near::<M, D, false, false> { cells, points, metric: PhantomData }),
        (false, true) => isa.run(Near::<M, D, false, true> { cells, points, metric: PhantomData }),
        (true, false) => isa.run(Near::<M, D, true, false> { cells, points, metric: PhantomData }),
        (true, true) => isa.run(Near::<M, D, true, true> { cells, points, metric: PhantomData }),
    };
    if let Some(unsure) = unsure {
        for i in (0..points.work).filter(|&i| unsure[i] != 0) {
            nearest.set::<true, true>(i, further::<M, D>(cells, points, i, 1, second, nearest.get(i)));
        }
    }
    nearest
}

/// The search of the nearest cells.
struct Near<'a, M, const D: usize, const SECOND: bool, const WHICH: bool> {
    cells: &'a Cells<D>,
    points: &'a Points<D>,
    metric: PhantomData<M>,
}

impl<M: Metric, const D: usize, const SECOND: bool, const WHICH: bool> Kernel
    for Near<'_, M, D, SECOND, WHICH>
{
    /// What was found; and, if there are any, the lanes for which that may not be all.
    type Output = (Nearest<[i32; TILE]>, Option<[i32; TILE]>);

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Near { cells, points, .. } = self;
        let work = points.work.min(TILE);
        let mut nearest = Nearest {
            first: [NONE; TILE],
            second: [NONE; TILE],
            first_cell: [0; TILE],
            second_cell: [0; TILE],
        };
        // Rows of three cells along the last axis.
        for row in 0..3_usize.pow(D as u32 - 1) {
            let (mut sides, mut left, mut cell) = ([0; D], row, 0);
            for k in 0..D - 1 {
                sides[k] = left % 3;
                left /= 3;
                cell |= (sides[k] as i32 + OWN - 1) << (4 * k);
            }
            for i in 0..work {
                let mut joined = 0;
                let mut middle = [0.0; D];
                for k in 0..D - 1 {
                    joined ^= points.keys[k][sides[k]][i];
                    middle[k] = (sides[k] as f32 - 0.5) - points.rest[k][i];
                }
                let mut lane = nearest.get(i);
                for side in 0..3 {
                    let hash = hash::point(joined ^ points.keys[D - 1][side][i]);
                    middle[D - 1] = (side as f32 - 0.5) - points.rest[D - 1][i];
                    let cell = cell | (side as i32 + OWN - 1) << (4 * (D - 1));
                    lane.meet::<SECOND, WHICH>(M::measure(cells.away(hash, middle)), cell);
                }
                nearest.set::<SECOND, WHICH>(i, lane);
            }
        }
        let mut unsure = [0; TILE];
        let mut any = 0;
        for i in 0..work {
            let sought = nearest.get(i).sought(SECOND);
            let beyond = sought > M::measure([points.to_face(i) + (1.0 + cells.margin)]);
            unsure[i] = i32::from(beyond & (sought < f32::INFINITY));
            any |= unsure[i];
        }
        (nearest, (any != 0).then_some(unsure))
    }
}

/// Goes on for one lane with cells more than `searched` off, until all others are farther than what was
/// found.
pub fn further<M: Metric, const D: usize>(
    cells: &Cells<D>,
    points: &Points<D>,
    i: usize,
    searched: i32,
    second: bool,
    nearest: Nearest<i32>,
) -> Nearest<i32> {
    let (low, rest) = (array(|k| points.low[k][i]), array(|k| points.rest[k][i]));
    let mut closest = [0.0; D];
    let mut least = 0.5;
    for k in (0..D).rev() {
        least = lesser(least, lesser(rest[k], 1.0 - rest[k]));
        closest[k] = least + cells.margin;
    }
    let mut shell =
        Shell { cells, low, rest, closest, middle: [0.0; D], gap: [0.0; D], size: searched, second, nearest };
    // (Four bits hold up to 7 off; nothing is ever so far.)
    while shell.size < OWN - 1 && shell.sought() > M::measure([shell.size as f32 + closest[0]]) {
        shell.size += 1;
        shell.along::<M>(0, 0, 0, false);
    }
    shell.nearest
}

/// The cells about a point that are `size` off along an axis, or several, and no more along any.
struct Shell<'a, const D: usize> {
    cells: &'a Cells<D>,
    low: [f32; D],
    rest: [f32; D],
    /// For the axes from each on, the least way to where feature points can be behind a face of the point's
    /// cell.
    closest: [f32; D],
    /// To the middle of a cell.
    middle: [f32; D],
    /// To the part of it where its feature point can be; 0 along the axes to come.
    gap: [f32; D],
    size: i32,
    second: bool,
    nearest: Nearest<i32>,
}

impl<const D: usize> Shell<'_, D> {
    fn sought(&self) -> f32 {
        self.nearest.sought(self.second)
    }

    /// Goes along an axis, and from all that is within reach along the next. Of the axes before, this has the
    /// hash, the number, and whether one was `size` off.
    fn along<M: Metric>(&mut self, axis: usize, joined: u32, cell: i32, outer: bool) {
        for off in -self.size..=self.size {
            let outer = outer || off.abs() == self.size;
            let last = axis == D - 1;
            if last && !outer {
                continue;
            }
            self.middle[axis] = (off as f32 + 0.5) - self.rest[axis];
            self.gap[axis] = greater(self.middle[axis].abs() - (0.5 - self.cells.margin), 0.0);
            if !outer {
                // One of the axes to come has to be, then.
                self.gap[axis + 1] = (self.size - 1) as f32 + self.closest[axis + 1];
            }
            // (Set back rather than done on a copy, which would wait for what was just written.)
            let gap = M::measure(self.gap);
            if !last {
                self.gap[axis + 1] = 0.0;
            }
            if gap >= self.sought() {
                continue;
            }
            let joined = joined ^ self.cells.key(axis, self.low[axis] + off as f32);
            let cell = cell | (off + OWN) << (4 * axis);
            if last {
                let away = self.cells.away(hash::point(joined), self.middle);
                self.nearest.meet::<true, true>(M::measure(away), cell);
            } else {
                self.along::<M>(axis + 1, joined, cell, outer);
            }
        }
        self.gap[axis] = 0.0;
    }
}
