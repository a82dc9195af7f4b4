//! Built-in functions of a plan. Those not found here are the evaluator's.

use super::build::{Builder, GiveUp, Val};
use super::graph::{Cell, Cells, Graph};
use super::op::{Arith, Op};
use super::strip::{Zip, zip};
use crate::builtin::{self, Builtin, Kernel, Octaves};
use crate::resolve::tree::Expr;
use crate::shape::Shape;
use crate::value::{Mask, Value};
use smallvec::SmallVec;
use std::sync::Arc;

/// The most knots of a curve.
const KNOTS: usize = builtin::Curve::MOST;

impl<'r> Builder<'_, 'r> {
    pub fn builtin(&mut self, builtin: &'static Builtin, args: &'r [Expr]) -> Result<Val, GiveUp> {
        let mut values: SmallVec<[Val; 4]> = SmallVec::new();
        for arg in args {
            values.push(self.expr(arg)?);
        }
        match builtin.kernel {
            Kernel::Map1(kernel) => self.meet([&values[0]], |graph, a| graph.one(Op::Map1(kernel), &a)),
            Kernel::Map2(kernel) => {
                self.meet([&values[0], &values[1]], |graph, args| graph.one(Op::Map2(kernel), &args))
            }
            Kernel::Maps(kernel) => match &values[..] {
                [a, b, c] => self.meet([a, b, c], |graph, args| graph.one(Op::Maps(kernel), &args)),
                [a, b, c, d] => self.meet([a, b, c, d], |graph, args| graph.one(Op::Maps(kernel), &args)),
                _ => Err(GiveUp),
            },
            Kernel::Fold(kernel) => {
                let mut sum = values[0].clone();
                for next in &values[1..] {
                    sum = self.meet([&sum, next], |graph, args| graph.one(Op::Map2(kernel), &args))?;
                }
                Ok(sum)
            }
            Kernel::Whole(_) => self.whole(builtin, &values),
            Kernel::Shadowed(_) => Err(GiveUp),
        }
    }

    fn whole(&mut self, builtin: &'static Builtin, args: &[Val]) -> Result<Val, GiveUp> {
        // Of what is known the evaluator's own kernel makes the value.
        if let Some(values) = args.iter().map(Val::known).collect::<Option<SmallVec<[Value; 4]>>>() {
            let max_cells = self.machine.limits.cells;
            let textures = &self.machine.bound.textures;
            let isa = self.machine.isa;
            let call =
                builtin::Call { isa, n: 1, pixels: 1, mask: &Mask::All, args: &values, max_cells, textures };
            let value = builtin.apply(&call).map_err(|_| GiveUp)?;
            return if value.is_uniform() { Ok(Val::from(&value)) } else { Err(GiveUp) };
        }
        let graph = &mut self.graph;
        match builtin.name {
            "dot" => {
                let (a, b) = pair(&args[0], &args[1])?;
                Ok(Val::scalar(dot(graph, &a, &b)))
            }
            "min" | "max" => {
                let parts: Vec<Val> = match args {
                    [one] if !one.shape.is_scalar() => {
                        (0..one.shape.len().unwrap_or(0)).map(|i| one.element(i)).collect()
                    }
                    many => many.to_vec(),
                };
                const MIN: Zip = |isa, args, out| zip(isa, args, out, |[a, b]| builtin::min(a, b));
                const MAX: Zip = |isa, args, out| zip(isa, args, out, |[a, b]| builtin::max(a, b));
                let kernel = if builtin.name == "min" { MIN } else { MAX };
                let (first, rest) = parts.split_first().ok_or(GiveUp)?;
                rest.iter().try_fold(first.clone(), |value, next| {
                    self.meet([&value, next], |graph, args| graph.one(Op::Zip(kernel), &args))
                })
            }
            "norm" | "length" => Ok(Val::scalar(norm(graph, flat(&args[0])?))),
            "distance" => {
                let (a, b) = pair(&args[0], &args[1])?;
                let between: Cells = a.iter().zip(&b).map(|(&a, &b)| graph.arith(Arith::Sub, a, b)).collect();
                Ok(Val::scalar(norm(graph, &between)))
            }
            "direction" => {
                let cells = flat(&args[0])?;
                let length = norm(graph, cells);
                let inverse = graph.one(
                    Op::Zip(|isa, args, out| zip(isa, args, out, |[length]| builtin::inverse(length))),
                    &[length],
                );
                let cells = cells.iter().map(|&x| graph.arith(Arith::Mul, x, inverse)).collect();
                Ok(Val { shape: args[0].shape.clone(), cells })
            }
            "cross" => {
                let (Shape::Vector(3), Shape::Vector(3)) = (&args[0].shape, &args[1].shape) else {
                    return Err(GiveUp);
                };
                let (a, b) = (&args[0].cells, &args[1].cells);
                const MINUS: Zip = |isa, args, out| zip(isa, args, out, |[a, b, c, d]| a * b - c * d);
                let cells = [(1, 2), (2, 0), (0, 1)]
                    .map(|(i, j)| graph.one(Op::Zip(MINUS), &[a[i], b[j], a[j], b[i]]));
                Ok(Val::vector(cells.into_iter().collect()))
            }
            "Noise" | "Dnoise" | "Vnoise" => self.noise(builtin.name, args),
            "turbulence" | "fractalsum" | "fBm" | "ridged" | "hybrid" => self.octaves(builtin.name, args),
            "spline" | "linear" => self.curve(builtin.name, args),
            _ => Err(GiveUp),
        }
    }

    fn noise(&mut self, name: &str, args: &[Val]) -> Result<Val, GiveUp> {
        let p = match args[0].shape {
            Shape::Scalar | Shape::Vector(1..=4) => &args[0].cells,
            _ => return Err(GiveUp),
        };
        // The point is not looked at: it may be any.
        let rest = args[1..].iter().map(|a| a.known().ok_or(GiveUp));
        let mut values: Vec<Value> = vec![Value::uniform(0.0)];
        for value in rest {
            values.push(value?);
        }
        let max_cells = self.machine.limits.cells;
        let (isa, textures) = (self.machine.isa, &[]);
        let call =
            builtin::Call { isa, n: 1, pixels: 1, mask: &Mask::All, args: &values, max_cells, textures };
        let fields = builtin::noise_fields(&call, p.len(), if name == "Vnoise" { 3 } else { 1 });
        let fields = fields.map_err(|_| GiveUp)?;
        if name == "Dnoise" {
            let cells = self.graph.several(Op::Derivative(fields[0].clone()), p, p.len());
            return Ok(Val { shape: args[0].shape.clone(), cells });
        }
        let cells: Cells = fields.into_iter().map(|field| self.graph.one(Op::Noise(field), p)).collect();
        Ok(if name == "Vnoise" { Val::vector(cells) } else { Val::scalar(cells[0]) })
    }

    fn octaves(&mut self, name: &str, args: &[Val]) -> Result<Val, GiveUp> {
        let (Shape::Scalar | Shape::Vector(1..=4)) = args[0].shape else { return Err(GiveUp) };
        let known: Vec<bool> = args.iter().map(|a| a.known().is_some()).collect();
        let values: Vec<Value> =
            args.iter().map(|a| a.known().unwrap_or_else(|| Value::uniform(0.0))).collect();
        let max_cells = self.machine.limits.cells;
        let (isa, textures) = (self.machine.isa, &[]);
        let call =
            builtin::Call { isa, n: 1, pixels: 1, mask: &Mask::All, args: &values, max_cells, textures };
        let octaves = Octaves::of(name, &call, &known, args[0].cells.len()).ok_or(GiveUp)?;
        let mut cells = args[0].cells.clone();
        for (i, place) in octaves.numbers.iter().enumerate() {
            let cell = match place {
                Some(place) => args[*place].as_scalar()?,
                None => Cell::number(1.0),
            };
            const OVER: Zip = |isa, args, out| zip(isa, args, out, |[low]: [f32; 1]| 1.0 / low);
            cells.push(if i == 2 { self.graph.one(Op::Zip(OVER), &[cell]) } else { cell });
        }
        Ok(Val::scalar(self.graph.one(Op::Octaves(Arc::new(octaves)), &cells)))
    }

    fn curve(&mut self, name: &str, args: &[Val]) -> Result<Val, GiveUp> {
        let t = args[0].as_scalar()?;
        let knots: Vec<Val> = match &args[1..] {
            [one] if !one.shape.is_scalar() => {
                (0..one.shape.len().unwrap_or(0)).map(|i| one.element(i)).collect()
            }
            many => many.to_vec(),
        };
        let shape = knots.first().ok_or(GiveUp)?.shape.clone();
        let cells = shape.cells();
        let alike =
            knots.iter().all(|k| k.shape == shape) && matches!(shape, Shape::Scalar | Shape::Vector(_));
        if !alike || !(1..=4).contains(&cells) || !(4..=KNOTS).contains(&knots.len()) {
            return Err(GiveUp);
        }
        let mut numbers = vec![Vec::with_capacity(knots.len()); cells];
        for knot in &knots {
            for (numbers, cell) in numbers.iter_mut().zip(&knot.cells) {
                numbers.push(cell.known().ok_or(GiveUp)?);
            }
        }
        let curve =
            if name == "spline" { builtin::Curve::spline(&numbers) } else { builtin::Curve::lines(&numbers) };
        let cells = self.graph.several(Op::Curve(Arc::new(curve)), &[t], cells);
        Ok(Val { shape, cells })
    }
}

/// The cells of a scalar or a vector of scalars.
fn flat(value: &Val) -> Result<&Cells, GiveUp> {
    match value.shape {
        Shape::Scalar | Shape::Vector(1..) => Ok(&value.cells),
        _ => Err(GiveUp),
    }
}

/// The cells of two scalars or vectors of one length.
fn pair(a: &Val, b: &Val) -> Result<(Cells, Cells), GiveUp> {
    let n = a.shape.len().or(b.shape.len()).unwrap_or(1);
    let spread = |v: &Val| -> Result<Cells, GiveUp> {
        let cells = flat(v)?;
        if v.shape.is_scalar() {
            Ok(Cells::from_elem(cells[0], n))
        } else if cells.len() == n {
            Ok(cells.clone())
        } else {
            Err(GiveUp)
        }
    };
    Ok((spread(a)?, spread(b)?))
}

/// As the built-in function has it, in the same order.
fn dot(graph: &mut Graph, a: &[Cell], b: &[Cell]) -> Cell {
    const THREE: Zip = |isa, args, out| {
        zip(isa, args, out, |[ax, ay, az, bx, by, bz]| ax * bx + ay * by + az * bz);
    };
    const MORE: Zip = |isa, args, out| zip(isa, args, out, |[sum, a, b]| sum + a * b);
    if let ([ax, ay, az], [bx, by, bz]) = (a, b) {
        return graph.one(Op::Zip(THREE), &[*ax, *ay, *az, *bx, *by, *bz]);
    }
    let first = graph.arith(Arith::Mul, a[0], b[0]);
    a[1..].iter().zip(&b[1..]).fold(first, |sum, (&a, &b)| graph.one(Op::Zip(MORE), &[sum, a, b]))
}

fn norm(graph: &mut Graph, v: &[Cell]) -> Cell {
    const ONE: Zip = |isa, args, out| zip(isa, args, out, |[x]: [f32; 1]| x.abs());
    const THREE: Zip = |isa, args, out| zip(isa, args, out, |[x, y, z]| (x * x + y * y + z * z).sqrt());
    const ROOT: Zip = |isa, args, out| zip(isa, args, out, |[x]: [f32; 1]| x.sqrt());
    match v {
        [x] => graph.one(Op::Zip(ONE), &[*x]),
        [x, y, z] => graph.one(Op::Zip(THREE), &[*x, *y, *z]),
        _ => {
            let square = dot(graph, v, v);
            graph.one(Op::Zip(ROOT), &[square])
        }
    }
}
