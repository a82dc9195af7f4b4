//! Images: named variables over a 2-D array of pixels; reading and writing them.
//!
//! [`read`] looks at a file's header and decides which channels are which variables (`names`, `bind`);
//! [`File::load`] then decodes only those that a program uses. [`write()`] makes files. Colours are linear
//! in memory, and premultiplied by `alpha` where there is one, as OpenEXR files hold them.

mod atomic;
mod bind;
mod bmp;
mod chroma;
mod chunk_table;
pub mod color;
mod error;
mod file;
mod frame_number;
pub(crate) mod guard;
mod hdr;
mod header_exr;
mod info;
mod jpeg;
mod layout;
mod names;
mod part_names;
mod png_chunks;
mod read_exr;
mod read_raster;
mod reading;
mod rows;
mod sampled_blocks;
mod scan_exr;
mod scan_raster;
mod sequence;
mod source;
mod stamp;
mod tga;
mod tiff;
mod unfinished;
mod write;
mod write_exr;
mod write_png;
mod write_raster;
mod write_tiff;

#[cfg(test)]
mod tests;

pub(crate) use atomic::temporary_folder;
pub use atomic::{NewFile, check_target, same_file, same_target, write_file, write_program};
pub use bind::{Binding, Candidate, Mapping};
pub use error::{ErrorKind, ImageError};
pub use file::{Channel, File, ReadOptions, Samples, read};
pub use frame_number::frame_number;
pub use info::{ChannelInfo, Info, PartInfo, info};
pub use reading::{Content, Force, protect_inputs, record, record_standard_input, recorded, set_force};
pub use rows::Rows;
pub use sequence::{Frame, MAX_FRAME, fill, has_pattern, number_in_name};
pub use source::Input;
pub use stamp::{is_whole, written_by_pse};
pub use unfinished::{Unfinished, commit, end_process};
pub use write::{Compression, Format, WriteOptions, Writer, encode, write};

mod build;

pub use build::BuildError;

use crate::shape::Shape;
use exr::meta::attribute::AttributeValue;
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
#[derive(Clone, Debug)]
pub struct Metadata {
    /// Where the first held pixel lies, from the top left of the display window; may be negative.
    pub origin: [i32; 2],
    /// Columns and rows of the display window; `None` where it is the held pixels.
    pub resolution: Option<[usize; 2]>,
    /// Where the file puts the display window's top left; nearly always `[0, 0]`, and of no effect
    /// but that an EXR file written with this metadata has it again.
    pub display_origin: [i32; 2],
    /// The width of a pixel over its height.
    pub pixel_aspect: f32,
    /// The other header attributes of an EXR file (frame rate, camera matrices, owner, …), for the
    /// files made from this image.
    pub attributes: Attributes,
}

impl Default for Metadata {
    fn default() -> Metadata {
        Metadata {
            origin: [0, 0],
            resolution: None,
            display_origin: [0, 0],
            pixel_aspect: 1.0,
            attributes: Attributes::default(),
        }
    }
}

/// A matrix of four rows, for points that are columns.
pub type Matrix4 = [[f32; 4]; 4];

/// EXR header attributes that pass through from an input to an output, sorted by name.
#[derive(Clone, Debug, Default)]
pub struct Attributes {
    pub(crate) list: Vec<(String, AttributeValue)>,
}

impl Attributes {
    /// Names and values as text, for people.
    pub fn iter(&self) -> impl Iterator<Item = (&str, String)> {
        self.list.iter().map(|(name, value)| (name.as_str(), info::attribute_text(value)))
    }

    /// The matrix of that name. OpenEXR's points are rows; here they are columns.
    pub fn matrix(&self, name: &str) -> Option<Matrix4> {
        let (_, value) = self.list.iter().find(|(n, _)| n == name)?;
        match value {
            AttributeValue::Matrix4x4(m) => {
                Some(std::array::from_fn(|row| std::array::from_fn(|column| m[column * 4 + row])))
            }
            _ => None,
        }
    }

    /// Sets the matrix of that name, for points that are columns.
    pub fn set_matrix(&mut self, name: &str, matrix: &Matrix4) {
        let rows = std::array::from_fn(|i| matrix[i % 4][i / 4]);
        self.list.retain(|(n, _)| n != name);
        self.list.push((name.to_string(), AttributeValue::Matrix4x4(rows)));
        self.list.sort_by(|a, b| a.0.cmp(&b.0));
    }
}

impl Image<'_> {
    /// The same with planes of its own.
    pub fn into_owned(self) -> Image<'static> {
        let own = |v: Variable<'_>| Variable {
            name: v.name,
            shape: v.shape,
            planes: v.planes.into_iter().map(|p| Cow::Owned(p.into_owned())).collect(),
        };
        let variables = self.variables.into_iter().map(own).collect();
        Image { width: self.width, height: self.height, variables, metadata: self.metadata }
    }

    /// In how many pixels some plane of the variables for which `of` holds is NaN or infinite.
    pub fn not_finite(&self, of: impl Fn(&str) -> bool) -> usize {
        let own = self.variables.iter().filter(|v| of(&v.name));
        let planes: Vec<&[f32]> = own.flat_map(|v| &v.planes).map(|p| &**p).collect();
        (0..self.width * self.height).filter(|&i| planes.iter().any(|p| !p[i].is_finite())).count()
    }

    /// The variable of that name.
    pub fn variable(&self, name: &str) -> Option<&Variable<'_>> {
        self.variables.iter().find(|v| v.name == name)
    }

    /// Columns and rows of the display window, which programs read as `resolution`.
    pub fn resolution(&self) -> [usize; 2] {
        self.metadata.resolution.unwrap_or([self.width, self.height])
    }
}
