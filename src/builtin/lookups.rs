//! Look-ups: in images, and in tables.

use super::apply::{each, vector_of};
use super::call::{Call, Fault};
use super::derivatives::changes;
use super::table::table;
use super::vectors::direction_planes;
use super::{Builtin, Kernel, Param, ex};
use crate::math;
use crate::shape::Shape;
use crate::texture::{Filter, Layout, Look, Near, Texture, Wrap, turned_z_up};
use crate::value::{Plane, Value};
use std::cell::RefCell;

/// The words for filters, and what they mean.
const FILTERS: [(&str, Filter); 5] = [
    ("mip", Filter::Mip),
    ("sat", Filter::Sums),
    ("nearest", Filter::Nearest),
    ("bilinear", Filter::Bilinear),
    ("cubic", Filter::Cubic),
];

/// The words for what is beyond the edges, and what they mean.
const WRAPS: [(&str, Wrap); 4] =
    [("periodic", Wrap::Periodic), ("black", Wrap::Black), ("clamp", Wrap::Clamp), ("mirror", Wrap::Mirror)];

const WIDTH: &str = "width";
const FILTER: &str = "filter";
const LAYOUT: &str = "layout";
const CHANNEL: &str = "channel";
const ENCODING: &str = "encoding";

static TEXTURE: [Param; 9] = [
    Param::text("file"),
    Param::new("s"),
    Param::or("t", "[]"),
    Param::or(WIDTH, "[]"),
    Param::choice(FILTER, &["mip", "sat", "nearest", "bilinear", "cubic"]),
    Param::choice("wrap", &["periodic", "black", "clamp", "mirror"]),
    Param::choice("wrap_t", &["same", "periodic", "black", "clamp", "mirror"]),
    Param::text_or(CHANNEL),
    Param::choice(ENCODING, &["color", "raw"]),
];

static ENVIRONMENT: [Param; 8] = [
    Param::text("file"),
    Param::new("direction"),
    Param::or(WIDTH, "[]"),
    Param::choice(FILTER, &["mip", "sat", "nearest", "bilinear", "cubic"]),
    Param::choice(LAYOUT, &["latlong", "cube"]),
    Param::choice("up", &["y", "z"]),
    Param::text_or(CHANNEL),
    Param::choice(ENCODING, &["color", "raw"]),
];

/// What a call asks of its image, by the numbers of the words that it gives.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    /// What the image shows.
    pub layout: Layout,
    /// How its texels are put together.
    pub filter: Filter,
    /// Are the numbers taken as they are stored?
    pub raw: bool,
    /// The place of the argument that names a channel.
    pub channel: usize,
    /// The place of the width that the filter takes, if it takes any. `[]` there: that of the pixel, for which the
    /// program has to run with shadows.
    pub width: Option<usize>,
}

impl Asked {
    /// What a call of this function asks; `word` tells the number of the word given for a parameter. `None` if
    /// the function looks up no image.
    pub fn of(builtin: &Builtin, word: impl Fn(usize) -> usize) -> Option<Asked> {
        let place = |name: &str| builtin.params.iter().position(|p| p.name == name);
        let number = |name: &str| place(name).map_or(0, &word);
        let layout = match (builtin.name, number(LAYOUT)) {
            ("texture", _) => Layout::Plane,
            ("environment", 0) => Layout::LatLong,
            ("environment", _) => Layout::Cube,
            _ => return None,
        };
        let filter = FILTERS[number(FILTER)].1;
        let width = place(WIDTH).filter(|_| matches!(filter, Filter::Mip | Filter::Sums));
        Some(Asked { layout, filter, raw: number(ENCODING) == 1, channel: place(CHANNEL)?, width })
    }
}

/// The word that an argument gives, by its number.
fn word(call: &Call<'_>, arg: usize) -> usize {
    call.args[arg].as_uniform().unwrap_or(0.0) as usize
}

/// The texture that the first argument names.
fn named<'a>(call: &Call<'a>) -> Result<&'a Texture, Fault> {
    match call.textures.get(word(call, 0)) {
        Some(texture) => Ok(texture),
        None => Err(Fault::of(0, "there is no such texture here")),
    }
}

/// The widths to filter over, along the columns and along the rows, at these s and t: those that are given, or what a
/// pixel covers.
fn widths(call: &Call<'_>, arg: usize, at: [&Plane; 2], wrap: [Wrap; 2]) -> Result<[Plane; 2], Fault> {
    let width = &call.args[arg];
    match width.shape {
        Shape::Vector(0) => Ok([0, 1].map(|axis| {
            let around = wrap[axis] == Wrap::Periodic;
            let [du, dv] = changes(call, at[axis]);
            call.lane([&du, &dv], |[du, dv]| {
                // From one side of the seam of a closed surface to the other is no change of the whole.
                let near = |d: f32| if around { d - math::round(d) } else { d };
                let (du, dv) = (near(du), near(dv));
                // A square pixel, turned, covers the same area.
                (du * du + dv * dv).sqrt()
            })
        })),
        Shape::Scalar => Ok([width.planes[0].clone(), width.planes[0].clone()]),
        Shape::Vector(2) => Ok([width.planes[0].clone(), width.planes[1].clone()]),
        _ => Err(Fault::of(arg, format!("a width is a scalar or a vector of 2, found {}", width.shape))),
    }
}

/// A look-up by `N` numbers of a lane; `near` are the tiles at hand.
trait Lookup<const N: usize> {
    fn at<const C: usize>(&self, x: [f32; N], near: &mut Near) -> [f32; C];
}

/// At s and t, over widths along both.
struct Place<'a>(&'a Texture, Look);

impl Lookup<4> for Place<'_> {
    #[inline(always)]
    fn at<const C: usize>(&self, [s, t, ws, wt]: [f32; 4], near: &mut Near) -> [f32; C] {
        // Rows are counted from the top, and t goes up.
        self.0.at(self.1, [s.into(), 1.0 - f64::from(t)], [ws, wt], near)
    }
}

/// In a direction, over an angle.
struct Direction<'a>(&'a Texture, Look, bool);

impl Lookup<4> for Direction<'_> {
    #[inline(always)]
    fn at<const C: usize>(&self, [x, y, z, width]: [f32; 4], near: &mut Near) -> [f32; C] {
        let direction = if self.2 { turned_z_up([x, y, z]) } else { [x, y, z] };
        self.0.toward(self.1, direction, width, near)
    }
}

/// What is looked up in each lane, in the texture's shape.
fn looked_up<const N: usize>(
    call: &Call<'_>,
    texture: &Texture,
    inputs: [&Plane; N],
    lookup: &impl Lookup<N>,
) -> Value {
    let near = RefCell::new(Near::default());
    let near = || near.borrow_mut();
    let planes = match texture.shape().cells() {
        1 => call.lanes(inputs, |x| lookup.at::<1>(x, &mut near())).into_iter().collect(),
        2 => call.lanes(inputs, |x| lookup.at::<2>(x, &mut near())).into_iter().collect(),
        3 => call.lanes(inputs, |x| lookup.at::<3>(x, &mut near())).into_iter().collect(),
        _ => call.lanes(inputs, |x| lookup.at::<4>(x, &mut near())).into_iter().collect(),
    };
    Value { shape: texture.shape().clone(), planes }
}

/// The angle between a direction and those of the neighbouring pixels, the larger of the two.
fn angle(call: &Call<'_>, direction: &[Plane]) -> Plane {
    let unit = direction_planes(call, direction);
    let [x, y, z] = [0, 1, 2].map(|axis| changes(call, &unit[axis]));
    let chord = |along: usize| {
        call.lane([&x[along], &y[along], &z[along]], |[x, y, z]| (x * x + y * y + z * z).sqrt())
    };
    call.lane([&chord(0), &chord(1)], |[u, v]| if u > v { u } else { v })
}

fn texture(call: &Call<'_>) -> Result<Value, Fault> {
    let texture = named(call)?;
    let wrap = WRAPS[word(call, 5)].1;
    let wrap_t = word(call, 6).checked_sub(1).map_or(wrap, |i| WRAPS[i].1);
    let look = Look { filter: FILTERS[word(call, 4)].1, wrap: [wrap, wrap_t] };
    let at = |s: &Plane, t: &Plane| {
        let [ws, wt] = widths(call, 3, [s, t], look.wrap)?;
        Ok(looked_up(call, texture, [s, t, &ws, &wt], &Place(texture, look)))
    };
    if call.args[2].shape != Shape::Vector(0) {
        if !call.args[1].shape.is_scalar() {
            let message =
                format!("texture takes one number for s where t is given, found {}", call.args[1].shape);
            return Err(Fault::of(1, message).hint("A width is given by its name: `width = …`."));
        }
        return at(&call.args[1].planes[0], call.scalar(2)?);
    }
    each([&call.args[1]], &mut |[place]| match place.shape {
        Shape::Vector(2) => at(&place.planes[0], &place.planes[1]),
        _ => Err(Fault::of(1, format!("texture takes s and t, or a vector of both, found {}", place.shape))
            .hint("`uv` is such a vector. By a direction, `environment()` looks images up.")),
    })
}

fn environment(call: &Call<'_>) -> Result<Value, Fault> {
    let texture = named(call)?;
    let width = |d: &[Plane]| match call.args[2].shape {
        Shape::Vector(0) => Ok(angle(call, d)),
        _ => call.scalar(2).cloned(),
    };
    // A picture of all that is around has no edges.
    let look = Look { filter: FILTERS[word(call, 3)].1, wrap: [Wrap::Periodic; 2] };
    let lookup = Direction(texture, look, word(call, 5) == 1);
    each([&call.args[1]], &mut |[direction]| {
        let d = vector_of("environment", 1, direction, &[3])?;
        Ok(looked_up(call, texture, [&d[0], &d[1], &d[2], &width(d)?], &lookup))
    })
}

/// Look-ups.
pub static FUNCTIONS: &[Builtin] = &[
    Builtin {
        name: "texture",
        params: &TEXTURE,
        brief: "The colour of an image at the coordinates s and t, from 0 to 1.",
        doc: "s runs along the columns and t up the rows; `[0 0]` is the bottom left corner, as in `uv`. \
              `texture(\"wood.png\", uv)` passes both in one vector. An image with one channel gives a scalar, a \
              coloured one `[red green blue]` in linear light. `channel` names another variable or channel of the \
              file, as `pse info` lists them (`\"alpha\"`, `\"point\"`, `\"ViewLayer.Position.X\"`), or `\"rgba\"`: \
              the colour with alpha. `encoding = \"raw\"` reads pictures such as PNG without sRGB decoding, for \
              normals and masks. `width` is the size of the filter in units of s and t: a scalar or `[width_s \
              width_t]`, which can differ from pixel to pixel. 0 means one texel. By default it is what the pixel \
              covers, from the change of s and t to the neighbouring pixels (see [Du](#Du)). `filter`: `\"mip\"` \
              takes the mean from a mip map, several times side by side where one width is much larger; `\"sat\"` \
              takes the exact mean over a box, from a summed-area table, and needs three times the memory. \
              `\"nearest\"`, `\"bilinear\"` and `\"cubic\"` (a B-spline, a little soft) read 1, 4 and 16 texels of \
              the image itself and ignore the width. `wrap` sets what is outside 0 … 1: the image again, black, its \
              edge, or the image mirrored; `wrap_t` sets it for t only. Files are searched beside the program, then \
              in the folders of `--path` (Peachey, *Texturing and Modeling*, chapter 2; Williams 1983; Crow 1984).",
        examples: &[
            ex("texture(\"earth.png\", 0.25, 0.5) - texture(\"earth.png\", [1.25 0.5])", "[0 0 0]"),
            ex("texture(\"earth.png\", 0.5, 2, wrap = \"black\")", "[0 0 0]"),
            ex("size(texture(\"earth.png\", 0.5, 0.5, width = 0.1, channel = \"rgba\"))", "4"),
        ],
        kernel: Kernel::Whole(texture),
    },
    Builtin {
        name: "environment",
        params: &ENVIRONMENT,
        brief: "The colour of the surroundings in a direction: a reflection map.",
        doc: "`environment(\"sky.exr\", reflect(I, normal))`. The direction is a vector of 3 of any length but 0. \
              `layout = \"latlong\"`: longitude runs along the columns, latitude up the rows. With y up, the middle \
              of the image is at +z and -x is to its right, as in OSL; with `up = \"z\"`, as for `point`, the middle \
              is +x and -y is to its right, as in Blender. `layout = \"cube\"`: six square sides +x -x +y -y +z -z, \
              oriented as those of OpenGL, in a row (6 x 1), a column (1 x 6), two rows (3 x 2), or a cross (4 x 3, \
              with -x +z +x -z in its row; 3 x 4, with +y +z -y and -z upside down in its column); the image's \
              proportions decide. `width` is the angle of the cone to average over, in radians: a wider cone gives a \
              blurrier reflection. By default it is the angle to the directions of the neighbouring pixels. \
              `filter`, `channel` and `encoding` are those of [texture](#texture); a cube has no `\"sat\"` (Blinn \
              and Newell 1976; Greene 1986).",
        examples: &[
            ex("environment(\"earth.png\", [0 0 1]) - texture(\"earth.png\", 0.5, 0.5)", "[0 0 0]"),
            ex(
                "environment(\"earth.png\", [0 -2 0], up = \"z\") - texture(\"earth.png\", 0.75, 0.5)",
                "[0 0 0]",
            ),
        ],
        kernel: Kernel::Whole(environment),
    },
    Builtin {
        name: "table",
        params: &[
            Param::new("v"),
            Param::new("x"),
            Param::or("width", "0"),
            Param::choice("wrap", &["clamp", "periodic"]),
        ],
        brief: "The vector v looked up at x, from 0 to 1; linear between its elements.",
        doc: "The elements are scalars, or vectors of one shape, evenly spaced: the first at 0, the last at 1. \
              Outside 0 … 1 the end values continue. With `wrap = \"periodic\"` the first element follows the last, \
              at 1. v may differ from pixel to pixel. `width` takes the exact mean over that much of x. A vector of \
              values for x gives a vector of results. [linear](#linear) and [spline](#spline) interpolate knots \
              given as arguments.",
        examples: &[
            ex("table([10 20 40], 0.25)", "15"),
            ex("table([10 20 40], [-1 0.5 2])", "[10 20 40]"),
            ex("table([[0 1] [2 5]], 0.5)", "[1 3]"),
            ex("table([0 1], 0.75, wrap = \"periodic\")", "0.5"),
            ex("table([0 4 0], 0.5, width = 1)", "2"),
        ],
        kernel: Kernel::Whole(table),
    },
];
