//! The workloads as somebody would write them in Rust who wants them fast: a frame in blocks of lanes, whatever has
//! to be computed only on the surface without the lanes beside it, in loops that the compiler vectorises, with the
//! noises and the mathematics of the library, and nothing of its evaluator.
//!
//! The arithmetic is that of the program, operation by operation, so that the picture is the same to the last bit.
//! It could be cheaper otherwise (one division for the three of `direction`, say): but the measure is of what the
//! evaluator adds, not of what somebody could leave out.

mod branchy;
mod flat;
mod frame;
mod noisy;
mod straight;
mod waves;

pub use branchy::branchy;
pub use flat::{diffuse, over, recursive};
pub use noisy::{marble, spotted, wrinkled};
pub use straight::straight;
pub use waves::waves;

use pse::Image;
use pse::internal::lanes::Isa;

/// A workload on an image: its planes of colour, and of alpha if it has that.
pub type Native = fn(Isa, &Image<'_>) -> Vec<Vec<f32>>;
