//! The noise of Perlin, "An Image Synthesizer", SIGGRAPH 85, section "Noise()".
//!
//! Each lattice point has a random value d and a random gradient (a, b, c), all from a hash; noise blends
//! the linear equations of the cell's corners by cubic weights. H() of the paper is `hash`, of whose product
//! (a, b, c) are bit fields.

use super::kind::{Contract, Kind, Smoothness};
use super::lattice::lattice_field;
use super::linear::{Linear, Planes};
use super::options::Opt;

/// Noise() of 1985.
pub static KIND: Kind = Kind {
    name: "perlin1985",
    brief: "random values and gradients at lattice points, cubic weights: what plain `Noise(p)` is",
    dimensions: 1..=4,
    options: &[Opt::Period],
    contract: Contract {
        // Half, and the sum of the offsets from the middle of a cell to its corners, in four dimensions times √¾.
        bounds: &[[-1.0, 1.0], [-1.5, 1.5], [-2.0, 2.0], [-2.2321, 2.2321]],
        mean: 0.0,
        deviation: 0.26,
        lattice: "even in -½ … ½",
        smoothness: Smoothness::C1,
        cost: 1.2,
        source: "Perlin 1985, \"Noise()\"",
        remarks: "Of four million points three in a million were beyond ±1, and none beyond ±1.13.",
    },
    make: |d, params| lattice_field!(fast d, params, [1 2 3 4], |lattice| Linear::<Perlin1985, _, _>::new(lattice)),
};

#[derive(Clone, Copy, Debug)]
struct Perlin1985;

impl Planes for Perlin1985 {
    const SCALE: f32 = 1.0;
    /// The larger, the more energy lies in low frequencies: 0.35 puts 27 % below 0.3 cycles a unit, 0.7 puts 34 %.
    /// A half also lets noise just reach ±1.
    const VALUE: f32 = 0.5;
}
