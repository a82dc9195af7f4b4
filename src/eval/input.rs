//! The variables that pixels are read from: those of an image, or a host's own buffers with strides.

use super::pixels::Pixels;
use crate::image::{Image, Metadata, Variable};
use crate::shape::Shape;
use crate::value::{Lanes, Plane};
use std::borrow::Cow;

/// How a buffer of `f32` holds a variable: distances are counted in numbers, not in bytes.
///
/// ```
/// use pse::Strides;
///
/// // RGBA, interleaved, 640 pixels a row, the first row at the top; and the same with the last row first.
/// let top_down = Strides::interleaved(4, 640);
/// let bottom_up = top_down.bottom_up(480);
/// assert_eq!((top_down.row, bottom_up.row), (2560, -2560));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Strides {
    /// The index of the first component of the top left pixel.
    pub start: usize,
    /// From a component to the next one of the same pixel.
    pub component: usize,
    /// From a pixel to the next one of its row.
    pub pixel: usize,
    /// From a row to the row below it; negative where the last row comes first.
    pub row: isize,
}

impl Strides {
    /// A plane of `width * height` numbers for each component, one plane after the other.
    pub fn planar(width: usize, height: usize) -> Strides {
        let component = width.saturating_mul(height);
        Strides { start: 0, component, pixel: 1, row: width as isize }
    }

    /// Pixels of `components` numbers each, row after row.
    pub fn interleaved(components: usize, width: usize) -> Strides {
        Strides { start: 0, component: 1, pixel: components, row: components.saturating_mul(width) as isize }
    }

    /// The same buffer with its `height` rows in the opposite order.
    #[must_use]
    pub fn bottom_up(self, height: usize) -> Strides {
        let last = self.row.unsigned_abs().saturating_mul(height.saturating_sub(1));
        let start =
            if self.row < 0 { self.start.saturating_sub(last) } else { self.start.saturating_add(last) };
        Strides { start, row: -self.row, ..self }
    }

    /// The same buffer where the variable begins at another component, as alpha in an RGBA buffer.
    #[must_use]
    pub fn from_component(self, first: usize) -> Strides {
        Strides { start: self.start.saturating_add(first.saturating_mul(self.component)), ..self }
    }

    /// Whether every component of an image lies inside of a buffer of `length` numbers.
    pub(crate) fn fits(&self, [width, height]: [usize; 2], components: usize, length: usize) -> bool {
        let numbers = width.checked_mul(height).and_then(|pixels| pixels.checked_mul(components));
        match numbers {
            Some(0) => return true,
            Some(count) if count <= isize::MAX as usize / size_of::<f32>() => {}
            _ => return false,
        }
        let last = |count: usize, step: usize| {
            i128::try_from((count - 1) as u128 * step as u128).unwrap_or(i128::MAX)
        };
        let rows = (height as i128 - 1) * self.row as i128;
        let first = self.start as i128 + rows.min(0);
        let end = self.start as i128
            + rows.max(0)
            + last(width, self.pixel).saturating_add(last(components, self.component));
        first >= 0 && end < length as i128
    }

    /// The index of a component of a pixel, which [`Strides::fits`] has found inside.
    #[inline(always)]
    pub(crate) fn index(&self, column: usize, row: usize, component: usize) -> usize {
        let start = self.start as isize + row as isize * self.row;
        start as usize + column * self.pixel + component * self.component
    }
}

/// One component of a variable at all pixels.
#[derive(Clone, Copy)]
pub(super) struct Samples<'r> {
    data: &'r [f32],
    width: usize,
    start: usize,
    pixel: usize,
    row: isize,
}

impl<'r> Samples<'r> {
    /// A plane of which the pixels follow one another.
    pub fn plane(data: &'r [f32], width: usize) -> Samples<'r> {
        Samples { data, width: width.max(1), start: 0, pixel: 1, row: width as isize }
    }

    fn strided(data: &'r [f32], width: usize, strides: &Strides, component: usize) -> Samples<'r> {
        let start = strides.index(0, 0, component);
        Samples { data, width: width.max(1), start, pixel: strides.pixel, row: strides.row }
    }

    /// All pixels one after another, if the buffer holds them so.
    pub fn contiguous(&self) -> Option<&'r [f32]> {
        let whole = self.pixel == 1 && self.row == self.width as isize;
        self.data.get(self.start..).filter(|_| whole)
    }

    /// The number at a pixel.
    #[inline]
    pub fn at(&self, pixel: usize) -> f32 {
        let (column, row) = (pixel % self.width, pixel / self.width);
        let start = self.start as isize + row as isize * self.row;
        self.data[start as usize + column * self.pixel]
    }

    /// Copies pixels that follow one another.
    pub fn copy(&self, first: usize, out: &mut [f32]) {
        if let Some(plane) = self.contiguous() {
            out.copy_from_slice(&plane[first..first + out.len()]);
            return;
        }
        let (mut column, mut row) = (first % self.width, first / self.width);
        let mut rest = out;
        while !rest.is_empty() {
            let (part, after) = rest.split_at_mut(rest.len().min(self.width - column));
            let start = (self.start as isize + row as isize * self.row) as usize + column * self.pixel;
            copy_step(&self.data[start..], self.pixel, part);
            (column, row, rest) = (0, row + 1, after);
        }
    }

    /// The numbers at a batch's pixels.
    pub fn gather(&self, pixels: Pixels<'_>) -> Plane {
        Plane::Varying(Lanes::filled(pixels.len(), |out| match pixels {
            Pixels::Run(start, _) => self.copy(start, out),
            Pixels::List(list) => {
                for (out, &pixel) in out.iter_mut().zip(list) {
                    *out = self.at(pixel);
                }
            }
        }))
    }
}

/// Copies every `step`-th number.
#[inline]
fn copy_step(from: &[f32], step: usize, to: &mut [f32]) {
    match step {
        // The usual numbers of components, as loops that the compiler can unroll.
        3 => from.chunks(3).zip(to).for_each(|(from, to)| *to = from[0]),
        4 => from.chunks(4).zip(to).for_each(|(from, to)| *to = from[0]),
        step => to.iter_mut().enumerate().for_each(|(i, to)| *to = from[i * step]),
    }
}

/// A variable of the input.
#[derive(Clone, Copy)]
pub(super) struct InputVariable<'r> {
    pub name: &'r str,
    pub shape: &'r Shape,
    width: usize,
    data: Data<'r>,
}

#[derive(Clone, Copy)]
enum Data<'r> {
    Planes(&'r [Cow<'r, [f32]>]),
    Strided(&'r [f32], Strides),
}

impl<'r> InputVariable<'r> {
    fn of_image(variable: &'r Variable<'r>, width: usize) -> InputVariable<'r> {
        let data = Data::Planes(&variable.planes);
        InputVariable { name: &variable.name, shape: &variable.shape, width, data }
    }

    fn of_view(view: &'r BufferView<'r>, width: usize) -> InputVariable<'r> {
        InputVariable {
            name: view.name,
            shape: &view.shape,
            width,
            data: Data::Strided(view.data, view.strides),
        }
    }

    /// One component at all pixels.
    #[inline]
    pub fn plane(&self, component: usize) -> Samples<'r> {
        match self.data {
            Data::Planes(planes) => Samples::plane(&planes[component], self.width),
            Data::Strided(data, strides) => Samples::strided(data, self.width, &strides, component),
        }
    }

    /// All components.
    pub fn planes(&self) -> impl Iterator<Item = Samples<'r>> + '_ {
        (0..self.shape.cells()).map(|component| self.plane(component))
    }

    /// Whether the pixels of each component follow one another.
    pub fn is_contiguous(&self) -> bool {
        match self.data {
            Data::Planes(_) => true,
            Data::Strided(_, strides) => strides.pixel == 1 && strides.row == self.width as isize,
        }
    }

    /// Why its planes do not fit an image of `pixels` pixels.
    fn fault(&self, pixels: usize) -> Option<String> {
        // The strides of a host's buffer were checked with its size.
        let Data::Planes(planes) = self.data else { return None };
        let (name, cells) = (self.name, self.shape.cells());
        if planes.len() != cells {
            return Some(format!(
                "`{name}` is {} and has {} planes instead of {cells}",
                self.shape,
                planes.len()
            ));
        }
        let wrong = planes.iter().map(|p| p.len()).find(|&n| n != pixels)?;
        Some(format!("a plane of `{name}` holds {wrong} numbers for {pixels} pixels"))
    }
}

/// What a program runs on.
#[derive(Clone, Copy)]
pub(super) struct Inputs<'r> {
    pub width: usize,
    pub height: usize,
    pub metadata: &'r Metadata,
    variables: Variables<'r>,
    /// Variables that were made anew for a sample; they follow the others.
    sampled: &'r [Variable<'r>],
}

#[derive(Clone, Copy)]
enum Variables<'r> {
    Image(&'r [Variable<'r>]),
    Views(&'r [BufferView<'r>]),
}

impl<'r> Inputs<'r> {
    /// The variables of an image.
    pub fn of(image: &'r Image<'r>) -> Inputs<'r> {
        Inputs {
            width: image.width,
            height: image.height,
            metadata: &image.metadata,
            variables: Variables::Image(&image.variables),
            sampled: &[],
        }
    }

    /// A host's buffers, whose strides were found to fit.
    pub fn of_buffers(size: [usize; 2], metadata: &'r Metadata, buffers: &'r [BufferView<'r>]) -> Inputs<'r> {
        let variables = Variables::Views(buffers);
        Inputs { width: size[0], height: size[1], metadata, variables, sampled: &[] }
    }

    /// The same, followed by variables that were made anew for a sample.
    pub fn with_sampled(self, sampled: Option<&'r Image<'r>>) -> Inputs<'r> {
        Inputs { sampled: sampled.map_or(&[], |image| &image.variables), ..self }
    }

    /// How many variables there are, without those of a sample.
    fn own(&self) -> usize {
        match self.variables {
            Variables::Image(list) => list.len(),
            Variables::Views(list) => list.len(),
        }
    }

    /// The variable of a number.
    #[inline]
    pub fn get(&self, number: usize) -> InputVariable<'r> {
        let own = self.own();
        match self.variables {
            _ if number >= own => InputVariable::of_image(&self.sampled[number - own], self.width),
            Variables::Image(list) => InputVariable::of_image(&list[number], self.width),
            Variables::Views(list) => InputVariable::of_view(&list[number], self.width),
        }
    }

    /// All variables, without those of a sample.
    pub fn iter(&self) -> impl Iterator<Item = InputVariable<'r>> + '_ {
        (0..self.own()).map(|number| self.get(number))
    }

    /// The number of the variable of that name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.iter().position(|v| v.name == name)
    }

    /// The number of the variable of that name that was made anew for a sample.
    pub fn find_sampled(&self, name: &str) -> Option<usize> {
        self.sampled.iter().position(|v| v.name == name).map(|at| self.own() + at)
    }

    /// The names of all variables.
    pub fn names(&self) -> Vec<String> {
        self.iter().map(|v| v.name.to_string()).collect()
    }

    /// Columns and rows of the display window.
    pub fn resolution(&self) -> [usize; 2] {
        self.metadata.resolution.unwrap_or([self.width, self.height])
    }

    /// What is wrong with them, if the planes are not those of the size.
    pub fn fault(&self) -> Option<String> {
        let (width, height) = (self.width, self.height);
        match width.checked_mul(height).filter(|&n| n <= isize::MAX as usize / size_of::<f32>()) {
            None => Some(format!("an image of {width} x {height} pixels is too large")),
            Some(pixels) => self.iter().find_map(|variable| variable.fault(pixels)),
        }
    }
}

/// A variable in a host's buffer, which a run reads.
#[derive(Clone, Debug)]
pub struct BufferView<'a> {
    /// Its name in programs.
    pub name: &'a str,
    /// Its shape: a scalar, or a vector with as many components as the buffer has for each pixel.
    pub shape: Shape,
    /// The numbers.
    pub data: &'a [f32],
    /// Where each number lies.
    pub strides: Strides,
}

/// A variable in a host's buffer, which a run writes.
#[derive(Debug)]
pub struct BufferViewMut<'a> {
    /// The program's variable.
    pub name: &'a str,
    /// Components that are written: a scalar is repeated in all of them, and an opaque colour in four has an alpha of 1.
    pub components: usize,
    /// The numbers. Those that belong to no pixel stay as they are.
    pub data: &'a mut [f32],
    /// Where each number lies.
    pub strides: Strides,
}
