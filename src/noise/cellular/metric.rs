//! What distance is.

use crate::lanes::array;
use crate::math::sign;

/// A way to measure vectors.
pub trait Metric: Copy + Send + Sync + 'static {
    /// A number that grows with the length of a vector, not below 0.
    fn measure<const D: usize>(away: [f32; D]) -> f32;
    /// The length that has this measure.
    fn length(measure: f32) -> f32;
    /// The derivative of a vector's length; 0 if it has none.
    fn slope<const D: usize>(away: [f32; D]) -> [f32; D];
}

/// The square root of the sum of squares, which are the measure.
#[derive(Clone, Copy)]
pub struct Euclidean;
/// The sum of sizes.
#[derive(Clone, Copy)]
pub struct Manhattan;
/// The greatest size.
#[derive(Clone, Copy)]
pub struct Chebyshev;

impl Metric for Euclidean {
    #[inline(always)]
    fn measure<const D: usize>(away: [f32; D]) -> f32 {
        let mut sum = away[0] * away[0];
        for a in &away[1..] {
            sum += a * a;
        }
        sum
    }

    #[inline(always)]
    fn length(measure: f32) -> f32 {
        measure.sqrt()
    }

    #[inline(always)]
    fn slope<const D: usize>(away: [f32; D]) -> [f32; D] {
        let length = Self::measure(away).sqrt();
        let inverse = if length > 0.0 { 1.0 / length } else { 0.0 };
        array(|k| away[k] * inverse)
    }
}

impl Metric for Manhattan {
    #[inline(always)]
    fn measure<const D: usize>(away: [f32; D]) -> f32 {
        let mut sum = away[0].abs();
        for a in &away[1..] {
            sum += a.abs();
        }
        sum
    }

    #[inline(always)]
    fn length(measure: f32) -> f32 {
        measure
    }

    #[inline(always)]
    fn slope<const D: usize>(away: [f32; D]) -> [f32; D] {
        array(|k| sign(away[k]))
    }
}

impl Metric for Chebyshev {
    #[inline(always)]
    fn measure<const D: usize>(away: [f32; D]) -> f32 {
        let mut most = away[0].abs();
        for a in &away[1..] {
            most = greater(most, a.abs());
        }
        most
    }

    #[inline(always)]
    fn length(measure: f32) -> f32 {
        measure
    }

    #[inline(always)]
    fn slope<const D: usize>(away: [f32; D]) -> [f32; D] {
        // Along the first of the longest.
        let mut slope = [0.0; D];
        let mut longest = Self::measure(away);
        for k in 0..D {
            let this = away[k].abs() == longest;
            slope[k] = if this { sign(away[k]) } else { 0.0 };
            longest = if this { -1.0 } else { longest };
        }
        slope
    }
}

#[inline(always)]
pub fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
pub fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
