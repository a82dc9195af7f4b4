//! Gradient noise: Perlin, SIGGRAPH 92 course 23, section 3.6.2 "The noise function"; Peachey's gnoise.
//!
//! Each lattice point has value 0 and a random gradient of length 1; cubic weights blend them, times 1.5.
//! Where the course has a table of 256 gradients, this has a hash, so nothing repeats.
//! In four dimensions gradients are directions in four dimensions.

use super::kind::{Contract, Kind, Smoothness};
use super::lattice::lattice_field;
use super::linear::{Linear, Planes, Tiled};
use super::options::Opt;

/// Gradient noise, 1992.
pub static KIND: Kind = Kind {
    name: "gradient",
    brief: "random gradients at lattice points, cubic weights",
    dimensions: 1..=4,
    options: &[Opt::Period],
    contract: Contract {
        // 1.5 times the distance from the middle of a cell to its corners.
        bounds: &[[-0.75, 0.75], [-1.061, 1.061], [-1.30, 1.30], [-1.501, 1.501]],
        mean: 0.0,
        deviation: 0.274,
        lattice: "0",
        smoothness: Smoothness::C1,
        cost: 1.0,
        source: "Perlin 1992, section 3.6.2; Peachey, \"Gradient Noise\"",
        remarks: "",
    },
    make: |d, params| lattice_field!(fast d, params, [1 2 3 4], Tiled |lattice| Linear::<Gradient, _, _>::new(lattice)),
};

#[derive(Clone, Copy, Debug)]
struct Gradient;

impl Planes for Gradient {
    /// Perlin's factor, which makes the range about -1 … 1.
    const SCALE: f32 = 1.5;
    const VALUE: f32 = 0.0;
}
