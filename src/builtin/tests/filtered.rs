//! Steps and pulses with a width, against sums over many places of the sharp ones.

use super::super::find;
use super::canonical::run;
use crate::lanes::Isa;
use proptest::prelude::*;

/// The value of a function at one place.
fn at(name: &str, args: &[f32]) -> f32 {
    let args: Vec<Vec<f32>> = args.iter().map(|&x| vec![x]).collect();
    run(name, Isa::detect(), 1, 0, &args)[0]
}

/// The mean of `f` over a box of that width, from so many places of it.
fn mean(f: impl Fn(f64) -> f64, x: f32, width: f32) -> f64 {
    const PLACES: i32 = 1 << 14;
    let place = |i| f64::from(x) + f64::from(width) * ((f64::from(i) + 0.5) / f64::from(PLACES) - 0.5);
    (0..PLACES).map(|i| f(place(i))).sum::<f64>() / f64::from(PLACES)
}

fn step(edge: f32) -> impl Fn(f64) -> f64 {
    move |x| f64::from(x >= edge.into())
}

fn ramp(a: f32, b: f32, x: f64) -> f64 {
    ((x - f64::from(a)) / f64::from(b - a)).clamp(0.0, 1.0)
}

fn frac(x: f64) -> f64 {
    x - x.floor()
}

/// What a sharp edge leaves of a sum over places.
const NEAR: f64 = 4e-4;

#[track_caller]
fn near(found: f32, wanted: f64, tolerance: f64) {
    assert!((f64::from(found) - wanted).abs() < tolerance, "{found} and not {wanted}");
}

proptest! {
    #[test]
    fn filtered_forms_are_means(
        a in -2.0f32..2.0,
        b in -2.0f32..2.0,
        x in -3.0f32..3.0,
        exponent in -3.0f32..4.0,
        duty in 0.0f32..1.0,
        negative: bool,
    ) {
        let wide = crate::math::exp2(exponent);
        let width = if negative { -wide } else { wide };
        near(at("step", &[a, x, width]), mean(step(a), x, wide), NEAR);
        near(at("pulse", &[a, b, x, width]), mean(|x| step(a)(x) - step(b)(x), x, wide), NEAR);
        let smooth = |x| { let t = ramp(a, b, x); t * t * (3.0 - 2.0 * t) };
        near(at("smoothstep", &[a, b, x, width]), mean(smooth, x, wide), NEAR);
        let smoother = |x| { let t = ramp(a, b, x); t * t * t * (t * (t * 6.0 - 15.0) + 10.0) };
        near(at("smootherstep", &[a, b, x, width]), mean(smoother, x, wide), NEAR);
        // An edge for each period.
        let train = mean(|x| f64::from(frac(x) < duty.into()), x, wide);
        near(at("pulsetrain", &[x, duty, width]), train, 40.0 * NEAR);
        near(at("frac", &[x, width]), mean(frac, x, wide), 40.0 * NEAR);
    }

    #[test]
    fn catstep_is_the_filter_under_the_step(edge in -2.0f32..2.0, x in -6.0f32..6.0, width in 0.1f32..3.0) {
        // The filter of four widths, piece by piece.
        let filter = |t: f64| match t.abs() {
            t if t < 1.0 => 1.5 * t * t * t - 2.5 * t * t + 1.0,
            t if t < 2.0 => -0.5 * t * t * t + 2.5 * t * t - 4.0 * t + 2.0,
            _ => 0.0,
        };
        let weighed = |y: f64| 4.0 * filter((y - f64::from(x)) / f64::from(width)) * step(edge)(y);
        near(at("catstep", &[edge, x, width]), mean(weighed, x, 4.0 * width), NEAR);
    }

    #[test]
    fn whole_periods_change_nothing(x in 0.0f32..1.0, duty in 0.0f32..1.0, k in 0i32..12) {
        // In steps of 2^-10, so that x is the same far out.
        let x = (x * 1024.0).floor() / 1024.0;
        let far = x + f32::from(1u16 << k) * if k % 2 == 0 { 1.0 } else { -1.0 };
        for width in [0.25, 1e-3, 1.75, 7.0, 100.5] {
            prop_assert_eq!(at("pulsetrain", &[x, duty, width]), at("pulsetrain", &[far, duty, width]));
            prop_assert_eq!(at("frac", &[x, width]), at("frac", &[far, width]));
        }
    }
}

#[test]
fn the_widest_and_the_narrowest_keep_their_digits() {
    for width in [1.0, 2.0, 3.0, 12345.0, 1e9, 1e30, f32::MAX, f32::INFINITY] {
        for x in [0.0, 0.3, -7.7, 1e5, 123456.79, -1e20] {
            assert_eq!(at("pulsetrain", &[x, 0.3, width]), 0.3, "{x} {width}");
            assert_eq!(at("frac", &[x, width]), 0.5, "{x} {width}");
        }
    }
    // 16777215 periods and nothing; half a period more is not a number of 32 bits, but 0.5 in 4194304.5 is.
    near(at("frac", &[0.25, 4_194_304.5]), 0.5 + 0.5 * (0.25 - 0.5) / 4_194_304.5, 1e-7);
    // Half of a box far narrower than the place has digits.
    for width in [1e-3, 1e-10, 1e-30, 1e-45] {
        assert_eq!(at("step", &[1.0, 1.0, width]), 0.5);
        assert_eq!(at("pulse", &[1.0, 2.0, 2.0, width]), 0.5);
        assert_eq!(at("pulsetrain", &[3.0, 0.25, width]), 0.5);
        assert_eq!(at("frac", &[5.0, width]), 0.5);
        near(at("smoothstep", &[0.0, 1.0, 0.25, width]), 0.15625, 1e-6);
    }
    // A pulse far narrower than the box.
    near(at("pulse", &[0.0, 1e-20, 0.0, 1.0]) * 1e20, 1.0, 1e-6);
    for name in ["step", "catstep"] {
        assert_eq!(at(name, &[0.0, 5.0, f32::INFINITY]), 0.5);
    }
    assert_eq!(at("smoothstep", &[0.0, 1.0, 5.0, f32::INFINITY]), 0.5);
}

#[test]
fn what_is_no_number_gives_none() {
    for name in ["step", "smoothstep", "smootherstep", "catstep", "pulse", "pulsetrain", "frac"] {
        let count = find(name).unwrap().params.len();
        for k in 0..count {
            let mut args = [0.25, 0.5, 0.75, 1.25][4 - count..].to_vec();
            args[k] = f32::NAN;
            assert!(at(name, &args).is_nan(), "{name} {args:?}");
        }
    }
}
