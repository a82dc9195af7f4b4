//! Noise: one file an algorithm, kernels over lanes, no knowledge of the language.
//!
//! | file | what it is |
//! |---|---|
//! | `kinds` | the table of all kinds |
//! | `kind` | what an entry says, and how a [`Field`] is made and kept |
//! | `options` | what kinds can be given beside a seed |
//! | `field` | the loop over lanes that most kinds share |
//! | `reference` | the entries of the kinds in words |
//! | `sums` | sums of octaves of any kind: turbulence and its like |
//! | `impulses` | what the kinds share that scatter impulses |
//! | `table`, `spline`, `fft` | what the kinds share that fill a table |
//! | `random` | a random number for each point |
//! | `lattice`, `tensor`, `direction`, `hash` | what the lattice kinds share |
//!
//! Every other file is a kind. To add one, write its file with a [`Kind`] and put that into the table.
//!
//! A lane's result depends on its own inputs only, and is the same bits on every instruction set.
//!
//! ```
//! use pse::Isa;
//! use pse::noise::{Kind, Params};
//!
//! let kind = Kind::from_name("gradient").unwrap();
//! let field = kind.field(2, &Params::seeded(7)).unwrap();
//! let (x, y) = ([0.5, 1.0], [0.25, 3.0]);
//! let mut noise = [0.0; 2];
//! field.noise(Isa::detect(), &[&x, &y], &mut noise);
//! assert_eq!(noise[1], 0.0); // gradient noise is zero at lattice points
//! ```

mod cellular;
#[cfg(test)]
mod checks;
mod composed;
pub mod direction;
mod fft;
mod field;
mod fourier;
mod gabor;
mod gardner;
mod gradient;
pub mod hash;
mod hermite;
mod improved;
mod impulses;
mod kind;
mod kinds;
mod lattice;
mod lattice_convolution;
mod linear;
mod midpoint;
mod options;
mod perlin1985;
pub mod random;
pub mod reference;
mod simplex;
mod sparse_convolution;
mod spline;
pub mod sums;
mod table;
mod tensor;
#[cfg(test)]
mod tests;
mod value;
mod value_gradient;
mod white;
mod wiener;

pub use field::Field;
pub use kind::{Contract, Kind, Made, Smoothness, Unfit};
pub use kinds::KINDS;
pub use options::{Info, OPTIONS, Opt, Params};
pub use wiener::wiener_error;

/// The seed of another, unrelated noise: one for each number below 2^32, and for 0 the seed itself.
pub fn related_seed(seed: u32, number: u32) -> u32 {
    if number == 0 { seed } else { hash::mix(seed ^ hash::mix(number.wrapping_mul(0x9E37_79B9))) }
}
