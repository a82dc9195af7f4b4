//! The sums of impulses.
//!
//! Cells are taken in blocks of 32. Of each block come the first impulses of its cells, then the second, and so on.
//! A number of these every lane looks for (those that a cell has not are of size 0); from there on only lanes do
//! of which one of eight has any. Where runs of lanes in one cell share their impulses, those that reach none
//! of the run's points are left out. Either way a lane adds the same numbers in the same order, but for zeros.

// Loops over lanes and axes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::kernels::Radial;
use super::tile::{BLOCK, GROUP, Group, Lanes, ROW, Tile};
use super::{Process, Profile, Slot, Waves, waves};
use crate::lanes::{Isa, Kernel, array};
use crate::noise::field::TILE;

/// Groups of lanes in a tile.
const GROUPS: usize = TILE / GROUP;

/// The sums of a tile, with lanes for groups that begin anywhere.
pub(super) type Sums<const N: usize> = [[f32; ROW]; N];

/// Impulses on their way to the sums, as many as a tile has lanes.
pub(super) struct Found<const D: usize> {
    /// Whether all lanes of a group have the same impulse.
    pub alike: bool,
    /// The offset of the impulse from the point, and its square.
    pub offsets: [Lanes<f32>; D],
    pub squares: Lanes<f32>,
    pub sizes: Lanes<f32>,
    pub words: Lanes<u32>,
    /// The waves along each axis, and where in their cycle they are at the point.
    pub waves: [Lanes<f32>; D],
    pub turns: Lanes<f32>,
}

/// What impulses add to N sums: that of the value, or with SLOPE those of the derivative.
pub(super) trait Part<const D: usize, const N: usize, const SLOPE: bool>: Copy {
    /// Whether it wants impulses' words, and their offsets for a value.
    const WAVES: bool;
    /// What so many impulses add. It may spoil them.
    fn parts(&self, isa: Isa, found: &mut Found<D>, count: usize, parts: &mut [Lanes<f32>; N]);
    /// Adds them to the sums of the first lanes.
    fn add(&self, isa: Isa, found: &mut Found<D>, count: usize, sums: &mut Sums<N>);
}

/// A kernel that is compiled into the loops.
#[derive(Clone, Copy)]
pub(super) struct Fused<R>(pub R);

impl<R: Radial, const D: usize, const N: usize, const SLOPE: bool> Part<D, N, SLOPE> for Fused<R> {
    const WAVES: bool = false;
    #[inline(always)]
    fn parts(&self, _: Isa, found: &mut Found<D>, count: usize, parts: &mut [Lanes<f32>; N]) {
        for i in 0..count.min(TILE) {
            if SLOPE {
                let slope = found.sizes[i] * self.0.slope(found.squares[i]);
                for n in 0..N {
                    parts[n][i] = slope * found.offsets[n][i];
                }
            } else {
                parts[0][i] = found.sizes[i] * self.0.value(found.squares[i]);
            }
        }
    }
    #[inline(always)]
    fn add(&self, _: Isa, found: &mut Found<D>, count: usize, sums: &mut Sums<N>) {
        for i in 0..count.min(TILE) {
            if SLOPE {
                let slope = found.sizes[i] * self.0.slope(found.squares[i]);
                for n in 0..N {
                    sums[n][i] += slope * found.offsets[n][i];
                }
            } else {
                sums[0][i] += found.sizes[i] * self.0.value(found.squares[i]);
            }
        }
    }
}

/// Any kernel.
#[derive(Clone, Copy)]
pub(super) struct Called<'a, const D: usize> {
    pub profile: &'a dyn Profile,
    pub waves: Option<Waves<D>>,
}

impl<const D: usize, const N: usize, const SLOPE: bool> Part<D, N, SLOPE> for Called<'_, D> {
    const WAVES: bool = true;
    #[inline(always)]
    fn parts(&self, isa: Isa, found: &mut Found<D>, count: usize, parts: &mut [Lanes<f32>; N]) {
        let count = count.min(TILE);
        if let Some(waves) = self.waves {
            waves::turn(isa, waves, found, count);
        }
        let (squares, turns, sizes) =
            (&found.squares[..count], &mut found.turns[..count], &mut found.sizes[..count]);
        if !SLOPE {
            self.profile.values(isa, squares, turns, sizes);
            parts[0][..count].copy_from_slice(sizes);
            return;
        }
        self.profile.slopes(isa, squares, turns, sizes);
        for n in 0..N {
            for i in 0..count {
                parts[n][i] = found.sizes[i] * found.offsets[n][i];
            }
            if self.waves.is_some() {
                for i in 0..count {
                    parts[n][i] += found.turns[i] * found.waves[n][i];
                }
            }
        }
    }
    #[inline(always)]
    fn add(&self, isa: Isa, found: &mut Found<D>, count: usize, sums: &mut Sums<N>) {
        let mut parts = [[0.0; TILE]; N];
        Part::<D, N, SLOPE>::parts(self, isa, found, count, &mut parts);
        for n in 0..N {
            for i in 0..count.min(TILE) {
                sums[n][i] += parts[n][i];
            }
        }
    }
}

impl<const D: usize> Slot<D> {
    /// Where the impulse of a cell with this hash is along an axis, from the middle of the cell.
    #[inline(always)]
    fn place(&self, hash: u32, axis: usize) -> f32 {
        hash.wrapping_mul(self.place[axis]) as i32 as f32
    }

    /// Its size; 0 if there is none.
    #[inline(always)]
    fn size(&self, hash: u32) -> f32 {
        let size = hash.wrapping_mul(self.size) as i32 as f32;
        if hash as i32 > self.above { size } else { 0.0 }
    }
}

/// Adds the impulses of a block of cells to the sums of a tile.
pub(super) struct Add<'a, P, const D: usize, const N: usize, const SLOPE: bool> {
    pub isa: Isa,
    pub process: &'a Process<D>,
    pub what: P,
    pub tile: &'a Tile<D>,
    pub block: usize,
    pub sums: &'a mut Sums<N>,
}

impl<P: Part<D, N, SLOPE>, const D: usize, const N: usize, const SLOPE: bool> Kernel
    for Add<'_, P, D, N, SLOPE>
{
    type Output = ();
    #[inline(always)]
    fn run(mut self) {
        let mut found = Found {
            alike: self.tile.shared(),
            offsets: [[0.0; TILE]; D],
            squares: [0.0; TILE],
            sizes: [0.0; TILE],
            words: [0; TILE],
            waves: [[0.0; TILE]; D],
            turns: [0.0; TILE],
        };
        if found.alike {
            self.add_shared(&mut found);
        } else {
            self.add_always(&mut found);
            self.add_asked(&mut found);
        }
    }
}

impl<P: Part<D, N, SLOPE>, const D: usize, const N: usize, const SLOPE: bool> Add<'_, P, D, N, SLOPE> {
    /// Adds the impulses for which every lane looks.
    #[inline(always)]
    fn add_always(&mut self, found: &mut Found<D>) {
        let (process, tile) = (self.process, self.tile);
        let work = tile.work.min(TILE);
        let mut sums = *self.sums;
        for slot in &process.slots[..process.always] {
            let slot = *slot;
            let near = process.block(self.block);
            for cell in 0..near.len().min(BLOCK) {
                let (seen, hash) = (tile.rows(&near[cell]), &tile.hashes[cell]);
                for i in 0..work {
                    let mut square = 0.0;
                    for k in 0..D {
                        let offset = slot.place(hash[i], k) - seen[k][i];
                        square += offset * offset;
                        if SLOPE || P::WAVES {
                            found.offsets[k][i] = offset;
                        }
                    }
                    found.squares[i] = square;
                    found.sizes[i] = slot.size(hash[i]);
                    if P::WAVES {
                        found.words[i] = hash[i].wrapping_mul(slot.word);
                    }
                }
                self.what.add(self.isa, found, work, &mut sums);
            }
        }
        *self.sums = sums;
    }

    /// Adds the other impulses, of which few lanes have any.
    #[inline(always)]
    fn add_asked(&mut self, found: &mut Found<D>) {
        let (process, tile) = (self.process, self.tile);
        let near = process.block(self.block);
        // Cells of which any lane of a group has more; the group is in the upper bits.
        let (mut list, mut count) = ([0_u8; GROUPS * BLOCK], 0);
        for first in (0..tile.work).step_by(GROUP) {
            let mut cells = (0..GROUP).fold(0, |cells, i| cells | tile.more[(first + i) % TILE]);
            while cells != 0 {
                list[count % (GROUPS * BLOCK)] = (first / GROUP * BLOCK) as u8 | cells.trailing_zeros() as u8;
                count += 1;
                cells &= cells - 1;
            }
        }
        let asked = &process.slots[process.always..];
        for (s, slot) in asked.iter().enumerate() {
            let slot = *slot;
            let next = asked.get(s + 1).map_or(i32::MAX, |slot| slot.above);
            let mut left = 0;
            for start in (0..count).step_by(GROUPS) {
                let (some, mut firsts) = ((count - start).min(GROUPS), [0; GROUPS]);
                for e in 0..some {
                    let at = list[(start + e) % (GROUPS * BLOCK)];
                    let (cell, first) = (usize::from(at) % BLOCK, usize::from(at) / BLOCK * GROUP);
                    let hash = group(&tile.hashes[cell], first);
                    let seen = array(|k| group(&tile.seen[k], usize::from(near[cell][k]) + first));
                    put::<P, D, N, SLOPE>(found, e, &slot, hash, seen);
                    firsts[e] = first;
                    list[left % (GROUPS * BLOCK)] = at;
                    let mut any = false;
                    for i in 0..GROUP {
                        any |= hash[i] as i32 > next;
                    }
                    left += usize::from(any);
                }
                self.add(found, some, &firsts);
            }
            count = left;
            if count == 0 {
                break;
            }
        }
    }

    /// Adds the impulses of runs.
    #[inline(always)]
    fn add_shared(&mut self, found: &mut Found<D>) {
        let (process, tile) = (self.process, self.tile);
        let near = process.block(self.block);
        let (mut some, mut firsts, mut begin) = (0, [0; GROUPS], 0);
        for run in 0..tile.runs {
            let (from, to) = (tile.starts[run], tile.starts[run + 1].min(TILE));
            let lanes = (to - from).next_multiple_of(GROUP).min(TILE);
            for &at in &tile.list[begin..tile.ends[run]] {
                if some + lanes / GROUP > GROUPS {
                    self.add(found, some, &firsts);
                    some = 0;
                }
                let (slot, cell) = (&process.slots[usize::from(at) / BLOCK], usize::from(at) % BLOCK);
                let hash = tile.hashes[cell][run];
                let place: [f32; D] = array(|k| slot.place(hash, k));
                let rows = tile.rows(&near[cell]);
                let seen: [&[f32]; D] = array(|k| &rows[k][from..from + lanes]);
                let here = some * GROUP..some * GROUP + lanes;
                let squares = &mut found.squares[here.clone()];
                let offsets = found.offsets.each_mut().map(|offsets| &mut offsets[here.clone()]);
                for i in 0..lanes {
                    let mut square = 0.0;
                    for k in 0..D {
                        let offset = place[k] - seen[k][i];
                        square += offset * offset;
                        if SLOPE || P::WAVES {
                            offsets[k][i] = offset;
                        }
                    }
                    squares[i] = square;
                }
                let (words, sizes) = (&mut found.words[here.clone()], &mut found.sizes[here]);
                let (word, size) = (hash.wrapping_mul(slot.word), slot.size(hash));
                for i in 0..lanes {
                    words[i] = word;
                    // Lanes after the run have other impulses.
                    sizes[i] = if i < to - from { size } else { 0.0 };
                }
                for first in (from..to).step_by(GROUP) {
                    firsts[some % GROUPS] = first;
                    some += 1;
                }
            }
            begin = tile.ends[run];
        }
        self.add(found, some, &firsts);
    }

    /// Adds the impulses of so many groups, of which the first lanes are given.
    #[inline(always)]
    fn add(&mut self, found: &mut Found<D>, groups: usize, firsts: &[usize; GROUPS]) {
        let mut parts = [[0.0; TILE]; N];
        self.what.parts(self.isa, found, groups * GROUP, &mut parts);
        for (e, first) in firsts[..groups].iter().enumerate() {
            let first = first % TILE;
            for n in 0..N {
                let part = group(&parts[n], e * GROUP);
                let sums = &mut self.sums[n][first..first + GROUP];
                for i in 0..GROUP {
                    sums[i] += part[i];
                }
            }
        }
    }
}

/// Puts an impulse of each lane of a group in place `e`, those of a slot of cells with these hashes.
#[inline(always)]
fn put<P: Part<D, N, SLOPE>, const D: usize, const N: usize, const SLOPE: bool>(
    found: &mut Found<D>,
    e: usize,
    slot: &Slot<D>,
    hash: &Group<u32>,
    seen: [&Group<f32>; D],
) {
    let first = e * GROUP;
    let (mut squares, mut sizes) = ([0.0; GROUP], [0.0; GROUP]);
    // Axis by axis, that the lanes of each are one vector.
    for k in 0..D {
        let mut offset = [0.0; GROUP];
        for i in 0..GROUP {
            offset[i] = slot.place(hash[i], k) - seen[k][i];
        }
        for i in 0..GROUP {
            squares[i] += offset[i] * offset[i];
        }
        if SLOPE || P::WAVES {
            *group_mut(&mut found.offsets[k], first) = offset;
        }
    }
    for i in 0..GROUP {
        sizes[i] = slot.size(hash[i]);
    }
    *group_mut(&mut found.squares, first) = squares;
    *group_mut(&mut found.sizes, first) = sizes;
    if P::WAVES {
        *group_mut(&mut found.words, first) = array(|i| hash[i].wrapping_mul(slot.word));
    }
}

/// Lanes that go together.
#[inline(always)]
fn group<T>(lanes: &[T], first: usize) -> &Group<T> {
    lanes[first..first + GROUP].try_into().expect("that many")
}

/// The same, to write to.
#[inline(always)]
fn group_mut<T>(lanes: &mut [T], first: usize) -> &mut Group<T> {
    (&mut lanes[first..first + GROUP]).try_into().expect("that many")
}
