//! Images: named variables over a 2-D array of pixels; reading and writing them.
//!
//! [`read`] looks at a file's header and decides which channels are which variables (`names`, `bind`);
//! [`File::load`] then decodes only those that a program uses. [`write()`] makes files. Colours are linear
//! in memory, and premultiplied by `alpha` where there is one, as OpenEXR files hold them.

#[cfg(feature = "exr")]
mod atomic;
mod attributes;
#[cfg_attr(not(feature = "exr"), allow(dead_code, reason = "most of it is about files"))]
mod bind;
#[cfg(feature = "raster")]
mod bmp;
#[cfg(feature = "exr")]
mod chroma;
#[cfg(feature = "exr")]
mod chunk_table;
pub mod color;
#[cfg_attr(not(feature = "exr"), allow(dead_code, reason = "most of it is about files"))]
mod error;
#[cfg(feature = "exr")]
mod file;
#[cfg(feature = "exr")]
mod frame_number;
#[cfg_attr(not(feature = "raster"), allow(dead_code, reason = "most of it is about files"))]
pub(crate) mod guard;
#[cfg(feature = "raster")]
mod hdr;
#[cfg(feature = "exr")]
mod header_exr;
#[cfg(feature = "exr")]
mod info;
#[cfg(feature = "raster")]
mod jpeg;
#[cfg(feature = "raster")]
mod layout;
#[cfg_attr(not(feature = "exr"), allow(dead_code, reason = "most of it is about files"))]
mod mapping;
#[cfg_attr(not(feature = "exr"), allow(dead_code, reason = "most of it is about files"))]
mod names;
#[cfg(not(feature = "exr"))]
mod no_files;
#[cfg(all(feature = "exr", not(feature = "raster")))]
mod no_raster;
#[cfg(feature = "exr")]
mod part_names;
#[cfg(feature = "raster")]
mod png_chunks;
#[cfg(feature = "exr")]
mod read_exr;
#[cfg(feature = "raster")]
mod read_raster;
#[cfg(feature = "exr")]
mod reading;
#[cfg(feature = "exr")]
mod rows;
#[cfg(feature = "exr")]
mod sampled_blocks;
#[cfg(feature = "exr")]
mod scan_exr;
#[cfg(feature = "raster")]
mod scan_raster;
mod sequence;
#[cfg(feature = "exr")]
mod source;
#[cfg(feature = "exr")]
mod stamp;
#[cfg(feature = "raster")]
mod tga;
#[cfg(feature = "raster")]
mod tiff;
#[cfg(feature = "exr")]
mod unfinished;
#[cfg(feature = "exr")]
mod write;
#[cfg(feature = "exr")]
mod write_exr;
#[cfg(feature = "raster")]
mod write_png;
#[cfg(feature = "raster")]
mod write_raster;
#[cfg(feature = "raster")]
mod write_tiff;

#[cfg(all(test, feature = "raster", feature = "threads"))]
mod tests;

#[cfg(feature = "exr")]
pub(crate) use atomic::temporary_folder;
#[cfg(feature = "exr")]
pub use atomic::{NewFile, TargetKey, check_target, same_file, target_keys, write_file, write_program};
pub use attributes::Attributes;
pub use bind::{Binding, Candidate};
pub use error::{ErrorKind, ImageError};
#[cfg(feature = "exr")]
pub use file::{Channel, File, ReadOptions, Samples, read};
#[cfg(feature = "exr")]
pub use frame_number::frame_number;
#[cfg(feature = "exr")]
pub use info::{ChannelInfo, Info, PartInfo, info};
pub use mapping::Mapping;
#[cfg(not(feature = "exr"))]
pub use no_files::{File, Input, ReadOptions, Rows, read};
#[cfg(feature = "exr")]
pub use reading::{Content, Force, protect_inputs, record, record_standard_input, recorded, set_force};
#[cfg(feature = "exr")]
pub use rows::Rows;
pub use sequence::{Frame, MAX_FRAME, fill, has_pattern, number_in_name};
#[cfg(feature = "exr")]
pub use source::Input;
#[cfg(feature = "exr")]
pub use stamp::{is_whole, written_by_pse};
#[cfg(feature = "exr")]
pub use unfinished::{Unfinished, commit, end_process};
#[cfg(feature = "exr")]
pub use write::{Compression, Format, WriteOptions, Writer, encode, write};

#[cfg(all(feature = "exr", not(feature = "raster")))]
use no_raster::{Raster, RasterScan, RasterWriter};
#[cfg(feature = "raster")]
use {read_raster::Raster, scan_raster::RasterScan, write_raster::RasterWriter};

mod build;

pub use build::BuildError;

use crate::shape::Shape;
use std::borrow::Cow;

/// An image in memory. Rows start at the top; a plane holds `width * height` numbers, row by row.
#[derive(Clone, Debug, Default)]
pub struct Image<'a> {
    /// Columns held (of the data window).
    pub width: usize,
    /// Rows held (of the data window).
    pub height: usize,
    /// Its variables, in the order of the file or of assignment.
    pub variables: Vec<Variable<'a>>,
    /// The display window, the position of the stored pixels in it, and other data of the file's header.
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

/// The data of a file's header other than its channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Metadata {
    /// The position of the first stored pixel, from the top left of the display window; may be negative.
    pub origin: [i32; 2],
    /// Columns and rows of the display window; `None` if it is the stored pixels.
    pub resolution: Option<[usize; 2]>,
    /// The top left of the display window in the file's coordinates, nearly always `[0, 0]`. It only affects EXR
    /// files written with this metadata.
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

impl Image<'_> {
    /// Converts the planes to owned ones.
    pub fn into_owned(self) -> Image<'static> {
        let own = |v: Variable<'_>| Variable {
            name: v.name,
            shape: v.shape,
            planes: v.planes.into_iter().map(|p| Cow::Owned(p.into_owned())).collect(),
        };
        let variables = self.variables.into_iter().map(own).collect();
        Image { width: self.width, height: self.height, variables, metadata: self.metadata }
    }

    /// Counts the pixels at which a plane of a variable accepted by `of` is NaN or infinite.
    pub fn not_finite(&self, of: impl Fn(&str) -> bool) -> usize {
        let own = self.variables.iter().filter(|v| of(&v.name));
        let planes: Vec<&[f32]> = own.flat_map(|v| &v.planes).map(|p| &**p).collect();
        (0..self.width * self.height).filter(|&i| planes.iter().any(|p| !p[i].is_finite())).count()
    }

    /// Finds the variable with this name.
    pub fn variable(&self, name: &str) -> Option<&Variable<'_>> {
        self.variables.iter().find(|v| v.name == name)
    }

    /// Columns and rows of the display window, which programs read as `resolution`.
    pub fn resolution(&self) -> [usize; 2] {
        self.metadata.resolution.unwrap_or([self.width, self.height])
    }
}
