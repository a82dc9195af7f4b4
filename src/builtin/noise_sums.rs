//! Sums of octaves for programs: turbulence and its like.

use super::apply::each;
use super::call::{Call, Fault};
use super::noise_kind::{coordinates, kind_and_params, make, params_of, with_kind};
use super::{Builtin, Kernel, Param, ex};
use crate::lanes::Isa;
use crate::noise::sums::{Form, OCTAVES, Sum};
use crate::noise::{Field, Opt};
use crate::value::{Plane, Value};
use std::sync::Arc;

/// What a sum takes after p, by place; 0 is what it does not take.
struct Places {
    low: usize,
    high: usize,
    octaves: usize,
    lacunarity: usize,
    gain: usize,
    fade: usize,
    offset: usize,
    kind: usize,
}

/// Of sums between two frequencies, as Perlin and Peachey have them.
const BAND: Places =
    Places { low: 1, high: 2, octaves: 3, lacunarity: 4, gain: 5, fade: 6, offset: 0, kind: 7 };
static BAND_PARAMS: [Param; params_of(BAND.kind)] = with_kind([
    Param::new("p"),
    Param::or("low", "1"),
    Param::or("high", "pixel_freq"),
    Param::or("octaves", "24"),
    Param::or("lacunarity", "2"),
    Param::or("gain", "0.5"),
    Param::or("fade", "1"),
]);

/// Of sums of so many octaves.
const COUNT: Places =
    Places { low: 0, high: 4, octaves: 1, lacunarity: 2, gain: 3, fade: 5, offset: 0, kind: 6 };
static COUNT_PARAMS: [Param; params_of(COUNT.kind)] = with_kind([
    Param::new("p"),
    Param::or("octaves", "8"),
    Param::or("lacunarity", "2"),
    Param::or("gain", "0.5"),
    Param::or("high", "pixel_freq"),
    Param::or("fade", "1"),
]);

/// Of the multifractals.
const OFFSET: Places =
    Places { low: 0, high: 5, octaves: 1, lacunarity: 2, gain: 3, fade: 6, offset: 4, kind: 7 };

const fn offset_params(gain: &'static str, offset: &'static str) -> [Param; params_of(OFFSET.kind)] {
    with_kind([
        Param::new("p"),
        Param::or("octaves", "8"),
        Param::or("lacunarity", "2"),
        Param::or("gain", gain),
        Param::or("offset", offset),
        Param::or("high", "pixel_freq"),
        Param::or("fade", "1"),
    ])
}
static RIDGED_PARAMS: [Param; params_of(OFFSET.kind)] = offset_params("0.5", "1");
static HYBRID_PARAMS: [Param; params_of(OFFSET.kind)] = offset_params("0.84", "0.7");

/// The sum of that form at the points of a call.
fn sum(call: &Call<'_>, form: Form, at: &Places) -> Result<Value, Fault> {
    let plane = |place: usize| if place == 0 { Ok(Plane::Uniform(1.0)) } else { call.scalar(place).cloned() };
    let low = plane(at.low)?;
    let numbers = [
        low.clone(),
        plane(at.high)?,
        // The first octave of a sum from `low` on is of the size that its frequency has.
        call.lane([&low], |[low]| 1.0 / low),
        plane(at.octaves)?,
        plane(at.lacunarity)?,
        plane(at.gain)?,
        plane(at.fade)?,
        plane(at.offset)?,
    ];
    each([&call.args[0]], &mut |[p]| {
        let p = coordinates(p)?;
        let fields = octave_fields(call, at, p.len())?;
        let [out] = call.planes(p.iter().chain(&numbers), |s, [out]| {
            run(call.isa, form, &fields, s, out);
        });
        Ok(Value::scalar(out))
    })
}

/// The sum of that form; `s` is the point's coordinates and eight numbers, in the order of [`sum`].
fn run(isa: Isa, form: Form, fields: &[Arc<dyn Field>], s: &[&[f32]], out: &mut [f32]) {
    let (p, numbers) = s.split_at(s.len() - NUMBERS);
    let &[low, high, size, octaves, lacunarity, gain, fade, offset] = numbers else {
        unreachable!("as many as were split off")
    };
    Sum { form, fields, low, high, size, octaves, lacunarity, gain, fade, offset }.run(isa, p, out);
}

/// How many numbers a sum takes beside the point.
const NUMBERS: usize = 8;

/// A call of one of these functions that knows its fields.
pub struct Octaves {
    form: Form,
    fields: Vec<Arc<dyn Field>>,
    /// The arguments that are its numbers, by place; `None` for 1. The third is 1 / the first.
    pub numbers: [Option<usize>; NUMBERS],
}

impl Octaves {
    /// That of a call, of which only the arguments in `known` are looked at; `None` if it needs others.
    pub fn of(name: &str, call: &Call<'_>, known: &[bool], dimensions: usize) -> Option<Octaves> {
        let (form, at) = match name {
            "turbulence" => (Form::Turbulence, &BAND),
            "fractalsum" => (Form::Fractal, &BAND),
            "fBm" => (Form::Fractal, &COUNT),
            "ridged" => (Form::Ridged, &OFFSET),
            "hybrid" => (Form::Hybrid, &OFFSET),
            _ => return None,
        };
        if !(at.kind..known.len()).chain([at.low, at.lacunarity]).all(|i| i == 0 || known[i]) {
            return None;
        }
        let place = |i: usize| (i > 0).then_some(i);
        let numbers =
            [at.low, at.high, at.low, at.octaves, at.lacunarity, at.gain, at.fade, at.offset].map(place);
        Some(Octaves { form, fields: octave_fields(call, at, dimensions).ok()?, numbers })
    }

    /// The sum at points; the slices are coordinates and then [`Octaves::numbers`].
    pub fn run(&self, isa: Isa, slices: &[&[f32]], out: &mut [f32]) {
        run(isa, self.form, &self.fields, slices, out);
    }
}

/// The noise of each octave, the last being that of all that follow. They differ if the sum has a period, which
/// is one of every octave: in an octave's own units it grows with the frequency.
fn octave_fields(call: &Call<'_>, at: &Places, dimensions: usize) -> Result<Vec<Arc<dyn Field>>, Fault> {
    let (kind, params) = kind_and_params(call, at.kind)?;
    let Some(period) = params.vector(Opt::Period) else {
        return Ok(vec![make(kind, dimensions, &params, at.kind)?]);
    };
    let low = if at.low == 0 { 1.0 } else { call.same_everywhere(at.low)? };
    let lacunarity = call.same_everywhere(at.lacunarity)?;
    if lacunarity.fract() != 0.0 || lacunarity < 1.0 {
        let message = format!("with a period lacunarity must be a whole number, found {lacunarity}");
        return Err(Fault::of(at.lacunarity, message));
    }
    let mut frequency = low;
    let mut fields = Vec::new();
    while fields.len() < OCTAVES {
        let scaled: Vec<f32> = period.iter().map(|p| p * frequency).collect();
        match make(kind, dimensions, &params.clone().with(Opt::Period, &scaled), at.kind) {
            Ok(field) => fields.push(field),
            // So fine that the lattice repeats where the coordinates themselves have no digits left.
            Err(_) if !fields.is_empty() => break,
            Err(fault) => return Err(fault),
        }
        frequency *= lacunarity;
    }
    Ok(fields)
}

/// Sums of octaves.
pub static FUNCTIONS: &[Builtin] = &[
    Builtin {
        name: "turbulence",
        params: &BAND_PARAMS,
        brief: "The sum of octaves of absolute noise, each of twice the frequency and half the amplitude.",
        doc: "The sum of `abs(Noise(p * f)) / f` for f = low, 2 low, 4 low … while f is below high, which is by \
              default the highest frequency that the pixels can show; an octave above half of it is faded, so that \
              none appears suddenly. (For samples at a distance w, give `high = 0.5 / w`.) With `high = 1 / \
              pixelsize, fade = 0` it is the procedure in the appendix of *An Image Synthesizer*, to the bit. Not \
              negative; at most 24 octaves, and none if low is not above 0. `lacunarity` and `gain` are the factors \
              of frequency and amplitude from octave to octave; the other parameters are those of [Noise](#Noise).",
        examples: &[
            ex("turbulence([0.3 0.6 0.1], high = 2) - abs(Noise([0.3 0.6 0.1]))", "0"),
            ex("turbulence(0.3, 2, 8) - abs(Noise(0.6)) / 2 - abs(Noise(1.2)) / 4", "0"),
            ex("turbulence(0.3, high = 1)", "0"),
        ],
        kernel: Kernel::Whole(|call| sum(call, Form::Turbulence, &BAND)),
    },
    Builtin {
        name: "fractalsum",
        params: &BAND_PARAMS,
        brief: "The sum of octaves of noise, each of twice the frequency and half the amplitude.",
        doc: "Like [turbulence](#turbulence), without the absolute value: signed, and without creases. Peachey, \
              \"Spectral Synthesis\".",
        examples: &[
            ex("fractalsum([0.3 0.6], high = 2) - Noise([0.3 0.6])", "0"),
            ex("fractalsum(0.3, 2, 8) - Noise(0.6) / 2 - Noise(1.2) / 4", "0"),
        ],
        kernel: Kernel::Whole(|call| sum(call, Form::Fractal, &BAND)),
    },
    Builtin {
        name: "fBm",
        params: &COUNT_PARAMS,
        brief: "Fractional Brownian motion: the sum of `octaves` octaves of noise.",
        doc: "`Noise(p) + gain * Noise(lacunarity * p) + gain^2 * Noise(lacunarity^2 * p) …`. With 4.5 octaves, the \
              fifth is weighted by half. As with [turbulence](#turbulence), octaves that the pixels cannot show are \
              omitted, and the last one fades.",
        examples: &[
            ex("fBm([0.3 0.6], 1, high = 9) - Noise([0.3 0.6])", "0"),
            ex("fBm(0.3, 2, high = 9) - Noise(0.3) - 0.5 * Noise(0.6)", "0"),
        ],
        kernel: Kernel::Whole(|call| sum(call, Form::Fractal, &COUNT)),
    },
    Builtin {
        name: "ridged",
        params: &RIDGED_PARAMS,
        brief: "A ridged multifractal: sharp crests, rough near their tops and smooth in the valleys.",
        doc: "Each octave is `(offset - abs(Noise))^2`, weighted by twice the octave before it, at most by 1 \
              (Musgrave). For mountains, lightning, veins. Not negative. Otherwise like [fBm](#fBm).",
        examples: &[ex("ridged([0.3 0.6], 1, high = 9) - (1 - abs(Noise([0.3 0.6])))^2", "0")],
        kernel: Kernel::Whole(|call| sum(call, Form::Ridged, &OFFSET)),
    },
    Builtin {
        name: "hybrid",
        params: &HYBRID_PARAMS,
        brief: "A hybrid multifractal: smooth in the lowlands, rough on the heights.",
        doc: "Each octave is `Noise + offset`, weighted by the product of the octaves before it, at most by 1 \
              (Musgrave). For land with valleys at every height. Otherwise like [fBm](#fBm).",
        examples: &[ex("hybrid([0.3 0.6], 1, high = 9) - Noise([0.3 0.6])", "0.7")],
        kernel: Kernel::Whole(|call| sum(call, Form::Hybrid, &OFFSET)),
    },
];
