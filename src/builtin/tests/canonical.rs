//! One canonical scalar line for each function that works component by component, run over awkward numbers.

use super::super::{Call, all, find};
use crate::lanes::Isa;
use crate::value::{Lanes, Mask, Plane, Value};
use std::f64::consts::{PI, TAU};

/// What a function is, in double precision. `error` is what the kernel may be off by, in parts of 2^-24 of
/// the result, or of 1 where that is smaller and `absolute` is said.
struct Line {
    name: &'static str,
    f: Formula,
    error: f64,
    absolute: bool,
}

enum Formula {
    One(fn(f64) -> f64),
    Two(fn(f64, f64) -> f64),
    Three(fn(f64, f64, f64) -> f64),
    Four(fn(f64, f64, f64, f64) -> f64),
}
use Formula::{Four, One, Three, Two};

const fn line(name: &'static str, f: Formula, error: f64) -> Line {
    Line { name, f, error, absolute: false }
}

const fn near_one(name: &'static str, f: Formula, error: f64) -> Line {
    Line { name, f, error, absolute: true }
}

fn step(a: f64, x: f64) -> f64 {
    if x >= a { 1.0 } else { 0.0 }
}

fn ramp(a: f64, b: f64, x: f64) -> f64 {
    if x.is_nan() || a.is_nan() || b.is_nan() {
        f64::NAN
    } else if a == b {
        step(a, x)
    } else {
        ((x - a) / (b - a)).clamp(0.0, 1.0)
    }
}

/// The share of a box of that width about x that lies above a.
fn above(a: f64, x: f64, width: f64) -> f64 {
    ((x - a) / width.abs() + 0.5).clamp(0.0, 1.0)
}

/// A curve from 0 at a to 1 at b under a box: Gauss's rule of three points is exact for the pieces inside.
fn curve(f: fn(f64) -> f64, a: f64, b: f64, x: f64, width: f64) -> f64 {
    if width == 0.0 || width.is_nan() {
        return f(ramp(a, b, x)) + 0.0 * width;
    }
    if a == b {
        return above(a, x, width);
    }
    let (t, half) = ((x - a) / (b - a), 0.5 * (width / (b - a)).abs());
    let (low, high) = ((t - half).clamp(0.0, 1.0), (t + half).clamp(0.0, 1.0));
    let (middle, reach) = (0.5 * (low + high), 0.5 * (high - low) * 0.6f64.sqrt());
    let mean = (5.0 * f(middle - reach) + 8.0 * f(middle) + 5.0 * f(middle + reach)) / 18.0;
    let inside = (above(0.0, t, 2.0 * half) - above(1.0, t, 2.0 * half)).abs();
    inside * mean + above(1.0, t, 2.0 * half)
}

/// The integral of the Catmull-Rom filter from 0 on.
fn catmull_rom(t: f64) -> f64 {
    match t.abs() {
        a if a < 1.0 => t * (1.0 - 5.0 * a * a / 6.0 + 3.0 * a * a * a / 8.0),
        a if a < 2.0 => {
            (2.0 * a - 2.0 * a * a + 5.0 * a * a * a / 6.0 - a * a * a * a / 8.0 - 1.0 / 6.0).copysign(t)
        }
        a if a.is_nan() => a,
        _ => 0.5f64.copysign(t),
    }
}

fn bias(b: f64, x: f64) -> f64 {
    libm::pow(x, libm::log(b) / libm::log(0.5))
}

fn gain(g: f64, x: f64) -> f64 {
    if x < 0.5 { bias(1.0 - g, 2.0 * x) / 2.0 } else { 1.0 - bias(1.0 - g, 2.0 - 2.0 * x) / 2.0 }
}

/// The cycloid by bisection.
fn cycloid(x: f64) -> f64 {
    let a = (x - TAU * (x / TAU).round()).abs();
    let (mut low, mut high) = (0.0, PI);
    for _ in 0..80 {
        let t = 0.5 * (low + high);
        if t - libm::sin(t) < a { low = t } else { high = t }
    }
    if x.is_finite() { libm::cos(low) } else { f64::NAN }
}

fn sign(x: f64) -> f64 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else {
        x
    }
}

fn encode(x: f64) -> f64 {
    let a = x.abs();
    (if a <= 0.0031308 { 12.92 * a } else { 1.055 * libm::pow(a, 1.0 / 2.4) - 0.055 }).copysign(x)
}

fn decode(x: f64) -> f64 {
    let a = x.abs();
    (if a <= 0.04045 { a / 12.92 } else { libm::pow((a + 0.055) / 1.055, 2.4) }).copysign(x)
}

const LINES: &[Line] = &[
    line("abs", One(f64::abs), 0.0),
    line("sign", One(sign), 0.0),
    line("floor", One(f64::floor), 0.0),
    line("ceil", One(f64::ceil), 0.0),
    line("trunc", One(f64::trunc), 0.0),
    line("sqrt", One(f64::sqrt), 1.0),
    line("cbrt", One(libm::cbrt), 4.0),
    line("exp", One(libm::exp), 4.0),
    line("exp2", One(libm::exp2), 4.0),
    line("log", One(libm::log), 4.0),
    line("log2", One(libm::log2), 4.0),
    line("log10", One(libm::log10), 4.0),
    line("isnan", One(|x| f64::from(x.is_nan())), 0.0),
    line("isinf", One(|x| f64::from(x.is_infinite())), 0.0),
    line("isfinite", One(|x| f64::from(x.is_finite())), 0.0),
    near_one("sin", One(libm::sin), 4.0),
    near_one("cos", One(libm::cos), 4.0),
    near_one("asin", One(libm::asin), 4.0),
    near_one("acos", One(libm::acos), 8.0),
    near_one("atan", Two(libm::atan2), 8.0),
    line("sinh", One(libm::sinh), 8.0),
    line("cosh", One(libm::cosh), 8.0),
    line("tanh", One(libm::tanh), 8.0),
    line("radians", One(|x| x * PI / 180.0), 2.0),
    line("degrees", One(|x| x * 180.0 / PI), 2.0),
    near_one("cycloid", One(|x| if x.abs() < 100.0 { cycloid(x) } else { f64::NAN }), 200.0),
    line("linear_to_srgb", One(encode), 16.0),
    line("srgb_to_linear", One(decode), 64.0),
    line("pow", Two(libm::pow), 4.0),
    near_one("step", Three(|a, x, w| if w == 0.0 { step(a, x) } else { above(a, x, w) }), 1.0),
    near_one(
        "catstep",
        Three(|a, x, w| if w == 0.0 { step(a, x) } else { 0.5 + catmull_rom((x - a) / w.abs()) }),
        2.0,
    ),
    near_one("bias", Two(bias), 64.0),
    near_one("gain", Two(gain), 64.0),
    line("gammacorrect", Two(|gamma, x| libm::pow(x, 1.0 / gamma)), 200.0),
    near_one(
        "clamp",
        Three(|x, a, b| {
            if x < a {
                a
            } else if x > b {
                b
            } else {
                x
            }
        }),
        0.0,
    ),
    near_one("boxstep", Three(ramp), 8.0),
    near_one("smoothstep", Four(|a, b, x, w| curve(|t| t * t * (3.0 - 2.0 * t), a, b, x, w)), 16.0),
    near_one(
        "smootherstep",
        Four(|a, b, x, w| curve(|t| t * t * t * (t * (6.0 * t - 15.0) + 10.0), a, b, x, w)),
        64.0,
    ),
    near_one(
        "pulse",
        Four(|a, b, x, w| match w {
            0.0 => step(a, x) - step(b, x),
            _ => above(a, x, w) - above(b, x, w),
        }),
        1.0,
    ),
    near_one("mix", Three(|a, b, t| a * (1.0 - t) + b * t), 64.0),
    near_one("lerp", Three(|a, b, t| a * (1.0 - t) + b * t), 64.0),
];

/// Functions whose value hangs on the last bits of their arguments are tested beside their definition, in `crate::math`.
/// Those of a period under a box are integrated in [`super::filtered`].
const ELSEWHERE: &[&str] = &["round", "frac", "mod", "tan", "hypot", "pulsetrain"];

const AWKWARD: &[f32] = &[
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    -0.5,
    0.25,
    0.75,
    0.9,
    0.003,
    2.0,
    -2.5,
    3.0,
    3.7,
    -7.25,
    10.0,
    1e-3,
    1e-20,
    1e-40,
    -1e-40,
    f32::MIN_POSITIVE,
    1e10,
    -1e10,
    1e30,
    f32::MAX,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

fn close(line: &Line, found: f32, exact: f64) -> bool {
    let rounded = exact as f32;
    if found.is_nan() || exact.is_nan() {
        return found.is_nan() && exact.is_nan();
    }
    if found == rounded {
        return true;
    }
    let unit = f64::from(f32::EPSILON) / 2.0;
    let scale = if line.absolute { exact.abs().max(1.0) } else { exact.abs() };
    // Where the result leaves the range of f32, either side of the edge will do; below it, a few steps.
    let edge = exact.abs() > f64::from(f32::MAX) * (1.0 - 1e-5) && found.abs() >= f32::MAX * (1.0 - 1e-5);
    edge || (f64::from(found) - exact).abs() <= line.error * unit * scale + 2e-38
}

/// Runs a function on the awkward numbers, `n` lanes at a time; argument `k` is uniform if bit `k` is set.
pub(super) fn run(name: &str, isa: Isa, n: usize, uniform: usize, args: &[Vec<f32>]) -> Vec<f32> {
    let builtin = find(name).unwrap();
    let values: Vec<Value> = args
        .iter()
        .enumerate()
        .map(|(k, numbers)| {
            Value::scalar(if uniform >> k & 1 == 1 {
                Plane::Uniform(numbers[0])
            } else {
                Plane::Varying(Lanes::filled(n, |out| out.copy_from_slice(&numbers[..n])))
            })
        })
        .collect();
    let call = Call { isa, n, pixels: n, mask: &Mask::All, args: &values, max_cells: 100, textures: &[] };
    let value = builtin.apply(&call).unwrap();
    (0..n).map(|i| value.planes[0].lane(i)).collect()
}

#[test]
fn each_function_is_its_formula() {
    let mut wrong = Vec::new();
    for line in LINES {
        let arity = match line.f {
            One(_) => 1,
            Two(_) => 2,
            Three(_) => 3,
            Four(_) => 4,
        };
        let count = AWKWARD.len();
        let n = count.pow(arity);
        let digit = |i: usize, k: u32| AWKWARD[i / count.pow(k) % count];
        let args: Vec<Vec<f32>> = (0..arity).map(|k| (0..n).map(|i| digit(i, k)).collect()).collect();
        let found = run(line.name, Isa::detect(), n, 0, &args);
        for i in 0..n {
            let x: Vec<f64> = args.iter().map(|a| f64::from(a[i])).collect();
            let exact = match line.f {
                One(f) => f(x[0]),
                Two(f) => f(x[0], x[1]),
                Three(f) => f(x[0], x[1], x[2]),
                Four(f) => f(x[0], x[1], x[2], x[3]),
            };
            // Far out, the argument's own steps are larger than the period.
            let skip = line.name == "cycloid" && x[0].abs() > 100.0;
            // Where f32 overflows on the way and f64 does not, the exact value is another.
            let limit = [f64::INFINITY, 1e35, 1e9, 1e9][arity as usize - 1];
            let huge = x.iter().any(|x| x.abs() > limit);
            if !skip && !huge && !close(line, found[i], exact) {
                wrong.push(format!("{}{x:?}: {} and not {exact}", line.name, found[i]));
            }
        }
    }
    assert!(wrong.is_empty(), "{} wrong, such as\n{}", wrong.len(), wrong[..wrong.len().min(60)].join("\n"));
}

#[test]
fn batches_agree_with_lanes_to_the_bit() {
    for b in all()
        .filter(|b| !matches!(b.kernel, super::super::Kernel::Whole(_) | super::super::Kernel::Shadowed(_)))
    {
        let arity = b.params.len().max(if matches!(b.kernel, super::super::Kernel::Fold(_)) { 2 } else { 1 });
        let number = |i: usize, k: usize| AWKWARD[(i * (k + 1) + 5 * k) % AWKWARD.len()];
        let args: Vec<Vec<f32>> = (0..arity).map(|k| (0..257).map(|i| number(i, k)).collect()).collect();
        for uniform in 0..1 << arity {
            for n in [1, 7, 255, 256, 257] {
                let fast = run(b.name, Isa::detect(), n, uniform, &args);
                let plain = run(b.name, Isa::baseline(), n, uniform, &args);
                for i in 0..n {
                    let alone: Vec<Vec<f32>> = args
                        .iter()
                        .enumerate()
                        .map(|(k, a)| vec![a[if uniform >> k & 1 == 1 { 0 } else { i }]])
                        .collect();
                    let alone = run(b.name, Isa::baseline(), 1, 0, &alone)[0];
                    let same = |x: f32| x.to_bits() == alone.to_bits() || (x.is_nan() && alone.is_nan());
                    assert!(
                        same(fast[i]) && same(plain[i]),
                        "{} lane {i} of {n}: {} {} {alone}",
                        b.name,
                        fast[i],
                        plain[i]
                    );
                }
            }
        }
    }
}

#[test]
fn no_function_is_forgotten() {
    for b in all()
        .filter(|b| !matches!(b.kernel, super::super::Kernel::Whole(_) | super::super::Kernel::Shadowed(_)))
    {
        let known = LINES.iter().any(|l| l.name == b.name) || ELSEWHERE.contains(&b.name);
        assert!(known, "{} has no canonical line", b.name);
    }
}
