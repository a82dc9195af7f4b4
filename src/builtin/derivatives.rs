//! Derivatives across the picture, from the pixel and its two shadows: the same program at the neighbours along the
//! row and along the column. See docs/language.md, "Derivatives".

use super::call::{Call, Fault};
use super::vectors::direction_planes;
use super::{Builtin, Kernel, Param, ex};
use crate::lanes::Isa;
use crate::shape::Shape;
use crate::value::{Lanes, Plane, Planes, Value};

/// A direction of the picture.
#[derive(Clone, Copy)]
enum Along {
    /// To the next column.
    Row = 1,
    /// To the next row.
    Column = 2,
}

/// What a plane's shadow holds, less what the pixel does. The shadows themselves are told the same: a derivative has
/// none.
fn difference(call: &Call<'_>, plane: &Plane, along: Along) -> Plane {
    let Plane::Varying(lanes) = plane else { return Plane::Uniform(0.0) };
    let (n, pixels) = (call.n, call.pixels);
    // Without shadows there is nothing to compare with: what is the same for a frame does not change in it.
    if n == pixels {
        return Plane::Uniform(0.0);
    }
    let lanes = lanes.get(n);
    let (here, there) = (&lanes[..pixels], &lanes[along as usize * pixels..][..pixels]);
    let out = Lanes::filled(n, |out| {
        let (first, rest) = out.split_at_mut(pixels);
        subtract(call.isa, there, here, first);
        rest.chunks_exact_mut(pixels).for_each(|shadow| shadow.copy_from_slice(first));
    });
    Plane::Varying(out)
}

/// How a plane changes to the next column and to the next row.
pub(super) fn changes(call: &Call<'_>, plane: &Plane) -> [Plane; 2] {
    [Along::Row, Along::Column].map(|along| difference(call, plane, along))
}

fn subtract(isa: Isa, a: &[f32], b: &[f32], out: &mut [f32]) {
    isa.run(|| {
        for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
            *out = a - b;
        }
    });
}

fn differences(call: &Call<'_>, value: &Value, along: Along) -> Value {
    let planes = value.planes.iter().map(|p| difference(call, p, along)).collect();
    Value { shape: value.shape.clone(), planes }
}

fn along_row(call: &Call<'_>) -> Result<Value, Fault> {
    Ok(differences(call, &call.args[0], Along::Row))
}

fn along_column(call: &Call<'_>) -> Result<Value, Fault> {
    Ok(differences(call, &call.args[0], Along::Column))
}

/// `abs(Du(e)) + abs(Dv(e))`.
fn filterwidth(call: &Call<'_>) -> Result<Value, Fault> {
    let value = &call.args[0];
    let width = |plane: &Plane| {
        let [u, v] = changes(call, plane);
        call.lane([&u, &v], |[u, v]| u.abs() + v.abs())
    };
    Ok(Value { shape: value.shape.clone(), planes: value.planes.iter().map(width).collect() })
}

fn calculatenormal(call: &Call<'_>) -> Result<Value, Fault> {
    let point = &call.args[0];
    if point.shape != Shape::Vector(3) {
        return Err(Fault::of(0, format!("needs a vector of 3, found {}", point.shape)));
    }
    let along = |along| [0, 1, 2].map(|i| difference(call, &point.planes[i], along));
    let ([ux, uy, uz], [vx, vy, vz]) = (along(Along::Row), along(Along::Column));
    // Rows run downwards, so it is this order that gives the side which the eye sees.
    let normal = call.lanes([&ux, &uy, &uz, &vx, &vy, &vz], |[ux, uy, uz, vx, vy, vz]| {
        [vy * uz - vz * uy, vz * ux - vx * uz, vx * uy - vy * ux]
    });
    let normal: Planes = normal.into_iter().collect();
    Ok(Value { shape: Shape::Vector(3), planes: direction_planes(call, &normal) })
}

const E: &[Param] = &[Param::new("e")];

pub(super) const FUNCTIONS: &[Builtin] = &[
    Builtin {
        name: "Du",
        params: E,
        brief: "The change of an expression from this pixel to the next one of its row.",
        doc: "The whole program is also run with the input variables of the neighbour, in a *helper lane* that \
              follows the pixel's path through conditions and loops; the change is the difference of the two values. \
              A neighbour on another `surface`, or behind a silhouette of the same one, does not count: the \
              neighbour on the other side is used instead, and without one the change is 0. A derivative is the same \
              in the helper lanes, so `Du(Du(e))` is 0. The derivative of a value that is the same for the whole \
              frame is 0.",
        examples: &[ex("Du(3)", "0")],
        kernel: Kernel::Shadowed(along_row),
    },
    Builtin {
        name: "Dv",
        params: E,
        brief: "The change of an expression from this pixel to the next one of its column, downwards.",
        doc: "See `Du`.",
        examples: &[ex("Dv([1 2])", "[0 0]")],
        kernel: Kernel::Shadowed(along_column),
    },
    Builtin {
        name: "filterwidth",
        params: E,
        brief: "How much an expression changes over a pixel: `abs(Du(e)) + abs(Dv(e))`.",
        doc: "The filter width that removes detail of `e` finer than a pixel. Component by component. See `Du`.",
        examples: &[ex("filterwidth(3)", "0")],
        kernel: Kernel::Shadowed(filterwidth),
    },
    Builtin {
        name: "calculatenormal",
        params: &[Param::new("p")],
        brief: "The unit normal of the surface through the points `p`, on the side of the eye.",
        doc: "`direction(cross(Dv(p), Du(p)))`: the normal of a surface that was displaced, as in Blinn's bump \
              mapping: `normal = calculatenormal(point + 0.1 * Noise(8 * point) * normal)`. Where `p` does not \
              change, the result is `[0 0 0]`. Because it uses differences between neighbours, it is the normal of a \
              facet half a pixel away.",
        examples: &[ex("calculatenormal([1 2 3])", "[0 0 0]")],
        kernel: Kernel::Shadowed(calculatenormal),
    },
];
