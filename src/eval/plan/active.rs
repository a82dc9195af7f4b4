//! The active lanes of a batch, strip by strip.

use super::strip::{BLOCK, STRIP, Strip};
use crate::lanes::Isa;
use crate::value::{Mask, Width};
use smallvec::SmallVec;

/// Where the lanes of a batch are that are on.
#[expect(clippy::large_enum_variant, reason = "one a plan, on the stack, rather than memory of its own")]
pub enum Active {
    /// All of so many.
    All(usize),
    /// In runs of neighbours: the first, and how many.
    Runs(SmallVec<[(u32, u32); 64]>, usize),
    /// One by one.
    List(Vec<u32>),
}

/// Runs as short as that on average are gone through lane by lane.
const SHORT: usize = 6;

impl Active {
    /// The lanes of a mask. `list` is room for them, to be had again by [`Active::room`].
    pub fn of(mask: &Mask, width: Width, list: Vec<u32>) -> Active {
        let Mask::Some(on) = mask else {
            return Active::All(if mask.is_none() { 0 } else { width.n });
        };
        Active::of_bits(on.bits(width.n), width.isa, list)
    }

    /// Those lanes of which all bits are set; of the others none is.
    pub fn of_bits(bits: &[u32], isa: Isa, list: Vec<u32>) -> Active {
        // As numbers they are 0 and -1.
        let (count, ends) = isa.run(|| {
            let count = bits.iter().fold(0_u32, |count, bits| count.wrapping_sub(*bits));
            let ends = bits[1..].iter().zip(bits).fold(0_u32, |ends, (a, b)| ends.wrapping_sub(a ^ b));
            (count as usize, ends as usize)
        });
        if (ends / 2 + 1) * SHORT > count {
            Active::list(bits, count, list)
        } else {
            Active::runs(bits, count)
        }
    }

    fn list(bits: &[u32], count: usize, mut list: Vec<u32>) -> Active {
        // One more for a lane that is off after the last that is on.
        list.resize(count + 1, 0);
        let mut at = 0;
        for (lane, &bits) in (0..).zip(bits) {
            list[at] = lane;
            at += (bits & 1) as usize;
        }
        list.truncate(count);
        Active::List(list)
    }

    fn runs(bits: &[u32], count: usize) -> Active {
        let mut runs: SmallVec<[(u32, u32); 64]> = SmallVec::new();
        let mut add = |start: usize, lanes: usize| match runs.last_mut() {
            Some(run) if (run.0 + run.1) as usize == start => run.1 += lanes as u32,
            _ => runs.push((start as u32, lanes as u32)),
        };
        for (k, bits) in bits.chunks(BLOCK).enumerate() {
            // Most blocks are on or off as a whole.
            let (any, all) = bits.iter().fold((0, !0), |(any, all), bits| (any | bits, all & bits));
            if all != 0 {
                add(k * BLOCK, bits.len());
            } else if any != 0 {
                let on = bits.iter().enumerate().filter(|(_, bits)| **bits != 0);
                on.for_each(|(i, _)| add(k * BLOCK + i, 1));
            }
        }
        Active::Runs(runs, count)
    }

    /// The room of a list.
    pub fn room(self) -> Option<Vec<u32>> {
        if let Active::List(list) = self { Some(list) } else { None }
    }

    /// How many lanes there are.
    pub fn count(&self) -> usize {
        match self {
            Active::All(n) | Active::Runs(_, n) => *n,
            Active::List(list) => list.len(),
        }
    }

    /// Calls `f` for each piece of the lanes from `start` on, a strip at most: where it is in the batch and where in the
    /// strip, and how long.
    fn pieces(runs: &[(u32, u32)], start: usize, lanes: usize, mut f: impl FnMut(usize, usize, usize)) {
        let mut before = 0;
        for &(first, length) in runs {
            let (first, length) = (first as usize, length as usize);
            let from = start.max(before);
            let to = (start + lanes).min(before + length);
            if from < to {
                f(first + from - before, from - start, to - from);
            }
            before += length;
            if before >= start + lanes {
                return;
            }
        }
    }

    /// The lanes from `start` on.
    pub fn gather(&self, from: &[f32], start: usize, lanes: usize, strip: &mut Strip) {
        let to = strip.0.as_flattened_mut();
        match self {
            Active::All(_) => to[..lanes].copy_from_slice(&from[start..start + lanes]),
            Active::Runs(runs, _) => Active::pieces(runs, start, lanes, |whole, at, n| {
                to[at..at + n].copy_from_slice(&from[whole..whole + n]);
            }),
            Active::List(list) => {
                for (to, &lane) in to.iter_mut().zip(&list[start..start + lanes]) {
                    *to = from[lane as usize];
                }
            }
        }
        // Something harmless where a kernel works on more lanes than there are.
        to[lanes..lanes.next_multiple_of(8).min(STRIP)].fill(0.0);
    }

    /// Puts the lanes from `start` on back where they belong. `from` is one number for all, or one a lane.
    pub fn scatter(&self, from: &[f32], start: usize, lanes: usize, to: &mut [f32]) {
        match self {
            Active::All(_) => to[start..start + lanes].copy_from_slice(&from[..lanes]),
            Active::Runs(runs, _) => Active::pieces(runs, start, lanes, |whole, at, n| {
                to[whole..whole + n].copy_from_slice(&from[at..at + n]);
            }),
            Active::List(list) => {
                for (&lane, &x) in list[start..start + lanes].iter().zip(from) {
                    to[lane as usize] = x;
                }
            }
        }
    }

    /// Writes a number to all of them.
    pub fn fill(&self, x: f32, to: &mut [f32]) {
        match self {
            Active::All(n) => to[..*n].fill(x),
            Active::Runs(runs, _) => {
                for &(start, n) in runs {
                    to[start as usize..(start + n) as usize].fill(x);
                }
            }
            Active::List(list) => list.iter().for_each(|&lane| to[lane as usize] = x),
        }
    }
}
