//! Textures in memory alone: without the feature `exr` there is no temporary file for larger ones.

use crate::image::{ErrorKind, ImageError};
use std::sync::Arc;

/// The tiles in memory: none.
#[derive(Debug, Default)]
pub struct Tiles {}

impl Tiles {
    /// How many bytes of tiles stay in memory.
    pub fn allow(&self, _: u64) {}
}

/// A temporary file: there is none.
#[derive(Debug)]
pub(super) enum Store {}

impl Store {
    /// Always an error.
    pub fn new(_: &Arc<Tiles>) -> Result<Store, ImageError> {
        let message = "a texture needs more memory than the limit";
        Err(ImageError::new(ErrorKind::TooLarge, message)
            .hint("Allow more with `texture_memory`, or build with the feature `exr` for temporary files."))
    }

    /// Writes a tile.
    pub fn put(&self, _: u64, _: &[u8]) -> Result<(), ImageError> {
        match *self {}
    }

    /// Tells whether every tile could be read so far.
    pub fn sound(&self) -> Result<(), ImageError> {
        match *self {}
    }

    /// The tile of so many bytes that begins there.
    pub fn tile<'n>(&self, _: u64, _: usize, _: &'n mut Near) -> &'n [u8] {
        match *self {}
    }
}

/// The tiles that a look-up had last: none.
#[derive(Debug, Default)]
pub struct Near(());
