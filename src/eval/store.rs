//! Assignments: to variables, and to elements of vectors.

use super::fault::{Fault, Result};
use super::index::Picked;
use super::machine::{Machine, Slot, blend};
use crate::diagnostic::{Diagnostic, Span};
use crate::resolve::tree::*;
use crate::shape::Shape;
use crate::value::{Mask, Plane, Planes, Value};

/// A step of the way to an element, its index computed.
struct At {
    index: Plane,
    span: Span,
}

impl<'r> Machine<'r> {
    /// `target = value` and `target op= value`.
    pub fn assign(
        &mut self,
        place: Place,
        name: Span,
        path: &'r [Step],
        op: Option<BinaryOp>,
        value: &'r Expr,
        mask: &Mask,
    ) -> Result<()> {
        let path = self.path(path, mask)?;
        let value = match op {
            None => self.eval(value, mask)?,
            Some(op) => {
                let old = self.read(place, name, mask)?.clone();
                let old = self.follow(old, &path, name, mask)?;
                match op {
                    BinaryOp::And | BinaryOp::Or => self.logical(op, old, name, value, mask)?,
                    _ => {
                        let right = self.eval(value, mask)?;
                        self.binary(op, &old, name, &right, value.span, name.to(value.span), mask)?
                    }
                }
            }
        };
        self.work(value.planes.len(), true, mask, name)?;
        if path.is_empty() {
            return self.store(place, value, mask);
        }
        self.store_element(place, name, &path, value, mask)
    }

    fn path(&mut self, path: &'r [Step], mask: &Mask) -> Result<Vec<At>> {
        path.iter()
            .map(|step| match step {
                Step::Component(i, span) => Ok(At { index: Plane::Uniform(*i as f32 + 1.0), span: *span }),
                Step::Index(e) => {
                    let value = self.eval(e, mask)?;
                    match value.shape {
                        Shape::Scalar => Ok(At { index: value.planes[0].clone(), span: e.span }),
                        _ => {
                            let message = format!(
                                "one element is assigned at a time, and the index is {}",
                                value.shape
                            );
                            let error = Diagnostic::error("shape", message, e.span)
                                .label(e.span, value.show(self.first(mask)))
                                .hint("Assign to several in a loop: `for i in [1 3]`.");
                            Err(self.fault(error, self.first(mask)))
                        }
                    }
                }
            })
            .collect()
    }

    /// The element that a path leads to.
    fn follow(&self, value: Value, path: &[At], name: Span, mask: &Mask) -> Result<Value> {
        path.iter().try_fold(value, |value, at| {
            self.index(&value, &Value::scalar(at.index.clone()), name, at.span, mask)
        })
    }

    fn store_element(
        &mut self,
        place: Place,
        name: Span,
        path: &[At],
        new: Value,
        mask: &Mask,
    ) -> Result<()> {
        self.check_memory()?;
        let width = self.width();
        let slot = std::mem::replace(self.slot(place), Slot::EMPTY);
        // Lanes with a value keep its shape; lanes without one begin with an empty vector.
        let current = match slot.value {
            Some(value) if mask.is_subset(&slot.defined, width) => Some(value),
            Some(_) => {
                let fresh = mask.minus(&slot.defined, width);
                if !mask.is_subset(&fresh, width) {
                    return Err(Fault::Split(fresh));
                }
                if !slot.defined.is_none() {
                    return Err(Fault::Split(mask.clone()));
                }
                None
            }
            None => None,
        };
        let alone = slot.defined.is_subset(mask, width);
        let value = self.stored(current, path, name, new, mask, alone)?;
        self.check_cells(value.planes.len(), name, mask)?;
        self.check_shape(&value.shape, name, mask)?;
        *self.slot(place) = Slot { value: Some(value), defined: slot.defined.or(mask, width) };
        Ok(())
    }

    /// `current` with `new` at the end of the path. `alone`: no lane outside of the mask has a value, so
    /// that shapes may change.
    fn stored(
        &self,
        current: Option<Value>,
        path: &[At],
        name: Span,
        new: Value,
        mask: &Mask,
        alone: bool,
    ) -> Result<Value> {
        let Some((at, rest)) = path.split_first() else {
            return match current {
                Some(old) if !alone => blend(mask, &new, &old, self.width()),
                _ => Ok(new),
            };
        };
        let current = current.unwrap_or_else(|| Value::vector(Planes::new()));
        let Some(len) = current.shape.len() else {
            let lane = self.first(mask);
            let error = Diagnostic::error("shape", "a scalar has no elements to assign to", name)
                .label(name, format!("a scalar: {}", current.show(lane)))
                .hint("Make it a vector first, as in `v = [0 0 0]`.");
            return Err(self.fault(error, lane));
        };
        // One past the end is where the vector grows.
        match self.pick(&current, &at.index, len + 1, at.span, mask)? {
            Picked::One(i) => self.stored_at(current, i, rest, name, new, mask, alone),
            Picked::Lanes(which) => {
                let first = which[self.first(mask)];
                let n = self.n;
                let mut elements: Vec<u32> = mask.lanes(n).map(|lane| which[lane]).collect();
                elements.sort_unstable();
                elements.dedup();
                if elements.len() == 1 {
                    return self.stored_at(current, first as usize, rest, name, new, mask, alone);
                }
                let mut value = current;
                for i in elements {
                    let lanes = Mask::from_fn(n, |lane| which[lane] == i && mask.has(lane));
                    value = self.stored_at(value, i as usize, rest, name, new.clone(), &lanes, false)?;
                }
                Ok(value)
            }
        }
    }

    #[expect(clippy::too_many_arguments, reason = "a step of a path, and what it leads to")]
    fn stored_at(
        &self,
        mut current: Value,
        i: usize,
        rest: &[At],
        name: Span,
        new: Value,
        mask: &Mask,
        alone: bool,
    ) -> Result<Value> {
        let len = current.shape.len().unwrap_or(0);
        if i == len {
            if !alone {
                return Err(Fault::Split(mask.clone()));
            }
            let element = self.stored(None, rest, name, new, mask, true)?;
            match (&mut current.shape, &element.shape) {
                (Shape::Vector(n), Shape::Scalar) => {
                    *n += 1;
                    current.planes.extend(element.planes);
                }
                _ => {
                    let mut shapes: Vec<Shape> = current.shape.elements().collect();
                    shapes.push(element.shape);
                    current.shape = Shape::vector_of(&shapes);
                    current.planes.extend(element.planes);
                }
            }
            return Ok(current);
        }
        let element = self.stored(Some(current.element(i)), rest, name, new, mask, alone)?;
        let cells = current.shape.cells_of(i);
        if element.shape == current.shape.element(i) {
            for (old, new) in current.planes[cells].iter_mut().zip(element.planes) {
                *old = new;
            }
            return Ok(current);
        }
        let elements = (0..len).map(|k| if k == i { element.clone() } else { current.element(k) });
        Ok(Value::vector_of(elements))
    }
}
