//! Waves about impulses: along which direction they go, and where in their cycle they are at a point.

// Loops over lanes and axes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::kernels::cosine;
use super::sum::Found;
use super::tile::GROUP;
use super::{SIZE, UNIT};
use crate::lanes::{Isa, Kernel, array};
use crate::noise::direction::{LENGTH, direction};
use crate::noise::field::TILE;
use crate::noise::hash;

/// The waves of impulses, in cycles a [`UNIT`].
#[derive(Clone, Copy, Debug)]
pub(in crate::noise) enum Waves<const D: usize> {
    /// So many along each axis, all at their crest at the impulse.
    Even([f32; D]),
    /// So many along each axis, with a random phase for each impulse; and all impulses are of size 1.
    Along([f32; D]),
    /// So many along a random direction for each impulse, with a random phase; and all impulses are of size 1.
    Around(f32),
}

/// Finds the waves of so many impulses. (Once for all kernels, hence not inlined.)
#[inline(never)]
pub(super) fn turn<const D: usize>(isa: Isa, waves: Waves<D>, found: &mut Found<D>, count: usize) {
    isa.run(Turn { waves, found, count });
}

struct Turn<'a, const D: usize> {
    waves: Waves<D>,
    found: &'a mut Found<D>,
    count: usize,
}

impl<const D: usize> Kernel for Turn<'_, D> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let (waves, len) = (self.waves, self.count.min(TILE));
        let Found { alike, offsets, sizes, words, turns, waves: here, .. } = self.found;
        match waves {
            Waves::Even(waves) | Waves::Along(waves) => {
                for k in 0..D {
                    for i in 0..len {
                        here[k][i] = waves[k];
                    }
                }
            }
            Waves::Around(waves) if *alike => {
                for first in (0..len).step_by(GROUP) {
                    let towards = around::<D>(hash::more(words[first]));
                    for k in 0..D {
                        let here: &mut [f32] = &mut here[k][first..first + GROUP];
                        for i in 0..GROUP {
                            here[i] = towards[k] * waves;
                        }
                    }
                }
            }
            Waves::Around(waves) => {
                for i in 0..len {
                    let towards = around::<D>(hash::more(words[i]));
                    for k in 0..D {
                        here[k][i] = towards[k] * waves;
                    }
                }
            }
        }
        if let Waves::Even(_) = waves {
            for i in 0..len {
                turns[i] = 0.0;
            }
        } else {
            for i in 0..len {
                turns[i] = words[i] as i32 as f32 * UNIT;
                sizes[i] = if sizes[i] == 0.0 { 0.0 } else { 1.0 / SIZE };
            }
        }
        for k in 0..D {
            for i in 0..len {
                turns[i] += offsets[k][i] * here[k][i];
            }
        }
    }
}

/// A direction, even in D dimensions, of length 1.
#[inline(always)]
fn around<const D: usize>(word: u32) -> [f32; D] {
    match D {
        1 => [1.0; D],
        2 => {
            let angle = word as i32 as f32 * UNIT;
            array(|k| cosine(angle - 0.25 * k as f32).0)
        }
        _ => {
            let direction = direction::<D>(word);
            array(|k| direction[k] * (1.0 / LENGTH))
        }
    }
}
