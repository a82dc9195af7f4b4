//! Without the feature `exr` there are no files: types that have no values stand for them, so that nothing else has to
//! know.

use super::{Binding, Image, ImageError, Mapping, Metadata};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Where to read an image from: nowhere.
#[derive(Clone, Debug)]
pub enum Input {}

impl Input {
    /// The path.
    pub fn path(&self) -> Option<&Path> {
        match *self {}
    }

    /// Another file in the place of this one.
    pub(crate) fn with_path(&self, _: PathBuf) -> Input {
        match *self {}
    }

    /// Whether both have the same bytes in memory.
    pub(crate) fn same_bytes(&self, _: &Input) -> bool {
        match *self {}
    }
}

/// Options for reading.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// The user's mappings (`--map`).
    pub maps: Vec<Mapping>,
    /// Take the numbers as they are stored.
    pub raw: bool,
}

/// A file: there is none.
pub enum File {}

/// Reads the header of an image.
///
/// # Errors
/// None: there is no input.
pub fn read(input: Input, _: &ReadOptions) -> Result<File, ImageError> {
    match input {}
}

impl File {
    /// The name in messages.
    pub fn name(&self) -> String {
        match *self {}
    }

    /// How many bytes the file has.
    pub(crate) fn length(&self) -> Result<u64, ImageError> {
        match *self {}
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        match *self {}
    }

    /// The windows and the other header attributes.
    pub fn metadata(&self) -> &Metadata {
        match *self {}
    }

    /// All variables.
    pub fn variables(&self) -> &[Binding] {
        match *self {}
    }

    /// Whether rows can be decoded without those above them.
    pub fn seeks(&self) -> bool {
        match *self {}
    }

    /// The reader of these variables.
    ///
    /// # Errors
    /// None: there is no file.
    pub fn rows(&self, _: &[&str]) -> Result<Rows<'_>, ImageError> {
        match *self {}
    }
}

/// The rows of a file, from the top down.
pub enum Rows<'f> {
    /// Of no file.
    Of(&'f File),
}

impl Rows<'_> {
    /// These rows of the variables.
    ///
    /// # Errors
    /// None: there is no file.
    pub fn read(&mut self, _: Range<usize>) -> Result<Image<'static>, ImageError> {
        match self {
            Rows::Of(file) => match **file {},
        }
    }
}
