//! The functions over slices.

use super::{round, trigonometric};
use crate::lanes::{Arg, Isa, Kernel, any1, map1, map2};

/// Slice forms of functions that are one loop.
macro_rules! lanes {
    ($($lanes:ident = $function:ident;)*) => { $(
        #[doc = concat!("`", stringify!($function), "` of each lane.")]
        pub fn $lanes(isa: Isa, a: &[f32], out: &mut [f32]) {
            map1(isa, a, out, super::$function);
        }
    )* };
}

lanes! {
    asin_lanes = asin; acos_lanes = acos; atan_lanes = atan;
    sinh_lanes = sinh; cosh_lanes = cosh; tanh_lanes = tanh;
    exp_lanes = exp; exp2_lanes = exp2; log_lanes = log; log2_lanes = log2; log10_lanes = log10;
    sqrt_lanes = sqrt; sign_lanes = sign; frac_lanes = frac;
    floor_lanes = floor; ceil_lanes = ceil; round_lanes = round; trunc_lanes = trunc;
}

/// Slice forms of functions of two arguments that are one loop.
macro_rules! lanes2 {
    ($($lanes:ident = $function:ident;)*) => { $(
        #[doc = concat!("[`", stringify!($function), "`](super::", stringify!($function), ") of each pair of lanes.")]
        pub fn $lanes(isa: Isa, a: Arg, b: Arg, out: &mut [f32]) {
            map2(isa, a, b, out, super::$function);
        }
    )* };
}

lanes2! { atan2_lanes = atan2; pow_lanes = pow; hypot_lanes = hypot; }

/// The largest size among the lanes; a NaN counts as larger than all. Cheaper than to ask each lane if it is far.
struct Largest<'a>(&'a [f32]);

impl Kernel for Largest<'_> {
    type Output = f32;
    #[inline(always)]
    fn run(self) -> f32 {
        // Sizes have the order of their bits, as integers with sign too, which every instruction set can compare.
        let largest = self.0.iter().fold(0, |largest: i32, x| largest.max(x.abs().to_bits() as i32));
        f32::from_bits(largest as u32)
    }
}

/// The fast loop over all lanes, then the slow function for those lanes that it cannot do.
#[inline(always)]
fn repaired(isa: Isa, a: &[f32], out: &mut [f32], near: impl Fn(f32) -> f32 + Copy, far: fn(f32) -> f32) {
    map1(isa, a, out, near);
    if trigonometric::is_far(isa.run(Largest(a))) {
        for (x, out) in a.iter().zip(out).filter(|(x, _)| trigonometric::is_far(**x)) {
            *out = far(*x);
        }
    }
}

/// [`sin`](super::sin) of each lane.
pub fn sin_lanes(isa: Isa, a: &[f32], out: &mut [f32]) {
    repaired(isa, a, out, trigonometric::sin_near, libm::sinf);
}

/// [`cos`](super::cos) of each lane.
pub fn cos_lanes(isa: Isa, a: &[f32], out: &mut [f32]) {
    repaired(isa, a, out, trigonometric::cos_near, libm::cosf);
}

/// [`tan`](super::tan) of each lane.
pub fn tan_lanes(isa: Isa, a: &[f32], out: &mut [f32]) {
    repaired(isa, a, out, trigonometric::tan_near, trigonometric::tan_far);
}

/// [`modulo`](super::modulo) of each pair of lanes.
pub fn modulo_lanes(isa: Isa, a: Arg, b: Arg, out: &mut [f32]) {
    // Where the quotient is too large for the loop, mark the lane with an infinity.
    map2(isa, a, b, out, |a, b| {
        let rest = round::modulo_near(a, b);
        if round::modulo_is_far(a, b) { f32::INFINITY } else { rest }
    });
    if any1(isa, out, f32::is_infinite) {
        for (i, out) in out.iter_mut().enumerate() {
            let (a, b) = (a.get(i), b.get(i));
            if round::modulo_is_far(a, b) {
                *out = round::modulo_far(a, b);
            }
        }
    }
}
