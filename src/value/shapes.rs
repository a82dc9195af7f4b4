//! Operators component by component: how scalars meet vectors, at any depth.

use super::{Plane, Planes, Value};
use crate::shape::Shape;

/// Two values whose shapes cannot meet: their lengths differ at some level.
#[derive(Clone, Debug, PartialEq)]
pub struct Mismatch {
    /// The length on the left, at the level where they differ.
    pub left: usize,
    /// The length on the right.
    pub right: usize,
}

/// The shape that an operator's result has: a scalar is used with each component of a vector, recursively.
pub fn broadcast_shape(a: &Shape, b: &Shape) -> Result<Shape, Mismatch> {
    match (a, b) {
        _ if a == b => Ok(a.clone()),
        (Shape::Scalar, shape) | (shape, Shape::Scalar) => Ok(shape.clone()),
        _ => {
            let (left, right) = (a.len().unwrap_or(0), b.len().unwrap_or(0));
            if left != right {
                return Err(Mismatch { left, right });
            }
            let elements: Result<Vec<Shape>, Mismatch> =
                (0..left).map(|i| broadcast_shape(&a.element(i), &b.element(i))).collect();
            Ok(Shape::vector_of(&elements?))
        }
    }
}

/// For each cell of `to`, the cell of `from` that it takes, where `from` broadcasts to `to`.
fn cell_map(from: &Shape, to: &Shape, first: usize, out: &mut Vec<usize>) {
    match from {
        _ if from == to => out.extend(first..first + from.cells()),
        Shape::Scalar => out.extend(std::iter::repeat_n(first, to.cells())),
        _ => {
            for i in 0..from.len().unwrap_or(0) {
                cell_map(&from.element(i), &to.element(i), first + from.cells_of(i).start, out);
            }
        }
    }
}

/// Applies `f` to the cells of any number of values that broadcast together.
pub fn map_cells<const K: usize>(
    args: [&Value; K],
    mut f: impl FnMut([&Plane; K]) -> Plane,
) -> Result<Value, Mismatch> {
    let mut shape = args[0].shape.clone();
    for arg in &args[1..] {
        shape = broadcast_shape(&shape, &arg.shape)?;
    }
    let cells = shape.cells();
    let simple = |v: &Value| v.shape == shape || v.shape.is_scalar();
    let planes: Planes = if args.iter().all(|v| simple(v)) {
        let step = args.map(|v| usize::from(!v.shape.is_scalar()));
        let mut planes = Planes::with_capacity(cells);
        for c in 0..cells {
            planes.push(f(std::array::from_fn(|k| &args[k].planes[c * step[k]])));
        }
        planes
    } else {
        let maps = args.map(|v| {
            let mut map = Vec::with_capacity(cells);
            cell_map(&v.shape, &shape, 0, &mut map);
            map
        });
        (0..cells).map(|c| f(std::array::from_fn(|k| &args[k].planes[maps[k][c]]))).collect()
    };
    Ok(Value { shape, planes })
}

/// Applies `f` to each cell of one value.
pub fn map1(a: &Value, mut f: impl FnMut(&Plane) -> Plane) -> Value {
    Value { shape: a.shape.clone(), planes: a.planes.iter().map(&mut f).collect() }
}

/// Applies `f` to the cells of two values.
pub fn binary(a: &Value, b: &Value, mut f: impl FnMut(&Plane, &Plane) -> Plane) -> Result<Value, Mismatch> {
    map_cells([a, b], |[a, b]| f(a, b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn add(a: &Value, b: &Value) -> Result<Value, Mismatch> {
        binary(a, b, |a, b| Plane::Uniform(a.lane(0) + b.lane(0)))
    }

    #[test]
    fn scalars_meet_vectors_at_every_depth() {
        let v = Value::uniform_vector(&[1.0, 2.0]);
        let m = Value::vector_of([v.clone(), Value::uniform_vector(&[3.0, 4.0])]);
        assert_eq!(add(&m, &Value::uniform(10.0)).unwrap().show(0), "[[11 12] [13 14]]");
        assert_eq!(add(&v, &m).unwrap().show(0), "[[2 3] [5 6]]");
        assert_eq!(add(&m, &v).unwrap().show(0), "[[2 3] [5 6]]");
    }

    #[test]
    fn lengths_must_agree() {
        let error = add(&Value::uniform_vector(&[1.0, 2.0]), &Value::uniform_vector(&[1.0]));
        assert_eq!(error.unwrap_err(), Mismatch { left: 2, right: 1 });
    }
}
