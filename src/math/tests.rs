//! Accuracy against libm's f64, special cases, and the same bits on every instruction set and length.

use super::*;
use crate::lanes::{Arg, Isa};

type Lanes1 = fn(Isa, &[f32], &mut [f32]);
type Lanes2 = fn(Isa, Arg, Arg, &mut [f32]);
/// Name, one lane, many lanes, the truth, the error allowed in ulp.
type Unary = (&'static str, fn(f32) -> f32, Lanes1, fn(f64) -> f64, f64);

const UNARY: &[Unary] = &[
    ("sin", sin, sin_lanes, libm::sin, 0.6),
    ("cos", cos, cos_lanes, libm::cos, 0.6),
    ("tan", tan, tan_lanes, libm::tan, 0.6),
    ("asin", asin, asin_lanes, libm::asin, 0.6),
    ("acos", acos, acos_lanes, libm::acos, 0.6),
    ("atan", atan, atan_lanes, libm::atan, 0.6),
    ("sinh", sinh, sinh_lanes, libm::sinh, 0.6),
    ("cosh", cosh, cosh_lanes, libm::cosh, 0.6),
    ("tanh", tanh, tanh_lanes, libm::tanh, 0.6),
    ("exp", exp, exp_lanes, libm::exp, 1.2),
    ("exp2", exp2, exp2_lanes, libm::exp2, 0.6),
    ("log", log, log_lanes, libm::log, 0.9),
    ("log2", log2, log2_lanes, libm::log2, 0.51),
    ("log10", log10, log10_lanes, libm::log10, 0.51),
    ("sqrt", sqrt, sqrt_lanes, libm::sqrt, 0.51),
    ("floor", floor, floor_lanes, libm::floor, 0.0),
    ("ceil", ceil, ceil_lanes, libm::ceil, 0.0),
    ("trunc", trunc, trunc_lanes, libm::trunc, 0.0),
    ("round", round, round_lanes, libm::round, 0.0),
    ("sign", sign, sign_lanes, |x| if x == 0.0 || x.is_nan() { x } else { x.signum() }, 0.0),
    ("frac", frac, frac_lanes, |x| x - libm::floor(x), 1.0),
];

/// Name, one lane, many lanes.
type Binary = (&'static str, fn(f32, f32) -> f32, Lanes2);

const BINARY: &[Binary] = &[
    ("atan2", atan2, atan2_lanes),
    ("pow", pow, pow_lanes),
    ("hypot", hypot, hypot_lanes),
    ("modulo", modulo, modulo_lanes),
];

/// Numbers that break careless code.
fn awkward() -> Vec<f32> {
    let mut all = vec![0.0, 1e-45, 1.1754942e-38, f32::MIN_POSITIVE, 1e-20, 0.1, 0.49999997, 0.5, 0.99999994];
    all.extend([1.0, 1.0000001, 1.5, 2.0, 2.5, 3.0, 10.0, 88.72283, 88.72284, 89.0, 103.9, 104.0, 127.0]);
    all.extend([128.0, 149.0, 150.0, 8388607.5, 8388608.0, 16777215.0, 16777216.0, 4194304.0, 4194304.5]);
    all.extend([1e10, 1e20, 1e30, f32::MAX, f32::INFINITY, f32::NAN]);
    for k in 1..100 {
        all.push(k as f32 * std::f32::consts::FRAC_PI_2);
        all.push((k as f32 * 12345.0) * std::f32::consts::PI);
    }
    let negative: Vec<f32> = all.iter().map(|x| -x).collect();
    all.extend(negative);
    all
}

/// Numbers of all sizes, and of the common sizes, from a linear congruence.
fn random(n: usize) -> Vec<f32> {
    let mut state = 0x1234_5678_9abc_def1_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 32) as u32
    };
    let numbers = (0..n).map(|i| match i % 3 {
        0 => f32::from_bits(next()),
        1 => (next() as i32 as f32) / (1_u32 << 31) as f32 * 1.01,
        _ => (next() as i32 as f32) / (1_u32 << 31) as f32 * 100.0,
    });
    numbers.collect()
}

/// The distance from the truth in units of the last place of the f32 nearest to it.
fn ulps(got: f32, truth: f64) -> f64 {
    let nearest = truth as f32;
    if got.is_nan() || nearest.is_nan() {
        return if got.is_nan() == nearest.is_nan() { 0.0 } else { f64::INFINITY };
    }
    if got == nearest && got.is_infinite() {
        return 0.0;
    }
    if got == nearest {
        // Half an ulp or less; only the sign of zero can still be wrong.
        return if got == 0.0 && got.is_sign_negative() != nearest.is_sign_negative() {
            9.0
        } else {
            0.5_f64.min(err(got, truth))
        };
    }
    err(got, truth)
}

fn err(got: f32, truth: f64) -> f64 {
    let size = (truth as f32).abs().min(f32::MAX);
    let ulp = f64::from(f32::from_bits(size.to_bits() + 1)) - f64::from(size);
    let ulp = if ulp.is_finite() { ulp } else { f64::from(f32::MAX) * 2.0_f64.recip() };
    (f64::from(got) - truth).abs() / ulp
}

/// The bits, with one NaN for all.
fn bits(x: &[f32]) -> Vec<u32> {
    x.iter().map(|x| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() }).collect()
}

#[test]
fn unary_functions_are_accurate() {
    let mut numbers = awkward();
    numbers.extend(random(300_000));
    for &(name, function, _, truth, allowed) in UNARY {
        let mut worst = (0.0, 0.0);
        for &x in &numbers {
            let error = ulps(function(x), truth(f64::from(x)));
            if error > worst.0 {
                worst = (error, x);
            }
        }
        println!("{name}: {:.4} ulp at {:e}", worst.0, worst.1);
        let allowed = if allowed == 0.0 { 1e-9 } else { allowed };
        assert!(worst.0 <= allowed, "{name}({:e}) = {:e}: {} ulp", worst.1, function(worst.1), worst.0);
    }
}

#[test]
fn angles_are_reduced_accurately() {
    const LIMIT: f32 = 8192.0;
    // A part of all bit patterns, and the neighbours of zeros and poles, where the reduction cancels most.
    let mut angles: Vec<f32> = (0..=LIMIT.to_bits()).step_by(4099).map(f32::from_bits).collect();
    for k in 1..=(f64::from(LIMIT) * std::f64::consts::FRAC_2_PI) as u32 {
        let bits = ((f64::from(k) * std::f64::consts::FRAC_PI_2) as f32).to_bits();
        angles.extend((bits - 2..=bits + 2).map(f32::from_bits));
    }
    for &(name, function, _, truth, allowed) in &UNARY[..3] {
        let mirrored = if name == "cos" { 1.0 } else { -1.0 };
        for &x in &angles {
            let (got, error) = (function(x), ulps(function(x), truth(f64::from(x))));
            assert!(error <= allowed, "{name}({x:e}) = {got:e}: {error} ulp");
            assert_eq!(function(-x).to_bits(), (mirrored * got).to_bits(), "{name}({:e})", -x);
        }
    }
}

#[test]
fn binary_functions_are_accurate() {
    let numbers = random(200_000);
    let mut pairs: Vec<(f32, f32)> = numbers.chunks_exact(2).map(|p| (p[0], p[1])).collect();
    let awkward = awkward();
    pairs.extend(awkward.iter().flat_map(|&a| awkward.iter().map(move |&b| (a, b))));
    let truths: [fn(f64, f64) -> f64; 3] = [libm::atan2, libm::pow, libm::hypot];
    for (&(name, function, _), truth) in BINARY.iter().zip(truths) {
        let mut worst = (0.0, (0.0, 0.0));
        for &(a, b) in &pairs {
            let error = ulps(function(a, b), truth(f64::from(a), f64::from(b)));
            if error > worst.0 {
                worst = (error, (a, b));
            }
        }
        println!("{name}: {:.4} ulp at {:?}", worst.0, worst.1);
        let (a, b) = worst.1;
        assert!(worst.0 <= 0.6, "{name}({a:e}, {b:e}) = {:e}: {} ulp", function(a, b), worst.0);
    }
}

#[test]
fn every_instruction_set_and_length_gives_the_bits_of_one_lane() {
    let mut numbers = awkward();
    numbers.extend(random(100_000));
    let turned: Vec<f32> = numbers.iter().skip(77).chain(&numbers[..77]).copied().collect();
    for isa in Isa::all() {
        for n in [1, 7, 255, 256, 257, numbers.len()] {
            let (a, b) = (&numbers[..n], &turned[..n]);
            let mut out = vec![0.0; n];
            for &(name, function, lanes, ..) in UNARY {
                lanes(isa, a, &mut out);
                let expected: Vec<f32> = a.iter().map(|&x| function(x)).collect();
                assert_eq!(bits(&out), bits(&expected), "{name} {}", isa.name());
            }
            for &(name, function, lanes) in BINARY {
                lanes(isa, Arg::Varying(a), Arg::Varying(b), &mut out);
                let expected: Vec<f32> = a.iter().zip(b).map(|(&x, &y)| function(x, y)).collect();
                assert_eq!(bits(&out), bits(&expected), "{name} {}", isa.name());
                lanes(isa, Arg::Varying(a), Arg::Uniform(b[0]), &mut out);
                let expected: Vec<f32> = a.iter().map(|&x| function(x, b[0])).collect();
                assert_eq!(bits(&out), bits(&expected), "{name} {} by a uniform", isa.name());
            }
        }
    }
}

/// The remainder as Python has it, in f64.
fn python_modulo(a: f64, b: f64) -> f64 {
    let rest = libm::fmod(a, b);
    if rest != 0.0 { if (b < 0.0) != (rest < 0.0) { rest + b } else { rest } } else { 0.0_f64.copysign(b) }
}

#[test]
fn modulo_is_pythons_and_below_its_divisor() {
    let awkward = awkward();
    let numbers = random(100_000);
    let pairs = numbers.chunks_exact(2).map(|p| (p[0], p[1]));
    for (a, b) in awkward.iter().flat_map(|&a| awkward.iter().map(move |&b| (a, b))).chain(pairs) {
        let (got, truth) = (modulo(a, b), python_modulo(f64::from(a), f64::from(b)));
        if a.is_finite() && b.is_finite() && b != 0.0 {
            assert!(
                got.abs() < b.abs() && got.is_sign_negative() == b.is_sign_negative(),
                "{a:e} {b:e} {got:e}"
            );
        }
        if got.abs() < b.abs() && truth.abs() as f32 >= b.abs() {
            continue; // kept below
        }
        assert!(ulps(got, truth) <= 0.5 + 1e-9, "{a:e} % {b:e} = {got:e}, not {truth:e}");
    }
    for (a, b) in
        awkward.iter().chain(&numbers).flat_map(|&a| [1.0, 2.0, 64.0, (1_u64 << 60) as f32].map(|b| (a, b)))
    {
        let (got, truth) = (modulo_of_power(a, b), modulo(a, b));
        assert!(
            got.to_bits() == truth.to_bits() || got.is_nan() && truth.is_nan(),
            "{a:e} % {b:e} = {got:e}, not {truth:e}"
        );
    }
    assert_eq!((modulo(-1.0, 3.0), modulo(1.0, -3.0), modulo(-1e-20, 1.0)), (2.0, -2.0, 0.99999994));
    assert!(modulo(1.0, 0.0).is_nan() && modulo(f32::INFINITY, 1.0).is_nan());
    assert_eq!((modulo(5.0, f32::INFINITY), modulo(-5.0, f32::INFINITY)), (5.0, f32::INFINITY));
}

#[test]
fn special_values() {
    let inf = f32::INFINITY;
    assert!(sin(inf).is_nan() && cos(-inf).is_nan() && log(-1.0).is_nan() && sqrt(-1.0).is_nan());
    assert_eq!((log(0.0), log(-0.0), log(inf), log10(1000.0), log2(8.0)), (-inf, -inf, inf, 3.0, 3.0));
    assert_eq!((exp(0.0), exp(100.0), exp(-200.0), exp2(10.0), exp2(-149.0)), (1.0, inf, 0.0, 1024.0, 1e-45));
    assert_eq!(
        (pow(f32::NAN, 0.0), pow(1.0, f32::NAN), pow(-1.0, inf), pow(-2.0, 3.0)),
        (1.0, 1.0, 1.0, -8.0)
    );
    assert!(pow(-8.0, 1.0 / 3.0).is_nan() && pow(-1.0, f32::NAN).is_nan());
    assert_eq!((pow(-0.0, -3.0), pow(-0.0, -2.0), pow(-inf, 0.5), pow(3.0, 2.0)), (-inf, inf, inf, 9.0));
    assert_eq!((round(0.5), round(-0.5), round(2.5), round(0.49999997)), (1.0, -1.0, 3.0, 0.0));
    assert_eq!((frac(-1e-20), frac(-0.25), frac(3.75)), (0.99999994, 0.75, 0.75));
    assert_eq!((cos(0.0), hypot(inf, f32::NAN), hypot(3e30, 4e30)), (1.0, inf, 5e30));
}
