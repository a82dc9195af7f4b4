//! Gradient noise: Perlin, SIGGRAPH 92 course 23, section 3.6.2 "The noise function"; Peachey's gnoise.
//!
//! Each lattice point has value 0 and a random gradient, even in a cube whose mean square length is 1; cubic weights
//! blend them, times 1.5. Where the course has a table of 256 gradients, this has a hash, so nothing repeats.

use super::kind::{Contract, Kind, Smoothness};
use super::lattice::lattice_field;
use super::linear::{Linear, Planes};
use super::options::Opt;

/// Gradient noise, 1992.
pub static KIND: Kind = Kind {
    name: "gradient",
    brief: "random gradients at lattice points, cubic weights",
    dimensions: 1..=4,
    options: &[Opt::Period],
    contract: Contract {
        // 1.5 times the sum of the offsets from the middle of a cell to its corners, in four dimensions times √¾.
        bounds: &[[-0.75, 0.75], [-1.5, 1.5], [-2.25, 2.25], [-2.5981, 2.5981]],
        mean: 0.0,
        deviation: 0.274,
        lattice: "0",
        smoothness: Smoothness::C1,
        cost: 1.0,
        source: "Perlin 1992, section 3.6.2; Peachey, \"Gradient Noise\"",
        remarks: "Of four million points six in 100,000 were beyond ±1, and none beyond ±1.26.",
    },
    make: |d, params| lattice_field!(fast d, params, [1 2 3 4], |lattice| Linear::<Gradient, _, _>::new(lattice)),
};

#[derive(Clone, Copy, Debug)]
struct Gradient;

impl Planes for Gradient {
    /// Perlin's factor, which makes the range about -1 … 1.
    const SCALE: f32 = 1.5;
    const VALUE: f32 = 0.0;
}
