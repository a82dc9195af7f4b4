//! Noise for programs: the kernels of [`crate::noise`], applied to points of one to four coordinates.

use super::apply::each;
use super::call::{Call, Fault};
use super::{Builtin, Kernel, Param, ex};
use crate::noise::{self, Kind, turbulence::turbulence_1992, white};
use crate::shape::Shape;
use crate::value::{Plane, Planes, Value};

/// The names of the algorithms, as `kind` takes them.
const KINDS: &[&str] = &{
    let mut names = [""; Kind::ALL.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = Kind::ALL[i].1;
        i += 1;
    }
    names
};

/// The algorithm that a `kind` parameter chose.
fn kind(call: &Call<'_>, arg: usize) -> Kind {
    let chosen = call.args[arg].as_uniform().unwrap_or(0.0) as usize;
    Kind::ALL.get(chosen).map_or(Kind::default(), |entry| entry.0)
}

/// A seed: every number is another one, 0 and -0 the same.
fn seed(call: &Call<'_>, arg: usize) -> Result<u32, Fault> {
    Ok((call.same_everywhere(arg)? + 0.0).to_bits())
}

/// The coordinates of a point, 1 to `most` of them.
fn coordinates<'v>(name: &str, p: &'v Value, most: usize) -> Result<&'v Planes, Fault> {
    match p.shape {
        Shape::Scalar => Ok(&p.planes),
        Shape::Vector(n) if (1..=most).contains(&(n as usize)) => Ok(&p.planes),
        _ => {
            Err(Fault::of(0, format!("{name} takes a scalar or a vector of 1 to {most}, found {}", p.shape)))
        }
    }
}

/// One number for each point.
fn field(
    call: &Call<'_>,
    name: &str,
    most: usize,
    f: impl Fn(&[&[f32]], &mut [f32]),
) -> Result<Value, Fault> {
    each([&call.args[0]], &mut |[p]| {
        let p = coordinates(name, p, most)?;
        let [out] = call.planes(p, |s, [out]| f(s, out));
        Ok(Value::scalar(out))
    })
}

fn noise_of(call: &Call<'_>) -> Result<Value, Fault> {
    let (kind, seed) = (kind(call, 1), seed(call, 2)?);
    field(call, "Noise", 4, |p, out| noise::noise(kind, call.isa, p, seed, out))
}

fn random(call: &Call<'_>) -> Result<Value, Fault> {
    let seed = seed(call, 1)?;
    field(call, "random", call.max_cells.max(1), |p, out| white::random(call.isa, p, seed, out))
}

/// The derivative of a noise of `D` coordinates.
fn derivative<const D: usize>(call: &Call<'_>, p: &[Plane], kind: Kind, seed: u32) -> Planes {
    let out: [Plane; D] = call.planes(p, |s, mut out| {
        noise::dnoise(kind, call.isa, s, seed, &mut out);
    });
    out.into_iter().collect()
}

fn dnoise_of(call: &Call<'_>) -> Result<Value, Fault> {
    let (kind, seed) = (kind(call, 1), seed(call, 2)?);
    each([&call.args[0]], &mut |[p]| {
        let coords = coordinates("Dnoise", p, 4)?;
        let planes = match coords.len() {
            1 => derivative::<1>(call, coords, kind, seed),
            2 => derivative::<2>(call, coords, kind, seed),
            3 => derivative::<3>(call, coords, kind, seed),
            _ => derivative::<4>(call, coords, kind, seed),
        };
        Ok(Value { shape: p.shape.clone(), planes })
    })
}

fn turbulence(call: &Call<'_>) -> Result<Value, Fault> {
    let (low, high) = (call.scalar(1)?, call.scalar(2)?);
    let (kind, seed) = (kind(call, 3), seed(call, 4)?);
    each([&call.args[0]], &mut |[p]| {
        let p = coordinates("turbulence", p, 4)?;
        // The kernel does not scale p by the lowest frequency.
        let scaled: Planes = p.iter().map(|x| call.lane([x, low], |[x, low]| x * low)).collect();
        let inputs = scaled.iter().chain([low, high]);
        let [out] = call.planes(inputs, |s, [out]| {
            let (p, limits) = s.split_at(s.len() - 2);
            turbulence_1992(kind, call.isa, p, [limits[0], limits[1]], seed, out);
        });
        Ok(Value::scalar(out))
    })
}

/// Noise.
pub static FUNCTIONS: &[Builtin] = &[
    Builtin {
        name: "Noise",
        params: &[Param::new("p"), Param::choice("kind", KINDS), Param::or("seed", "0")],
        brief: "A smooth random number for a point: Perlin's Noise().",
        doc: "Signed, with details of about size 1; it looks the same everywhere and in every direction. p is a \
              scalar or a vector of 2, 3 or 4 (time, say); of a vector of points it gives the noise of each. \
              The kinds: `\"perlin1985\"`, the paper's, random at lattice points; `\"gradient\"`, Perlin's of 1992, \
              which is 0 at lattice points. Each seed is another noise of the same kind.",
        examples: &[
            ex("Noise([1 2 3], kind = \"gradient\")", "0"),
            ex("Noise([0.3 0.4]) - Noise([0.3 0.4], seed = 0)", "0"),
        ],
        kernel: Kernel::Whole(noise_of),
    },
    Builtin {
        name: "Dnoise",
        params: &[Param::new("p"), Param::choice("kind", KINDS), Param::or("seed", "0")],
        brief: "How fast Noise changes at a point along each axis: its gradient.",
        doc: "A vector with as many components as p (a scalar for a scalar): the exact derivative of \
              [Noise](#Noise) of the same kind and seed. `normal += Dnoise(point)` makes a surface look bumpy.",
        examples: &[
            ex("size(Dnoise([0.1 0.2 0.3]))", "3"),
            ex("Dnoise([1 2], seed = 3) - Dnoise([1 2], seed = 3)", "[0 0]"),
        ],
        kernel: Kernel::Whole(dnoise_of),
    },
    Builtin {
        name: "turbulence",
        params: &[
            Param::new("p"),
            Param::or("low", "1"),
            Param::or("high", "1 / pixelsize"),
            Param::choice("kind", KINDS),
            Param::or("seed", "0"),
        ],
        brief: "The absolute noise of octaves, each twice as fine and half as large.",
        doc: "The sum of `abs(Noise(p * f)) / f` for f = low, 2 low, 4 low … while f is below high. With the defaults \
              it is the procedure in the appendix of *An Image Synthesizer*, which adds detail down to the size of a \
              pixel and no further. Not negative; at most 24 octaves, and none if low is not above 0.",
        examples: &[
            ex("turbulence([0.3 0.6 0.1], high = 2) - abs(Noise([0.3 0.6 0.1]))", "0"),
            ex("turbulence(0.3, 2, 8) - abs(Noise(0.6)) / 2 - abs(Noise(1.2)) / 4", "0"),
            ex("turbulence(0.3, high = 1)", "0"),
        ],
        kernel: Kernel::Whole(turbulence),
    },
    Builtin {
        name: "random",
        params: &[Param::new("p"), Param::or("seed", "0")],
        brief: "A random number from 0 up to 1 for a point, unrelated to that of any other.",
        doc: "White noise: the same p always gives the same number, and the smallest change of p another one. Any \
              number of coordinates. `random(floor(p))` is one number a cell; `random(pixel, seed = frame)` is \
              grain.",
        examples: &[ex("random([1 2]) - random([1 2])", "0"), ex("random(3) >= 0 && random(3) < 1", "1")],
        kernel: Kernel::Whole(random),
    },
];
