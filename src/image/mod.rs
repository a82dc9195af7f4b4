//! Images: named variables over a 2-D array of pixels; reading and writing them.

mod build;

pub use build::BuildError;

use crate::shape::Shape;
use std::borrow::Cow;

/// An image in memory. Rows run from the top; a plane holds `width * height` numbers, row after row.
#[derive(Clone, Debug, Default)]
pub struct Image<'a> {
    /// Columns held (of the data window).
    pub width: usize,
    /// Rows held (of the data window).
    pub height: usize,
    /// Its variables, in the order of the file or of assignment.
    pub variables: Vec<Variable<'a>>,
    /// The display window, the place of the held pixels in it, and what else the file's header said.
    pub metadata: Metadata,
}

/// One variable of an image: a plane of numbers for each cell of its shape.
#[derive(Clone, Debug)]
pub struct Variable<'a> {
    /// Its name in programs.
    pub name: String,
    /// Its shape, the same at every pixel.
    pub shape: Shape,
    /// `shape.cells()` planes; borrowed from the host or owned.
    pub planes: Vec<Cow<'a, [f32]>>,
}

/// What a file's header says beside its channels.
#[derive(Clone, Debug, Default)]
pub struct Metadata {
    /// Where the first held pixel lies, from the top left of the display window; may be negative.
    pub origin: [i32; 2],
    /// Columns and rows of the display window; `None` where it is the held pixels.
    pub resolution: Option<[usize; 2]>,
}

impl Image<'_> {
    /// The variable of that name.
    pub fn variable(&self, name: &str) -> Option<&Variable<'_>> {
        self.variables.iter().find(|v| v.name == name)
    }

    /// Columns and rows of the display window, which programs read as `resolution`.
    pub fn resolution(&self) -> [usize; 2] {
        self.metadata.resolution.unwrap_or([self.width, self.height])
    }
}
