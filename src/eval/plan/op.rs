//! What a step of a plan computes.

use super::strip::{Block, Zip, zip_numbers};
use crate::builtin::{Curve, Lanes2, LanesN, Octaves};
use crate::lanes::{Arg, Isa};
use crate::noise::Field;
use smallvec::SmallVec;
use std::sync::Arc;

/// Operators that are joined two and two, where the result of one is only wanted by the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Arith {
    Add,
    Sub,
    Mul,
}

/// The most arguments of a step: those of a sum of octaves in four dimensions.
pub const ARGUMENTS: usize = 12;

/// What a step computes.
#[derive(Clone)]
pub enum Op {
    /// A plane of a variable, by its number among the inputs.
    Input(usize),
    /// The same number in all lanes, for kernels that take no single blocks.
    Fill,
    /// `a ∘ b`.
    Arith(Arith),
    /// `(a ∘ b) • c`, the outer operator first.
    Left(Arith, Arith),
    /// `a • (b ∘ c)`, the outer operator first.
    Right(Arith, Arith),
    /// Lane by lane.
    Zip(Zip),
    /// The kernels of built-in functions.
    Map1(fn(Isa, &[f32], &mut [f32])),
    Map2(Lanes2),
    Maps(LanesN),
    /// The noise at a point.
    Noise(Arc<dyn Field>),
    /// Its derivative.
    Derivative(Arc<dyn Field>),
    /// A sum of octaves.
    Octaves(Arc<Octaves>),
    /// Coordinates of a curve.
    Curve(Arc<Curve>),
}

/// What tells operations apart: what they are, and of which kernel.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Key(u8, usize, Option<(Arith, Arith)>);

impl Op {
    /// Two of the same key compute the same. None for inputs.
    pub fn key(&self) -> Option<Key> {
        let address = |field: &Arc<dyn Field>| Arc::as_ptr(field).cast::<()>() as usize;
        Some(match self {
            Op::Input(_) => return None,
            Op::Fill => Key(0, 0, None),
            Op::Arith(a) => Key(1, 0, Some((*a, *a))),
            Op::Left(a, b) => Key(2, 0, Some((*a, *b))),
            Op::Right(a, b) => Key(3, 0, Some((*a, *b))),
            Op::Zip(f) => Key(4, *f as usize, None),
            Op::Map1(f) => Key(5, *f as usize, None),
            Op::Map2(f) => Key(6, *f as usize, None),
            Op::Maps(f) => Key(7, *f as usize, None),
            Op::Noise(field) => Key(8, address(field), None),
            Op::Derivative(field) => Key(9, address(field), None),
            Op::Octaves(octaves) => Key(11, Arc::as_ptr(octaves) as usize, None),
            Op::Curve(curve) => Key(10, Arc::as_ptr(curve) as usize, None),
        })
    }

    /// Does it take what is the same in all lanes as a single block?
    pub fn takes_blocks(&self) -> bool {
        matches!(
            self,
            Op::Fill
                | Op::Arith(_)
                | Op::Left(..)
                | Op::Right(..)
                | Op::Zip(_)
                | Op::Map2(_)
                | Op::Maps(_)
                | Op::Curve(_)
        )
    }

    /// Computes so many lanes (a multiple of 8): `out` has room for all blocks that hold some of them.
    ///
    /// # Panics
    /// If there are too few arguments.
    pub fn run(&self, isa: Isa, lanes: usize, args: &[&[Block]], out: &mut [&mut [Block]]) {
        match self {
            Op::Input(_) => {}
            Op::Fill => out[0].fill(args[0][0]),
            Op::Arith(a) => arith(*a)(isa, args, out[0]),
            Op::Left(a, b) => left(*a, *b)(isa, args, out[0]),
            Op::Right(a, b) => right(*a, *b)(isa, args, out[0]),
            Op::Zip(f) => f(isa, args, out[0]),
            Op::Map1(f) => f(isa, &args[0].as_flattened()[..lanes], &mut out[0].as_flattened_mut()[..lanes]),
            Op::Map2(f) => {
                f(
                    isa,
                    operand(args[0], lanes),
                    operand(args[1], lanes),
                    &mut out[0].as_flattened_mut()[..lanes],
                );
            }
            Op::Maps(f) => {
                let args: SmallVec<[Arg<'_>; 4]> = args.iter().map(|a| operand(a, lanes)).collect();
                f(isa, &args, &mut out[0].as_flattened_mut()[..lanes]);
            }
            Op::Noise(field) => with_slices(args, lanes, |p| {
                field.noise(isa, p, &mut out[0].as_flattened_mut()[..lanes]);
            }),
            Op::Derivative(field) => with_slices(args, lanes, |p| match out {
                [x] => field.derivative(isa, p, &mut [front(x, lanes)]),
                [x, y] => field.derivative(isa, p, &mut [front(x, lanes), front(y, lanes)]),
                [x, y, z] => {
                    field.derivative(isa, p, &mut [front(x, lanes), front(y, lanes), front(z, lanes)]);
                }
                [x, y, z, w] => field.derivative(
                    isa,
                    p,
                    &mut [front(x, lanes), front(y, lanes), front(z, lanes), front(w, lanes)],
                ),
                _ => {}
            }),
            Op::Octaves(octaves) => {
                with_slices(args, lanes, |slices| octaves.run(isa, slices, front(out[0], lanes)))
            }
            Op::Curve(curve) => {
                for (cell, out) in out.iter_mut().enumerate() {
                    let t = &args[0].as_flattened()[..lanes];
                    curve.look_up(isa, cell, t, &mut out.as_flattened_mut()[..lanes]);
                }
            }
        }
    }
}

fn front(blocks: &mut [Block], lanes: usize) -> &mut [f32] {
    &mut blocks.as_flattened_mut()[..lanes]
}

fn operand<'a>(blocks: &'a [Block], lanes: usize) -> Arg<'a> {
    match blocks {
        [one] if lanes > one.len() => Arg::Uniform(one[0]),
        _ => Arg::Varying(&blocks.as_flattened()[..lanes]),
    }
}

fn with_slices(args: &[&[Block]], lanes: usize, f: impl FnOnce(&[&[f32]])) {
    let mut slices: [&[f32]; ARGUMENTS] = [&[]; ARGUMENTS];
    for (slice, arg) in slices.iter_mut().zip(args) {
        *slice = &arg.as_flattened()[..lanes];
    }
    f(&slices[..args.len()]);
}

/// A kernel for each operator, and for each pair of them.
macro_rules! kernels {
    ($($name:ident $op:tt),*) => {
        /// `a ∘ b`
        fn arith(a: Arith) -> Zip {
            match a {
                $(Arith::$name => |isa, args, out| zip_numbers(isa, args, out, |[a, b]| a $op b),)*
            }
        }
    };
}
kernels!(Add +, Sub -, Mul *);

macro_rules! pairs {
    ($(($outer:ident $o:tt, $inner:ident $i:tt)),*) => {
        fn left(outer: Arith, inner: Arith) -> Zip {
            match (outer, inner) {
                $((Arith::$outer, Arith::$inner) => |isa, args, out| zip_numbers(isa, args, out, |[a, b, c]| (a $i b) $o c),)*
            }
        }

        fn right(outer: Arith, inner: Arith) -> Zip {
            match (outer, inner) {
                $((Arith::$outer, Arith::$inner) => |isa, args, out| zip_numbers(isa, args, out, |[a, b, c]| a $o (b $i c)),)*
            }
        }
    };
}
pairs!(
    (Add +, Add +),
    (Add +, Sub -),
    (Add +, Mul *),
    (Sub -, Add +),
    (Sub -, Sub -),
    (Sub -, Mul *),
    (Mul *, Add +),
    (Mul *, Sub -),
    (Mul *, Mul *)
);
