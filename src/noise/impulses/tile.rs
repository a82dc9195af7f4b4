//! What is known of the lanes of a tile, whatever the kernel: their cells, and the impulses that can reach them.

// Loops over lanes and axes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::{MOST, Near, Process, REACH, UNIT};
use crate::lanes::{Isa, Kernel, array};
use crate::noise::field::{TILE, load};
use crate::noise::hash;

/// Lanes that go together.
pub(super) const GROUP: usize = 8;
/// Cells that are looked at together: a bit each of a word.
pub(super) const BLOCK: usize = 32;
/// A row of lanes; those at the end are for groups that begin anywhere.
pub(super) const ROW: usize = TILE + GROUP;
/// The rows for the cells of a line that matter to a point.
const ROWS: usize = (2 * REACH + 1) * ROW;
/// If runs are of so many lanes on average, their impulses are found once.
const LONG: usize = 3;

/// Numbers of a tile's lanes.
pub(super) type Lanes<T> = [T; TILE];
/// Numbers of lanes that go together.
pub(super) type Group<T> = [T; GROUP];

/// The lanes of a tile.
pub(super) struct Tile<const D: usize> {
    /// How many there are, filled up to whole groups.
    pub work: usize,
    /// What makes the sums of lanes NaN that have no place; else 0.
    pub poison: Lanes<f32>,
    /// Where in its cell a point is, 0 … 1.
    within: [Lanes<f32>; D],
    /// The points, as seen from the middles of the cells in a line about theirs, in [`UNIT`]s: a row a cell.
    pub seen: [[f32; ROWS]; D],
    /// The hashes of the coordinates of those cells.
    keys: [[u32; ROWS]; D],
    /// The hashes of a block of cells.
    pub hashes: [Lanes<u32>; BLOCK],
    /// Which of those cells have impulses that are asked for.
    pub more: Lanes<u32>,
    /// Runs of lanes in one cell: where each starts; after the last where that ends.
    pub starts: [usize; TILE + 1],
    /// How many runs there are.
    pub runs: usize,
    /// If runs are shared, the impulses of the block that may reach points of the first run, of the second, …: the
    /// cell, and the slot in the upper bits.
    pub list: Vec<u16>,
    /// Where in the list those of each run end.
    pub ends: [usize; TILE],
}

impl<const D: usize> Tile<D> {
    pub(super) fn new() -> Tile<D> {
        Tile {
            work: 0,
            poison: [0.0; TILE],
            within: [[0.0; TILE]; D],
            seen: [[0.0; ROWS]; D],
            keys: [[0; ROWS]; D],
            hashes: [[0; TILE]; BLOCK],
            more: [0; TILE],
            starts: [0; TILE + 1],
            runs: 0,
            list: vec![],
            ends: [0; TILE],
        }
    }

    /// Whether the impulses of runs are found once.
    pub(super) fn shared(&self) -> bool {
        self.runs * LONG <= self.starts[self.runs]
    }

    /// The points as seen from a cell.
    #[inline(always)]
    pub(super) fn rows(&self, near: &Near<D>) -> [&[f32; ROW]; D] {
        array(|k| {
            let seen = &self.seen[k][usize::from(near[k])..];
            seen[..ROW].try_into().expect("that many")
        })
    }

    /// How many sets of cells there are: of runs, or of lanes.
    #[inline(always)]
    fn sets(&self) -> usize {
        if self.shared() { self.runs.next_multiple_of(GROUP) } else { self.work }
    }
}

/// Finds the cells of some lanes. (Once for all kernels, hence not inlined.)
#[inline(never)]
pub(super) fn locate<const D: usize>(
    isa: Isa,
    process: &Process<D>,
    tile: &mut Tile<D>,
    p: &[&[f32]; D],
    start: usize,
    end: usize,
) {
    isa.run(Locate { process, tile, p, start, end });
}

struct Locate<'a, 'b, const D: usize> {
    process: &'a Process<D>,
    tile: &'a mut Tile<D>,
    p: &'a [&'b [f32]; D],
    start: usize,
    end: usize,
}

impl<const D: usize> Kernel for Locate<'_, '_, D> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Locate { process, tile, p, start, end } = self;
        let mut padded = [[0.0; TILE]; D];
        let points = load(p, (start, end), &mut padded);
        let (p, work) = (points.p, points.work());
        let (mut low, mut within, mut poison) = ([[0.0; TILE]; D], [[0.0; TILE]; D], [0.0; TILE]);
        for i in 0..work {
            for k in 0..D {
                let q = p[k][i] * process.cells;
                low[k][i] = q.floor();
                // Counted in cells a finite coordinate may be infinite.
                within[k][i] = if low[k][i] == q { 0.0 } else { q - low[k][i] };
                poison[i] += p[k][i] * 0.0;
            }
        }
        (tile.work, tile.poison, tile.within) = (work, poison, within);
        let mut other = [1_u8; TILE];
        for i in 1..work {
            other[i] = 1 - (0..D).fold(1, |same, k| same & u8::from(low[k][i] == low[k][i - 1]));
        }
        let mut runs = 0;
        for i in 0..(end - start).min(TILE) {
            // Overwritten if none starts here.
            tile.starts[runs % TILE] = i;
            runs += usize::from(other[i]);
        }
        tile.starts[runs.min(TILE)] = end - start;
        tile.runs = runs;
        if tile.shared() {
            for (run, &start) in tile.starts[..tile.runs].iter().enumerate() {
                for low in &mut low {
                    low[run] = low[start];
                }
            }
        }
        let sets = tile.sets();
        for k in 0..D {
            for s in 0..2 * process.reach + 1 {
                let step = s as f32 - process.reach as f32;
                let (mut seen, mut keys) = ([0.0; TILE], [0; TILE]);
                for i in 0..work {
                    seen[i] = (within[k][i] - (step + 0.5)) * (1.0 / UNIT);
                }
                if let Some(lattice) = &process.periodic {
                    for i in 0..sets {
                        keys[i] = lattice.key(k, low[k][i] + step);
                    }
                } else {
                    for i in 0..sets {
                        keys[i] = process.lattice.key(k, low[k][i] + step);
                    }
                }
                tile.seen[k][s * ROW..][..TILE].copy_from_slice(&seen);
                tile.keys[k][s * ROW..][..TILE].copy_from_slice(&keys);
            }
        }
    }
}

/// Finds the hashes of a block of cells, and what there is in them.
#[inline(never)]
pub(super) fn look_up<const D: usize>(isa: Isa, process: &Process<D>, tile: &mut Tile<D>, block: usize) {
    isa.run(LookUp { process, tile, block });
}

struct LookUp<'a, const D: usize> {
    process: &'a Process<D>,
    tile: &'a mut Tile<D>,
    block: usize,
}

impl<const D: usize> Kernel for LookUp<'_, D> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let LookUp { process, tile, block } = self;
        let above = process.slots.get(process.always).map_or(i32::MAX, |slot| slot.above);
        let sets = tile.sets().min(TILE);
        let mut more = [0; TILE];
        for (cell, near) in process.block(block).iter().enumerate() {
            let keys: [&[u32; TILE]; D] = array(|k| {
                let keys = &tile.keys[k][usize::from(near[k])..];
                keys[..TILE].try_into().expect("that many")
            });
            let bit = 1 << cell;
            let mut hashes = [0; TILE];
            for i in 0..sets {
                let mut joined = keys[0][i];
                for k in 1..D {
                    joined ^= keys[k][i];
                }
                hashes[i] = hash::point(joined);
                more[i] |= if hashes[i] as i32 > above { bit } else { 0 };
            }
            tile.hashes[cell % BLOCK] = hashes;
        }
        tile.more = more;
        if tile.shared() {
            tile.list.clear();
            for run in 0..tile.runs {
                list(process, tile, block, run);
                tile.ends[run] = tile.list.len();
            }
        }
    }
}

/// Lists the impulses of a block that may reach a point of a run, in the order in which lanes on their own add them.
#[inline(always)]
fn list<const D: usize>(process: &Process<D>, tile: &mut Tile<D>, block: usize, run: usize) {
    let (from, to) = (tile.starts[run], tile.starts[run + 1]);
    let bounds = tile.within.map(|x| bounds(&x[from..to]));
    let middles = &process.middles[block];
    // No cell beyond the block has impulses.
    let mut hash = [i32::MIN as u32; BLOCK];
    for cell in 0..process.block(block).len() {
        hash[cell % BLOCK] = tile.hashes[cell % BLOCK][run];
    }
    let (always, asked) = process.slots.split_at(process.always);
    for (s, slot) in always.iter().enumerate() {
        let mut close = [0_u32; BLOCK];
        for cell in 0..BLOCK {
            let mut square = 0.0;
            for k in 0..D {
                let x = hash[cell].wrapping_mul(slot.place[k]) as i32 as f32 + middles[k][cell];
                let (below, above) = (bounds[k][0] - x, x - bounds[k][1]);
                let gap = if below > above { below } else { above };
                let gap = if gap > 0.0 { gap } else { 0.0 };
                square += gap * gap;
            }
            close[cell] = u32::from((hash[cell] as i32 > slot.above) & (square < process.far));
        }
        let (mut list, mut count) = ([0_u16; BLOCK], 0);
        for cell in 0..BLOCK {
            list[count % BLOCK] = (s * BLOCK + cell) as u16;
            count += close[cell] as usize;
        }
        tile.list.extend_from_slice(&list[..count]);
    }
    let mut more = tile.more[run];
    for (s, slot) in asked.iter().enumerate() {
        let mut cells = more;
        while cells != 0 {
            let cell = cells.trailing_zeros() as usize;
            cells &= cells - 1;
            if hash[cell] as i32 > slot.above {
                tile.list.push(((always.len() + s) * BLOCK + cell) as u16);
            } else {
                more &= !(1 << cell);
            }
        }
        if more == 0 {
            break;
        }
    }
}

/// The least and the most of coordinates, in [`UNIT`]s.
#[inline(always)]
fn bounds(within: &[f32]) -> [f32; 2] {
    let (mut least, mut most) = (1.0_f32, 0.0_f32);
    for &x in within {
        least = if x < least { x } else { least };
        most = if x > most { x } else { most };
    }
    [least * (1.0 / UNIT), most * (1.0 / UNIT)]
}

// A list's entry has room for the cell and the slot.
const _: () = assert!(MOST * BLOCK <= 1 << 16);
