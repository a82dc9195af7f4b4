//! Without the feature `raster` OpenEXR is the only format: types that have no values stand for readers and writers of the
//! others.

use super::Image;
use super::error::{ErrorKind, ImageError};
use super::file::Channel;
use super::source::Input;
use super::write::{Format, WriteOptions};
use std::convert::Infallible;
use std::io::{Seek, Write};
use std::marker::PhantomData;
use std::ops::Range;

const HINT: &str =
    "Built with the feature `raster`, the library reads and writes PNG, JPEG, TIFF, HDR, BMP, TGA and WebP.";

/// What the header of such a file says.
pub(crate) struct Raster {
    pub size: [usize; 2],
    pub format: &'static str,
    pub whole: Option<&'static str>,
    never: Infallible,
}

impl Raster {
    /// Always an error.
    pub fn open(input: &Input, _raw: bool) -> Result<Raster, ImageError> {
        let message = format!("`{}` is not an OpenEXR file", input.name());
        Err(ImageError::new(ErrorKind::UnknownFormat, message).hint(HINT))
    }

    pub fn channels(&self) -> Vec<Channel> {
        match self.never {}
    }

    pub fn notes(&self) -> Vec<String> {
        match self.never {}
    }

    pub fn working_memory(&self) -> u64 {
        match self.never {}
    }
}

/// A reader of rows.
pub(crate) struct RasterScan<'f>(Infallible, PhantomData<&'f Raster>);

impl<'f> RasterScan<'f> {
    pub fn new(raster: &'f Raster, _: &Input) -> Result<RasterScan<'f>, ImageError> {
        match raster.never {}
    }

    pub fn rows(&mut self, _: Range<usize>) -> Result<Vec<Vec<f32>>, ImageError> {
        match self.0 {}
    }
}

/// A writer.
pub(crate) struct RasterWriter(Infallible);

impl RasterWriter {
    /// Always an error.
    pub fn new(
        name: &str,
        _: Format,
        _: &Image<'_>,
        _: usize,
        _: &WriteOptions,
    ) -> Result<RasterWriter, ImageError> {
        let message = format!("cannot write `{name}`: this build writes only OpenEXR");
        Err(ImageError::new(ErrorKind::UnknownFormat, message).hint(HINT))
    }

    pub fn rows(&mut self, _: &Image<'_>, _: &mut impl Write) -> Result<(), ImageError> {
        match self.0 {}
    }

    pub fn finish(self, _: &mut (impl Write + Seek)) -> Result<(), ImageError> {
        match self.0 {}
    }
}
