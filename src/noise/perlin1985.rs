//! The noise of Perlin, "An Image Synthesizer", SIGGRAPH 85, section "Noise()".
//!
//! Each lattice point has a random value d and a random gradient (a, b, c), all from a hash; noise blends
//! the linear equations of the cell's corners by cubic weights. H() of the paper is `hash` and `direction`.
//!
//! Contract
//! - signed, mean 0, |noise| ≤ ½ + √¾ < 1.37; measured in 3-D: standard deviation 0.26, and of a million
//!   points all within ±1
//! - at lattice points noise is d, even in -½ … ½, and its derivative a direction of length 1
//! - continuous with its first derivative (C¹)
//! - of fewer coordinates than three: the noise with the others 0; of four: directions in four dimensions,
//!   |noise| ≤ 1.5
//! - on plane sections 31 % of the energy lies below 0.3 cycles a unit, 58 % in 0.3 … 0.7, 1 % above 1,
//!   whatever the direction of the plane (256² samples, 48 planes, Hann window)

use super::direction::{LENGTH, along};
use super::hash::more;
use super::lattice::Planes;

/// Noise() of 1985.
#[derive(Clone, Copy, Debug)]
pub struct Perlin1985;

/// Values are even in -VALUE … VALUE, gradients being of length 1. The larger, the more energy lies in low
/// frequencies: 0.35 puts 27 % below 0.3 cycles a unit, 0.7 puts 34 %. A half also lets noise just reach ±1.
const VALUE: f32 = 0.5;

impl Planes for Perlin1985 {
    const SCALE: f32 = 1.0 / LENGTH;

    #[inline(always)]
    fn height<const D: usize>(hash: u32, offset: [f32; D]) -> f32 {
        const UNIT: f32 = VALUE * LENGTH / (1_u32 << 31) as f32;
        more(hash) as i32 as f32 * UNIT + along(hash, offset)
    }
}
