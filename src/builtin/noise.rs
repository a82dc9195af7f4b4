//! Noise for programs: the kinds of [`crate::noise`], applied to points.

use super::apply::each;
use super::call::{Call, Fault};
use super::noise_kind::{coordinates, fault, field, fields, params_of, with_kind, with_options};
use super::{Builtin, Kernel, Param, ex};
use crate::noise::{Field, OPTIONS, Opt, Params, random};
use crate::shape::Shape;
use crate::value::{Plane, Planes, Value};
use std::sync::Arc;

/// The fields of a call of `Noise`, `Dnoise` (one) or `Vnoise` (three) at points of so many coordinates.
pub fn noise_fields(call: &Call<'_>, dimensions: usize, count: usize) -> Result<Vec<Arc<dyn Field>>, Fault> {
    if count == 3 {
        return Ok(fields::<3>(call, 1, dimensions)?.into());
    }
    Ok(vec![field(call, 1, dimensions)?])
}

/// The noise at points.
fn values(call: &Call<'_>, field: &dyn Field, p: &[Plane]) -> Plane {
    let [out] = call.planes(p, |p, [out]| field.noise(call.isa, p, out));
    out
}

/// Its derivative along each of `D` coordinates.
fn derivatives<const D: usize>(call: &Call<'_>, field: &dyn Field, p: &[Plane]) -> [Plane; D] {
    call.planes(p, |p, mut out| field.derivative(call.isa, p, &mut out))
}

fn noise(call: &Call<'_>) -> Result<Value, Fault> {
    each([&call.args[0]], &mut |[p]| {
        let p = coordinates(p)?;
        Ok(Value::scalar(values(call, &*field(call, 1, p.len())?, p)))
    })
}

fn vnoise(call: &Call<'_>) -> Result<Value, Fault> {
    each([&call.args[0]], &mut |[p]| {
        let p = coordinates(p)?;
        let fields = fields::<3>(call, 1, p.len())?;
        Ok(Value::vector(fields.iter().map(|field| values(call, &**field, p)).collect()))
    })
}

fn dnoise(call: &Call<'_>) -> Result<Value, Fault> {
    each([&call.args[0]], &mut |[value]| {
        let p = coordinates(value)?;
        let field = field(call, 1, p.len())?;
        let planes: Planes = match p.len() {
            1 => derivatives::<1>(call, &*field, p).into_iter().collect(),
            2 => derivatives::<2>(call, &*field, p).into_iter().collect(),
            3 => derivatives::<3>(call, &*field, p).into_iter().collect(),
            _ => derivatives::<4>(call, &*field, p).into_iter().collect(),
        };
        Ok(Value { shape: value.shape.clone(), planes })
    })
}

fn curl(call: &Call<'_>) -> Result<Value, Fault> {
    each([&call.args[0]], &mut |[p]| {
        let p = coordinates(p)?;
        let minus = |a: &Plane, b: &Plane| call.lane([a, b], |[a, b]| a - b);
        // Of a potential, one noise in the plane and three in space, what turns about it.
        let flow: Planes = match p.len() {
            1 => return Err(Fault::of(0, "curl needs a vector of 2 to 4, found a scalar")),
            2 => {
                let [dx, dy] = derivatives::<2>(call, &*field(call, 1, 2)?, p);
                [dy, call.lane([&dx], |[dx]| -dx)].into_iter().collect()
            }
            n => {
                let [a, b, c] = fields::<3>(call, 1, n)?;
                let [a, b, c] = [a, b, c].map(|potential| -> Planes {
                    if n == 3 {
                        derivatives::<3>(call, &*potential, p).into_iter().collect()
                    } else {
                        derivatives::<4>(call, &*potential, p).into_iter().collect()
                    }
                });
                [minus(&c[1], &b[2]), minus(&a[2], &c[0]), minus(&b[0], &a[1])].into_iter().collect()
            }
        };
        Ok(Value::vector(flow))
    })
}

fn random(call: &Call<'_>) -> Result<Value, Fault> {
    let seed = super::noise_kind::seed(call, 1)?;
    each([&call.args[0]], &mut |[p]| {
        if !matches!(p.shape, Shape::Scalar | Shape::Vector(1..)) {
            return Err(Fault::of(0, format!("random takes a scalar or a vector, found {}", p.shape)));
        }
        let [out] = call.planes(&p.planes, |p, [out]| random::random(call.isa, p, seed, out));
        Ok(Value::scalar(out))
    })
}

/// The options that the error of `wiener` noise depends on, as it takes them.
const OF_ERROR: [Opt; 5] = [Opt::Covariance, Opt::Width, Opt::Frequency, Opt::Knots, Opt::Neighbours];

fn wiener_error(call: &Call<'_>) -> Result<Value, Fault> {
    each([&call.args[0]], &mut |[p]| {
        let p = coordinates(p)?;
        let params = with_options(call, Params::default(), 1, OF_ERROR.iter().map(|option| option.info()))?;
        let arg = |option| 1 + OF_ERROR.iter().position(|o| *o == option).unwrap_or(0);
        let field = crate::noise::wiener_error(p.len(), &params).map_err(|unfit| fault(unfit, arg))?;
        Ok(Value::scalar(values(call, &*field, p)))
    })
}

static PARAMS: [Param; params_of(1)] = with_kind([Param::new("p")]);

static ERROR_PARAMS: [Param; 1 + OF_ERROR.len()] = {
    let mut params = [Param::new("p"); 1 + OF_ERROR.len()];
    let mut i = 0;
    while i < OF_ERROR.len() {
        let info = &OPTIONS[OF_ERROR[i] as usize];
        params[1 + i] = Param { minor: i > 0, ..Param::option(info.name, info.choices) };
        i += 1;
    }
    params
};

/// Noise.
pub static FUNCTIONS: &[Builtin] = &[
    Builtin {
        name: "Noise",
        params: &PARAMS,
        brief: "A smooth random number for a point: Perlin's Noise().",
        doc: "Its details have a size of about 1, and it looks the same everywhere. p is a scalar or a vector of 2, \
              3 or 4 (for example with time); for a vector of points it gives the noise of each. Plain `Noise(p)` is \
              that of the paper, signed, random at lattice points. [noise.md](noise.md) shows all kinds, their \
              properties, and which to use. Each seed gives a different noise of the same kind. The other parameters \
              depend on the kind, and so do their defaults.",
        examples: &[
            ex("Noise([1 2 3], kind = \"gradient\")", "0"),
            ex("Noise([0.3 0.4]) - Noise([0.3 0.4], seed = 0)", "0"),
            ex("Noise([0.5 8.25], period = 8) - Noise([8.5 0.25], period = 8)", "0"),
        ],
        kernel: Kernel::Whole(noise),
    },
    Builtin {
        name: "Dnoise",
        params: &PARAMS,
        brief: "The gradient of Noise at a point: its rate of change along each axis.",
        doc: "A vector with as many components as p (a scalar for a scalar): the exact derivative of \
              [Noise](#Noise) with the same arguments. `normal += Dnoise(point)` makes a surface look bumpy.",
        examples: &[
            ex("size(Dnoise([0.1 0.2 0.3]))", "3"),
            ex("Dnoise([1 2], seed = 3) - Dnoise([1 2], seed = 3)", "[0 0]"),
        ],
        kernel: Kernel::Whole(dnoise),
    },
    Builtin {
        name: "Vnoise",
        params: &PARAMS,
        brief: "A smooth random vector for a point: three independent noises.",
        doc: "The first is [Noise](#Noise) with the same arguments; the others use other seeds. Use it to deform a \
              shape, to perturb a point, or to make colours: Lewis 1989, section 5.3.",
        examples: &[ex("size(Vnoise(0.5))", "3"), ex("Vnoise([0.1 0.2 0.3])[1] - Noise([0.1 0.2 0.3])", "0")],
        kernel: Kernel::Whole(vnoise),
    },
    Builtin {
        name: "curl",
        params: &PARAMS,
        brief: "A random flow without divergence: the curl of noise.",
        doc: "For a vector of 2, a vector of 2 along the level lines of [Noise](#Noise); for a vector of 3, the curl \
              of [Vnoise](#Vnoise); a fourth component of p is time. It is computed from exact derivatives, so its \
              divergence is 0.",
        examples: &[
            ex("size(curl([0.1 0.2])) + size(curl([0.1 0.2 0.3]))", "5"),
            ex("dot(curl([0.1 0.2]), Dnoise([0.1 0.2]))", "0"),
        ],
        kernel: Kernel::Whole(curl),
    },
    Builtin {
        name: "random",
        params: &[Param::new("p"), Param::or("seed", "0")],
        brief: "A random number from 0 up to 1 for a point, independent of every other point.",
        doc: "White noise: the same p always gives the same number, and any change of p a different one. p has any \
              number of coordinates. `random(floor(p))` is one number per cell; `random(pixel, seed = frame)` is \
              grain.",
        examples: &[ex("random([1 2]) - random([1 2])", "0"), ex("random(3) >= 0 && random(3) < 1", "1")],
        kernel: Kernel::Whole(random),
    },
    Builtin {
        name: "wiener_error",
        params: &ERROR_PARAMS,
        brief: "The expected squared error of the interpolation of `wiener` noise at a point.",
        doc: "Relative to the variance: 0 at lattice points, where values are known, below 1 between, the same in every \
              cell and for every seed. It is 1 - cᵗC⁻¹c, the confidence measure of Lewis 1989, section 3; the square \
              root is the expected error in standard deviations. `covariance`, `width`, `frequency`, `knots` and \
              `neighbours` are those of `Noise(p, kind = \"wiener\")`, with the same defaults.",
        examples: &[
            ex("wiener_error([1 2 3])", "0"),
            ex("wiener_error(0.5) > wiener_error(0.25) && wiener_error(0.25) > 0", "1"),
            ex("wiener_error([0.3 0.7], width = 1) < wiener_error([0.3 0.7], width = 0.4)", "1"),
            ex("wiener_error([0.3 0.7]) - wiener_error([5.7 0.3])", "0"),
        ],
        kernel: Kernel::Whole(wiener_error),
    },
];
