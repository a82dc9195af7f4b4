//! Values of a batch of pixels: planes of lanes, masks, and the component-by-component operators.
//!
//! A *lane* is one pixel's place in a batch. A *plane* holds one number a lane, or one number for all
//! of them (*uniform*). A value is a shape and a plane for each of its cells. A *mask* says which
//! lanes are active; lanes that are off hold numbers without meaning, which nothing may depend on.

mod mask;
mod pixel;
mod plane;
mod shapes;

pub use mask::{Mask, Width};
pub use pixel::PixelValue;
pub use plane::{Lanes, Plane, live_bytes};
pub use shapes::{Mismatch, binary, broadcast_shape, map_cells, map1};

use crate::shape::Shape;
use smallvec::{SmallVec, smallvec};

/// The planes of a value; a colour or a point with alpha needs no heap.
pub type Planes = SmallVec<[Plane; 4]>;

/// One value, for every lane of a batch. All lanes have the same shape.
#[derive(Clone, Debug)]
pub struct Value {
    /// How the cells nest.
    pub shape: Shape,
    /// One plane a cell.
    pub planes: Planes,
}

impl Value {
    /// The same number in every lane.
    pub fn uniform(number: f32) -> Value {
        Value::scalar(Plane::Uniform(number))
    }

    /// A scalar.
    pub fn scalar(plane: Plane) -> Value {
        Value { shape: Shape::Scalar, planes: smallvec![plane] }
    }

    /// A vector of scalars.
    pub fn vector(planes: Planes) -> Value {
        Value { shape: Shape::Vector(planes.len() as u32), planes }
    }

    /// A vector of scalars, the same in every lane.
    pub fn uniform_vector(numbers: &[f32]) -> Value {
        Value::vector(numbers.iter().map(|&x| Plane::Uniform(x)).collect())
    }

    /// A vector of the given elements.
    pub fn vector_of(elements: impl IntoIterator<Item = Value>) -> Value {
        let mut planes = Planes::new();
        let mut shapes: SmallVec<[Shape; 4]> = SmallVec::new();
        for element in elements {
            shapes.push(element.shape);
            planes.extend(element.planes);
        }
        Value { shape: Shape::vector_of(&shapes), planes }
    }

    /// Element `i`, counted from 0.
    ///
    /// # Panics
    /// If it is a scalar or has no such element.
    pub fn element(&self, i: usize) -> Value {
        let range = self.shape.cells_of(i);
        Value { shape: self.shape.element(i), planes: self.planes[range].iter().cloned().collect() }
    }

    /// The elements of a vector in order; none for a scalar.
    pub fn elements(&self) -> impl Iterator<Item = Value> + '_ {
        (0..self.shape.len().unwrap_or(0)).map(|i| self.element(i))
    }

    /// Is it the same in every lane?
    pub fn is_uniform(&self) -> bool {
        self.planes.iter().all(|p| matches!(p, Plane::Uniform(_)))
    }

    /// The number, if it is a scalar and the same in every lane.
    pub fn as_uniform(&self) -> Option<f32> {
        match (&self.shape, self.planes.first()) {
            (Shape::Scalar, Some(Plane::Uniform(x))) => Some(*x),
            _ => None,
        }
    }

    /// The cells of one lane, in reading order.
    pub fn lane(&self, lane: usize) -> impl Iterator<Item = f32> + '_ {
        self.planes.iter().map(move |p| p.lane(lane))
    }

    /// What one lane holds, as a program would write it: `[0.5 [1 2]]`.
    pub fn show(&self, lane: usize) -> String {
        let cells: Vec<f32> = self.lane(lane).collect();
        let mut text = String::new();
        // As much as a matrix: what a message shows of a value is to recognise it.
        show_part(&self.shape, &cells, &mut 16, &mut text);
        text
    }
}

/// A value of one pixel as a program would write it; long vectors are cut with `…`.
pub fn show(shape: &Shape, cells: &[f32]) -> String {
    let mut text = String::new();
    show_part(shape, cells, &mut 64, &mut text);
    text
}

/// Adds a value to the text. No more than `left` numbers and empty vectors are shown: vectors of vectors can
/// be large at each level.
fn show_part(shape: &Shape, cells: &[f32], left: &mut usize, text: &mut String) {
    const ELEMENTS: usize = 16;
    let Some(n) = shape.len() else {
        *left = left.saturating_sub(1);
        text.push_str(&number(cells[0]));
        return;
    };
    if n == 0 {
        *left = left.saturating_sub(1);
    }
    text.push('[');
    for i in 0..n {
        if i > 0 {
            text.push(' ');
        }
        if *left == 0 || i == ELEMENTS {
            text.push_str(&format!("… {} more", n - i));
            break;
        }
        show_part(&shape.element(i), &cells[shape.cells_of(i)], left, text);
    }
    text.push(']');
}

/// A number as messages show it: the shortest digits that read back as the same float.
pub fn number(x: f32) -> String {
    let magnitude = x.abs();
    if x.is_nan() {
        "NaN".into()
    } else if x.is_infinite() {
        if x > 0.0 { "infinity" } else { "-infinity" }.into()
    } else if magnitude != 0.0 && !(1e-5..1e9).contains(&magnitude) {
        format!("{x:e}")
    } else {
        format!("{x}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_of_nested_vectors() {
        let row = Value::uniform_vector(&[1.0, 2.0]);
        let v = Value::vector_of([row, Value::uniform(3.0)]);
        assert_eq!(v.show(0), "[[1 2] 3]");
        assert_eq!(v.element(1).as_uniform(), Some(3.0));
        assert_eq!(v.element(0).show(0), "[1 2]");
    }

    #[test]
    fn what_is_shown_is_short_for_any_value() {
        let row = Value::uniform_vector(&[1.0; 20]);
        assert!(row.show(0).ends_with("1 1 1 … 4 more]"));
        let mut nested = Value::uniform_vector(&[1.0, 2.0]);
        for _ in 0..12 {
            nested = Value::vector_of([nested.clone(), nested]);
        }
        assert!(nested.show(0).len() < 400, "{}", nested.show(0));
    }

    #[test]
    fn numbers_read_as_written() {
        assert_eq!(number(0.1), "0.1");
        assert_eq!(number(f32::NEG_INFINITY), "-infinity");
        assert_eq!(number(1e-9), "1e-9");
    }
}
