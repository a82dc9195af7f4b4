//! Elements of vectors: `v[i]`, `v[[3 2 1]]`, `v.y`.

use super::fault::{Fault, Result};
use super::machine::Machine;
use crate::diagnostic::{Diagnostic, Span};
use crate::shape::Shape;
use crate::value::{Mask, Plane, Value, number};

/// What an index picks in the active lanes.
pub(super) enum Picked {
    /// The same element in every lane, counted from 0; it may be out of range.
    One(usize),
    /// One a lane, counted from 0, all in range; lanes that are off say 0.
    Lanes(Vec<u32>),
}

impl Machine<'_> {
    /// `value[index]`.
    pub fn index(
        &self,
        value: &Value,
        index: &Value,
        span: Span,
        index_span: Span,
        mask: &Mask,
    ) -> Result<Value> {
        if value.shape.is_scalar() {
            return Err(self.no_vector(value, span, mask));
        }
        if index.shape != Shape::Scalar {
            let mut picked: Vec<Value> = Vec::new();
            let mut cells = 0;
            for i in index.elements() {
                let element = self.index(value, &i, span, index_span, mask)?;
                cells += element.planes.len();
                // Before it is built: a large element may be picked many times.
                self.check_cells(cells, index_span, mask)?;
                picked.push(element);
            }
            let picked = Value::vector_of(picked);
            self.check_shape(&picked.shape, index_span, mask)?;
            return Ok(picked);
        }
        match self.pick(value, &index.planes[0], value.shape.len().unwrap_or(0), index_span, mask)? {
            Picked::One(i) => Ok(value.element(i)),
            Picked::Lanes(which) => {
                let n = self.n;
                let first = which[self.first(mask)];
                let shape = value.shape.element(first as usize);
                let uneven = value.shape.elements().any(|s| s != shape);
                if uneven {
                    // Elements of different shapes: lanes with the same element go together.
                    return Err(Fault::Split(Mask::from_fn(n, |i| which[i] == first)));
                }
                let cells = shape.cells();
                let planes = (0..cells)
                    .map(|cell| {
                        Plane::filled(n, |out| {
                            for (lane, out) in out.iter_mut().enumerate() {
                                *out = value.planes[which[lane] as usize * cells + cell].lane(lane);
                            }
                        })
                    })
                    .collect();
                Ok(Value { shape, planes })
            }
        }
    }

    /// Rounds indices to elements and checks that there are such: 1 to `last`.
    pub fn pick(&self, value: &Value, index: &Plane, last: usize, span: Span, mask: &Mask) -> Result<Picked> {
        let check = |x: f32, lane: usize| -> Result<usize> {
            let i = crate::math::round(x);
            if i >= 1.0 && i <= last as f32 {
                return Ok(i as usize - 1);
            }
            let count = value.shape.len().unwrap_or(0);
            let mut asked = number(i);
            if i != x && x.is_finite() {
                asked += &format!(" ({}, rounded)", number(x));
            }
            let message = format!("there is no element {asked} in {}", value.shape);
            let few = value.shape.len().is_some_and(|n| n <= 8) && value.shape.cells() <= 16;
            let shown = if few { value.show(lane) } else { String::new() };
            let mut error = Diagnostic::error("index", message, span);
            if !shown.is_empty() {
                error = error.label(span, format!("the vector is {shown}"));
            }
            error = match count {
                _ if last > count => {
                    error.hint(format!("A vector grows one element at a time: the next one is [{last}]."))
                }
                0 => error.hint("`size(…)` gives the number of elements."),
                _ if i == 0.0 => error.hint(format!("Elements are counted from 1: [1] to [{count}].")),
                _ => error.hint(format!("It has the elements [1] to [{count}].")),
            };
            Err(self.fault(error, lane))
        };
        match &self.decided_plane(index) {
            Plane::Uniform(x) => Ok(Picked::One(check(*x, self.first(mask))?)),
            Plane::Varying(lanes) => {
                let lanes = lanes.get(self.n);
                let mut which = vec![0u32; self.n];
                for lane in mask.lanes(self.n) {
                    which[lane] = check(lanes[lane], lane)? as u32;
                }
                Ok(Picked::Lanes(which))
            }
        }
    }

    /// `value.y` and the like.
    pub fn component(&self, value: &Value, i: u32, base: Span, span: Span, mask: &Mask) -> Result<Value> {
        let Some(count) = value.shape.len() else { return Err(self.no_vector(value, base, mask)) };
        if (i as usize) < count {
            return Ok(value.element(i as usize));
        }
        let lane = self.first(mask);
        // As it is written: `.a` and `.w` are the same.
        let written = self.program.sources.text(Span { start: base.end.clamp(span.start, span.end), ..span });
        let written = written.trim_start_matches('.');
        let names = if matches!(written, "r" | "g" | "b" | "a") {
            ["r", "g", "b", "a"]
        } else {
            ["x", "y", "z", "w"]
        };
        let letter = names.get(i as usize).copied().unwrap_or("x");
        let message = format!("there is no component `.{letter}` in {}", value.shape);
        // The dot and its letter.
        let member = Span { start: base.end.clamp(span.start, span.end), ..span };
        let error = Diagnostic::error("index", message, member).label(base, value.show(lane));
        let error = match names[..count.min(4)].last() {
            Some(last) => error.hint(format!("Its last component is `.{last}`.")),
            None => error,
        };
        let error = match (letter, self.program.sources.text(base)) {
            ("a", "color") => error.hint("The alpha of the picture is the variable `alpha`."),
            _ => error,
        };
        Err(self.fault(error, lane))
    }

    fn no_vector(&self, value: &Value, span: Span, mask: &Mask) -> Fault {
        let lane = self.first(mask);
        let error = Diagnostic::error("shape", "a scalar has no elements", span)
            .label(span, format!("a scalar: {}", value.show(lane)))
            .hint("Only vectors have elements and components.");
        self.fault(error, lane)
    }
}
