//! The names that every program knows: constants, what the system provides, and what G-buffers usually hold.

use std::f32::consts;

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
    ("begin_frame", "1 in what runs once a frame, 0 at the pixels"),
    ("resolution", "[columns rows] of the image"),
    ("pixel", "[column row] of this pixel, its centre at .5, rows counted from the top"),
    ("pixelsize", "how far apart neighbouring pixels lie in the space of point, at this pixel"),
    ("pixel_freq", "0.5 / pixelsize, the highest frequency that the pixels can show"),
    (
        "eye",
        "where the camera's eye is, in the space of point: as an option or the image's header gives it, or found from the points",
    ),
];

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

/// What a function of shading languages and Python is called here, as a sentence; those of the same name need none.
pub fn of_other_languages(name: &str) -> Option<&'static str> {
    Some(match name {
        "normalize" | "normalise" => "A vector of length 1 is made by `direction(v)`.",
        "vec2" | "vec3" | "vec4" | "float2" | "float3" | "float4" | "vector" | "color" | "rgb" => {
            "A vector is written in brackets: `[1 0 0]`."
        }
        "fract" => "It is called `frac(x)` here.",
        "saturate" => "It is called `clamp(x)` here.",
        "len" => "The number of elements is `size(v)`, the length of an arrow `norm(v)`.",
        "inversesqrt" | "rsqrt" => "Write `1 / sqrt(x)`.",
        "atan2" => "It is called `atan(y, x)` here.",
        "fmod" => "Write `a % b`.",
        "range" => "A range is written `[1 .. 10]`.",
        "turb" | "turbulent" => "It is called `turbulence(p)` here.",
        "fbm" | "fractal" => {
            "Sums of octaves of noise are made by `fBm(p)`, `fractalsum(p)` and `turbulence(p)`."
        }
        "ridgedmf" | "ridged_multifractal" => "It is called `ridged(p)` here.",
        "curlnoise" | "curl_noise" => "It is called `curl(p)` here.",
        "snoise" | "perlin" | "noise3" => "Noise is called `Noise(p)` here.",
        "cellnoise" => {
            "A random number for each cell is `random(floor(p))`, or `Noise(p, kind = \"white\")`."
        }
        "worley" | "voronoi" | "cellular" => "It is a kind of noise: `Noise(p, kind = \"cellular\")`.",
        "simplex" => "It is a kind of noise: `Noise(p, kind = \"simplex\")`.",
        _ => return None,
    })
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

/// The name out of `known` that a misspelt one most likely means.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = name.to_lowercase();
    known
        .into_iter()
        .filter(|k| *k != name)
        .map(|k| {
            // A slip of case is no slip of spelling.
            let distance = strsim::damerau_levenshtein(&lower, &k.to_lowercase());
            (distance, k)
        })
        .filter(|(distance, k)| {
            let length = name.chars().count().max(k.chars().count());
            *distance
                <= if length <= 3 {
                    usize::from(length > 1 || *distance == 0)
                } else {
                    length.div_ceil(3).min(3)
                }
        })
        .min_by_key(|(distance, k)| (*distance, k.len().abs_diff(name.len()), *k))
        .map(|(_, k)| k)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_names() {
        let known = ["normal", "point", "noise", "norm", "x"];
        assert_eq!(nearest("nrmal", known), Some("normal"));
        assert_eq!(nearest("Point", known), Some("point"));
        assert_eq!(nearest("zebra", known), None);
        assert_eq!(nearest("q", known), None);
    }
}
