//! Hyperbolic functions, from e^x in f64 and, near zero, from the series.

use super::exponential::exp_f64;
use super::polynomial;

/// sinh and cosh in f64.
#[inline(always)]
fn sinh_cosh(x: f32) -> (f64, f64) {
    // (sinh x / x - 1) / x^2 for |x| up to 1, where e^x - e^-x would cancel; Chebyshev fit in x^2, error 4e-13.
    const P: [f64; 5] = [
        0.166_666_666_666_984_07,
        0.008_333_333_317_464_362,
        0.000_198_412_825_301_159_9,
        2.755_377_026_364_148e-6,
        2.545_670_657_152_422_8e-8,
    ];
    let e = exp_f64(x);
    let inverse = 1.0 / e;
    let x = f64::from(x);
    let near = x * (1.0 + x * x * polynomial(x * x, P));
    let far = 0.5 * (e - inverse);
    (if x.abs() < 1.0 { near } else { far }, 0.5 * (e + inverse))
}

/// The hyperbolic sine.
#[inline(always)]
pub fn sinh(x: f32) -> f32 {
    sinh_cosh(x).0 as f32
}

/// The hyperbolic cosine.
#[inline(always)]
pub fn cosh(x: f32) -> f32 {
    sinh_cosh(x).1 as f32
}

/// The hyperbolic tangent. (At the limit of `exp_f64` the quotient is 1 to the last bit of an f64.)
#[inline(always)]
pub fn tanh(x: f32) -> f32 {
    let (sinh, cosh) = sinh_cosh(x);
    (sinh / cosh) as f32
}
