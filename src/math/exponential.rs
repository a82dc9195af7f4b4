//! Exponentials, logarithms, powers.
//!
//! [`exp`] and [`log`] compute in f32 and are within 1.2 ulp. The others go through f64 inside: its 53 bits absorb the
//! errors of argument reduction, so short polynomials and one rounding at the end give results within 0.6 ulp.
//! Denormals are included in both.

use super::polynomial;

/// 1.5·2^52: added to a small f64 it rounds it to an integer, which then stands in the lowest bits.
pub(super) const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// 2^t for |t| below 1000, relative error 4e-9; NaN for NaN.
#[inline(always)]
fn exp2_f64(t: f64) -> f64 {
    // (2^r - 1) / r on -1/2 … 1/2, Chebyshev fit, error 8e-9.
    const P: [f64; 6] = [
        0.693_147_188_026_228_8,
        0.240_226_507_605_681_82,
        0.055_503_571_142_192_835,
        0.009_618_082_557_266_563,
        0.001_339_086_336_456_137_9,
        0.000_154_531_629_496_123_86,
    ];
    let rounded = t + ROUNDER;
    let r = t - (rounded - ROUNDER);
    // The integer's low bits, moved to the exponent's place, and the bias of the exponent.
    let scale = f64::from_bits((rounded.to_bits() << 52).wrapping_add(1023 << 52));
    (1.0 + r * polynomial(r, P)) * scale
}

/// Limits `x`; NaN passes.
#[inline(always)]
fn limit(x: f32, size: f32) -> f32 {
    let x = if x < -size { -size } else { x };
    if x > size { size } else { x }
}

/// e^x in f64, for f32 arguments: 1e-66 … 1e65, beyond f32 at both ends.
#[inline(always)]
pub(super) fn exp_f64(x: f32) -> f64 {
    exp2_f64(f64::from(limit(x, 150.0)) * std::f64::consts::LOG2_E)
}

/// ln 2 in two parts: products of the first with whole numbers up to 2^15 are exact.
const LN_2: [f32; 2] = [0.693_359_4, -2.121_944_4e-4];

/// e^x.
#[inline(always)]
pub fn exp(x: f32) -> f32 {
    // (e^r - 1 - r) / r² on |r| ≤ ln 2 / 2, minimax, relative error of e^r 3e-9.
    const P: [f32; 5] = [0.5, 0.166_665_2, 0.041_668_394, 0.008_368_781, 0.001_381_446_5];
    // 1.5·2^23: added, it rounds to an integer, which then stands in the lowest bits.
    const ROUNDER: f32 = 12_582_912.0;
    let x = if x < -104.0 { -104.0 } else { x };
    let x = if x > 89.0 { 89.0 } else { x };
    let rounded = x * std::f32::consts::LOG2_E + ROUNDER;
    let n = rounded - ROUNDER;
    let r = (x - n * LN_2[0]) - n * LN_2[1];
    let p = P[0] + r * (P[1] + r * (P[2] + r * (P[3] + r * P[4])));
    let e = 1.0 + (r + r * r * p);
    // Two steps, as 2^n may be beyond the normal numbers.
    let n = rounded.to_bits().wrapping_sub(ROUNDER.to_bits()) as i32;
    let half = n >> 1;
    let power = |n: i32| f32::from_bits((n.wrapping_add(127) << 23) as u32);
    e * power(half) * power(n.wrapping_sub(half))
}

/// 2^x, exact for integers.
#[inline(always)]
pub fn exp2(x: f32) -> f32 {
    exp2_f64(f64::from(limit(x, 200.0))) as f32
}

/// `(k, s)` such that x = 2^k · m with m in √½ … √2 and s = (m - 1) / (m + 1), for positive finite x.
#[inline(always)]
fn split(x: f32) -> (f64, f64) {
    const SQRT_HALF: u64 = std::f64::consts::FRAC_1_SQRT_2.to_bits();
    const ONE: u64 = 1023 << 52;
    const FRACTION: u64 = (1 << 52) - 1;
    const TWO_52: f64 = (1_u64 << 52) as f64;
    // Every f32 but zero is a normal number of f64.
    let bits = f64::from(x).to_bits();
    let shifted = bits.wrapping_sub(SQRT_HALF).wrapping_add(ONE);
    let m = f64::from_bits((shifted & FRACTION).wrapping_add(SQRT_HALF));
    // The exponent as a number: AVX2 has no conversion from u64, but 2^52 + i has i in its low bits.
    let k = f64::from_bits((shifted >> 52) | TWO_52.to_bits()) - (TWO_52 + 1023.0);
    (k, (m - 1.0) / (m + 1.0))
}

/// The natural logarithm of m, from s: 2 artanh s; relative error 1e-13.
#[inline(always)]
fn log_from_split(s: f64) -> f64 {
    // (artanh s / s - 1) / s^2 on |s| up to 0.1716, Chebyshev fit in s^2, error 4e-12.
    const P: [f64; 5] = [
        0.333_333_333_336_877_26,
        0.199_999_993_984_243_37,
        0.142_858_773_178_664_1,
        0.110_956_972_465_861_63,
        0.096_813_884_183_944_11,
    ];
    let u = s * s;
    2.0 * s * (1.0 + u * polynomial(u, P))
}

/// The value of a logarithm outside of the positive finite numbers.
#[inline(always)]
fn log_special(x: f32, log: f32) -> f32 {
    let log = if x == 0.0 { f32::NEG_INFINITY } else { log };
    let log = if x == f32::INFINITY { f32::INFINITY } else { log };
    if x >= 0.0 { log } else { f32::NAN }
}

/// The natural logarithm.
#[inline(always)]
pub fn log(x: f32) -> f32 {
    // (ln(1 + f) - f + f²/2) / f³ on √½ ≤ 1 + f < √2, minimax, relative error of the logarithm 6e-9.
    const P: [f32; 8] = [
        0.333_333_3,
        -0.250_008_2,
        0.200_012_27,
        -0.166_233_57,
        0.142_017_62,
        -0.131_601_94,
        0.127_615_57,
        -0.076_344_41,
    ];
    const SQRT_HALF: u32 = 0x3f35_04f3;
    let tiny = x < f32::MIN_POSITIVE;
    let normal = if tiny { x * (1 << 23) as f32 } else { x };
    let bits = normal.to_bits().wrapping_sub(SQRT_HALF);
    let k = ((bits as i32) >> 23) as f32 - if tiny { 23.0 } else { 0.0 };
    let f = f32::from_bits((bits & 0x7f_ffff).wrapping_add(SQRT_HALF)) - 1.0;
    let mut p = P[7];
    for k in (0..7).rev() {
        p = p * f + P[k];
    }
    let square = f * f;
    let low = (k * LN_2[1] + f * square * p) - 0.5 * square;
    log_special(x, (f + low) + k * LN_2[0])
}

/// The logarithm to base 2, exact for powers of 2.
#[inline(always)]
pub fn log2(x: f32) -> f32 {
    let (k, s) = split(x);
    log_special(x, (k + log_from_split(s) * std::f64::consts::LOG2_E) as f32)
}

/// The logarithm to base 10, exact for powers of 10.
#[inline(always)]
pub fn log10(x: f32) -> f32 {
    let (k, s) = split(x);
    log_special(x, (k * std::f64::consts::LOG10_2 + log_from_split(s) * std::f64::consts::LOG10_E) as f32)
}

/// x^y after IEEE 754 and C99: x^0 = 1 and 1^y = 1 for every x and y, NaN included; a negative x has
/// powers for integer y only.
#[inline(always)]
pub fn pow(x: f32, y: f32) -> f32 {
    // The power of |x|. Beyond 2^±200 every f32 is infinite or zero, so the exponent may be limited.
    let size = x.abs();
    let (k, s) = split(size);
    let log = k + log_from_split(s) * std::f64::consts::LOG2_E;
    let log = if size == 0.0 { f64::NEG_INFINITY } else { log };
    let log = if size < f32::INFINITY { log } else { f64::from(size) };
    let exponent = log * f64::from(y);
    let exponent = if exponent < -200.0 { -200.0 } else { exponent };
    let exponent = if exponent > 200.0 { 200.0 } else { exponent };
    let power = exp2_f64(exponent) as f32;
    let power = if (size == 1.0) & !y.is_nan() { 1.0 } else { power };

    // Give it the sign of an odd power, or none to a power that is no integer.
    let integer = y.trunc() == y;
    let half = y * 0.5;
    let odd = integer & (half.trunc() != half);
    let power = if odd & x.is_sign_negative() { -power } else { power };
    let power = if !integer & (x < 0.0) & (x > f32::NEG_INFINITY) { f32::NAN } else { power };
    if (y == 0.0) | (x == 1.0) { 1.0 } else { power }
}

/// The square root, rounded correctly; NaN below zero.
#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    x.sqrt()
}

/// √(x² + y²) without overflow on the way; infinite if either is, even beside a NaN.
#[inline(always)]
pub fn hypot(x: f32, y: f32) -> f32 {
    let (a, b) = (f64::from(x), f64::from(y));
    let root = (a * a + b * b).sqrt() as f32;
    if x.is_infinite() | y.is_infinite() { f32::INFINITY } else { root }
}
