//! Directions spread evenly over the sphere, from 32 random bits, without a table.

use super::hash::more;

/// The length of [`direction`]s: their bits serve as integers, and noise is scaled once in the end.
pub const LENGTH: f32 = (1_u32 << 31) as f32;

/// Cosine and sine of up to a quarter turn either way, from the lower 16 bits, signed.
#[inline(always)]
fn half_circle(bits: u32) -> (f32, f32) {
    // sin(π/2 t)/t and cos(π/2 t)/(1 - t²) on |t| ≤ 1, Chebyshev fits in t², errors 1.4e-4 and 3e-5.
    const S: [f32; 3] = [1.570_657_4 / LENGTH, -0.643_457_8 / LENGTH, 0.072_934_65 / LENGTH];
    const C: [f32; 3] = [0.999_973_2, -0.233_217_07, 0.018_668_13];
    const SQUARE: f32 = 1.0 / (LENGTH * LENGTH);
    let t = (bits << 16) as i32 as f32;
    let u = t * t * SQUARE;
    ((1.0 - u) * (C[0] + u * (C[1] + u * C[2])), t * (S[0] + u * (S[1] + u * S[2])))
}

/// The units of [`arc`]'s cosine and sine.
pub const ARC: [f32; 2] = [0.139_467_8, 0.544_176_06];

/// Cosine and sine of up to a quarter turn either way, t = -1 … 1: the more direct way of the noises that need
/// many. Each is in its unit of [`ARC`], to be multiplied by in the end, so that no factor stands before t². `one`
/// is 1, or where t is so many times as large, the square of it.
///
/// Fitted so that the length is 1 within 1e-4 and that the squares of both have the same mean. (The arc is three
/// degrees longer at both ends than it should be, and a turn in ten there not quite evenly gone through.)
#[inline(always)]
pub fn arc(t: f32, one: f32) -> (f32, f32) {
    let u = t * t;
    ((0.943_246_5 * one - u) * (7.601_169 * one - u), t * (2.835_302_8 * one - u))
}

/// All bits as a number in -[`LENGTH`] … [`LENGTH`].
#[inline(always)]
fn coordinate(bits: u32) -> f32 {
    bits as i32 as f32
}

/// Changes the sign by the lowest bit.
#[inline(always)]
fn turn(v: f32, bits: u32) -> f32 {
    f32::from_bits(v.to_bits() ^ (bits << 31))
}

/// A vector of length [`LENGTH`], within 0.02 %, whose direction is even on the sphere in 3 dimensions,
/// and for D = 4 in 4; for D < 3 the first components of the former.
///
/// On a sphere each coordinate is evenly distributed (Archimedes): that is x, of which the
/// upper 16 bits decide. The others go round a circle of what remains, half of it from the lower 16 bits;
/// the lowest bit, which hardly shows in either, then turns the vector about.
#[inline(always)]
pub fn direction<const D: usize>(hash: u32) -> [f32; D] {
    if D == 4 {
        return four(hash);
    }
    let mut g = [0.0; D];
    let x = coordinate(hash);
    g[0] = turn(x, hash);
    if D > 1 {
        let radius = turn((LENGTH * LENGTH - x * x).sqrt(), hash);
        let (cos, sin) = half_circle(hash);
        g[1 % D] = radius * cos;
        g[2 % D] = if D > 2 { radius * sin } else { g[2 % D] };
    }
    g
}

/// The product of [`direction`] with a vector, in fewer steps than by its components.
#[inline(always)]
pub fn along<const D: usize>(hash: u32, v: [f32; D]) -> f32 {
    if D == 4 {
        let g = four::<D>(hash);
        return (g[0] * v[0] + g[1 % D] * v[1 % D]) + (g[2 % D] * v[2 % D] + g[3 % D] * v[3 % D]);
    }
    let x = coordinate(hash);
    let mut sum = x * v[0];
    if D > 1 {
        let radius = (LENGTH * LENGTH - x * x).sqrt();
        let (cos, sin) = half_circle(hash);
        let around = cos * v[1 % D];
        sum += radius * if D > 2 { around + sin * v[2 % D] } else { around };
    }
    turn(sum, hash)
}

/// In four dimensions: two circles whose radii squared share 1 evenly (Marsaglia 1972).
#[inline(always)]
fn four<const D: usize>(hash: u32) -> [f32; D] {
    let share = (coordinate(hash) + LENGTH) * (LENGTH / 2.0);
    let other = more(hash);
    let mut g = [0.0; D];
    for (k, (square, bits)) in [(share, hash), (LENGTH * LENGTH - share, other)].into_iter().enumerate() {
        let radius = turn(square.sqrt(), bits);
        let (cos, sin) = half_circle(bits);
        g[2 * k % D] = radius * cos;
        g[(2 * k + 1) % D] = radius * sin;
    }
    g
}
