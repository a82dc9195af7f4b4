//! The sums of impulses.
//!
//! Cells are taken in blocks of 32. Of each block come the first impulses of its cells, then the second, and so on.
//! A number of these every lane looks for (those that a cell has not are of size 0); from there on only lanes do
//! of which one of eight has any. Where runs of lanes in one cell share their impulses, those that reach none
//! of the run's points are left out. Either way a lane adds the same numbers in the same order, but for zeros.

// Loops over lanes and axes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::kernels::Profile;
use super::tile::{BLOCK, GROUP, Group, SPAN, Tile};
use super::waves::Turn;
use super::{Lookout, Near, Slot};
use crate::lanes::{Isa, Kernel};
use crate::noise::field::TILE;

/// Groups of lanes in a tile.
const GROUPS: usize = TILE / GROUP;
/// Groups of lanes, an impulse each, that are on their way to the sums together.
const BATCH: usize = 64;

/// The sums of a tile, with lanes for groups that begin anywhere.
pub(super) type Sums<const N: usize> = [[f32; TILE + GROUP]; N];

/// Impulses on their way to the sums, for each lane of each group one.
pub(super) struct Batch<const D: usize> {
    /// How many groups there are.
    pub count: usize,
    /// Whether all lanes of a group have the same impulse.
    pub alike: bool,
    /// Where in the tile each begins.
    lanes: [u8; BATCH],
    /// The offset of the impulse from the point, and its square.
    pub offsets: [[f32; BATCH * GROUP]; D],
    squares: [f32; BATCH * GROUP],
    /// The size of the impulse; then the value, or what of the derivative is along the offset.
    pub sizes: [f32; BATCH * GROUP],
    pub words: [u32; BATCH * GROUP],
    /// Where in their cycle its waves are at the point, in turns; then what of the derivative is along the waves.
    pub turns: [f32; BATCH * GROUP],
    pub waves: [[f32; BATCH * GROUP]; D],
}

/// Adds the impulses of a block of cells to the sums of a tile: to the value's sum if N is 1, or for D > 1 and
/// SLOPE to those of the derivative. WAVES tells whether kernels have any.
pub(super) struct Add<'a, const D: usize, const N: usize, const SLOPE: bool, const WAVES: bool> {
    pub isa: Isa,
    pub noise: &'a Lookout<D>,
    pub profile: &'a dyn Profile,
    pub tile: &'a Tile<D>,
    pub block: usize,
    pub sums: &'a mut Sums<N>,
}

impl<const D: usize, const N: usize, const SLOPE: bool, const WAVES: bool> Kernel
    for Add<'_, D, N, SLOPE, WAVES>
{
    type Output = ();
    #[inline(always)]
    fn run(mut self) {
        let mut batch = Batch {
            count: 0,
            alike: self.tile.shared(),
            lanes: [0; BATCH],
            offsets: [[0.0; BATCH * GROUP]; D],
            squares: [0.0; BATCH * GROUP],
            sizes: [0.0; BATCH * GROUP],
            words: [0; BATCH * GROUP],
            turns: [0.0; BATCH * GROUP],
            waves: [[0.0; BATCH * GROUP]; D],
        };
        if self.tile.shared() {
            self.add_shared(&mut batch);
        } else {
            self.add_always(&mut batch);
            self.add_asked(&mut batch);
        }
    }
}

impl<const D: usize, const N: usize, const SLOPE: bool, const WAVES: bool> Add<'_, D, N, SLOPE, WAVES> {
    /// Adds the impulses of runs.
    #[inline(always)]
    fn add_shared(&mut self, batch: &mut Batch<D>) {
        let (noise, tile) = (self.noise, self.tile);
        let near = noise.block(self.block);
        let mut begin = 0;
        for run in 0..tile.runs {
            let (from, to) = (tile.starts[run], tile.starts[run + 1]);
            for &at in &tile.list[begin..tile.ends[run]] {
                let (slot, cell) = (&noise.slots[usize::from(at) / BLOCK], usize::from(at) % BLOCK);
                let hash = [tile.hashes[cell][run]; GROUP];
                let seen = rows(tile, &near[cell]);
                for first in (from..to).step_by(GROUP) {
                    self.push(batch, slot, &hash, &seen, first, to - first);
                    if batch.count == BATCH {
                        self.flush(batch);
                    }
                }
            }
            begin = tile.ends[run];
        }
        self.flush(batch);
    }

    /// Adds the impulses for which every lane looks.
    #[inline(always)]
    fn add_always(&mut self, batch: &mut Batch<D>) {
        let (noise, tile) = (self.noise, self.tile);
        let work = tile.work.min(TILE);
        for slot in &noise.slots[..noise.always] {
            let slot = *slot;
            for (near, hash) in noise.block(self.block).iter().zip(&tile.hashes) {
                if batch.count + GROUPS > BATCH {
                    self.flush(batch);
                }
                let seen = rows(tile, near);
                for first in (0..work).step_by(GROUP) {
                    self.push(batch, &slot, group(hash, first), &seen, first, GROUP);
                }
            }
        }
        self.flush(batch);
    }

    /// Adds the other impulses, of which few lanes have any.
    #[inline(always)]
    fn add_asked(&mut self, batch: &mut Batch<D>) {
        let (noise, tile) = (self.noise, self.tile);
        let near = noise.block(self.block);
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
        let asked = &noise.slots[noise.always..];
        for (s, slot) in asked.iter().enumerate() {
            let slot = *slot;
            let next = asked.get(s + 1).map_or(i32::MAX, |slot| slot.above);
            let mut left = 0;
            for e in 0..count {
                let at = list[e % (GROUPS * BLOCK)];
                let (cell, first) = (usize::from(at) % BLOCK, usize::from(at) / BLOCK * GROUP);
                let hash = group(&tile.hashes[cell], first);
                self.push(batch, &slot, hash, &rows(tile, &near[cell]), first, GROUP);
                if batch.count == BATCH {
                    self.flush(batch);
                }
                list[left % (GROUPS * BLOCK)] = at;
                left += usize::from(hash.iter().fold(false, |any, hash| any | (*hash as i32 > next)));
            }
            count = left;
            if count == 0 {
                break;
            }
        }
        self.flush(batch);
    }

    /// Puts the impulses of a group of lanes into the batch; the cells have these hashes and are near `so`, and of the
    /// group only so many lanes are meant.
    #[inline(always)]
    fn push(
        &self,
        batch: &mut Batch<D>,
        slot: &Slot<D>,
        hash: &Group<u32>,
        seen: &[&[f32; TILE + GROUP]; D],
        first: usize,
        live: usize,
    ) {
        let seen: [&Group<f32>; D] = std::array::from_fn(|k| group(seen[k], first));
        let (mut offsets, mut squares, mut sizes) = ([[0.0; GROUP]; D], [0.0; GROUP], [0.0; GROUP]);
        for k in 0..D {
            for i in 0..GROUP {
                let x = hash[i].wrapping_mul(slot.place[k]) as i32 as f32 - seen[k][i];
                offsets[k][i] = x;
                squares[i] += x * x;
            }
        }
        for i in 0..GROUP {
            let size = hash[i].wrapping_mul(slot.size) as i32 as f32;
            sizes[i] = if hash[i] as i32 > slot.above { size } else { 0.0 };
        }
        if live < GROUP {
            sizes[live..].fill(0.0);
        }
        let at = batch.count % BATCH;
        batch.lanes[at] = first as u8;
        batch.squares[at * GROUP..(at + 1) * GROUP].copy_from_slice(&squares);
        batch.sizes[at * GROUP..(at + 1) * GROUP].copy_from_slice(&sizes);
        if SLOPE || WAVES {
            for k in 0..D {
                batch.offsets[k][at * GROUP..(at + 1) * GROUP].copy_from_slice(&offsets[k]);
            }
        }
        if WAVES {
            let words = hash.map(|hash| hash.wrapping_mul(slot.word));
            batch.words[at * GROUP..(at + 1) * GROUP].copy_from_slice(&words);
        }
        batch.count = at + 1;
    }

    /// Adds a batch to the sums.
    #[inline(always)]
    fn flush(&mut self, batch: &mut Batch<D>) {
        flush::<D, N, SLOPE, WAVES>(self.isa, self.noise, self.profile, batch, self.sums);
    }
}

/// Adds a batch to sums. (Once for all callers, hence not inlined.)
#[inline(never)]
fn flush<const D: usize, const N: usize, const SLOPE: bool, const WAVES: bool>(
    isa: Isa,
    noise: &Lookout<D>,
    profile: &dyn Profile,
    batch: &mut Batch<D>,
    sums: &mut Sums<N>,
) {
    if let Some(waves) = noise.waves {
        isa.run(Turn { waves, batch });
    }
    let len = batch.count * GROUP;
    let (squares, sizes) = (&batch.squares[..len], &mut batch.sizes[..len]);
    if SLOPE {
        profile.slopes(isa, squares, &mut batch.turns[..len], sizes);
    } else {
        profile.values(isa, squares, &batch.turns[..len], sizes);
    }
    isa.run(Gather::<D, N, SLOPE, WAVES> { batch, sums });
    batch.count = 0;
}

/// Adds what has been found of a batch to sums.
struct Gather<'a, const D: usize, const N: usize, const SLOPE: bool, const WAVES: bool> {
    batch: &'a Batch<D>,
    sums: &'a mut Sums<N>,
}

impl<const D: usize, const N: usize, const SLOPE: bool, const WAVES: bool> Kernel
    for Gather<'_, D, N, SLOPE, WAVES>
{
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Gather { batch, sums } = self;
        for (at, &first) in batch.lanes[..batch.count].iter().enumerate() {
            let first = usize::from(first) % TILE;
            let along = group(&batch.sizes, at * GROUP);
            for n in 0..N {
                let sums = &mut sums[n][first..first + GROUP];
                let mut parts = *along;
                if SLOPE {
                    let offset = group(&batch.offsets[n], at * GROUP);
                    for i in 0..GROUP {
                        parts[i] *= offset[i];
                    }
                }
                if SLOPE && WAVES {
                    let (waves, across) =
                        (group(&batch.waves[n], at * GROUP), group(&batch.turns, at * GROUP));
                    for i in 0..GROUP {
                        parts[i] += waves[i] * across[i];
                    }
                }
                for i in 0..GROUP {
                    parts[i] += sums[i];
                }
                sums.copy_from_slice(&parts);
            }
        }
    }
}

/// The points as seen from a cell.
#[inline(always)]
fn rows<'a, const D: usize>(tile: &'a Tile<D>, near: &Near<D>) -> [&'a [f32; TILE + GROUP]; D] {
    std::array::from_fn(|k| &tile.seen[k][usize::from(near[k]) % SPAN])
}

/// Lanes that go together.
#[inline(always)]
fn group<T>(lanes: &[T], first: usize) -> &Group<T> {
    lanes[first..first + GROUP].try_into().expect("so many")
}
