//! Curves through knots: Catmull–Rom splines, and straight lines.

use super::apply::each_scalar;
use super::call::{Call, Fault};
use super::{Builtin, Kernel, Param, ex};
use crate::lanes::{self, Isa};
use crate::math;
use crate::shape::Shape;
use crate::value::{Lanes, Plane, Planes, Value};
use std::array::from_fn;

/// The coefficients of a piece of a curve, constant first: the cubic through `k[1]` and `k[2]` whose slope at
/// each is half the difference of its neighbours (Catmull and Rom, 1974; the matrix is Peachey's).
#[inline(always)]
fn catmull_rom(k: [f32; 4]) -> [f32; 4] {
    [
        k[1],
        -0.5 * k[0] + 0.5 * k[2],
        k[0] - 2.5 * k[1] + 2.0 * k[2] - 0.5 * k[3],
        -0.5 * k[0] + 1.5 * k[1] - 1.5 * k[2] + 0.5 * k[3],
    ]
}

/// The coefficients of the straight line from `k[0]` to `k[1]`.
#[inline(always)]
fn straight(k: [f32; 2]) -> [f32; 2] {
    [k[0], k[1] - k[0]]
}

/// A polynomial's value by Horner's rule.
#[inline(always)]
fn horner<const W: usize>(c: [f32; W], x: f32) -> f32 {
    let mut sum = c[W - 1];
    for &c in c[..W - 1].iter().rev() {
        sum = sum * x + c;
    }
    sum
}

/// Where a parameter lies on a curve.
struct Place {
    /// The piece, counted from 0, in each lane.
    piece: Lanes,
    /// How far along that piece, from 0 to 1.
    along: Plane,
}

/// The piece that a parameter falls into, of so many, and how far along it lies.
#[inline(always)]
fn locate(t: f32, pieces: f32) -> [f32; 2] {
    let at = super::arithmetic::clamp(t, 0.0, 1.0) * pieces;
    let whole = math::floor(at);
    // The very end belongs to the last piece. NaN does too, and stays NaN along it.
    let whole = if whole < pieces { whole } else { pieces - 1.0 };
    [whole, at - whole]
}

/// The piece that each lane's parameter falls into.
fn place(call: &Call<'_>, t: &Plane, pieces: usize) -> Place {
    let last = pieces as f32;
    let [piece, along] = call.lanes([t], |[t]| locate(t, last));
    let n = if matches!(piece, Plane::Uniform(_)) { 1 } else { call.n };
    Place { piece: piece.spread(n), along }
}

/// One coordinate of a curve through `knots`, each piece made by `make` from `W` of them.
fn curve<const W: usize>(
    call: &Call<'_>,
    place: &Place,
    knots: &[&Plane],
    make: fn([f32; W]) -> [f32; W],
) -> Plane {
    let numbers: Option<Vec<f32>> =
        knots.iter().map(|k| if let Plane::Uniform(x) = k { Some(*x) } else { None }).collect();
    if let Some(numbers) = numbers {
        // The usual case: each piece's polynomial is made once, and each lane looks its own up.
        let table = pieces(&numbers, make);
        return match &place.along {
            Plane::Uniform(x) => Plane::Uniform(horner(table[place.piece.get(1)[0] as usize], *x)),
            Plane::Varying(along) => Plane::filled(call.n, |out| {
                look_up(call.isa, &table, place.piece.get(call.n), along.get(call.n), out)
            }),
        };
    }
    if let Plane::Uniform(x) = place.along {
        let x = Plane::Uniform(x);
        let first = place.piece.get(1)[0] as usize;
        return piece(call, from_fn(|k| knots[first + k]), &x, make);
    }
    // Every lane may have its own knots and its own piece.
    let spread: Vec<Lanes> = knots.iter().map(|k| k.spread(call.n)).collect();
    let knots: Vec<&[f32]> = spread.iter().map(|l| l.get(call.n)).collect();
    let (at, along) = (place.piece.get(call.n), place.along.spread(call.n));
    let along = along.get(call.n);
    Plane::filled(call.n, |out| {
        for (i, out) in out.iter_mut().enumerate() {
            let first = at[i] as usize;
            *out = horner(make(lanes::array(|k| knots[first + k][i])), along[i]);
        }
    })
}

/// The same piece in every lane.
fn piece<const W: usize>(
    call: &Call<'_>,
    knots: [&Plane; W],
    along: &Plane,
    make: fn([f32; W]) -> [f32; W],
) -> Plane {
    let [out] = call.planes(knots.into_iter().chain([along]), |s, [out]| {
        for (i, out) in out.iter_mut().enumerate() {
            *out = horner(make(lanes::array(|k| s[k][i])), s[W][i]);
        }
    });
    out
}

/// Each lane's polynomial out of a table. A short table is copied to one of fixed size, which needs no checks.
fn look_up<const W: usize>(isa: Isa, table: &[[f32; W]], at: &[f32], along: &[f32], out: &mut [f32]) {
    if table.len() <= SHORT {
        isa.run(LookUp { table: &fixed(table), at, along, out });
    } else {
        for ((out, &at), &x) in out.iter_mut().zip(at).zip(along) {
            *out = horner(table[at as usize], x);
        }
    }
}

/// So few pieces are all looked at.
const FEW: usize = 12;

/// The most pieces of a short table.
const SHORT: usize = 64;

/// The coefficients of a short table, the same one of all pieces together.
type Fixed<const W: usize> = [[f32; SHORT]; W];

fn fixed<const W: usize>(table: &[[f32; W]]) -> Fixed<W> {
    let mut fixed = [[0.0; SHORT]; W];
    for (piece, row) in table.iter().enumerate() {
        for k in 0..W {
            fixed[k][piece] = row[k];
        }
    }
    fixed
}

/// The loop over a short table.
struct LookUp<'a, const W: usize> {
    table: &'a Fixed<W>,
    at: &'a [f32],
    along: &'a [f32],
    out: &'a mut [f32],
}

impl<const W: usize> lanes::Kernel for LookUp<'_, W> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        for ((out, &at), &x) in self.out.iter_mut().zip(self.at).zip(self.along) {
            let piece = at as i32 as usize & (SHORT - 1);
            *out = horner::<W>(lanes::array(|k| self.table[k][piece]), x);
        }
    }
}

/// A curve through known knots, to be looked up again and again.
pub enum Curve {
    /// A spline, by coordinate, and its number of pieces.
    Spline(Vec<Fixed<4>>, usize),
    /// Straight lines.
    Lines(Vec<Fixed<2>>, usize),
}

impl Curve {
    /// The most knots of one.
    pub const MOST: usize = SHORT;

    /// The spline of the function `spline` through knots, each coordinate's in order.
    pub fn spline(knots: &[Vec<f32>]) -> Curve {
        Curve::Spline(knots.iter().map(|k| fixed(&pieces(k, catmull_rom))).collect(), knots[0].len() - 3)
    }

    /// The lines of the function `linear`.
    pub fn lines(knots: &[Vec<f32>]) -> Curve {
        Curve::Lines(knots.iter().map(|k| fixed(&pieces(k, straight))).collect(), knots[0].len() - 1)
    }

    /// A coordinate of the points at t.
    pub fn look_up(&self, isa: Isa, coordinate: usize, t: &[f32], out: &mut [f32]) {
        match self {
            Curve::Spline(tables, pieces) => {
                isa.run(Follow { table: &tables[coordinate], last: *pieces as f32, t, out });
            }
            Curve::Lines(tables, pieces) => {
                isa.run(Follow { table: &tables[coordinate], last: *pieces as f32, t, out });
            }
        }
    }
}

/// Place and polynomial of each lane.
struct Follow<'a, const W: usize> {
    table: &'a Fixed<W>,
    last: f32,
    t: &'a [f32],
    out: &'a mut [f32],
}

impl<const W: usize> lanes::Kernel for Follow<'_, W> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        const LANES: usize = 32;
        let pieces = self.last as usize;
        for (out, t) in self.out.chunks_mut(LANES).zip(self.t.chunks(LANES)) {
            let mut strip = [0.0; LANES];
            strip[..t.len()].copy_from_slice(t);
            let (mut at, mut along, mut row) = ([0.0; LANES], [0.0; LANES], [[0_u32; LANES]; W]);
            for i in 0..LANES {
                [at[i], along[i]] = locate(strip[i], self.last);
            }
            if pieces <= FEW {
                // To go through all pieces eight lanes at a time is faster than to look one up for each lane.
                for piece in 0..pieces {
                    let number = piece as f32;
                    let mut here = [0_u32; LANES];
                    for i in 0..LANES {
                        here[i] = if at[i] == number { !0 } else { 0 };
                    }
                    for (row, table) in row.iter_mut().zip(self.table) {
                        let bits = table[piece].to_bits();
                        let mut coefficients = *row;
                        for i in 0..LANES {
                            coefficients[i] |= bits & here[i];
                        }
                        *row = coefficients;
                    }
                }
            } else {
                for (row, table) in row.iter_mut().zip(self.table) {
                    for i in 0..LANES {
                        row[i] = table[at[i] as i32 as usize & (SHORT - 1)].to_bits();
                    }
                }
            }
            let mut result = [0.0; LANES];
            for i in 0..LANES {
                result[i] = horner::<W>(lanes::array(|k| f32::from_bits(row[k][i])), along[i]);
            }
            let n = out.len();
            out.copy_from_slice(&result[..n]);
        }
    }
}

/// The polynomials of all pieces.
fn pieces<const W: usize>(knots: &[f32], make: fn([f32; W]) -> [f32; W]) -> Vec<[f32; W]> {
    knots.windows(W).map(|w| make(from_fn(|k| w[k]))).collect()
}

/// The knots of a call: the further arguments, or the elements of the only one.
fn knots(call: &Call<'_>, name: &str, least: usize) -> Result<(Shape, Vec<Value>), Fault> {
    let knots: Vec<Value> = match &call.args[1..] {
        [one] if !one.shape.is_scalar() => one.elements().collect(),
        many => many.to_vec(),
    };
    if knots.len() < least {
        return Err(Fault::of(1, format!("{name} needs at least {least} knots, found {}", knots.len()))
            .hint(format!("Give them as `{name}(t, k1, k2, …)` or `{name}(t, [k1 k2 …])`.")));
    }
    let shape = knots.iter().map(|k| &k.shape).find(|s| !s.is_scalar()).unwrap_or(&Shape::Scalar).clone();
    if let Some(odd) = knots.iter().find(|k| k.shape != shape && !k.shape.is_scalar()) {
        return Err(Fault::of(
            1,
            format!("{name} needs knots of one shape, found {} and {}", shape, odd.shape),
        ));
    }
    Ok((shape, knots))
}

fn through<const W: usize>(
    call: &Call<'_>,
    name: &str,
    least: usize,
    make: fn([f32; W]) -> [f32; W],
) -> Result<Value, Fault> {
    let (shape, knots) = knots(call, name, least)?;
    call.room(shape.cells().saturating_mul(call.args[0].planes.len()))?;
    each_scalar(&call.args[0], &mut |t| {
        if let [only] = &knots[..] {
            return Ok(only.clone());
        }
        let place = place(call, t, knots.len() + 1 - W);
        let planes: Planes = (0..shape.cells())
            .map(|cell| {
                let cells: Vec<&Plane> =
                    knots.iter().map(|k| &k.planes[if k.shape.is_scalar() { 0 } else { cell }]).collect();
                curve(call, &place, &cells, make)
            })
            .collect();
        Ok(Value { shape: shape.clone(), planes })
    })
}

/// Splines.
pub static FUNCTIONS: &[Builtin] = &[
    Builtin {
        name: "spline",
        params: &[Param::new("t"), Param::rest("knots", 1)],
        brief: "A smooth curve through knots, for t from 0 to 1.",
        doc: "The Catmull–Rom spline of the RenderMan language: it starts at the second knot and ends at the last \
              but one; the first and the last only set the slope at the ends. At least 4 knots, evenly spaced in t; \
              t is clamped to 0 … 1. The knots are scalars or vectors of one shape, one argument each, or the \
              elements of a single vector, so a table of colours is a colour map: `spline(t, [c1 c2 c3 c4 c5])`. A \
              scalar among vectors is used for each component. A vector of values for t gives a vector of points of \
              the curve (Peachey, *Texturing and Modeling*, chapter 2, “Splines and Mappings”).",
        examples: &[
            ex("spline(0.5, 0, 0, 1, 1)", "0.5"),
            ex("spline([0 0.5 1], [0 1 5 2 0])", "[1 5 2]"),
            ex("spline(0.25, [0 0], [0 0], [1 2], [1 2])", "[0.203125 0.40625]"),
        ],
        kernel: Kernel::Whole(|call| through(call, "spline", 4, catmull_rom)),
    },
    Builtin {
        name: "linear",
        params: &[Param::new("t"), Param::rest("knots", 1)],
        brief: "Straight lines through knots, for t from 0 to 1.",
        doc: "It starts at the first knot and ends at the last; otherwise like [spline](#spline). One knot is a \
              constant.",
        examples: &[
            ex("linear(0.25, 10, 20, 40)", "15"),
            ex("linear([0 0.75 1], [[0 0] [2 4] [4 0]])", "[[0 0] [3 2] [4 0]]"),
        ],
        kernel: Kernel::Whole(|call| through(call, "linear", 1, straight)),
    },
];
