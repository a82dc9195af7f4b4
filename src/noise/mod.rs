//! Noise: one file an algorithm, kernels over lanes, no knowledge of the language.
//!
//! | file | what it is |
//! |---|---|
//! | `perlin1985` | Noise() and Dnoise() of the 1985 paper: random values and gradients |
//! | `gradient` | Perlin's gradient noise of 1992: random gradients only |
//! | `turbulence` | sums of octaves, in the forms of 1985 and 1992 |
//! | `white` | a random number for each point |
//! | `lattice`, `direction`, `hash` | what these share |
//!
//! Every file is headed by its contract. To add a lattice noise, write its [`lattice::Planes`] and an
//! entry of [`Kind`].
//!
//! A lane's result depends on its own inputs only, and is the same bits on every instruction set.

pub mod direction;
pub mod gradient;
pub mod hash;
pub mod lattice;
pub mod perlin1985;
#[cfg(test)]
mod tests;
pub mod turbulence;
pub mod white;

use crate::lanes::Isa;
use gradient::Gradient;
use perlin1985::Perlin1985;

/// The noise algorithms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Random values and gradients at lattice points, of 1985.
    #[default]
    Perlin1985,
    /// Random gradients at lattice points, of 1992.
    Gradient,
}

impl Kind {
    /// All of them: the kind, its name, its contract in a line.
    pub const ALL: [(Kind, &'static str, &'static str); 2] = [
        (
            Kind::Perlin1985,
            "perlin1985",
            "signed, within ±1.37, random at lattice points, C1: Perlin 1985, Noise()",
        ),
        (Kind::Gradient, "gradient", "signed, within ±1.3, 0 at lattice points, C1: Perlin 1992, noise3()"),
    ];

    /// The kind of this name.
    pub fn from_name(name: &str) -> Option<Kind> {
        Kind::ALL.iter().find(|entry| entry.1 == name).map(|entry| entry.0)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        Kind::ALL[self as usize].1
    }
}

/// Noise of 1 to 4 coordinates in each lane.
///
/// # Panics
/// If there are no coordinates or more than four, or if lengths differ.
pub fn noise(kind: Kind, isa: Isa, coords: &[&[f32]], seed: u32, out: &mut [f32]) {
    match kind {
        Kind::Perlin1985 => noise_of::<Perlin1985>(isa, coords, seed, out),
        Kind::Gradient => noise_of::<Gradient>(isa, coords, seed, out),
    }
}

fn noise_of<P: lattice::Planes>(isa: Isa, coords: &[&[f32]], seed: u32, out: &mut [f32]) {
    match *coords {
        [x] => lattice::noise::<P, 1>(isa, [x], seed, out),
        [x, y] => lattice::noise::<P, 2>(isa, [x, y], seed, out),
        [x, y, z] => lattice::noise::<P, 3>(isa, [x, y, z], seed, out),
        [x, y, z, w] => lattice::noise::<P, 4>(isa, [x, y, z, w], seed, out),
        _ => panic!("noise of {} coordinates", coords.len()),
    }
}

/// The derivative of [`noise`] along each coordinate, in each lane: as many outputs as coordinates.
///
/// # Panics
/// If there are no coordinates or more than four, or if numbers or lengths differ.
pub fn dnoise(kind: Kind, isa: Isa, coords: &[&[f32]], seed: u32, out: &mut [&mut [f32]]) {
    match kind {
        Kind::Perlin1985 => dnoise_of::<Perlin1985>(isa, coords, seed, out),
        Kind::Gradient => dnoise_of::<Gradient>(isa, coords, seed, out),
    }
}

fn dnoise_of<P: lattice::Planes>(isa: Isa, coords: &[&[f32]], seed: u32, out: &mut [&mut [f32]]) {
    match (coords, out) {
        (&[x], [dx]) => lattice::gradient::<P, 1>(isa, [x], seed, [dx]),
        (&[x, y], [dx, dy]) => lattice::gradient::<P, 2>(isa, [x, y], seed, [dx, dy]),
        (&[x, y, z], [dx, dy, dz]) => lattice::gradient::<P, 3>(isa, [x, y, z], seed, [dx, dy, dz]),
        (&[x, y, z, w], [dx, dy, dz, dw]) => {
            lattice::gradient::<P, 4>(isa, [x, y, z, w], seed, [dx, dy, dz, dw]);
        }
        (coords, out) => panic!("{} derivatives of {} coordinates", out.len(), coords.len()),
    }
}
