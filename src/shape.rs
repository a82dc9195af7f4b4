//! The shape of a value: a scalar, or a vector of scalars and vectors to any depth.
//!
//! A value's numbers lie flat, one plane a *cell* (a scalar somewhere in it), in reading order;
//! its shape tells how they nest. `[[1 2] 3]` has three cells and the shape `Nested([Vector(2), Scalar])`.

use std::fmt;
use std::sync::Arc;

/// The nesting of a value. [`Shape::vector_of`] keeps it canonical: a list whose elements are all scalars is always
/// [`Shape::Vector`], so `==` compares meaning.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Shape {
    /// A number.
    Scalar,
    /// A vector of this many scalars; `Vector(0)` is `[]`.
    Vector(u32),
    /// A vector with at least one element that is itself a vector.
    Nested(Arc<[Shape]>),
}

impl Shape {
    /// The shape of a vector with elements of these shapes.
    pub fn vector_of(elements: &[Shape]) -> Shape {
        if elements.iter().all(Shape::is_scalar) {
            Shape::Vector(elements.len() as u32)
        } else {
            Shape::Nested(elements.into())
        }
    }

    /// Whether the value is a scalar.
    pub fn is_scalar(&self) -> bool {
        matches!(self, Shape::Scalar)
    }

    /// The number of cells: scalars at any depth.
    pub fn cells(&self) -> usize {
        match self {
            Shape::Scalar => 1,
            Shape::Vector(n) => *n as usize,
            Shape::Nested(elements) => elements.iter().map(Shape::cells).sum(),
        }
    }

    /// The number of elements at the outermost level; `None` for a scalar.
    pub fn len(&self) -> Option<usize> {
        match self {
            Shape::Scalar => None,
            Shape::Vector(n) => Some(*n as usize),
            Shape::Nested(elements) => Some(elements.len()),
        }
    }

    /// The number of scalars and vectors at any depth, and the nesting depth. Vectors of empty vectors have no cells
    /// but can be large.
    pub fn extent(&self) -> (usize, usize) {
        match self {
            Shape::Scalar => (1, 0),
            Shape::Vector(n) => (1 + *n as usize, 1),
            Shape::Nested(elements) => elements
                .iter()
                .map(Shape::extent)
                .fold((1, 1), |whole, part| (whole.0.saturating_add(part.0), whole.1.max(part.1 + 1))),
        }
    }

    /// Whether the value is the empty vector.
    pub fn is_empty(&self) -> bool {
        self.len() == Some(0)
    }

    /// The shape of element `i`, counted from 0.
    ///
    /// # Panics
    /// If it is a scalar or has no such element.
    pub fn element(&self, i: usize) -> Shape {
        match self {
            Shape::Nested(elements) => elements[i].clone(),
            Shape::Vector(n) if i < *n as usize => Shape::Scalar,
            _ => panic!("{self} has no element {i}"),
        }
    }

    /// The range of cells that element `i`, counted from 0, occupies.
    pub fn cells_of(&self, i: usize) -> std::ops::Range<usize> {
        match self {
            Shape::Nested(elements) => {
                let start = elements[..i].iter().map(Shape::cells).sum();
                start..start + elements[i].cells()
            }
            _ => i..i + 1,
        }
    }

    /// The shapes of the elements; none for a scalar.
    pub fn elements(&self) -> impl Iterator<Item = Shape> + '_ {
        (0..self.len().unwrap_or(0)).map(|i| self.element(i))
    }
}

/// In words, as the messages say it: "a scalar", "a vector of 3", "a vector of 2 vectors of 3".
impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Shape::Scalar => write!(f, "a scalar"),
            Shape::Vector(0) => write!(f, "an empty vector"),
            Shape::Vector(n) => write!(f, "a vector of {n}"),
            Shape::Nested(elements) => {
                let n = elements.len();
                let first = &elements[0];
                match first.len() {
                    Some(m) if elements.iter().all(|e| matches!(e, Shape::Vector(k) if *k as usize == m)) => {
                        let s = if n == 1 { "" } else { "s" };
                        write!(f, "a vector of {n} vector{s} of {m}")
                    }
                    _ => write!(f, "a vector of {n} with nested vectors"),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_of_scalars_is_a_plain_vector() {
        assert_eq!(Shape::vector_of(&[Shape::Scalar, Shape::Scalar]), Shape::Vector(2));
        let nested = Shape::vector_of(&[Shape::Vector(2), Shape::Scalar]);
        assert_eq!(nested.cells(), 3);
        assert_eq!(nested.cells_of(1), 2..3);
        assert_eq!(nested.len(), Some(2));
    }

    #[test]
    fn shapes_read_as_words() {
        let rows = Shape::vector_of(&[Shape::Vector(3), Shape::Vector(3)]);
        assert_eq!(rows.to_string(), "a vector of 2 vectors of 3");
        assert_eq!(Shape::Vector(0).to_string(), "an empty vector");
    }
}
