//! Mathematics with the same bits on every machine.
//!
//! Each function exists for one lane (`sin`) and for slices (`sin_lanes`); a lane of the slice equals the
//! former bit for bit, whatever its neighbours, the length and the instruction set. Errors are within 0.6 ulp
//! of the true value, of [`exp`] within 1.2 and of [`log`] within 0.9 (`tests.rs` measures them). Special cases are
//! those of IEEE 754 and C99.
//!
//! The functions are free of branches so that their loops vectorise, and most compute in f64: on AVX2 four
//! lanes at a time, which is cheaper than to save the bits that an f32 reduction loses.

mod exponential;
mod hyperbolic;
mod lanes;
mod round;
#[cfg(test)]
mod tests;
mod trigonometric;

pub use exponential::{exp, exp2, hypot, log, log2, log10, pow, sqrt};
pub use hyperbolic::{cosh, sinh, tanh};
pub use lanes::*;
pub use round::{ceil, floor, frac, modulo, modulo_of_power, round, sign, trunc};
pub use trigonometric::{acos, asin, atan, atan2, cos, sin, tan};

/// `c[0] + c[1] x + c[2] x² …`, by Horner's rule, without fused operations.
#[inline(always)]
fn polynomial<const N: usize>(x: f64, c: [f64; N]) -> f64 {
    let mut sum = c[N - 1];
    for &c in c[..N - 1].iter().rev() {
        sum = sum * x + c;
    }
    sum
}
