//! The texels of an image by rows of its display window, decoded a few rows at a time.

use super::source::{Opened, Pixels};
use crate::image::{self, Image, ImageError};
use std::borrow::Cow;
use std::ops::Range;

/// Rows of a file that are in memory at a time.
const BAND: usize = 64;

/// The texels of an image, by rows.
pub(super) struct Texels<'a> {
    opened: &'a Opened<'a>,
    /// A file's reader, once it is read; begun again to go back up.
    rows: Option<image::Rows<'a>>,
    /// The rows in memory, and the number of the first, counted in the data window.
    held: Option<(Cow<'a, Image<'static>>, usize)>,
    band: usize,
}

impl<'a> Texels<'a> {
    /// The texels of this image; `at_once`: all of them are decoded together.
    pub fn new(opened: &'a Opened<'a>, at_once: bool) -> Texels<'a> {
        let (held, band) = match &opened.pixels {
            Pixels::Memory(image) => (Some((Cow::Borrowed(&***image), 0)), image.height),
            Pixels::File(file) if at_once => (None, file.size()[1]),
            Pixels::File(_) => (None, BAND),
        };
        Texels { opened, rows: None, held, band }
    }

    /// A part of a row of the display window, interleaved; `turned`: from the right to the left. Beyond the pixels that
    /// the image holds there is nothing.
    ///
    /// # Errors
    /// If the file turns out damaged.
    pub fn row(
        &mut self,
        y: usize,
        columns: Range<usize>,
        turned: bool,
        out: &mut Vec<f32>,
    ) -> Result<(), ImageError> {
        out.clear();
        let wanted = &self.opened.wanted;
        let Some((image, y)) = self.image(y)? else {
            out.resize(columns.len() * wanted.shape.cells(), 0.0);
            return Ok(());
        };
        let all: Vec<&[f32]> = wanted
            .names
            .iter()
            .filter_map(|name| image.variable(name))
            .flat_map(|variable| variable.planes.iter().map(|p| &**p))
            .collect();
        let planes: Vec<&[f32]> = wanted.components.iter().map(|&i| all[i]).collect();
        let left = i64::from(image.metadata.origin[0]);
        let mut put = |column: usize| {
            let x = column as i64 - left;
            let held = (0..image.width as i64).contains(&x);
            let at = held.then(|| y * image.width + x as usize);
            out.extend(planes.iter().map(|plane| at.map_or(0.0, |at| sound(plane[at]))));
            if wanted.opaque {
                out.push(if held { 1.0 } else { 0.0 });
            }
        };
        match turned {
            true => columns.rev().for_each(&mut put),
            false => columns.for_each(&mut put),
        }
        Ok(())
    }

    /// The image in memory that holds a row of the display window, and the row's number there.
    fn image(&mut self, y: usize) -> Result<Option<(&Image<'static>, usize)>, ImageError> {
        let (top, height) = match &self.opened.pixels {
            Pixels::Memory(image) => (image.metadata.origin[1], image.height),
            Pixels::File(file) => (file.metadata().origin[1], file.size()[1]),
        };
        let y = y as i64 - i64::from(top);
        if !(0..height as i64).contains(&y) {
            return Ok(None);
        }
        let y = y as usize;
        let held = self.held.as_ref().map_or(0..0, |(image, first)| *first..first + image.height);
        if let (Pixels::File(file), false) = (&self.opened.pixels, held.contains(&y)) {
            // Down from here; up again as far as to here.
            let band = match y < held.start {
                true => (y + 1).saturating_sub(self.band)..y + 1,
                false => y..(y + self.band).min(height),
            };
            let names: Vec<&str> = self.opened.wanted.names.iter().map(String::as_str).collect();
            if y < held.start {
                self.rows = None;
            }
            self.held = None;
            let rows = match &mut self.rows {
                Some(rows) => rows,
                none => none.insert(file.rows(&names)?),
            };
            self.held = Some((Cow::Owned(rows.read(band.clone())?), band.start));
        }
        Ok(self.held.as_ref().map(|(image, first)| (&**image, y - first)))
    }
}

/// A number that averages can bear.
fn sound(x: f32) -> f32 {
    const MOST: f32 = 65504.0;
    if x.is_finite() {
        x
    } else if x.is_nan() {
        0.0
    } else {
        MOST.copysign(x)
    }
}
