//! The output variables: their shapes over all pixels, and the planes they are written to.

use super::input::Inputs;
use super::machine::Machine;
use super::pixels::Pixels;
use super::run::Options;
use crate::diagnostic::Diagnostic;
use crate::image::Variable;
use crate::lanes::Isa;
use crate::resolve::names;
use crate::resolve::tree::Resolved;
use crate::shape::Shape;
use crate::value::{Mask, Plane};
use crate::vocabulary;
use smallvec::SmallVec;

/// A variable to write.
#[derive(Clone)]
pub(super) struct Output {
    pub name: String,
    /// Its slot, if the program assigns it.
    pub slot: Option<u32>,
    /// The input variable that passes through, if it does not.
    pub input: Option<usize>,
    /// The shape of its planes; grows from a scalar to a vector when a pixel needs it.
    pub shape: Shape,
    /// Where a pixel is, in the display window, that has this shape.
    pub seen: Option<[i32; 2]>,
    /// Is it the image's alpha, which goes with a colour that has none of its own?
    pub kept: bool,
}

/// A pixel's value does not fit the planes.
pub(super) struct Misfit {
    /// Which output.
    pub output: usize,
    /// What the pixel has.
    pub shape: Shape,
    /// The pixel.
    pub pixel: usize,
}

impl Output {
    /// An output that is there already.
    pub fn of_variable(variable: &Variable<'_>) -> Output {
        let (name, shape) = (variable.name.clone(), variable.shape.clone());
        Output { name, slot: None, input: None, shape, seen: None, kept: false }
    }

    /// Does it hold a colour?
    fn is_color(&self) -> bool {
        self.name == "color"
    }

    /// The shape in which an output of that shape is written: a scalar colour is grey.
    pub fn written(name: &str, shape: &Shape) -> Shape {
        if name == "color" && shape.is_scalar() { Shape::Vector(3) } else { shape.clone() }
    }

    /// The shape that holds both; `None` if no shape does.
    pub fn join(&self, found: &Shape) -> Option<Shape> {
        let found = Output::written(&self.name, found);
        match (&self.shape, &found) {
            (a, b) if a == b => Some(found),
            (Shape::Vector(3), Shape::Vector(4)) | (Shape::Vector(4), Shape::Vector(3))
                if self.is_color() =>
            {
                Some(Shape::Vector(4))
            }
            _ if self.seen.is_none() && self.color_has(&found) => Some(found),
            (Shape::Scalar, _) => Some(found),
            (shape, Shape::Scalar) => Some(shape.clone()),
            _ => None,
        }
    }

    /// Can it be a colour, if it has to be one?
    pub fn color_has(&self, shape: &Shape) -> bool {
        !self.is_color() || matches!(shape, Shape::Scalar | Shape::Vector(3 | 4))
    }
}

/// Writes what a batch left in the output variables to their planes, one after the other, at `pixels` counted from
/// `start`. Lanes without a value are 0.
pub(super) fn write(
    outputs: &[Output],
    machine: &Machine<'_>,
    pixels: Pixels<'_>,
    start: usize,
    planes: &mut [&mut [f32]],
) -> Result<(), Misfit> {
    let n = pixels.len();
    let mut rest = planes;
    for (k, output) in outputs.iter().enumerate() {
        let (own, others) = std::mem::take(&mut rest).split_at_mut(output.shape.cells());
        rest = others;
        let Some(slot) = output.slot.map(|i| &machine.globals[i as usize]) else { continue };
        let first = slot.defined.first(n);
        let (Some(value), Some(first)) = (&slot.value, first) else {
            own.iter_mut()
                .for_each(|out| put(machine.isa, &Plane::Uniform(0.0), &Mask::All, pixels, start, out));
            continue;
        };
        let written = Output::written(&output.name, &value.shape);
        if output.join(&value.shape).as_ref() != Some(&output.shape) || !output.color_has(&value.shape) {
            return Err(Misfit { output: k, shape: value.shape.clone(), pixel: pixels.at(first) });
        }
        let opaque = Plane::Uniform(1.0);
        for (cell, out) in own.iter_mut().enumerate() {
            let plane = if output.is_color() && cell >= written.cells() {
                &opaque
            } else if value.shape.is_scalar() {
                &value.planes[0]
            } else {
                &value.planes[cell]
            };
            put(machine.isa, plane, &slot.defined, pixels, start, out);
        }
    }
    Ok(())
}

/// The same number, and of all that are none the same: which sign and payload a NaN has depends on the machine and on
/// the order of operands.
#[inline(always)]
fn proper(x: f32) -> f32 {
    if x.is_nan() { f32::NAN } else { x }
}

fn put(isa: Isa, plane: &Plane, defined: &Mask, pixels: Pixels<'_>, start: usize, out: &mut [f32]) {
    let n = pixels.len();
    match (pixels, defined, plane) {
        (Pixels::Run(first, n), Mask::All, Plane::Varying(lanes)) => {
            let out = &mut out[first - start..][..n];
            isa.run(|| {
                for (out, x) in out.iter_mut().zip(lanes.get(n)) {
                    *out = proper(*x);
                }
            });
        }
        (Pixels::Run(first, n), Mask::All, Plane::Uniform(x)) => out[first - start..][..n].fill(proper(*x)),
        _ => {
            for lane in 0..n {
                let x = if defined.has(lane) { proper(plane.lane(lane)) } else { 0.0 };
                out[pixels.at(lane) - start] = x;
            }
        }
    }
}

/// The pixels, of `n` in a row, in which some plane holds NaN or an infinity.
pub(super) fn not_finite(planes: &[&[f32]], n: usize) -> usize {
    const EXPONENT: u32 = 0x7f80_0000;
    let odd = |x: &f32| x.to_bits() & EXPONENT == EXPONENT;
    let touched: SmallVec<[&[f32]; 16]> =
        planes.iter().copied().filter(|p| p.iter().fold(false, |any, x| any | odd(x))).collect();
    if touched.is_empty() { 0 } else { (0..n).filter(|&i| touched.iter().any(|p| odd(&p[i]))).count() }
}

/// Which variables to write: those asked for, or `color` (and `alpha`), or all that the program assigns.
pub fn default_names(program: &Resolved) -> Vec<String> {
    let assigned: Vec<&str> = program.assigned().collect();
    let color = program.by_normal.is_some() || assigned.contains(&"color");
    if color {
        let alpha = assigned.contains(&"alpha").then(|| "alpha".to_string());
        return std::iter::once("color".to_string()).chain(alpha).collect();
    }
    assigned.into_iter().map(String::from).collect()
}

/// Does the program give a colour and no alpha, so that the image's alpha is kept?
pub fn keeps_alpha(program: &Resolved) -> bool {
    let own = |name: &str| program.globals.iter().find(|g| g.name == name && !g.library);
    let alpha = own("alpha").is_some_and(|g| g.assigned.is_some() || g.framed.is_some());
    !alpha && (program.by_normal.is_some() || program.assigned().any(|name| name == "color"))
}

/// The image's alpha, if a run keeps it.
pub(super) fn kept_alpha(program: &Resolved, inputs: &Inputs<'_>, options: &Options<'_>) -> Option<usize> {
    let kept = (options.outputs.is_none() || options.keep_alpha) && keeps_alpha(program);
    inputs.find("alpha").filter(|&alpha| kept && inputs.get(alpha).shape.is_scalar())
}

/// The error of an output that has `shape` at a pixel, and what does not go with it where it was seen before.
pub(super) fn misfits(program: &Resolved, output: &Output, shape: &Shape) -> Diagnostic {
    let name = &output.name;
    let error = if output.color_has(shape) {
        let other = match output.seen {
            Some([column, row]) => format!("at pixel [{column} {row}]"),
            None => "elsewhere".to_string(),
        };
        Diagnostic::bare("output", format!("`{name}` is {} {other}, and {shape} here", output.shape))
            .hint("An output needs the same shape at all pixels. Only a scalar is extended to a vector.")
    } else {
        Diagnostic::bare("output", format!("`color` is {shape}, which is not a colour"))
            .hint("A colour is a scalar (grey), `[red green blue]`, or `[red green blue alpha]`.")
    };
    match output.slot.and_then(|i| program.globals[i as usize].assigned) {
        Some(span) => error.label(span, "first assigned here"),
        None => error,
    }
}

/// The error of an output that the program does not have.
pub(super) fn missing(program: &Resolved, name: &str) -> Diagnostic {
    let assigned: Vec<&str> = program.assigned().collect();
    let error = Diagnostic::bare("output", format!("there is no variable `{name}` to write"));
    if let Some(near) = names::nearest(name, assigned.iter().copied()) {
        return error.hint(format!("Did you mean `{near}`?"));
    }
    let error = vocabulary::variable(name).into_iter().fold(error, Diagnostic::hint);
    if assigned.is_empty() {
        return error.hint("The program assigns no variable at all.");
    }
    error.hint(format!("The program assigns {}.", assigned.join(", ")))
}
