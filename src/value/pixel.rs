//! A value of one pixel, apart from any batch: what frame variables hold and embedding programs exchange.

use super::{Plane, Value, show};
use crate::shape::Shape;
use std::fmt;

/// A scalar or vector, as one pixel has it.
#[derive(Clone, Debug, PartialEq)]
pub struct PixelValue {
    shape: Shape,
    cells: Vec<f32>,
}

impl PixelValue {
    /// From a shape and its cells in reading order; `None` if their numbers differ.
    pub fn new(shape: Shape, cells: Vec<f32>) -> Option<PixelValue> {
        (shape.cells() == cells.len()).then_some(PixelValue { shape, cells })
    }

    /// A vector of any values.
    pub fn vector(elements: impl IntoIterator<Item = PixelValue>) -> PixelValue {
        let mut shapes = Vec::new();
        let mut cells = Vec::new();
        for element in elements {
            shapes.push(element.shape);
            cells.extend(element.cells);
        }
        PixelValue { shape: Shape::vector_of(&shapes), cells }
    }

    /// How the cells nest.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// The numbers in reading order.
    pub fn cells(&self) -> &[f32] {
        &self.cells
    }

    /// The number, if it is one.
    pub fn as_scalar(&self) -> Option<f32> {
        self.shape.is_scalar().then(|| self.cells[0])
    }
}

impl From<f32> for PixelValue {
    fn from(x: f32) -> PixelValue {
        PixelValue { shape: Shape::Scalar, cells: vec![x] }
    }
}

impl<const N: usize> From<[f32; N]> for PixelValue {
    fn from(x: [f32; N]) -> PixelValue {
        PixelValue { shape: Shape::Vector(N as u32), cells: x.to_vec() }
    }
}

impl From<&[f32]> for PixelValue {
    fn from(x: &[f32]) -> PixelValue {
        PixelValue { shape: Shape::Vector(x.len() as u32), cells: x.to_vec() }
    }
}

/// As a program would write it.
impl fmt::Display for PixelValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&show(&self.shape, &self.cells))
    }
}

impl Value {
    /// What one lane holds.
    pub fn pixel(&self, lane: usize) -> PixelValue {
        PixelValue { shape: self.shape.clone(), cells: self.lane(lane).collect() }
    }
}

/// The same in every lane.
impl From<&PixelValue> for Value {
    fn from(pixel: &PixelValue) -> Value {
        Value { shape: pixel.shape.clone(), planes: pixel.cells.iter().map(|&x| Plane::Uniform(x)).collect() }
    }
}
