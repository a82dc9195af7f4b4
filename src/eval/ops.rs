//! The operators, component by component.

use crate::builtin::map2;
use crate::lanes::{self, Arg, Isa};
use crate::math;
use crate::syntax::ast::{BinaryOp, UnaryOp};
use crate::value::{Mismatch, Plane, Value};

#[inline(always)]
fn truth(condition: bool) -> f32 {
    if condition { 1.0 } else { 0.0 }
}

/// `a op b`. `&&` and `||` of two values that are known are 1 or 0.
pub(super) fn binary(isa: Isa, n: usize, op: BinaryOp, a: &Value, b: &Value) -> Result<Value, Mismatch> {
    crate::value::binary(a, b, |a, b| plane(isa, n, op, a, b))
}

fn plane(isa: Isa, n: usize, op: BinaryOp, a: &Plane, b: &Plane) -> Plane {
    fn with(isa: Isa, n: usize, a: &Plane, b: &Plane, f: impl Fn(f32, f32) -> f32 + Copy) -> Plane {
        map2(isa, n, a, b, |isa, a: Arg<'_>, b: Arg<'_>, out: &mut [f32]| lanes::map2(isa, a, b, out, f))
    }
    match op {
        BinaryOp::Add => with(isa, n, a, b, |a, b| a + b),
        BinaryOp::Sub => with(isa, n, a, b, |a, b| a - b),
        BinaryOp::Mul => with(isa, n, a, b, |a, b| a * b),
        BinaryOp::Div => with(isa, n, a, b, |a, b| a / b),
        BinaryOp::Rem => with(isa, n, a, b, math::modulo),
        BinaryOp::Pow => with(isa, n, a, b, math::pow),
        BinaryOp::Eq => with(isa, n, a, b, |a, b| truth(a == b)),
        BinaryOp::Ne => with(isa, n, a, b, |a, b| truth(a != b)),
        BinaryOp::Lt => with(isa, n, a, b, |a, b| truth(a < b)),
        BinaryOp::Le => with(isa, n, a, b, |a, b| truth(a <= b)),
        BinaryOp::Gt => with(isa, n, a, b, |a, b| truth(a > b)),
        BinaryOp::Ge => with(isa, n, a, b, |a, b| truth(a >= b)),
        BinaryOp::And => with(isa, n, a, b, |a, b| truth((a != 0.0) & (b != 0.0))),
        BinaryOp::Or => with(isa, n, a, b, |a, b| truth((a != 0.0) | (b != 0.0))),
    }
}

/// `op a`.
pub(super) fn unary(isa: Isa, n: usize, op: UnaryOp, a: &Value) -> Value {
    fn with(isa: Isa, n: usize, a: &Plane, f: impl Fn(f32) -> f32 + Copy) -> Plane {
        match a {
            Plane::Uniform(x) => Plane::Uniform(f(*x)),
            Plane::Varying(lanes) => Plane::filled(n, |out| lanes::map1(isa, lanes.get(n), out, f)),
        }
    }
    crate::value::map1(a, |a| match op {
        UnaryOp::Neg => with(isa, n, a, |a| -a),
        UnaryOp::Not => with(isa, n, a, |a| truth(a == 0.0)),
    })
}
