//! A random number for each point, from the bits of its coordinates.
//!
//! Contract
//! - even in 0 … 1 without the 1, mean 1/2, standard deviation √(1/12) = 0.289, steps of 2^-24
//! - no continuity: every change of a coordinate, be it of the last bit, gives an unrelated number
//! - 0 and -0 are one coordinate; infinities are ordinary; a NaN gives NaN
//! - x, (x, 0) and (x, 0, 0) are unrelated
//!
//! Source: none; the hash is ours.

use super::field;
use super::hash::mix;
use crate::lanes::{Isa, Kernel};

/// Tells seeds from coordinates; a random odd number.
const SEED: u32 = 0x632B_E5AB;

/// A random number for each lane's 1 to 4 coordinates (there may be more).
///
/// # Panics
/// If there are no coordinates, or if lengths differ.
pub fn random(isa: Isa, coords: &[&[f32]], seed: u32, out: &mut [f32]) {
    assert!(!coords.is_empty(), "a random number of no coordinates");
    isa.run(Random { coords, seed: mix(seed ^ SEED), out });
}

struct Random<'a> {
    coords: &'a [&'a [f32]],
    seed: u32,
    out: &'a mut [f32],
}

impl Kernel for Random<'_> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        for (start, end) in field::tiles(self.out.len()) {
            // Hash coordinate by coordinate, so that their number may vary; a sum that is NaN if one is.
            let mut hashes = [self.seed; field::TILE];
            let mut poison = [0.0; field::TILE];
            for coord in self.coords {
                let mut padded = [[0.0; field::TILE]];
                let tile = field::load(&[coord], (start, end), &mut padded);
                for i in 0..tile.work() {
                    let x = tile.p[0][i] + 0.0; // one of the two zeros
                    // One to one in x, with the hash so far turned lest (x, y) and (y, x) be alike.
                    hashes[i] = mix(hashes[i].rotate_left(13).wrapping_mul(SEED) ^ x.to_bits());
                    poison[i] += if x.is_nan() { x } else { 0.0 };
                }
            }
            for (i, out) in self.out[start..end].iter_mut().enumerate() {
                // 24 bits, all that an f32 below 1 can tell apart.
                *out = (hashes[i] >> 8) as f32 * (1.0 / (1 << 24) as f32) + poison[i];
            }
        }
    }
}
