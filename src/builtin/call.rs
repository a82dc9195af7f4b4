//! What a kernel that looks at whole values gets, and what it may answer.

use super::Lanes2;
use crate::lanes::{Arg, Isa};
use crate::texture::Texture;
use crate::value::{Lanes, Mask, Plane, Planes, Value};
use smallvec::SmallVec;
use std::sync::Arc;

/// A call of a built-in function, for a batch of lanes.
pub struct Call<'a> {
    /// The instructions to use.
    pub isa: Isa,
    /// How many lanes there are.
    pub n: usize,
    /// How many of them, from the first on, are pixels. In programs with derivatives there are then as many lanes for
    /// their shadows along the row, and as many for those along the column; else all lanes are pixels.
    ///
    /// What decides on a shape, or whether a call fails, is decided by a pixel for its shadows.
    pub pixels: usize,
    /// Which of them are active. The others may hold anything: they must not fail.
    pub mask: &'a Mask,
    /// The arguments, one a parameter with defaults filled in; a `Rest` parameter's values come last.
    pub args: &'a [Value],
    /// How many cells a value may have.
    pub max_cells: usize,
    /// The program's textures, by the numbers that strings have become.
    pub textures: &'a [Arc<Texture>],
}

/// Why a kernel could not compute its value.
#[derive(Clone, Debug)]
pub enum Fault {
    /// The call is wrong at `lane`, the first active one where it is.
    Error {
        /// One sentence without a full stop.
        message: String,
        /// How to mend it.
        hint: Option<String>,
        /// The argument it is about, from 0.
        arg: Option<usize>,
        /// The lane; `None` if every lane has the same fault.
        lane: Option<usize>,
    },
    /// The lanes of the mask would get another shape than the rest: run the two parts apart.
    Split(Mask),
}

impl Fault {
    /// The call is wrong in every lane.
    pub fn new(message: impl Into<String>) -> Fault {
        Fault::Error { message: message.into(), hint: None, arg: None, lane: None }
    }

    /// An argument, counted from 0, is wrong in every lane.
    pub fn of(arg: usize, message: impl Into<String>) -> Fault {
        Fault::Error { message: message.into(), hint: None, arg: Some(arg), lane: None }
    }

    /// The same with a way to mend it.
    pub fn hint(mut self, text: impl Into<String>) -> Fault {
        if let Fault::Error { hint, .. } = &mut self {
            *hint = Some(text.into());
        }
        self
    }

    /// The same, at one lane alone.
    pub fn at(mut self, at: usize) -> Fault {
        if let Fault::Error { lane, .. } = &mut self {
            *lane = Some(at);
        }
        self
    }
}

impl Call<'_> {
    /// Computes planes from planes: `kernel` gets the inputs as slices of one length and writes every number
    /// of `K` outputs of that length. Where all inputs are uniform it runs once, on slices of length one.
    pub fn planes<'p, const K: usize>(
        &self,
        inputs: impl IntoIterator<Item = &'p Plane>,
        kernel: impl FnOnce(&[&[f32]], [&mut [f32]; K]),
    ) -> [Plane; K] {
        let inputs: SmallVec<[&Plane; 8]> = inputs.into_iter().collect();
        if inputs.iter().all(|p| matches!(p, Plane::Uniform(_))) {
            let numbers: SmallVec<[f32; 8]> = inputs.iter().map(|p| p.lane(0)).collect();
            let slices: SmallVec<[&[f32]; 8]> = numbers.iter().map(std::slice::from_ref).collect();
            let mut out = [[0.0f32]; K];
            kernel(&slices, out.each_mut().map(|o| &mut o[..]));
            out.map(|[x]| Plane::Uniform(x))
        } else {
            let n = self.n;
            let spread: SmallVec<[Lanes; 8]> = inputs.iter().map(|p| p.spread(n)).collect();
            let slices: SmallVec<[&[f32]; 8]> = spread.iter().map(|l| l.get(n)).collect();
            let mut out: [Lanes; K] = std::array::from_fn(|_| Lanes::new(n));
            kernel(&slices, out.each_mut().map(|l| l.get_mut(n)));
            out.map(Plane::Varying)
        }
    }

    /// One plane from one, by a kernel over lanes.
    pub fn map1(&self, a: &Plane, kernel: fn(Isa, &[f32], &mut [f32])) -> Plane {
        let [out] = self.planes([a], |a, [out]| kernel(self.isa, a[0], out));
        out
    }

    /// One plane from two, by a kernel over lanes that takes a uniform side as it is.
    pub fn map2(&self, a: &Plane, b: &Plane, kernel: Lanes2) -> Plane {
        map2(self.isa, self.n, a, b, kernel)
    }

    /// The planes of a vector of scalars, or a fault that says what the argument is.
    pub fn vector(&self, arg: usize) -> Result<&Planes, Fault> {
        let value = &self.args[arg];
        match value.shape {
            crate::shape::Shape::Vector(_) => Ok(&value.planes),
            _ => Err(Fault::of(arg, format!("expected a vector of scalars, found {}", value.shape))),
        }
    }

    /// The plane of a scalar, or a fault that says what the argument is.
    pub fn scalar(&self, arg: usize) -> Result<&Plane, Fault> {
        let value = &self.args[arg];
        match value.shape {
            crate::shape::Shape::Scalar => Ok(&value.planes[0]),
            _ => Err(Fault::of(arg, format!("expected a scalar, found {}", value.shape))),
        }
    }

    /// A scalar that decides a result's shape, such as a size: its number in the active lanes.
    /// Lanes that differ are split apart.
    pub fn same_everywhere(&self, arg: usize) -> Result<f32, Fault> {
        self.settle(self.scalar(arg)?)
    }

    /// The number of a plane in the active lanes. Lanes that differ are split apart.
    pub fn settle(&self, plane: &Plane) -> Result<f32, Fault> {
        match plane {
            Plane::Uniform(x) => Ok(*x),
            Plane::Varying(lanes) => {
                let lanes = lanes.get(self.n);
                let Some(first) = self.mask.first(self.n) else { return Ok(0.0) };
                let x = lanes[first];
                let same = |i: usize| lanes[i % self.pixels].to_bits() == x.to_bits();
                if self.mask.lanes(self.pixels).all(same) {
                    Ok(x)
                } else {
                    Err(Fault::Split(Mask::from_fn(self.n, same)))
                }
            }
        }
    }
}

/// One plane from two, once if both are uniform.
pub fn map2(
    isa: Isa,
    n: usize,
    a: &Plane,
    b: &Plane,
    kernel: impl FnOnce(Isa, Arg<'_>, Arg<'_>, &mut [f32]),
) -> Plane {
    match (a, b) {
        (Plane::Uniform(a), Plane::Uniform(b)) => {
            let mut out = [0.0];
            kernel(isa, Arg::Uniform(*a), Arg::Uniform(*b), &mut out);
            Plane::Uniform(out[0])
        }
        _ => Plane::filled(n, |out| kernel(isa, arg(a, n), arg(b, n), out)),
    }
}

/// A plane as a kernel takes it.
pub fn arg(plane: &Plane, n: usize) -> Arg<'_> {
    match plane {
        Plane::Uniform(x) => Arg::Uniform(*x),
        Plane::Varying(lanes) => Arg::Varying(lanes.get(n)),
    }
}
