//! Vectors as arrows in space: lengths, angles, mirrors. A sum over components is taken from left to right,
//! always, so that its last bit does not depend on how it is computed.

use super::apply::{each, pair, vector_of};
use super::call::{Call, Fault};
use super::{Builtin, Kernel, Param, ex};
use crate::math;
use crate::shape::Shape;
use crate::value::{Plane, Planes, Value};

/// `a · b` of two lists of planes of one length.
pub fn dot_planes(call: &Call<'_>, a: &[Plane], b: &[Plane]) -> Plane {
    match (a, b) {
        ([ax, ay, az], [bx, by, bz]) => {
            call.lane([ax, ay, az, bx, by, bz], |[ax, ay, az, bx, by, bz]| ax * bx + ay * by + az * bz)
        }
        ([ax, ay, az, aw], [bx, by, bz, bw]) => call
            .lane([ax, ay, az, aw, bx, by, bz, bw], |[ax, ay, az, aw, bx, by, bz, bw]| {
                ax * bx + ay * by + az * bz + aw * bw
            }),
        ([], _) | (_, []) => Plane::Uniform(0.0),
        ([ax, a @ ..], [bx, b @ ..]) => {
            let first = call.lane([ax, bx], |[a, b]| a * b);
            a.iter().zip(b).fold(first, |sum, (a, b)| call.lane([&sum, a, b], |[sum, a, b]| sum + a * b))
        }
    }
}

/// The Euclidean length of a list of planes.
pub fn norm_planes(call: &Call<'_>, v: &[Plane]) -> Plane {
    match v {
        [x] => call.lane([x], |[x]| x.abs()),
        [x, y, z] => call.lane([x, y, z], |[x, y, z]| (x * x + y * y + z * z).sqrt()),
        _ => call.lane([&dot_planes(call, v, v)], |[x]| x.sqrt()),
    }
}

/// What a vector of this length is multiplied by to become of length 1: 0 for no length, as a pixel without a
/// surface has a zero normal, which must not turn to NaN.
#[inline(always)]
pub fn inverse(length: f32) -> f32 {
    let inverse = 1.0 / length;
    if length == 0.0 { 0.0 } else { inverse }
}

/// Each component divided by the length; zero vectors stay zero.
pub fn direction_planes(call: &Call<'_>, v: &[Plane]) -> Planes {
    if let [x, y, z] = v {
        let unit = call.lanes([x, y, z], |[x, y, z]| {
            let inverse = inverse((x * x + y * y + z * z).sqrt());
            [x * inverse, y * inverse, z * inverse]
        });
        return unit.into_iter().collect();
    }
    let inverse = call.lane([&norm_planes(call, v)], |[length]| inverse(length));
    v.iter().map(|x| call.lane([x, &inverse], |[x, inverse]| x * inverse)).collect()
}

/// A scalar if both arguments were, else a vector.
fn with_planes(like: [&Value; 2], planes: Planes) -> Value {
    let scalar = like.iter().all(|v| v.shape.is_scalar());
    let shape = if scalar { Shape::Scalar } else { Shape::Vector(planes.len() as u32) };
    Value { shape, planes }
}

fn dot(call: &Call<'_>) -> Result<Value, Fault> {
    each([&call.args[0], &call.args[1]], &mut |[a, b]| {
        let (a, b) = pair("dot", a, b)?;
        Ok(Value::scalar(dot_planes(call, &a, &b)))
    })
}

fn cross(call: &Call<'_>) -> Result<Value, Fault> {
    each([&call.args[0], &call.args[1]], &mut |[a, b]| {
        let a = vector_of("cross", 0, a, &[3])?;
        let b = vector_of("cross", 1, b, &[3])?;
        let inputs = [&a[0], &a[1], &a[2], &b[0], &b[1], &b[2]];
        let out = call.lanes(inputs, |[ax, ay, az, bx, by, bz]| {
            [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
        });
        Ok(Value::vector(out.into_iter().collect()))
    })
}

fn norm(call: &Call<'_>) -> Result<Value, Fault> {
    each([&call.args[0]], &mut |[v]| Ok(Value::scalar(norm_planes(call, &v.planes))))
}

fn direction(call: &Call<'_>) -> Result<Value, Fault> {
    each([&call.args[0]], &mut |[v]| Ok(with_planes([v, v], direction_planes(call, &v.planes))))
}

fn distance(call: &Call<'_>) -> Result<Value, Fault> {
    each([&call.args[0], &call.args[1]], &mut |[a, b]| {
        let (a, b) = pair("distance", a, b)?;
        let between: Planes = a.iter().zip(&b).map(|(a, b)| call.lane([a, b], |[a, b]| a - b)).collect();
        Ok(Value::scalar(norm_planes(call, &between)))
    })
}

/// For each component, `f` of the numbers of v and n, of `n · v`, and of a further plane.
fn across(
    call: &Call<'_>,
    name: &str,
    [v, n]: [&Value; 2],
    more: &Plane,
    f: impl Fn([f32; 4]) -> f32 + Copy,
) -> Result<Value, Fault> {
    let (a, b) = pair(name, v, n)?;
    let product = dot_planes(call, &b, &a);
    let planes = a.iter().zip(&b).map(|(v, n)| call.lane([v, n, &product, more], f));
    Ok(with_planes([v, n], planes.collect()))
}

fn reflect(call: &Call<'_>) -> Result<Value, Fault> {
    let mirror = |[v, n, product, _]: [f32; 4]| v - 2.0 * product * n;
    each([&call.args[0], &call.args[1]], &mut |args| {
        across(call, "reflect", args, &Plane::Uniform(0.0), mirror)
    })
}

fn faceforward(call: &Call<'_>) -> Result<Value, Fault> {
    let turn = |[n, _, product, _]: [f32; 4]| if product > 0.0 { -n } else { n };
    each([&call.args[0], &call.args[1]], &mut |args| {
        across(call, "faceforward", args, &Plane::Uniform(0.0), turn)
    })
}

/// One component of a refracted direction, where `c` is `n · v`.
#[inline(always)]
fn bend([v, n, c, ratio]: [f32; 4]) -> f32 {
    // The cosine in the second medium, squared; negative where all light is reflected.
    let k = 1.0 - ratio * ratio * (1.0 - c * c);
    let bent = ratio * v - (ratio * c + k.sqrt()) * n;
    if k < 0.0 { 0.0 } else { bent }
}

fn refract(call: &Call<'_>) -> Result<Value, Fault> {
    let ratio = call.scalar(2)?;
    each([&call.args[0], &call.args[1]], &mut |args| across(call, "refract", args, ratio, bend))
}

/// A point turned about a unit axis by Rodrigues' formula; about no axis, not turned.
#[inline(always)]
pub fn rodrigues([x, y, z, sin, cos, u, v, w]: [f32; 8]) -> [f32; 3] {
    let along = (u * x + v * y + w * z) * (1.0 - cos);
    let turned = [
        x * cos + (v * z - w * y) * sin + u * along,
        y * cos + (w * x - u * z) * sin + v * along,
        z * cos + (u * y - v * x) * sin + w * along,
    ];
    let still = u == 0.0 && v == 0.0 && w == 0.0;
    if still { [x, y, z] } else { turned }
}

fn rotate(call: &Call<'_>) -> Result<Value, Fault> {
    let angle = call.scalar(1)?;
    let (sin, cos) = (call.map1(angle, math::sin_lanes), call.map1(angle, math::cos_lanes));
    let (zero, one) = (Plane::Uniform(0.0), Plane::Uniform(1.0));
    each([&call.args[0], &call.args[2]], &mut |[p, axis]| {
        let p = vector_of("rotate", 0, p, &[2, 3])?;
        let axis = vector_of("rotate", 2, axis, &[3])?;
        let out = if let [x, y] = &p[..] {
            call.lanes([x, y, &zero, &sin, &cos, &zero, &zero, &one], rodrigues)
        } else {
            let axis = direction_planes(call, axis);
            call.lanes([&p[0], &p[1], &p[2], &sin, &cos, &axis[0], &axis[1], &axis[2]], rodrigues)
        };
        Ok(Value::vector(out.into_iter().take(p.len()).collect()))
    })
}

/// Vectors.
pub static FUNCTIONS: &[Builtin] = &[
    Builtin {
        name: "dot",
        params: &[Param::new("a"), Param::new("b")],
        brief: "The dot product of two vectors of any length.",
        doc: "The sum of the products of their components, from left to right; of unit vectors, the cosine of the \
              angle between them. A scalar is used with each component. Of a vector of vectors it gives the dot \
              product of each, so `dot(m, v)` of the rows of a matrix is the matrix times v.",
        examples: &[ex("dot([1 2 3], [4 5 6])", "32"), ex("dot([[1 0] [0 2]], [3 4])", "[3 8]")],
        kernel: Kernel::Whole(dot),
    },
    Builtin {
        name: "cross",
        params: &[Param::new("a"), Param::new("b")],
        brief: "The cross product of two vectors of 3.",
        doc: "It is at right angles to both; in right-handed space x cross y is z.",
        examples: &[ex("cross([1 0 0], [0 1 0])", "[0 0 1]")],
        kernel: Kernel::Whole(cross),
    },
    Builtin {
        name: "norm",
        params: &[Param::new("v")],
        brief: "The Euclidean length of a vector.",
        doc: "The square root of the sum of the squares, of any number of components; of a scalar, its `abs`; of a \
              vector of vectors, the length of each. The paper's “scalar length (ie. norm) of a vector”.",
        examples: &[ex("norm([3 4])", "5"), ex("norm([[3 4] [0 2]])", "[5 2]")],
        kernel: Kernel::Whole(norm),
    },
    Builtin {
        name: "length",
        params: &[Param::new("v")],
        brief: "The Euclidean length of a vector, the same as `norm(v)`.",
        doc: "As in shading languages. For the number of elements, see [size](#size).",
        examples: &[ex("length([2 3 6])", "7")],
        kernel: Kernel::Whole(norm),
    },
    Builtin {
        name: "direction",
        params: &[Param::new("v")],
        brief: "The unit vector in the direction of v (normalize).",
        doc: "`v / norm(v)`, except that the direction of the zero vector is the zero vector. So a pixel without a \
              surface does not become NaN. Of a vector of vectors, the direction of each.",
        examples: &[ex("direction([3 4])", "[0.6 0.8]"), ex("direction([0 0 0])", "[0 0 0]")],
        kernel: Kernel::Whole(direction),
    },
    Builtin {
        name: "distance",
        params: &[Param::new("a"), Param::new("b")],
        brief: "The distance between two points: `norm(a - b)`.",
        doc: "Of a vector of points, the distance of each.",
        examples: &[ex("distance([1 2], [4 6])", "5"), ex("distance([[3 4] [0 1]], [0 0])", "[5 1]")],
        kernel: Kernel::Whole(distance),
    },
    Builtin {
        name: "reflect",
        params: &[Param::new("v"), Param::new("normal")],
        brief: "The direction of v after reflection at a surface with this normal.",
        doc: "v points towards the mirror; the normal must have length 1. `v - 2 * dot(normal, v) * normal`.",
        examples: &[ex("reflect([1 -1 0], [0 1 0])", "[1 1 0]")],
        kernel: Kernel::Whole(reflect),
    },
    Builtin {
        name: "refract",
        params: &[Param::new("v"), Param::new("normal"), Param::new("ratio")],
        brief: "The direction of v after refraction at a surface (Snell's law).",
        doc: "v and the normal must have length 1; v points towards the surface, the normal against it. The ratio is \
              the refractive index of the medium that v leaves, divided by that of the medium it enters: `1/1.5` \
              from air into glass. For total internal reflection, the result is the zero vector.",
        examples: &[
            ex("refract([0.6 -0.8 0], [0 1 0], 1)", "[0.6 -0.8 0]"),
            ex("refract([0.6 -0.8 0], [0 1 0], 1/1.5)", "[0.4 -0.9165151 0]"),
            ex("refract([0.8 -0.6 0], [0 1 0], 1.5)", "[0 0 0]"),
        ],
        kernel: Kernel::Whole(refract),
    },
    Builtin {
        name: "faceforward",
        params: &[Param::new("normal"), Param::new("v")],
        brief: "The normal, flipped if it points along v instead of against it.",
        doc: "For surfaces that are visible from both sides; v is the view direction. A normal at right angles to v \
              stays as it is.",
        examples: &[
            ex("faceforward([0 0 1], [0 0 2])", "[0 0 -1]"),
            ex("faceforward([0 0 1], [0 0 -2])", "[0 0 1]"),
        ],
        kernel: Kernel::Whole(faceforward),
    },
    Builtin {
        name: "rotate",
        params: &[Param::new("p"), Param::new("angle"), Param::or("axis", "[0 0 1]")],
        brief: "Rotates the point p about an axis through the origin, by an angle in radians.",
        doc: "Looking against the axis, a positive angle turns counterclockwise (in right-handed space). The axis \
              may have any length; a zero axis rotates nothing. A vector of 2 rotates in its plane, whatever the \
              axis. In a vector of points, each is rotated.",
        examples: &[
            ex("rotate([1 0 0], pi/2, [0 0 1])", "[0 1 0]"),
            ex("rotate([1 2 3], 2*pi/3, [1 1 1])", "[3 1 2]"),
            ex("rotate([1 0], pi)", "[-1 0]"),
        ],
        kernel: Kernel::Whole(rotate),
    },
];
