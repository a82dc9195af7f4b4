//! Arithmetic, component by component.

use super::call::{Call, Fault};
use super::{Builtin, Kernel, Lanes2, Param, ex, steps};
use crate::lanes::{Arg, Isa, map1, map2, map3};
use crate::math;
use crate::value::Value;

/// The smaller number; NaN if either is. Written out, as `f32::min` leaves open which zero it gives.
#[inline(always)]
pub fn min(a: f32, b: f32) -> f32 {
    if a < b || a.is_nan() { a } else { b }
}

/// The larger number; NaN if either is.
#[inline(always)]
pub fn max(a: f32, b: f32) -> f32 {
    if a > b || a.is_nan() { a } else { b }
}

/// Peachey's `clamp`: as it is between the bounds; NaN stays NaN.
#[inline(always)]
pub fn clamp(x: f32, low: f32, high: f32) -> f32 {
    if x < low {
        low
    } else if x > high {
        high
    } else {
        x
    }
}

/// The cube root of any number, with its sign.
#[inline(always)]
fn cbrt(x: f32) -> f32 {
    let a = x.abs();
    let y = math::pow(a, 1.0 / 3.0);
    // One Newton step takes off the error of the exponent, which is no exact third.
    let better = y - (y - a / (y * y)) * (1.0 / 3.0);
    let root = if a > 0.0 && a < f32::INFINITY { better } else { y };
    root.copysign(x)
}

fn min_lanes(isa: Isa, a: Arg<'_>, b: Arg<'_>, out: &mut [f32]) {
    map2(isa, a, b, out, min);
}

fn max_lanes(isa: Isa, a: Arg<'_>, b: Arg<'_>, out: &mut [f32]) {
    map2(isa, a, b, out, max);
}

/// Reduces several arguments, or the elements of a single vector.
fn extreme(call: &Call<'_>, name: &str, kernel: Lanes2) -> Result<Value, Fault> {
    let elements: Vec<Value>;
    let values = match call.args {
        [one] if !one.shape.is_scalar() => {
            elements = one.elements().collect();
            &elements
        }
        many => many,
    };
    let Some((first, rest)) = values.split_first() else {
        return Err(Fault::of(0, format!("{name} of an empty vector has no value")));
    };
    rest.iter().try_fold(first.clone(), |value, next| call.cells2(&value, next, kernel))
}

/// Arithmetic.
pub static FUNCTIONS: &[Builtin] = &[
    Builtin {
        name: "abs",
        params: &[Param::new("x")],
        brief: "The absolute value.",
        doc: "",
        examples: &[ex("abs(-2)", "2"), ex("abs([-1 2])", "[1 2]")],
        kernel: Kernel::Map1(|isa, a, out| map1(isa, a, out, f32::abs)),
    },
    Builtin {
        name: "sign",
        params: &[Param::new("x")],
        brief: "-1 below zero, 1 above it, 0 at it.",
        doc: "",
        examples: &[ex("sign([-3 0 2])", "[-1 0 1]")],
        kernel: Kernel::Map1(math::sign_lanes),
    },
    Builtin {
        name: "floor",
        params: &[Param::new("x")],
        brief: "The largest whole number not above x.",
        doc: "",
        examples: &[ex("floor([1.7 -1.2])", "[1 -2]")],
        kernel: Kernel::Map1(math::floor_lanes),
    },
    Builtin {
        name: "ceil",
        params: &[Param::new("x")],
        brief: "The smallest whole number not below x.",
        doc: "",
        examples: &[ex("ceil([1.2 -1.7])", "[2 -1]")],
        kernel: Kernel::Map1(math::ceil_lanes),
    },
    Builtin {
        name: "round",
        params: &[Param::new("x")],
        brief: "The nearest whole number.",
        doc: "",
        examples: &[ex("round([1.4 1.6 -1.6])", "[1 2 -2]")],
        kernel: Kernel::Map1(math::round_lanes),
    },
    Builtin {
        name: "trunc",
        params: &[Param::new("x")],
        brief: "The whole part of x: rounds towards zero.",
        doc: "",
        examples: &[ex("trunc([1.7 -1.7])", "[1 -1]")],
        kernel: Kernel::Map1(math::trunc_lanes),
    },
    Builtin {
        name: "frac",
        params: &[Param::new("x"), Param::or("width", "0")],
        brief: "The fractional part: `x - floor(x)`.",
        doc: "At least 0, also for a negative x, so `frac` repeats with period 1 everywhere. With a width, the mean \
              of this sawtooth over that width, as in [step](#step); a large width gives 1/2.",
        examples: &[ex("frac([1.75 -0.25])", "[0.75 0.75]"), ex("frac(1, width = 0.5)", "0.5")],
        kernel: Kernel::Map2(steps::frac),
    },
    Builtin {
        name: "mod",
        params: &[Param::new("a"), Param::new("b")],
        brief: "The remainder of `a / b`, with the sign of b.",
        doc: "The same as `a % b`. For a positive b it is never negative, so patterns made with it repeat \
              through zero, as Peachey's `mod` does (*Texturing and Modeling*, chapter 2, “Periodic Functions”). \
              `mod(a, 0)` is NaN.",
        examples: &[ex("mod(7, 3)", "1"), ex("mod(-1, 3)", "2")],
        kernel: Kernel::Map2(math::modulo_lanes),
    },
    Builtin {
        name: "min",
        params: &[Param::rest("x", 1)],
        brief: "The smallest of several numbers, or of the elements of one vector.",
        doc: "Of several values it works component by component: `min([1 5], [4 2])` is `[1 2]`. Of one vector it \
              gives its smallest element; of a vector of vectors, the smallest in each place. If a number is NaN, \
              so is the result.",
        examples: &[ex("min(3, 1, 2)", "1"), ex("min([1 5], [4 2])", "[1 2]"), ex("min([3 1 2])", "1")],
        kernel: Kernel::Whole(|call| extreme(call, "min", min_lanes)),
    },
    Builtin {
        name: "max",
        params: &[Param::rest("x", 1)],
        brief: "The largest of several numbers, or of the elements of one vector.",
        doc: "Of several values it works component by component: `max(1, [0 2])` is `[1 2]`. Of one vector it \
              gives its largest element; of a vector of vectors, the largest in each place. If a number is NaN, \
              so is the result.",
        examples: &[ex("max(3, 1, 2)", "3"), ex("max(1, [0 2])", "[1 2]"), ex("max([3 1 2])", "3")],
        kernel: Kernel::Whole(|call| extreme(call, "max", max_lanes)),
    },
    Builtin {
        name: "clamp",
        params: &[Param::new("x"), Param::or("low", "0"), Param::or("high", "1")],
        brief: "Limits x to the range from low to high.",
        doc: "NaN stays NaN. If low is above high, the result is low below low and high elsewhere (Peachey, \
              *Texturing and Modeling*, chapter 2).",
        examples: &[ex("clamp([-1 0.5 3])", "[0 0.5 1]"), ex("clamp(7, 2, 5)", "5")],
        kernel: Kernel::Maps(|isa, args, out| map3(isa, args[0], args[1], args[2], out, clamp)),
    },
    Builtin {
        name: "sqrt",
        params: &[Param::new("x")],
        brief: "The square root; NaN below zero.",
        doc: "",
        examples: &[ex("sqrt([4 2])", "[2 1.41421356]")],
        kernel: Kernel::Map1(math::sqrt_lanes),
    },
    Builtin {
        name: "cbrt",
        params: &[Param::new("x")],
        brief: "The cube root; of a negative number, negative.",
        doc: "",
        examples: &[ex("cbrt([8 -27])", "[2 -3]")],
        kernel: Kernel::Map1(|isa, a, out| map1(isa, a, out, cbrt)),
    },
    Builtin {
        name: "exp",
        params: &[Param::new("x")],
        brief: "e to the power x.",
        doc: "",
        examples: &[ex("exp([0 1])", "[1 2.71828183]")],
        kernel: Kernel::Map1(math::exp_lanes),
    },
    Builtin {
        name: "exp2",
        params: &[Param::new("x")],
        brief: "2 to the power x.",
        doc: "",
        examples: &[ex("exp2([3 -1])", "[8 0.5]")],
        kernel: Kernel::Map1(math::exp2_lanes),
    },
    Builtin {
        name: "log",
        params: &[Param::new("x")],
        brief: "The natural logarithm.",
        doc: "-infinity at 0, NaN below.",
        examples: &[ex("log(exp(2))", "2"), ex("log(1)", "0")],
        kernel: Kernel::Map1(math::log_lanes),
    },
    Builtin {
        name: "log2",
        params: &[Param::new("x")],
        brief: "The logarithm to base 2.",
        doc: "-infinity at 0, NaN below.",
        examples: &[ex("log2([8 0.5])", "[3 -1]")],
        kernel: Kernel::Map1(math::log2_lanes),
    },
    Builtin {
        name: "log10",
        params: &[Param::new("x")],
        brief: "The logarithm to base 10.",
        doc: "-infinity at 0, NaN below.",
        examples: &[ex("log10([1000 0.1])", "[3 -1]")],
        kernel: Kernel::Map1(math::log10_lanes),
    },
    Builtin {
        name: "pow",
        params: &[Param::new("x"), Param::new("y")],
        brief: "x to the power y, the same as `x ^ y`.",
        doc: "NaN for a negative x unless y is a whole number.",
        examples: &[ex("pow(2, [3 0.5])", "[8 1.41421356]")],
        kernel: Kernel::Map2(math::pow_lanes),
    },
    Builtin {
        name: "hypot",
        params: &[Param::rest("x", 2)],
        brief: "The square root of the sum of the squares.",
        doc: "The length of the diagonal of a box with these sides, component by component; [norm](#norm) \
              gives it for the elements of one vector. It does not overflow where its value does not.",
        examples: &[ex("hypot(3, 4)", "5"), ex("hypot([3 6], [4 8])", "[5 10]"), ex("hypot(2, 3, 6)", "7")],
        kernel: Kernel::Fold(math::hypot_lanes),
    },
    Builtin {
        name: "isnan",
        params: &[Param::new("x")],
        brief: "1 if x is NaN (not a number, such as 0/0), else 0.",
        doc: "",
        examples: &[ex("isnan([sqrt(-1) 1])", "[1 0]")],
        kernel: Kernel::Map1(|isa, a, out| map1(isa, a, out, |x| f32::from(x.is_nan()))),
    },
    Builtin {
        name: "isinf",
        params: &[Param::new("x")],
        brief: "1 if x is infinity or -infinity, else 0.",
        doc: "",
        examples: &[ex("isinf([1/0 1])", "[1 0]")],
        kernel: Kernel::Map1(|isa, a, out| map1(isa, a, out, |x| f32::from(x.is_infinite()))),
    },
    Builtin {
        name: "isfinite",
        params: &[Param::new("x")],
        brief: "1 if x is neither infinite nor NaN, else 0.",
        doc: "",
        examples: &[ex("isfinite([1/0 sqrt(-1) 1])", "[0 0 1]")],
        kernel: Kernel::Map1(|isa, a, out| map1(isa, a, out, |x| f32::from(x.is_finite()))),
    },
];
