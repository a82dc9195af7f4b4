//! Sine, cosine, tangent, and their inverses.
//!
//! The argument is reduced in f64 by π in two parts (Cody and Waite 1980), which is exact enough up to
//! [`NEAR`]; from there on libm reduces it with as many digits of π as it takes. The `…_near` functions
//! are the loops of the slice kernels, which repair far lanes afterwards.

use std::f64::consts::{FRAC_1_PI, FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, PI};

use super::exponential::ROUNDER;
use super::polynomial;

/// Up to this size the multiple of π has at most 22 bits, so its product with the 30 bits of [`PI_HIGH`] is exact.
pub(super) const NEAR: f32 = (1 << 22) as f32;

/// The first 30 bits of π.
const PI_HIGH: f64 = 3.141_592_651_605_606;
/// The next 53.
const PI_LOW: f64 = 1.984_187_159_361_081e-9;

/// sin r for |r| up to π/2, relative error 1e-10.
#[inline(always)]
fn sin_poly(r: f64) -> f64 {
    // (sin r / r - 1) / r^2, Chebyshev fit in r^2, error 3e-11.
    const P: [f64; 5] = [
        -0.166_666_666_638_784_66,
        0.008_333_332_768_305_049,
        -0.000_198_410_864_525_061_94,
        2.753_645_532_390_912e-6,
        -2.407_999_973_210_425e-8,
    ];
    let u = r * r;
    // As a product, for r = -0.
    r * (1.0 + u * polynomial(u, P))
}

/// cos r for |r| up to π/4, error 2e-10.
#[inline(always)]
fn cos_poly(r: f64) -> f64 {
    // (cos r - 1) / r^2, Chebyshev fit in r^2, error 3e-10.
    const P: [f64; 4] = [
        -0.499_999_999_688_719_83,
        0.041_666_650_548_440_196,
        -0.001_388_758_397_081_767,
        2.446_311_670_243_778e-5,
    ];
    let u = r * r;
    1.0 + u * polynomial(u, P)
}

/// Is it beyond the reach of the fast reduction (or infinite, or NaN)?
#[inline(always)]
pub(super) fn is_far(x: f32) -> bool {
    (x.to_bits() << 1) > (NEAR.to_bits() << 1)
}

/// sin x for |x| ≤ [`NEAR`].
#[inline(always)]
pub(super) fn sin_near(x: f32) -> f32 {
    // sin x = (-1)^k sin(x - kπ)
    let x = f64::from(x);
    let rounded = x * FRAC_1_PI + ROUNDER;
    let k = rounded - ROUNDER;
    let r = x - k * PI_HIGH - k * PI_LOW;
    f64::from_bits(sin_poly(r).to_bits() ^ (rounded.to_bits() << 63)) as f32
}

/// cos x for |x| ≤ [`NEAR`].
#[inline(always)]
pub(super) fn cos_near(x: f32) -> f32 {
    // cos x = (-1)^k sin((k + ½)π - x)
    let x = f64::from(x);
    let rounded = (x * FRAC_1_PI - 0.5) + ROUNDER;
    let k = rounded - ROUNDER + 0.5;
    let r = k * PI_HIGH - x + k * PI_LOW;
    f64::from_bits(sin_poly(r).to_bits() ^ (rounded.to_bits() << 63)) as f32
}

/// tan x for |x| ≤ [`NEAR`].
#[inline(always)]
pub(super) fn tan_near(x: f32) -> f32 {
    // tan x = tan(x - kπ/2), and for odd k -1 / tan of it
    let x = f64::from(x);
    let rounded = x * FRAC_2_PI + ROUNDER;
    let k = rounded - ROUNDER;
    let r = x - k * (0.5 * PI_HIGH) - k * (0.5 * PI_LOW);
    let (sin, cos) = (sin_poly(r), cos_poly(r));
    let odd = rounded.to_bits() & 1 == 1;
    let above = if odd { -cos } else { sin };
    let below = if odd { sin } else { cos };
    (above / below) as f32
}

/// tan x for large x; libm's own `tanf` errs by 0.8 ulp.
pub(super) fn tan_far(x: f32) -> f32 {
    libm::tan(f64::from(x)) as f32
}

/// The sine of an angle in radians; NaN for infinities.
#[inline(always)]
pub fn sin(x: f32) -> f32 {
    if is_far(x) { libm::sinf(x) } else { sin_near(x) }
}

/// The cosine of an angle in radians; NaN for infinities.
#[inline(always)]
pub fn cos(x: f32) -> f32 {
    if is_far(x) { libm::cosf(x) } else { cos_near(x) }
}

/// The tangent of an angle in radians; NaN for infinities.
#[inline(always)]
pub fn tan(x: f32) -> f32 {
    if is_far(x) { tan_far(x) } else { tan_near(x) }
}

/// The angle of the point (x, y), in f64, -π … π.
#[inline(always)]
fn angle(y: f64, x: f64) -> f64 {
    // (atan t / t - 1) / t^2 for |t| up to tan(π/8), Chebyshev fit in t^2, error 6e-10.
    const P: [f64; 6] = [
        -0.333_333_332_792_245_4,
        0.199_999_772_482_335_28,
        -0.142_841_506_297_302_1,
        0.110_713_545_712_003_26,
        -0.086_245_982_151_901_77,
        0.050_479_374_320_275_223,
    ];
    const TAN_PI_8: f64 = std::f64::consts::SQRT_2 - 1.0;
    let (ax, ay) = (x.abs(), y.abs());
    let steep = ay > ax;
    let (small, large) = (if steep { ax } else { ay }, if steep { ay } else { ax });

    // Fold the eighth of a circle once more, about π/8: atan(s/l) = π/4 + atan((s - l)/(s + l)).
    let fold = small > TAN_PI_8 * large;
    let above = if fold { small - large } else { small };
    let above = if small == large { 0.0 } else { above }; // for two infinities
    let below = if fold { small + large } else { large };
    let below = if large == 0.0 { 1.0 } else { below };
    // Two infinities do not fold, inf > inf being false: they are put at π/4 with all equals.
    let fold = fold | ((small == large) & (large > 0.0));
    let t = above / below;
    let a = t * (1.0 + t * t * polynomial(t * t, P));

    // Unfold.
    let a = if fold { a + FRAC_PI_4 } else { a };
    let a = if steep { FRAC_PI_2 - a } else { a };
    let a = if x.is_sign_negative() { PI - a } else { a };
    let a = a.copysign(y);
    if x.is_nan() | y.is_nan() { f64::NAN } else { a }
}

/// The angle of the point (x, y), -π … π, with the sign of y, as IEEE 754 has it for zeros and infinities.
#[inline(always)]
pub fn atan2(y: f32, x: f32) -> f32 {
    angle(f64::from(y), f64::from(x)) as f32
}

/// The angle whose tangent is x, -π/2 … π/2.
#[inline(always)]
pub fn atan(x: f32) -> f32 {
    angle(f64::from(x), 1.0) as f32
}

/// The angle whose sine is x, -π/2 … π/2; NaN where there is none.
#[inline(always)]
pub fn asin(x: f32) -> f32 {
    let x = f64::from(x);
    angle(x, ((1.0 - x) * (1.0 + x)).sqrt()) as f32
}

/// The angle whose cosine is x, 0 … π; NaN where there is none.
#[inline(always)]
pub fn acos(x: f32) -> f32 {
    let x = f64::from(x);
    angle(((1.0 - x) * (1.0 + x)).sqrt(), x) as f32
}
