//! The names that every program knows: constants, what the system provides, and what G-buffers usually hold.

use std::f32::consts;

pub use crate::spelling::nearest;

/// A constant: name, components (one for a scalar), and what it is.
pub struct Constant {
    /// Its name.
    pub name: &'static str,
    /// One number for a scalar, more for a vector.
    pub value: &'static [f32],
    /// What it is.
    pub brief: &'static str,
}

/// The constants. An input image's variable of the same name hides one; so does an assignment.
pub static CONSTANTS: &[Constant] = &[
    Constant {
        name: "pi",
        value: &[consts::PI],
        brief: "the ratio of a circle's circumference to its diameter",
    },
    Constant { name: "infinity", value: &[f32::INFINITY], brief: "larger than any number" },
    Constant { name: "white", value: &[1.0, 1.0, 1.0], brief: "the colour white" },
    Constant { name: "black", value: &[0.0, 0.0, 0.0], brief: "the colour black" },
    Constant {
        name: "gray",
        value: &[0.5, 0.5, 0.5],
        brief: "the linear colour half way between black and white",
    },
    Constant { name: "red", value: &[1.0, 0.0, 0.0], brief: "the colour red" },
    Constant { name: "green", value: &[0.0, 1.0, 0.0], brief: "the colour green" },
    Constant { name: "blue", value: &[0.0, 0.0, 1.0], brief: "the colour blue" },
    Constant { name: "cyan", value: &[0.0, 1.0, 1.0], brief: "the colour cyan" },
    Constant { name: "magenta", value: &[1.0, 0.0, 1.0], brief: "the colour magenta" },
    Constant { name: "yellow", value: &[1.0, 1.0, 0.0], brief: "the colour yellow" },
];

/// What the system gives every program, with what it is. Those in [`FRAME`] have one value for the frame.
pub static SYSTEM: &[(&str, &str)] = &[
    ("frame", "the number of the frame"),
    ("begin_frame", "1 in code that runs once per frame, 0 at the pixels"),
    ("resolution", "[columns rows] of the image"),
    ("pixel", "[column row] of this pixel, its centre at .5, rows counted from the top"),
    ("pixelsize", "the distance between neighbouring pixels in the space of point, at this pixel"),
    ("pixel_freq", "0.5 / pixelsize, the highest frequency that the pixels can show"),
    (
        "eye",
        "the position of the camera's eye in the space of point: from options, from the image's header, or found from the points",
    ),
];

/// The system's names that no variable of an image hides: programs rely on them whatever the file holds.
pub static RESERVED: &[&str] = &["frame", "begin_frame", "resolution", "pixel"];

/// Whether a program can read a variable of that name, which may have an image's or a view's name before it.
pub fn is_readable(name: &str) -> bool {
    let fields: Vec<&str> = name.split('.').collect();
    let is_name = |field: &&str| {
        let id = crate::diagnostic::SourceId::default();
        let parsed = crate::syntax::parse_expression(id, field);
        parsed.is_some_and(|e| matches!(&*e.kind, crate::syntax::ast::ExprKind::Name(_)))
    };
    // A component stands behind a dot, or several.
    let is_member = |field: &&str| component(field).is_none() && !super::unknown::is_swizzle(field);
    fields.len() <= 3
        && fields.iter().all(is_name)
        && fields[1..].iter().all(is_member)
        // Of a variable that programs assign, what stands behind it is a component.
        && !(if fields.len() > 1 { USUAL_INPUTS } else { RESERVED }).contains(&fields[0])
}

/// The system's names that have one value for the frame.
pub static FRAME: &[&str] = &["frame", "begin_frame", "resolution", "eye"];

/// The variables that G-buffers usually hold: what a checker without an image takes for granted.
pub static USUAL_INPUTS: &[&str] =
    &["surface", "point", "normal", "uv", "depth", "color", "alpha", "albedo", "motion", "I", "dPdu", "dPdv"];

/// The constant of that name.
pub fn constant(name: &str) -> Option<&'static Constant> {
    CONSTANTS.iter().find(|c| c.name == name)
}

/// Does the system provide it?
pub fn is_system(name: &str) -> bool {
    SYSTEM.iter().any(|(n, _)| *n == name)
}

/// Has it one value for the frame, unless something hides it?
pub fn is_frame_constant(name: &str) -> bool {
    constant(name).is_some() || FRAME.contains(&name) || super::space_of(name).is_some()
}

/// The component that a letter names, counted from 0.
pub fn component(name: &str) -> Option<u32> {
    Some(match name {
        "x" | "r" => 0,
        "y" | "g" => 1,
        "z" | "b" => 2,
        "w" | "a" => 3,
        _ => return None,
    })
}
