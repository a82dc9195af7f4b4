//! Steps and pulses, sharp or filtered, after Peachey's chapter “Building Procedural Textures” (Ebert et al.,
//! *Texturing and Modeling*, chapter 2, “Analytic Prefiltering”). Edges come first and the signal last, as in the
//! RenderMan language; then the width.
//!
//! A width is that of a box about x: the value is the mean over the box, by a formula. The formulas are of shares of
//! the box, each a quotient with the width, and not of differences of integrals: those of a narrow box would leave no
//! digits. They are computed in `f64`, in which the difference of two numbers of 32 bits is as good as exact.

use super::apply::strips;
use super::arithmetic::clamp;
use super::{Builtin, Kernel, Param, ex};
use crate::lanes::{Arg, Isa, map2, map3};
use crate::math;

/// 0 below the edge, 1 from it on.
#[inline(always)]
fn step(edge: f32, x: f32) -> f32 {
    f32::from(x >= edge)
}

/// How far x has come from a to b, from 0 to 1; where both are one point, a step there.
#[inline(always)]
fn ramp(a: f32, b: f32, x: f32) -> f32 {
    let sloping = (x - a) / (b - a);
    // Divided by zero it would be right or not by the sign of that zero. NaN stays NaN.
    let steep = if x >= a { 1.0 } else { clamp(x, 0.0, 0.0) };
    let t = if a == b { steep } else { sloping };
    clamp(t, 0.0, 1.0)
}

#[inline(always)]
fn smoothstep(a: f32, b: f32, x: f32) -> f32 {
    let t = ramp(a, b, x);
    t * t * (3.0 - 2.0 * t)
}

#[inline(always)]
fn smootherstep(a: f32, b: f32, x: f32) -> f32 {
    let t = ramp(a, b, x);
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

#[inline(always)]
fn pulse(a: f32, b: f32, x: f32) -> f32 {
    step(a, x) - step(b, x)
}

#[inline(always)]
fn pulsetrain(x: f32, duty: f32) -> f32 {
    let at = math::frac(x);
    // NaN stays NaN.
    if at < duty { 1.0 } else { clamp(at + duty, 0.0, 0.0) }
}

/// From 0 to 1; NaN stays NaN.
#[inline(always)]
fn unit(x: f64) -> f64 {
    x.clamp(0.0, 1.0)
}

/// The smaller number; NaN if either is.
#[inline(always)]
fn least(a: f64, b: f64) -> f64 {
    if a < b || a.is_nan() { a } else { b }
}

/// The share of a box that lies above a place, by how far the box's middle lies above it.
#[inline(always)]
fn above(distance: f64, width: f64) -> f64 {
    unit(distance / width + 0.5)
}

/// The share of a box about x that lies between a and b, a not above b.
#[inline(always)]
fn between(a: f64, b: f64, x: f64, width: f64) -> f64 {
    let ends = least((x - a) / width, (b - x) / width) + 0.5;
    unit(least(least(ends, (b - a) / width), 1.0))
}

/// The mean of a curve that goes from 0 at a to 1 at b, as a polynomial with these coefficients of t, t², … for its
/// integral from 0 to t.
#[inline(always)]
fn curved<const K: usize>(integral: [f64; K], [a, b, x, width]: [f64; 4]) -> f64 {
    let side = b - a;
    let t = (x - a) / side;
    // Boxes in the unit of t, by their inverse: it is 0 for an infinite one.
    let inverse = side.abs() / width;
    let half = 0.5 / inverse;
    let inside = unit(least(least(t, 1.0 - t) * inverse + 0.5, least(inverse, 1.0)));
    let beyond = unit((t - 1.0) * inverse + 0.5);
    // The mean inside is a divided difference of the integral: of t^n that is the sum of all products of n - 1 of u, v.
    let (u, v) = (unit(t + half), unit(t - half));
    let (mut products, mut power, mut mean) = (1.0, 1.0, 0.0);
    for coefficient in integral {
        mean += coefficient * products;
        power *= v;
        products = u * products + power;
    }
    if side == 0.0 { above(x - a, width) } else { inside * mean + beyond }
}

/// Integrals of the two smooth steps.
const SMOOTH: [f64; 4] = [0.0, 0.0, 1.0, -0.5];
const SMOOTHER: [f64; 6] = [0.0, 0.0, 0.0, 2.5, -3.0, 1.0];

/// The mean of a function of period 1, from its mean over a whole period and that over a box narrower than one about
/// a place from 0 to 1. Whole periods are taken off the box first, and off x.
#[inline(always)]
fn periodic(x: f64, width: f64, whole: f64, part: impl Fn(f64, f64) -> f64) -> f64 {
    // Wider ones have no part of a period left in 32 bits.
    let width = least(width, f64::from(1 << 30));
    let periods = width.floor();
    let rest = width - periods;
    // An odd number of periods cannot be taken off both sides alike: the middle of what is left lies half a period off.
    let odd = periods - 2.0 * (0.5 * periods).floor();
    let middle = x - x.floor() + 0.5 * odd;
    let middle = middle - middle.floor();
    let off = if rest == 0.0 { 0.0 * middle } else { rest / width * (part(middle, rest) - whole) };
    whole + off
}

/// The integral of the Catmull-Rom filter from 0 to t, t from 0 to 2.
#[inline(always)]
fn catmull_rom(t: f64) -> f64 {
    let near = t * (1.0 + t * t * (0.375 * t - 2.5 / 3.0));
    let far = t * (2.0 + t * (-2.0 + t * (2.5 / 3.0 - 0.125 * t))) - 1.0 / 6.0;
    if t < 1.0 { near } else { far }
}

/// The filtered form where there is a width, else the sharp one.
#[inline(always)]
fn choose<const N: usize>(
    args: [f32; N],
    sharp: impl Fn([f32; N]) -> f32,
    filtered: impl Fn([f64; N]) -> f64,
) -> [f32; 1] {
    let mut wide = args.map(f64::from);
    wide[N - 1] = wide[N - 1].abs();
    [if wide[N - 1] == 0.0 { sharp(args) } else { filtered(wide) as f32 }]
}

fn step_lanes(isa: Isa, args: &[Arg<'_>], out: &mut [f32]) {
    match *args {
        [edge, x, Arg::Uniform(0.0)] => map2(isa, edge, x, out, step),
        [edge, x, width] => strips(isa, [edge, x, width], [out], |args| {
            choose(args, |[edge, x, _]| step(edge, x), |[edge, x, width]| above(x - edge, width))
        }),
        _ => {}
    }
}

fn smoothstep_lanes(isa: Isa, args: &[Arg<'_>], out: &mut [f32]) {
    match *args {
        [a, b, x, Arg::Uniform(0.0)] => map3(isa, a, b, x, out, smoothstep),
        [a, b, x, width] => strips(isa, [a, b, x, width], [out], |args| {
            choose(args, |[a, b, x, _]| smoothstep(a, b, x), |args| curved(SMOOTH, args))
        }),
        _ => {}
    }
}

fn smootherstep_lanes(isa: Isa, args: &[Arg<'_>], out: &mut [f32]) {
    match *args {
        [a, b, x, Arg::Uniform(0.0)] => map3(isa, a, b, x, out, smootherstep),
        [a, b, x, width] => strips(isa, [a, b, x, width], [out], |args| {
            choose(args, |[a, b, x, _]| smootherstep(a, b, x), |args| curved(SMOOTHER, args))
        }),
        _ => {}
    }
}

fn pulse_lanes(isa: Isa, args: &[Arg<'_>], out: &mut [f32]) {
    let filtered = |[a, b, x, width]: [f64; 4]| {
        if a <= b { between(a, b, x, width) } else { -between(b, a, x, width) }
    };
    match *args {
        [a, b, x, Arg::Uniform(0.0)] => map3(isa, a, b, x, out, pulse),
        [a, b, x, width] => {
            strips(isa, [a, b, x, width], [out], |args| choose(args, |[a, b, x, _]| pulse(a, b, x), filtered))
        }
        _ => {}
    }
}

fn pulsetrain_lanes(isa: Isa, args: &[Arg<'_>], out: &mut [f32]) {
    let filtered = |[x, duty, width]: [f64; 3]| {
        let duty = unit(duty);
        periodic(x, width, duty, |x, width| {
            let pulse = |start: f64| between(start, start + duty, x, width);
            pulse(-1.0) + pulse(0.0) + pulse(1.0)
        })
    };
    match *args {
        [x, duty, Arg::Uniform(0.0)] => map2(isa, x, duty, out, pulsetrain),
        [x, duty, width] => strips(isa, [x, duty, width], [out], |args| {
            choose(args, |[x, duty, _]| pulsetrain(x, duty), filtered)
        }),
        _ => {}
    }
}

fn catstep_lanes(isa: Isa, args: &[Arg<'_>], out: &mut [f32]) {
    let filtered = |[edge, x, width]: [f64; 3]| {
        let t = (x - edge) / width;
        0.5 + catmull_rom(least(t.abs(), 2.0)).copysign(t)
    };
    match *args {
        [edge, x, Arg::Uniform(0.0)] => map2(isa, edge, x, out, step),
        [edge, x, width] => {
            strips(isa, [edge, x, width], [out], |args| choose(args, |[edge, x, _]| step(edge, x), filtered))
        }
        _ => {}
    }
}

/// `frac(x, width)`, the sawtooth.
pub(super) fn frac(isa: Isa, x: Arg<'_>, width: Arg<'_>, out: &mut [f32]) {
    let part = |x: f64, width: f64| x + unit(0.5 - x / width) - above(x - 1.0, width);
    match (x, width) {
        (Arg::Varying(x), Arg::Uniform(0.0)) => math::frac_lanes(isa, x, out),
        _ => strips(isa, [x, width], [out], |args| {
            choose(args, |[x, _]| math::frac(x), |[x, width]| periodic(x, width, 0.5, part))
        }),
    }
}

/// The last parameter of each.
const WIDTH: Param = Param::or("width", "0");

/// Steps and pulses.
pub static FUNCTIONS: &[Builtin] = &[
    Builtin {
        name: "step",
        params: &[Param::new("edge"), Param::new("x"), WIDTH],
        brief: "0 where x is below the edge, 1 from the edge on.",
        doc: "With a width other than 0 (its sign does not matter), the mean of the step over that width, centred at \
              x: `step(edge, x, filterwidth(x))` is antialiased. The other functions with a width work the same way; \
              with a width of 0 they are sharp. An x of NaN counts as below a sharp step, and gives NaN with a \
              width. A width of NaN gives NaN.",
        examples: &[
            ex("step(0.5, [0.4 0.5 0.6])", "[0 1 1]"),
            ex("step(0.5, [0.4 0.5 0.6], width = 0.4)", "[0.25 0.5 0.75]"),
        ],
        kernel: Kernel::Maps(step_lanes),
    },
    Builtin {
        name: "boxstep",
        params: &[Param::new("a"), Param::new("b"), Param::new("x")],
        brief: "A straight ramp from 0 at a to 1 at b.",
        doc: "A step filtered by a box as wide as `b - a`: Peachey's `boxstep(b - w, b, x)` looks ahead from x, where \
              `step(b, x, w)` looks to both sides. With a above b it falls from 1 at b to 0 at a; with a equal to b \
              it is a step.",
        examples: &[ex("boxstep(1, 3, [0 1.5 4])", "[0 0.25 1]")],
        kernel: Kernel::Maps(|isa, args, out| map3(isa, args[0], args[1], args[2], out, ramp)),
    },
    Builtin {
        name: "smoothstep",
        params: &[Param::new("a"), Param::new("b"), Param::new("x"), WIDTH],
        brief: "A smooth step from 0 at a to 1 at b.",
        doc: "The cubic 3t² - 2t³, with slope 0 at both ends. With a above b it falls from 1 at b to 0 at a; with a \
              equal to b it is a step. With a width, the mean over that width, as in [step](#step).",
        examples: &[
            ex("smoothstep(0, 1, [-1 0.25 0.5 2])", "[0 0.15625 0.5 1]"),
            ex("smoothstep(0, 1, 0, width = 2)", "0.25"),
        ],
        kernel: Kernel::Maps(smoothstep_lanes),
    },
    Builtin {
        name: "smootherstep",
        params: &[Param::new("a"), Param::new("b"), Param::new("x"), WIDTH],
        brief: "A smooth step from 0 at a to 1 at b, with no curvature at its ends.",
        doc: "The quintic 6t⁵ - 15t⁴ + 10t³ of Perlin, *Improving Noise*, 2002. Edges and width as in \
              [smoothstep](#smoothstep).",
        examples: &[ex("smootherstep(0, 1, [-1 0.25 0.5 2])", "[0 0.103515625 0.5 1]")],
        kernel: Kernel::Maps(smootherstep_lanes),
    },
    Builtin {
        name: "catstep",
        params: &[Param::new("edge"), Param::new("x"), WIDTH],
        brief: "A step filtered by a Catmull-Rom filter: sharper than with a box filter, with a small overshoot.",
        doc: "The filter reaches two widths to either side; its width is that of a box of the same area and height, \
              so `catstep(edge, x, w)` can replace `step(edge, x, w)`. Beside the edge it overshoots by 0.07 below 0 \
              and above 1 (Sayre's function in Peachey, *Texturing and Modeling*, chapter 2, “Better Filters”).",
        examples: &[ex("catstep(0, [-2 -1 0 2], width = 1)", "[0 -1/24 0.5 1]")],
        kernel: Kernel::Maps(catstep_lanes),
    },
    Builtin {
        name: "pulse",
        params: &[Param::new("a"), Param::new("b"), Param::new("x"), WIDTH],
        brief: "1 from a up to b, 0 elsewhere.",
        doc: "`step(a, x) - step(b, x)`. With a width, the mean over that width, as in [step](#step). For stripes \
              use [pulsetrain](#pulsetrain): `pulse(0.4, 0.6, mod(x, 1))` makes sharp stripes, but a width that \
              reaches past one period would miss the next.",
        examples: &[ex("pulse(1, 2, [0.5 1 1.5 2])", "[0 1 1 0]"), ex("pulse(1, 2, 1.5, width = 4)", "0.25")],
        kernel: Kernel::Maps(pulse_lanes),
    },
    Builtin {
        name: "pulsetrain",
        params: &[Param::new("x"), Param::or("duty", "0.5"), WIDTH],
        brief: "Stripes with period 1: 1 in the first part of each, which is as long as `duty`, and 0 in the rest.",
        doc: "`frac(x) < duty`. With a width, the exact mean over that width, even across many stripes, as in \
              [step](#step); a large width gives `duty` (Peachey, *Texturing and Modeling*, chapter 2, “Integrals \
              and Summed-Area Tables”). Stripes of period p are `pulsetrain(x / p, duty, width / p)`.",
        examples: &[
            ex("pulsetrain([0.25 0.75 1.25])", "[1 0 1]"),
            ex("pulsetrain([0.25 0.75], width = 1)", "[0.5 0.5]"),
            ex("pulsetrain(0.25, 0.25, width = 1.5)", "1/6"),
        ],
        kernel: Kernel::Maps(pulsetrain_lanes),
    },
];
