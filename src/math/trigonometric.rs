//! Sine, cosine, tangent, and their inverses.
//!
//! The argument is reduced in f64 to the part of a half turn that it goes beyond a whole number of them, as exactly
//! as it takes up to [`NEAR`]; from there on libm reduces it with as many digits of π as it takes. The `…_near`
//! functions are the loops of the slice kernels, which repair far lanes afterwards.
//!
//! Eight lanes of f32 are hardly faster: without a fused multiply-add, the parts of π, the rest that an f32 loses
//! and a second polynomial cost as many instructions as the two halves of f64, and errors rise to 1.4 ulp.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::exponential::ROUNDER;
use super::polynomial;

/// Up to this size [`PER_HALF_TURN_LOW`] moves an angle by less than 2^-8 half turns; the polynomials reach that
/// much further than to 1/2.
pub(super) const NEAR: f32 = (1 << 22) as f32;

/// The first 29 bits of 1/π. Their product with the 24 of an f32 is exact.
const PER_HALF_TURN_HIGH: f64 = 0.318_309_885_449_707_5;
/// The next 53. Positive, as is the first part, so that both products of -0 are -0.
const PER_HALF_TURN_LOW: f64 = 7.340_831_634_506_093e-10;

/// `(f, k)` such that x = (k + f) π / `parts` with |f| up to 1/2 and the integer k in the lowest bits, for
/// |x| ≤ [`NEAR`]. `parts` is a power of 2, which leaves products as exact as they were.
#[inline(always)]
fn reduce(x: f32, parts: f64) -> (f64, u64) {
    let x = f64::from(x);
    let whole = x * (parts * PER_HALF_TURN_HIGH);
    let rounded = whole + ROUNDER;
    // All exact but the small product and its addition: an angle next to a multiple of π keeps its bits.
    ((whole - (rounded - ROUNDER)) + x * (parts * PER_HALF_TURN_LOW), rounded.to_bits())
}

/// Changes the sign for odd k.
#[inline(always)]
fn alternate(value: f64, k: u64) -> f64 {
    f64::from_bits(value.to_bits() ^ (k << 63))
}

/// Is it beyond the reach of the fast reduction (or infinite, or NaN)?
#[inline(always)]
pub(super) fn is_far(x: f32) -> bool {
    (x.to_bits() << 1) > (NEAR.to_bits() << 1)
}

/// sin x for |x| ≤ [`NEAR`].
#[inline(always)]
pub(super) fn sin_near(x: f32) -> f32 {
    // sin(πf) / f for |f| up to 1/2, minimax in f^2, relative error 6e-9.
    const P: [f64; 5] = [
        3.141_592_635_491_005_3,
        -5.167_709_480_451_275_5,
        2.550_065_134_431_731,
        -0.598_209_494_827_310_9,
        0.077_488_670_763_334_6,
    ];
    // sin((k + f)π) = (-1)^k sin(πf). As a product, for x = -0.
    let (f, k) = reduce(x, 1.0);
    alternate(f * polynomial(f * f, P), k) as f32
}

/// cos x for |x| ≤ [`NEAR`].
#[inline(always)]
pub(super) fn cos_near(x: f32) -> f32 {
    // cos(πf) / (1/4 - f^2) for |f| up to 1/2, minimax in f^2, relative error 1e-9. The divisor has the zeros.
    const P: [f64; 5] = [
        3.999_999_995_749_133,
        -3.739_207_998_805_099,
        1.277_988_635_045_993_2,
        -0.228_730_354_430_250_17,
        0.024_135_836_843_335_305,
    ];
    let (f, k) = reduce(x, 1.0);
    let u = f * f;
    alternate((0.25 - u) * polynomial(u, P), k) as f32
}

/// tan x for |x| ≤ [`NEAR`].
#[inline(always)]
pub(super) fn tan_near(x: f32) -> f32 {
    // sin(πf/2) / f for |f| up to 1/2, minimax in f^2, relative error 4e-9.
    const SIN: [f64; 4] = [
        1.570_796_321_029_587_4,
        -0.645_963_397_729_006_4,
        0.079_679_224_960_933_84,
        -0.004_599_139_131_966_466,
    ];
    // cos(πf/2) likewise, error 7e-11.
    const COS: [f64; 5] = [
        0.999_999_999_934_183,
        -1.233_700_538_128_616,
        0.253_669_150_168_948,
        -0.020_859_705_329_087_284,
        0.000_902_856_498_932_854_9,
    ];
    // The tangent of kπ/2 + πf/2 is tan(πf/2), and for odd k -1 / tan(πf/2).
    let (f, k) = reduce(x, 2.0);
    let u = f * f;
    let (sin, cos) = (f * polynomial(u, SIN), polynomial(u, COS));
    let odd = k & 1 == 1;
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
