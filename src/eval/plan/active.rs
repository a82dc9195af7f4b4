//! The active lanes of a batch, strip by strip.

use super::strip::{STRIP, Strip};
use crate::value::Mask;

/// Where the lanes of a batch are that are on.
pub enum Active {
    /// All of so many.
    All(usize),
    /// In runs of neighbours: the first, and how many.
    Runs(Vec<(u32, u32)>, usize),
    /// One by one.
    List(Vec<u32>),
}

/// Runs as short as that on average are gone through lane by lane.
const SHORT: usize = 6;

impl Active {
    pub fn of(mask: &Mask, n: usize) -> Active {
        let Mask::Some(on) = mask else {
            return Active::All(if mask.is_none() { 0 } else { n });
        };
        let mut runs: Vec<(u32, u32)> = Vec::new();
        let (mut before, mut count) = (0, 0);
        for (lane, &bits) in on.bits(n).iter().enumerate() {
            if bits != 0 {
                match runs.last_mut() {
                    Some(run) if before != 0 => run.1 += 1,
                    _ => runs.push((lane as u32, 1)),
                }
                count += 1;
            }
            before = bits;
        }
        if runs.len() * SHORT > count {
            return Active::List(runs.iter().flat_map(|&(start, n)| start..start + n).collect());
        }
        Active::Runs(runs, count)
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
