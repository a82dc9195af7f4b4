//! Calling a built-in function, and what many kernels share: how a function of vectors meets vectors of them.

use super::call::{Call, Fault, arg};
use super::{Builtin, Kernel as Form, Lanes2, LanesN};
use crate::lanes::{Arg, Isa, Kernel, array};
use crate::shape::Shape;
use crate::value::{self, Lanes, Mismatch, Plane, Planes, Value};

impl Builtin {
    /// Computes the value of a call, whatever the form of the kernel.
    pub fn apply(&self, call: &Call<'_>) -> Result<Value, Fault> {
        let args = call.args;
        let value = match self.kernel {
            Form::Map1(kernel) => value::map1(&args[0], |a| call.map1(a, kernel)),
            Form::Map2(kernel) => {
                value::binary(&args[0], &args[1], |a, b| call.map2(a, b, kernel)).map_err(differ)?
            }
            Form::Maps(kernel) => match args.len() {
                3 => call.maps::<3>(kernel)?,
                _ => call.maps::<4>(kernel)?,
            },
            Form::Fold(kernel) => {
                let mut value = args[0].clone();
                for next in &args[1..] {
                    value = value::binary(&value, next, |a, b| call.map2(a, b, kernel)).map_err(differ)?;
                }
                value
            }
            Form::Whole(kernel) | Form::Shadowed(kernel) => kernel(call)?,
        };
        call.room(value.planes.len())?;
        Ok(value)
    }
}

/// Vectors of different lengths; who calls puts the function's name before it.
fn differ(m: Mismatch) -> Fault {
    Fault::new(format!("meets vectors of different lengths, {} and {}", m.left, m.right))
}

impl Call<'_> {
    /// May a value have so many cells?
    pub fn room(&self, cells: usize) -> Result<(), Fault> {
        if cells <= self.max_cells {
            return Ok(());
        }
        let message = format!("the value would have {cells} numbers, and the limit is {}", self.max_cells);
        Err(Fault::new(message).hint("A higher limit can be set (`--max-vector`)."))
    }

    /// The component-by-component operation on the cells of two values.
    pub fn cells2(&self, a: &Value, b: &Value, kernel: Lanes2) -> Result<Value, Fault> {
        value::binary(a, b, |a, b| self.map2(a, b, kernel)).map_err(differ)
    }

    /// The component-by-component operation on the cells of `N` arguments.
    fn maps<const N: usize>(&self, kernel: LanesN) -> Result<Value, Fault> {
        let args: [&Value; N] = std::array::from_fn(|k| &self.args[k]);
        value::map_cells(args, |planes| {
            if planes.iter().all(|p| matches!(p, Plane::Uniform(_))) {
                let mut out = [0.0];
                kernel(self.isa, &planes.map(|p| Arg::Uniform(p.lane(0))), &mut out);
                return Plane::Uniform(out[0]);
            }
            Plane::filled(self.n, |out| kernel(self.isa, &planes.map(|p| arg(p, self.n)), out))
        })
        .map_err(differ)
    }

    /// `K` planes from `N`: `f` is given the numbers of one lane and gives that lane's results. It should be an
    /// `#[inline(always)]` function, or a closure of a line or two, to be compiled for the instruction set.
    pub fn lanes<const N: usize, const K: usize>(
        &self,
        inputs: [&Plane; N],
        f: impl Fn([f32; N]) -> [f32; K],
    ) -> [Plane; K] {
        if inputs.iter().all(|p| matches!(p, Plane::Uniform(_))) {
            return f(inputs.map(|p| p.lane(0))).map(Plane::Uniform);
        }
        let mut out: [Lanes; K] = std::array::from_fn(|_| Lanes::new(self.n));
        let inputs = inputs.map(|p| arg(p, self.n));
        strips(self.isa, inputs, out.each_mut().map(|l| l.get_mut(self.n)), f);
        out.map(Plane::Varying)
    }

    /// One plane from `N`, lane by lane.
    pub fn lane<const N: usize>(&self, inputs: [&Plane; N], f: impl Fn([f32; N]) -> f32) -> Plane {
        let [out] = self.lanes(inputs, |x| [f(x)]);
        out
    }
}

/// Computes `K` numbers a lane from `N`, as [`Call::lanes`] does.
pub fn strips<const N: usize, const K: usize>(
    isa: Isa,
    inputs: [Arg<'_>; N],
    out: [&mut [f32]; K],
    f: impl Fn([f32; N]) -> [f32; K],
) {
    isa.run(Strips { inputs, out, f });
}

/// So many lanes are computed at once.
const STRIP: usize = 32;

/// The loop under [`strips`]. It copies strips of lanes to the stack and back: the compiler cannot know that
/// several outputs and inputs are apart in memory, and would not vectorise across them.
struct Strips<'a, const N: usize, const K: usize, F> {
    inputs: [Arg<'a>; N],
    out: [&'a mut [f32]; K],
    f: F,
}

impl<const N: usize, const K: usize, F: Fn([f32; N]) -> [f32; K]> Kernel for Strips<'_, N, K, F> {
    type Output = ();
    #[inline(always)]
    fn run(mut self) {
        let n = self.out.first().map_or(0, |o| o.len());
        let mut strips =
            self.inputs.map(|arg| if let Arg::Uniform(x) = arg { [x; STRIP] } else { [0.0; STRIP] });
        // The last strip may be shorter: it is computed apart, so that the others are copied at a known length.
        let whole = n - n % STRIP;
        for start in (0..whole).step_by(STRIP) {
            self.load(&mut strips, start, STRIP);
            let results = self.compute(&strips);
            for (out, strip) in self.out.iter_mut().zip(&results) {
                out[start..start + STRIP].copy_from_slice(strip);
            }
        }
        if whole < n {
            self.load(&mut strips, whole, n - whole);
            let results = self.compute(&strips);
            for (out, strip) in self.out.iter_mut().zip(&results) {
                out[whole..n].copy_from_slice(&strip[..n - whole]);
            }
        }
    }
}

impl<const N: usize, const K: usize, F: Fn([f32; N]) -> [f32; K]> Strips<'_, N, K, F> {
    #[inline(always)]
    fn load(&self, strips: &mut [[f32; STRIP]; N], start: usize, count: usize) {
        for (strip, arg) in strips.iter_mut().zip(self.inputs) {
            if let Arg::Varying(lanes) = arg {
                strip[..count].copy_from_slice(&lanes[start..start + count]);
            }
        }
    }

    #[inline(always)]
    fn compute(&self, strips: &[[f32; STRIP]; N]) -> [[f32; STRIP]; K] {
        let mut results = [[0.0; STRIP]; K];
        for i in 0..STRIP {
            let result = (self.f)(array(|k| strips[k][i]));
            for k in 0..K {
                results[k][i] = result[k];
            }
        }
        results
    }
}

/// Applies a function of vectors: where an argument is a vector of vectors, to each of those in turn, the
/// arguments that are not being used with each.
pub fn each<const K: usize>(
    args: [&Value; K],
    f: &mut dyn FnMut([&Value; K]) -> Result<Value, Fault>,
) -> Result<Value, Fault> {
    let nested = |v: &Value| matches!(v.shape, Shape::Nested(_));
    let Some(first) = args.iter().position(|v| nested(v)) else { return f(args) };
    let n = args[first].shape.len().unwrap_or(0);
    for (k, other) in args.iter().enumerate() {
        let m = other.shape.len().unwrap_or(0);
        if nested(other) && m != n {
            return Err(Fault::of(k, format!("expected {n} vectors as in the other argument, found {m}")));
        }
    }
    let mut out = Vec::with_capacity(n);
    for i in 0..n {
        let elements = args.map(|v| if nested(v) { v.element(i) } else { v.clone() });
        out.push(each(elements.each_ref(), f)?);
    }
    Ok(Value::vector_of(out))
}

/// Applies a function of a scalar to each one in a value, at any depth.
pub fn each_scalar(value: &Value, f: &mut dyn FnMut(&Plane) -> Result<Value, Fault>) -> Result<Value, Fault> {
    if value.shape.is_scalar() {
        return f(&value.planes[0]);
    }
    let elements: Result<Vec<Value>, Fault> = value.elements().map(|e| each_scalar(&e, f)).collect();
    Ok(Value::vector_of(elements?))
}

/// The planes of a vector of one of the given lengths, or a fault that says what was found.
pub fn vector_of<'v>(
    name: &str,
    arg: usize,
    value: &'v Value,
    lengths: &[usize],
) -> Result<&'v Planes, Fault> {
    match value.shape {
        Shape::Vector(n) if lengths.contains(&(n as usize)) => Ok(&value.planes),
        _ => {
            let wanted: Vec<String> = lengths.iter().map(usize::to_string).collect();
            Err(Fault::of(
                arg,
                format!("{name} needs a vector of {}, found {}", wanted.join(" or "), value.shape),
            ))
        }
    }
}

/// The planes of two scalars or vectors of one length; a scalar is used with each component of a vector.
pub fn pair(name: &str, a: &Value, b: &Value) -> Result<(Planes, Planes), Fault> {
    let spread = |v: &Value, n: usize| -> Planes {
        if v.shape.is_scalar() {
            std::iter::repeat_n(v.planes[0].clone(), n).collect()
        } else {
            v.planes.clone()
        }
    };
    match (a.shape.len(), b.shape.len()) {
        (Some(m), Some(n)) if m != n => Err(Fault::of(
            1,
            format!("{name} needs vectors of one length, found {} and {}", a.shape, b.shape),
        )),
        (m, n) => {
            let n = m.or(n).unwrap_or(1);
            Ok((spread(a, n), spread(b, n)))
        }
    }
}
