//! Rounding, the part after the point, the remainder, the sign.

/// The largest integer not above `x`. Exact; keeps the sign of zero.
#[inline(always)]
pub fn floor(x: f32) -> f32 {
    x.floor()
}

/// The smallest integer not below `x`. Exact; keeps the sign of zero.
#[inline(always)]
pub fn ceil(x: f32) -> f32 {
    x.ceil()
}

/// The integer next to `x` on the side of zero.
#[inline(always)]
pub fn trunc(x: f32) -> f32 {
    x.trunc()
}

/// The nearest integer; a half goes away from zero.
#[inline(always)]
pub fn round(x: f32) -> f32 {
    // The largest number below one half: with a half itself, 0.49999997 would sum up to 1.
    const BELOW_HALF: f32 = 0.499_999_97;
    (x + BELOW_HALF.copysign(x)).trunc()
}

/// `x - floor(x)`, in 0 … 1 without the 1: where it would round to 1, the number before. NaN for infinities.
#[inline(always)]
pub fn frac(x: f32) -> f32 {
    const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;
    let part = x - x.floor();
    if part > BELOW_ONE { BELOW_ONE } else { part }
}

/// -1, 0 or 1; zeros and NaN stay what they are.
#[inline(always)]
pub fn sign(x: f32) -> f32 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else {
        x
    }
}

/// Up to this quotient [`modulo_near`] is exact: the 28 bits of the quotient and the 24 of the divisor
/// fit into the 53 of an f64.
const QUOTIENT_LIMIT: f64 = (1 << 28) as f64;

/// Is `a / b` beyond what [`modulo_near`] can do?
#[inline(always)]
pub(super) fn modulo_is_far(a: f32, b: f32) -> bool {
    (f64::from(a) / f64::from(b)).abs() >= QUOTIENT_LIMIT
}

/// The remainder of `a / b` with the sign of `b`, exact but for one rounding, where the quotient is below 2^28.
#[inline(always)]
pub(super) fn modulo_near(a: f32, b: f32) -> f32 {
    let (x, y) = (f64::from(a), f64::from(b));
    let rest = x - (x / y).floor() * y;
    // A quotient that rounded up to an integer leaves the rest one divisor short.
    let rest = if rest * y < 0.0 { rest + y } else { rest };
    finish_modulo(a, b, rest as f32)
}

/// [`modulo`] where `b` is a power of two, 1 to 2^100: quotient and product are exact.
#[inline(always)]
pub fn modulo_of_power(a: f32, b: f32) -> f32 {
    let rest = a - (a / b).floor() * b;
    // Where the quotient was too small to be told from 0.
    let rest = if rest < 0.0 { rest + b } else { rest };
    let rest = if rest >= b { f32::from_bits(b.to_bits().wrapping_sub(1)) } else { rest };
    if rest == 0.0 { 0.0 } else { rest }
}

/// The remainder where the quotient is large: the loop of `fmod`.
pub(super) fn modulo_far(a: f32, b: f32) -> f32 {
    let rest = libm::fmodf(a, b);
    let against = rest != 0.0 && (rest < 0.0) != (b < 0.0);
    finish_modulo(a, b, if against { rest + b } else { rest })
}

/// Keeps the remainder below `b` in size where rounding made it `b`; gives zeros the sign of `b`; divides by infinities.
#[inline(always)]
fn finish_modulo(a: f32, b: f32, rest: f32) -> f32 {
    let below = f32::from_bits(b.to_bits().wrapping_sub(1));
    let rest = if rest.abs() >= b.abs() { below } else { rest };
    let by_infinity = if (a * b >= 0.0) | (a == 0.0) { a } else { b };
    let rest = if b.is_infinite() & a.is_finite() { by_infinity } else { rest };
    if rest == 0.0 { 0.0_f32.copysign(b) } else { rest }
}

/// The remainder of `a / b` with the sign of `b`, as Python's `%`: `a - b * floor(a / b)` without its
/// rounding errors, and below `b` in size. NaN for b = 0 and for infinite a; for infinite b it is `a`
/// where the signs agree, else `b`.
#[inline(always)]
pub fn modulo(a: f32, b: f32) -> f32 {
    if modulo_is_far(a, b) { modulo_far(a, b) } else { modulo_near(a, b) }
}
