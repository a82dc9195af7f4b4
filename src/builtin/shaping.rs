//! Functions that shape a signal: blends, and curves of the unit interval, after Peachey's
//! chapter “Building Procedural Textures” (Ebert et al., *Texturing and Modeling*, chapter 2).
//! Where there are parameters they come first and the signal last, as in the RenderMan language.

use super::apply::strips;
use super::arithmetic::min;
use super::{Builtin, Kernel, Param, ex};
use crate::lanes::{map1, map3};
use crate::math;

/// The blend that gives a and b exactly at its ends.
#[inline(always)]
pub fn mix(a: f32, b: f32, t: f32) -> f32 {
    a * (1.0 - t) + b * t
}

/// Perlin and Hoffert's bias: the power of x that takes 1/2 to b.
#[inline(always)]
fn bias([b, x]: [f32; 2]) -> [f32; 1] {
    // The logarithm to base 2 of 1/2 is -1, exactly.
    [math::pow(x, -math::log2(b))]
}

#[inline(always)]
fn gammacorrect([gamma, x]: [f32; 2]) -> [f32; 1] {
    [math::pow(x, 1.0 / gamma)]
}

#[inline(always)]
fn gain([g, x]: [f32; 2]) -> [f32; 1] {
    let [bent] = bias([1.0 - g, min(2.0 * x, 2.0 - 2.0 * x)]);
    // The upper half is the lower one turned about. By numbers, not by branches around the power.
    let (start, sign) = if x < 0.5 { (0.0, 0.5) } else { (1.0, -0.5) };
    [start + sign * bent]
}

/// The cycloid's height as a polynomial in `w = (6 |x|)^(2/3)`, less its constant 1. The curve is
/// x = t - sin t, y = cos t; by series t² is an analytic function of w, so y is too, cusp and all. Chebyshev
/// interpolation over a half-period gave the coefficients; the error is 3e-7.
const CYCLOID: [f32; 9] = [
    -0.5,
    0.024999686,
    0.0005368744,
    2.1191065e-05,
    2.3397095e-06,
    -3.475646e-07,
    9.369851e-08,
    -9.746979e-09,
    5.1930904e-10,
];

#[inline(always)]
fn cycloid(x: f32) -> f32 {
    use std::f32::consts::TAU;
    let turns = x * (1.0 / TAU);
    let a = (turns - math::round(turns)).abs() * TAU;
    let w = math::pow(6.0 * a, 2.0 / 3.0);
    let height = CYCLOID.iter().rev().fold(0.0, |sum, c| sum * w + c);
    1.0 + w * height
}

/// Shaping.
pub static FUNCTIONS: &[Builtin] = &[
    Builtin {
        name: "mix",
        params: &[Param::new("a"), Param::new("b"), Param::new("t")],
        brief: "A blend: a where t is 0, b where t is 1.",
        doc: "`a * (1 - t) + b * t`, so a t outside 0 to 1 goes beyond a and b.",
        examples: &[ex("mix(10, 20, 0.3)", "13"), ex("mix([0 0 0], [1 2 4], 0.5)", "[0.5 1 2]")],
        kernel: Kernel::Maps(|isa, args, out| map3(isa, args[0], args[1], args[2], out, mix)),
    },
    Builtin {
        name: "lerp",
        params: &[Param::new("a"), Param::new("b"), Param::new("t")],
        brief: "A blend: a where t is 0, b where t is 1. The same as `mix`.",
        doc: "The amount comes last, as in most shading languages. Perlin's own code has it first. By name, the \
              order does not matter: `lerp(t = 0.3, a = 10, b = 20)`.",
        examples: &[ex("lerp(10, 20, 0.3)", "13")],
        kernel: Kernel::Maps(|isa, args, out| map3(isa, args[0], args[1], args[2], out, mix)),
    },
    Builtin {
        name: "bias",
        params: &[Param::new("b"), Param::new("x")],
        brief: "Maps the unit interval to itself, with 0.5 mapped to b.",
        doc: "`x ^ (log(b) / log(0.5))`: 0 and 1 stay fixed; a b above 0.5 raises the values between, one below 0.5 \
              lowers them. b is between 0 and 1 (Perlin and Hoffert, *Hypertexture*, 1989).",
        examples: &[ex("bias(0.25, [0 0.5 1])", "[0 0.25 1]"), ex("bias(0.5, 0.3)", "0.3")],
        kernel: Kernel::Map2(|isa, a, b, out| strips(isa, [a, b], [out], bias)),
    },
    Builtin {
        name: "gain",
        params: &[Param::new("g"), Param::new("x")],
        brief: "Maps the unit interval to itself by an S-curve about 0.5.",
        doc: "Two halves of [bias](#bias): a g above 0.5 makes the middle steeper, one below makes it flatter; 0, \
              0.5 and 1 stay fixed. g is between 0 and 1 (Perlin and Hoffert, *Hypertexture*, 1989).",
        examples: &[
            ex("gain(0.75, [0 0.25 0.5 0.75 1])", "[0 0.125 0.5 0.875 1]"),
            ex("gain(0.5, 0.3)", "0.3"),
        ],
        kernel: Kernel::Map2(|isa, a, b, out| strips(isa, [a, b], [out], gain)),
    },
    Builtin {
        name: "gammacorrect",
        params: &[Param::new("gamma"), Param::new("x")],
        brief: "`x ^ (1 / gamma)`: raises the middle of the unit interval if gamma is above 1.",
        doc: "Colours in image files usually need [linear_to_srgb](#linear_to_srgb); pictures are encoded \
              automatically when written.",
        examples: &[ex("gammacorrect(2, [0 0.25 1])", "[0 0.5 1]")],
        kernel: Kernel::Map2(|isa, a, b, out| strips(isa, [a, b], [out], gammacorrect)),
    },
    Builtin {
        name: "cycloid",
        params: &[Param::new("x")],
        brief: "A wave with sharp crests and broad troughs, from -1 to 1, with period 2 pi.",
        doc: "The height of the curve that a point on a rolling wheel draws, turned over: with x = t - sin(t) it is \
              cos(t). Its crests, at 0 and every 2 pi, are cusps of height 1; its troughs, at pi, are at -1; its \
              mean is -1/2. It is the steepest shape of a water wave, and the profile of the waves of *An Image \
              Synthesizer*: `normal += direction(v) * cycloid(norm(v))`.",
        examples: &[ex("cycloid([0 pi 2*pi])", "[1 -1 1]"), ex("cycloid(pi/2 - 1)", "0")],
        kernel: Kernel::Map1(|isa, a, out| map1(isa, a, out, cycloid)),
    },
];
