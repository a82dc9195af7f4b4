//! Expressions of a plan.

use super::build::{Builder, GiveUp, MOST, Val};
use super::graph::{Cell, Cells};
use super::op::{Arith, Cost, Op};
use super::strip::{Zip, zip};
use crate::math;
use crate::resolve::tree::*;
use crate::shape::Shape;

/// Expressions that nest deeper are left to the evaluator.
const NESTING: usize = 100;

#[inline(always)]
fn truth(condition: bool) -> f32 {
    if condition { 1.0 } else { 0.0 }
}

/// Or is it one with a minus before it?
fn power_of_two(x: f32) -> bool {
    x.is_normal() && x.to_bits() & 0x7f_ffff == 0
}

/// The power of two that dividing by this number can be done by multiplying with, exactly.
fn reciprocal(cell: Cell) -> Option<Cell> {
    let x = cell.known()?;
    let inverse = 1.0 / x;
    (power_of_two(x) && inverse.is_normal()).then(|| Cell::number(inverse))
}

impl<'r> Builder<'_, 'r> {
    pub fn expr(&mut self, e: &'r Expr) -> Result<Val, GiveUp> {
        self.depth += 1;
        let deep = self.depth > NESTING || self.graph.nodes.len() > MOST;
        let value = if deep { Err(GiveUp) } else { self.expr_here(e) };
        self.depth -= 1;
        value
    }

    fn expr_here(&mut self, e: &'r Expr) -> Result<Val, GiveUp> {
        match &e.kind {
            ExprKind::Number(x) => Ok(Val::number(*x)),
            ExprKind::Variable(place) => self.get(*place),
            ExprKind::Kept(id, inner, reads) => {
                if let Some(value) = &self.machine.kept[*id as usize] {
                    return Ok(Val::from(value));
                }
                if reads.iter().any(|&i| self.machine.bound.sources[i as usize].varies()) {
                    return self.expr(inner);
                }
                // What goes wrong here will go wrong again in the walk, which can tell it.
                let mask = self.mask;
                let value = self.machine.guarded(|machine| machine.keep(inner, mask)).map_err(|_| GiveUp)?;
                self.machine.kept[*id as usize] = Some(value.clone());
                Ok(Val::from(&value))
            }
            ExprKind::Unary(op, a) => {
                let a = self.expr(a)?;
                let op: Zip = match op {
                    UnaryOp::Neg => |isa, args, out| zip(isa, args, out, |[a]: [f32; 1]| -a),
                    UnaryOp::Not => |isa, args, out| zip(isa, args, out, |[a]| truth(a == 0.0)),
                };
                self.meet([&a], |graph, a| graph.one(Op::Zip(op), &a))
            }
            ExprKind::Binary(op @ (BinaryOp::And | BinaryOp::Or), a, b) => {
                let a = self.expr(a)?;
                self.logical(*op, &a, b)
            }
            ExprKind::Binary(op, a, b) => {
                let (a, b) = (self.expr(a)?, self.expr(b)?);
                self.binary(*op, &a, &b)
            }
            ExprKind::Conditional(parts) => {
                let [c, a, b] = &**parts;
                let condition = self.expr(c)?.as_scalar()?;
                match condition.known() {
                    Some(0.0) => self.expr(b),
                    Some(_) => self.expr(a),
                    None => {
                        let a = self.under(condition, true, |builder| builder.expr(a))?;
                        let b = self.under(condition, false, |builder| builder.expr(b))?;
                        self.select(condition, &a, &b)
                    }
                }
            }
            ExprKind::Vector(elements) => {
                let mut values = Vec::with_capacity(elements.len());
                for element in elements {
                    match element {
                        Element::Item(e) => values.push(self.expr(e)?),
                        Element::Range(..) => return Err(GiveUp),
                    }
                }
                let shapes: Vec<Shape> = values.iter().map(|v| v.shape.clone()).collect();
                let cells: Cells = values.into_iter().flat_map(|v| v.cells).collect();
                Ok(Val { shape: Shape::vector_of(&shapes), cells })
            }
            ExprKind::Index(base, index) => {
                let i = self.known_index(index)?;
                self.element(base, i)
            }
            ExprKind::Component(base, i) => self.element(base, *i as usize),
            ExprKind::Call(f, args) => self.call(*f, args),
            ExprKind::Builtin(builtin, args) => self.builtin(builtin, args),
            ExprKind::Host(..) => Err(GiveUp),
        }
    }

    fn element(&mut self, base: &'r Expr, i: usize) -> Result<Val, GiveUp> {
        let base = self.expr(base)?;
        if base.shape.len().is_none_or(|n| i >= n) { Err(GiveUp) } else { Ok(base.element(i)) }
    }

    /// `a && b` or `a || b`.
    pub fn logical(&mut self, op: BinaryOp, a: &Val, b: &'r Expr) -> Result<Val, GiveUp> {
        let a = a.as_scalar()?;
        match (op, a.known()) {
            (BinaryOp::And, Some(0.0)) => return Ok(Val::number(0.0)),
            (BinaryOp::Or, Some(x)) if x != 0.0 => return Ok(Val::number(1.0)),
            _ => {}
        }
        let b = match a {
            Cell::Known(_) => self.expr(b)?,
            Cell::Result(_) => self.under(a, op == BinaryOp::And, |builder| builder.expr(b))?,
        };
        let b = b.as_scalar()?;
        let kernel: Zip = match op {
            BinaryOp::And => |isa, args, out| zip(isa, args, out, |[a, b]| truth((a != 0.0) & (b != 0.0))),
            _ => |isa, args, out| zip(isa, args, out, |[a, b]| truth((a != 0.0) | (b != 0.0))),
        };
        Ok(Val::scalar(self.graph.one(Op::Zip(kernel), &[a, b])))
    }

    /// `a op b`, component by component.
    pub fn binary(&mut self, op: BinaryOp, a: &Val, b: &Val) -> Result<Val, GiveUp> {
        let kernel: Zip = match op {
            BinaryOp::Add => return self.meet([a, b], |graph, [a, b]| graph.arith(Arith::Add, a, b)),
            BinaryOp::Sub => return self.meet([a, b], |graph, [a, b]| graph.arith(Arith::Sub, a, b)),
            BinaryOp::Mul => return self.meet([a, b], |graph, [a, b]| graph.arith(Arith::Mul, a, b)),
            BinaryOp::Div => {
                const OVER: Zip = |isa, args, out| zip(isa, args, out, |[a, b]| a / b);
                return self.meet([a, b], |graph, [a, b]| match reciprocal(b) {
                    Some(inverse) => graph.arith(Arith::Mul, a, inverse),
                    None => graph.one(Op::Zip(OVER), &[a, b]),
                });
            }
            BinaryOp::Rem => {
                const POWER: Zip = |isa, args, out| zip(isa, args, out, |[a, b]| math::modulo_of_power(a, b));
                return self.meet([a, b], |graph, [a, b]| match b.known() {
                    Some(x) if power_of_two(x) && (1.0..1e30).contains(&x) => {
                        graph.one(Op::Zip(POWER), &[a, b])
                    }
                    _ => graph.one(Op::Map2(math::modulo_lanes, Cost::Heavy), &[a, b]),
                });
            }
            BinaryOp::Pow => {
                const POW: Zip = |isa, args, out| zip(isa, args, out, |[a, b]| math::pow(a, b));
                return self.meet([a, b], |graph, [a, b]| graph.one(Op::Costly(POW), &[a, b]));
            }
            BinaryOp::Eq => |isa, args, out| zip(isa, args, out, |[a, b]| truth(a == b)),
            BinaryOp::Ne => |isa, args, out| zip(isa, args, out, |[a, b]| truth(a != b)),
            BinaryOp::Lt => |isa, args, out| zip(isa, args, out, |[a, b]| truth(a < b)),
            BinaryOp::Le => |isa, args, out| zip(isa, args, out, |[a, b]| truth(a <= b)),
            BinaryOp::Gt => |isa, args, out| zip(isa, args, out, |[a, b]| truth(a > b)),
            BinaryOp::Ge => |isa, args, out| zip(isa, args, out, |[a, b]| truth(a >= b)),
            BinaryOp::And | BinaryOp::Or => return Err(GiveUp),
        };
        self.meet([a, b], |graph, [a, b]| graph.one(Op::Zip(kernel), &[a, b]))
    }
}
