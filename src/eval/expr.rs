//! Expressions.

use super::fault::{Fault, Result};
use super::limits::NESTING;
use super::machine::{Machine, blend};
use super::ops;
use crate::builtin::map2;
use crate::diagnostic::{Diagnostic, Span};
use crate::lanes;
use crate::resolve::tree::*;
use crate::shape::Shape;
use crate::stack;
use crate::value::{Mask, Plane, Planes, Value};

/// How far a range's end may miss a whole step, so that `[0.1 .. 5.1]` has its last element.
const RANGE_SLACK: f32 = 1e-4;

impl<'r> Machine<'r> {
    /// The value of an expression in the active lanes. In the others it means nothing.
    pub fn eval(&mut self, e: &'r Expr, mask: &Mask) -> Result<Value> {
        // Every nesting of brackets and of calls comes through here, and that of blocks through `block`.
        if stack::is_low() {
            return stack::grow(|| self.eval(e, mask));
        }
        if !self.nesting.enter(u32::MAX) {
            return Err(self.too_deep(e.span, mask));
        }
        let value = match self.tracer.is_some() {
            true => self.eval_traced(e, mask),
            false => self.eval_here(e, mask),
        };
        self.nesting.leave();
        value
    }

    /// The stack is full, and can't grow.
    #[cold]
    pub(super) fn too_deep(&self, span: Span, mask: &Mask) -> Fault {
        let error =
            Diagnostic::error("limit", "expressions, calls and blocks nest too deep for the stack", span)
                .hint("Built with the feature `deep`, the library has no such limit: the stack grows.");
        self.fault(error, self.first(mask))
    }

    pub(super) fn eval_here(&mut self, e: &'r Expr, mask: &Mask) -> Result<Value> {
        match &e.kind {
            ExprKind::Number(x) => Ok(Value::uniform(*x)),
            ExprKind::Variable(place) => self.read(*place, e.span, mask).cloned(),
            ExprKind::Kept(id, inner, reads) => {
                if let Some(value) = &self.kept[*id as usize] {
                    return Ok(value.clone());
                }
                // An image may have a variable of a constant's name: then it differs from pixel to pixel.
                if reads.iter().any(|&i| self.bound.sources[i as usize].varies()) {
                    return self.eval(inner, mask);
                }
                let value = self.keep(inner, mask)?;
                self.kept[*id as usize] = Some(value.clone());
                Ok(value)
            }
            ExprKind::Unary(op, a) => {
                let a = self.eval(a, mask)?;
                Ok(ops::unary(self.isa, self.n, *op, &a))
            }
            ExprKind::Binary(op @ (BinaryOp::And | BinaryOp::Or), a, b) => {
                let left = self.eval(a, mask)?;
                self.logical(*op, left, a.span, b, mask)
            }
            ExprKind::Binary(op, a, b) => {
                let left = self.eval(a, mask)?;
                let right = self.eval(b, mask)?;
                let cells = left.planes.len().max(right.planes.len());
                self.work(cells, left.is_uniform() && right.is_uniform(), mask, e.span)?;
                self.binary(*op, &left, a.span, &right, b.span, e.span, mask)
            }
            ExprKind::Conditional(parts) => self.conditional(parts, mask),
            ExprKind::Vector(elements) => self.vector(elements, e.span, mask),
            ExprKind::Index(base, index) => {
                let index_value = self.eval(index, mask)?;
                self.with(base, mask, |machine, value, mask| {
                    machine.index(value, &index_value, base.span, index.span, mask)
                })
            }
            ExprKind::Component(base, i) => self.with(base, mask, |machine, value, mask| {
                machine.component(value, *i, base.span, e.span, mask)
            }),
            ExprKind::Call(f, args) => self.call(*f, args, e.span, mask),
            ExprKind::Builtin(builtin, args) => self.call_builtin(builtin, args, e.span, mask),
            ExprKind::Host(host, args) => self.call_host(host, args, e.span, mask),
        }
    }

    /// Gives `f` a look at an expression's value, without a copy if it is a variable.
    pub fn with<T>(
        &mut self,
        e: &'r Expr,
        mask: &Mask,
        f: impl FnOnce(&Machine<'r>, &Value, &Mask) -> Result<T>,
    ) -> Result<T> {
        if let ExprKind::Variable(place) = e.kind {
            self.read(place, e.span, mask)?;
            let slot = match place {
                Place::Global(i) => &self.globals[i as usize],
                Place::Local(i) => &self.locals[self.base + i as usize],
            };
            return match &slot.value {
                Some(value) => f(self, value, mask),
                // `read` has just seen that it has one.
                None => Err(Fault::Cancelled),
            };
        }
        let value = self.eval(e, mask)?;
        f(self, &value, mask)
    }

    /// `a op b`, or the error of lengths that differ.
    #[expect(clippy::too_many_arguments, reason = "two operands with their places")]
    pub fn binary(
        &self,
        op: BinaryOp,
        left: &Value,
        left_span: Span,
        right: &Value,
        right_span: Span,
        span: Span,
        mask: &Mask,
    ) -> Result<Value> {
        ops::binary(self.isa, self.n, op, left, right).map_err(|mismatch| {
            let lane = self.first(mask);
            let message =
                format!("`{}` meets vectors of different lengths, {} and {}", op.symbol(), mismatch.left, mismatch.right);
            let error = Diagnostic::error("shape", message, span)
                .label(left_span, format!("{}: {}", left.shape, left.show(lane)))
                .label(right_span, format!("{}: {}", right.shape, right.show(lane)))
                .hint("Operators work component by component. Give both vectors the same length, or use a scalar.");
            self.fault(error, lane)
        })
    }

    /// A condition's truth: the lanes where it holds, and the rest.
    pub fn split(&self, condition: &Value, span: Span, mask: &Mask) -> Result<(Mask, Mask)> {
        let plane = self.condition(condition, span, mask)?;
        Ok(match self.shadowed() {
            false => mask.split(plane, self.width()),
            true => mask.split(&self.decided_plane(plane), self.width()),
        })
    }

    fn condition<'v>(&self, condition: &'v Value, span: Span, mask: &Mask) -> Result<&'v Plane> {
        if condition.shape == Shape::Scalar {
            return Ok(&condition.planes[0]);
        }
        let lane = self.first(mask);
        let error = Diagnostic::error("shape", format!("the condition is {}", condition.shape), span)
            .label(span, condition.show(lane))
            .hint("A condition is a scalar: `all(…)` is 1 if every component is true, `any(…)` if at least one is.");
        Err(self.fault(error, lane))
    }

    /// `left && right` or `left || right`, the right side only where the left does not decide.
    pub fn logical(
        &mut self,
        op: BinaryOp,
        left: Value,
        left_span: Span,
        right: &'r Expr,
        mask: &Mask,
    ) -> Result<Value> {
        let (yes, no) = self.split(&left, left_span, mask)?;
        let (open, decided) = if op == BinaryOp::And { (yes, 0.0) } else { (no, 1.0) };
        if open.is_none() {
            return Ok(Value::uniform(decided));
        }
        let value = self.eval(right, &open)?;
        let plane = self.condition(&value, right.span, &open)?;
        let truth = map2(self.isa, self.n, plane, &Plane::Uniform(0.0), |isa, a, b, out| {
            lanes::map2(isa, a, b, out, |a, b| if a != b { 1.0 } else { 0.0 })
        });
        // Where every active lane asks for the right side, there is nothing to blend.
        if mask.is_subset(&open, self.width()) {
            return Ok(Value::scalar(truth));
        }
        Ok(Value::scalar(open.select(&truth, &Plane::Uniform(decided), self.width())))
    }

    fn conditional(&mut self, [c, a, b]: &'r [Expr; 3], mask: &Mask) -> Result<Value> {
        let condition = self.eval(c, mask)?;
        let (yes, no) = self.split(&condition, c.span, mask)?;
        if no.is_none() {
            return self.eval(a, &yes);
        }
        if yes.is_none() {
            return self.eval(b, &no);
        }
        let a = self.eval(a, &yes)?;
        let b = self.eval(b, &no)?;
        blend(&yes, &a, &b, self.width())
    }

    fn vector(&mut self, elements: &'r [Element], span: Span, mask: &Mask) -> Result<Value> {
        let mut shapes: smallvec::SmallVec<[Shape; 4]> = smallvec::SmallVec::new();
        let mut planes = Planes::new();
        for element in elements {
            match element {
                Element::Item(e) => {
                    let value = self.eval(e, mask)?;
                    shapes.push(value.shape);
                    planes.extend(value.planes);
                }
                Element::Range(a, b) => {
                    let range = self.range(a, b, mask)?;
                    shapes.extend(range.iter().map(|_| Shape::Scalar));
                    planes.extend(range);
                }
            }
            self.check_cells(planes.len(), span, mask)?;
        }
        self.check_memory()?;
        let shape = Shape::vector_of(&shapes);
        self.check_shape(&shape, span, mask)?;
        Ok(Value { shape, planes })
    }

    /// `a .. b`: a, a+1, … up to b.
    fn range(&mut self, a: &'r Expr, b: &'r Expr, mask: &Mask) -> Result<Planes> {
        let first = self.eval(a, mask)?;
        let last = self.eval(b, mask)?;
        for (value, e) in [(&first, a), (&last, b)] {
            if !value.shape.is_scalar() {
                let lane = self.first(mask);
                let error =
                    Diagnostic::error("shape", format!("the end of a range is {}", value.shape), e.span)
                        .label(e.span, value.show(lane))
                        .hint("A range goes from one number to another: `[1 .. 10]`.");
                return Err(self.fault(error, lane));
            }
        }
        let n = self.n;
        let pixels = self.pixels();
        let count = |lane: usize| {
            let lane = lane % pixels;
            (last.planes[0].lane(lane) - first.planes[0].lane(lane) + RANGE_SLACK).floor() + 1.0
        };
        let lane = self.first(mask);
        let length = count(lane);
        if !(first.is_uniform() && last.is_uniform()) {
            let same = |i: usize| count(i).to_bits() == length.to_bits();
            if !mask.lanes(n).all(same) {
                return Err(Fault::Split(Mask::from_fn(n, same)));
            }
        }
        if length.is_nan() {
            let message = format!("a range from {} to {} has no length", first.show(lane), last.show(lane));
            let error = Diagnostic::error("range", message, a.span.to(b.span))
                .hint("NaN comes from operations without a result, such as `0 / 0` and `sqrt(-1)`.");
            return Err(self.fault(error, lane));
        }
        let length = length.max(0.0);
        self.check_cells(length as usize, a.span.to(b.span), mask)?;
        Ok((0..length as usize)
            .map(|k| {
                map2(self.isa, n, &first.planes[0], &Plane::Uniform(k as f32), |isa, a, b, out| {
                    lanes::map2(isa, a, b, out, |a, b| a + b)
                })
            })
            .collect())
    }

    /// Ends a program whose vectors hold too many others, or nest too deep.
    pub fn check_shape(&self, shape: &Shape, span: Span, mask: &Mask) -> Result<()> {
        if !matches!(shape, Shape::Nested(_)) {
            return Ok(());
        }
        let (size, depth) = shape.extent();
        if depth > NESTING {
            let error =
                Diagnostic::error("limit", format!("vectors are nested more than {NESTING} deep"), span)
                    .hint("`append(v, x)` adds an element to a vector; `[v x]` makes a new one around it.");
            return Err(self.fault(error, self.first(mask)));
        }
        // Each number in a vector of its own counts twice; a vector of empty ones has no numbers at all.
        self.check_cells(size / 2, span, mask)
    }

    /// Ends a program whose vector grows too long.
    pub fn check_cells(&self, cells: usize, span: Span, mask: &Mask) -> Result<()> {
        if cells <= self.limits.cells {
            return Ok(());
        }
        let message = format!("the vector has more than {} elements", self.limits.cells);
        let error =
            Diagnostic::error("limit", message, span).hint("A higher limit can be set (`--max-vector`).");
        Err(self.fault(error, self.first(mask)))
    }
}
