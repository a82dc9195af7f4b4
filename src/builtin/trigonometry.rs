//! Trigonometry and its hyperbolic kin, component by component. Angles are in radians.

use super::{Builtin, Kernel, Param, ex};
use crate::lanes::map1;
use crate::math;
use std::f32::consts::PI;

/// Trigonometry.
pub static FUNCTIONS: &[Builtin] = &[
    Builtin {
        name: "sin",
        params: &[Param::new("x")],
        brief: "The sine of an angle in radians.",
        doc: "",
        examples: &[ex("sin([0 pi/6 pi/2])", "[0 0.5 1]")],
        kernel: Kernel::Map1(math::sin_lanes),
    },
    Builtin {
        name: "cos",
        params: &[Param::new("x")],
        brief: "The cosine of an angle in radians.",
        doc: "",
        examples: &[ex("cos([0 pi/3 pi])", "[1 0.5 -1]")],
        kernel: Kernel::Map1(math::cos_lanes),
    },
    Builtin {
        name: "tan",
        params: &[Param::new("x")],
        brief: "The tangent of an angle in radians.",
        doc: "",
        examples: &[ex("tan(pi/4)", "1")],
        kernel: Kernel::Map1(math::tan_lanes),
    },
    Builtin {
        name: "asin",
        params: &[Param::new("x")],
        brief: "The angle between -pi/2 and pi/2 with this sine.",
        doc: "NaN outside -1 to 1.",
        examples: &[ex("asin([0 1])", "[0 pi/2]")],
        kernel: Kernel::Map1(math::asin_lanes),
    },
    Builtin {
        name: "acos",
        params: &[Param::new("x")],
        brief: "The angle between 0 and pi with this cosine.",
        doc: "NaN outside -1 to 1.",
        examples: &[ex("acos([0 -1])", "[pi/2 pi]")],
        kernel: Kernel::Map1(math::acos_lanes),
    },
    Builtin {
        name: "atan",
        params: &[Param::new("y"), Param::or("x", "1")],
        brief: "The angle with this tangent; of two numbers, the angle of the point (x, y).",
        doc: "`atan(y)` is between -pi/2 and pi/2. `atan(y, x)` is between -pi and pi, in the quadrant given by both \
              signs. The order is y, then x.",
        examples: &[ex("atan(1)", "pi/4"), ex("atan(1, -1)", "3*pi/4"), ex("atan(0, -1)", "pi")],
        kernel: Kernel::Map2(math::atan2_lanes),
    },
    Builtin {
        name: "sinh",
        params: &[Param::new("x")],
        brief: "The hyperbolic sine.",
        doc: "",
        examples: &[ex("sinh([0 1])", "[0 1.17520119]")],
        kernel: Kernel::Map1(math::sinh_lanes),
    },
    Builtin {
        name: "cosh",
        params: &[Param::new("x")],
        brief: "The hyperbolic cosine.",
        doc: "",
        examples: &[ex("cosh([0 1])", "[1 1.54308063]")],
        kernel: Kernel::Map1(math::cosh_lanes),
    },
    Builtin {
        name: "tanh",
        params: &[Param::new("x")],
        brief: "The hyperbolic tangent, a smooth step from -1 to 1.",
        doc: "",
        examples: &[ex("tanh([0 1 20])", "[0 0.76159416 1]")],
        kernel: Kernel::Map1(math::tanh_lanes),
    },
    Builtin {
        name: "radians",
        params: &[Param::new("degrees")],
        brief: "Converts an angle from degrees to radians.",
        doc: "",
        examples: &[ex("radians(180)", "pi")],
        kernel: Kernel::Map1(|isa, a, out| map1(isa, a, out, |x| x * (PI / 180.0))),
    },
    Builtin {
        name: "degrees",
        params: &[Param::new("radians")],
        brief: "Converts an angle from radians to degrees.",
        doc: "",
        examples: &[ex("degrees(pi/2)", "90")],
        kernel: Kernel::Map1(|isa, a, out| map1(isa, a, out, |x| x * (180.0 / PI))),
    },
];
