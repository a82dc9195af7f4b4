//! A file's variables a few rows at a time, so that an image need not be in memory as a whole.

use super::error::{ErrorKind, ImageError};
use super::file::{File, Source};
use super::scan_exr::{Scan, working_memory};
use super::scan_raster::RasterScan;
use super::source::Input;
use super::{Image, Variable, guard};
use crate::shape::Shape;
use std::borrow::Cow;
use std::ops::Range;

/// Some variables of a file, read from the top down.
///
/// EXR and PNG files are decoded as far as the rows that are asked for; of other formats the picture is decoded when
/// the first row is.
pub struct Rows<'f> {
    file: &'f File,
    /// Name, shape and channels of each variable.
    variables: Vec<(String, Shape, Vec<usize>)>,
    wanted: Vec<bool>,
    pixels: Decoded<'f>,
    /// A plane for each wanted channel of the file, of the rows that are in memory.
    planes: Vec<Vec<f32>>,
    /// Which rows those are.
    held: Range<usize>,
    /// The rows before this one have been decoded.
    done: usize,
}

enum Decoded<'f> {
    Exr(Scan<'f>),
    Raster(RasterScan<'f>),
}

impl File {
    /// Prepares to read these variables, in this order, and nothing else.
    ///
    /// # Errors
    /// If one is missing or ambiguous, or the file cannot be opened.
    pub fn rows(&self, names: &[&str]) -> Result<Rows<'_>, ImageError> {
        let mut wanted = vec![false; self.channels.len()];
        let mut variables = Vec::new();
        for name in names {
            let found = self.find(name)?;
            found.channels.iter().for_each(|&c| wanted[c] = true);
            variables.push((name.to_string(), found.shape.clone(), found.channels.clone()));
        }
        self.rows_of(variables, wanted)
    }

    /// Prepares to read all channels, each as a scalar under its full name, whatever programs would call it.
    ///
    /// # Errors
    /// If the file cannot be opened.
    pub fn channel_rows(&self) -> Result<Rows<'_>, ImageError> {
        let variables = self.channels.iter().enumerate();
        let variables = variables.map(|(i, c)| (c.name.clone(), Shape::Scalar, vec![i])).collect();
        self.rows_of(variables, vec![true; self.channels.len()])
    }

    fn rows_of(
        &self,
        variables: Vec<(String, Shape, Vec<usize>)>,
        wanted: Vec<bool>,
    ) -> Result<Rows<'_>, ImageError> {
        let pixels = match &self.source {
            Source::Exr(exr) => Decoded::Exr(Scan::new(exr, &self.input, &self.channels, &wanted)?),
            Source::Raster(raster) => Decoded::Raster(RasterScan::new(raster, &self.input)?),
        };
        let planes = vec![Vec::new(); wanted.len()];
        Ok(Rows { file: self, variables, wanted, pixels, planes, held: 0..0, done: 0 })
    }

    /// Can its rows be read one after another, without the whole picture in memory?
    pub fn streams(&self) -> bool {
        self.whole().is_none()
    }

    /// Are its lower rows read without those above?
    pub(crate) fn seeks(&self) -> bool {
        matches!(self.source, Source::Exr(_))
    }

    /// Bytes that decoding takes beside the rows themselves, about.
    pub fn working_memory(&self) -> u64 {
        let spooled = match &self.input {
            Input::Bytes { bytes, .. } => bytes.len() as u64,
            _ => 0,
        };
        spooled
            + match &self.source {
                Source::Exr(exr) => working_memory(exr),
                Source::Raster(raster) => raster.working_memory(),
            }
    }

    /// Why its pixels have to be in memory as a whole, if they have.
    pub fn whole(&self) -> Option<&'static str> {
        match &self.source {
            Source::Exr(_) => None,
            Source::Raster(raster) => raster.whole,
        }
    }
}

impl Rows<'_> {
    /// The next rows, as an image whose origin is theirs. They may begin again with rows that were read before, but
    /// not further up than the last ones began.
    ///
    /// # Errors
    /// If the file turns out damaged, or memory does not suffice.
    ///
    /// # Panics
    /// If the rows lie outside the image or begin too far up.
    pub fn read(&mut self, rows: Range<usize>) -> Result<Image<'static>, ImageError> {
        let [width, height] = self.file.size();
        assert!(rows.start >= self.held.start && rows.end <= height, "rows are read from the top down");
        let decoded = self.decode(&rows);
        // Of a file that somebody writes to at the same time no error and no number means anything.
        self.file.unchanged()?;
        decoded?;
        let about = self.file.metadata();
        let mut metadata = about.clone();
        if rows != (0..height) {
            metadata.resolution = Some(about.resolution.unwrap_or([width, height]));
            metadata.origin[1] += rows.start as i32;
        }
        // The whole image takes the planes with it, each with its last user.
        let last = rows == (0..height);
        let mut uses = vec![0usize; self.planes.len()];
        self.variables.iter().flat_map(|v| &v.2).for_each(|&c| uses[c] += 1);
        let part = (rows.start - self.held.start) * width..(rows.end - self.held.start) * width;
        let mut plane = |c: usize| {
            uses[c] -= 1;
            match last && uses[c] == 0 {
                true => std::mem::take(&mut self.planes[c]),
                false => self.planes[c][part.clone()].to_vec(),
            }
        };
        let variables = self
            .variables
            .iter()
            .map(|(name, shape, channels)| Variable {
                name: name.clone(),
                shape: shape.clone(),
                planes: channels.iter().map(|&c| Cow::Owned(plane(c))).collect(),
            })
            .collect();
        if last {
            self.held = height..height;
        }
        Ok(Image { width, height: rows.len(), variables, metadata })
    }

    /// Brings these rows into memory, and lets go of those above.
    fn decode(&mut self, rows: &Range<usize>) -> Result<(), ImageError> {
        let [width, _] = self.file.size();
        let name = self.file.name();
        let too_large = || ImageError::new(ErrorKind::TooLarge, format!("`{name}` is too large"));
        let reach = match &self.pixels {
            Decoded::Exr(scan) => scan.reach(rows.end),
            Decoded::Raster(_) => rows.end,
        };
        let end = reach.max(rows.end).max(self.held.end);
        let gone = (rows.start.min(self.held.end) - self.held.start) * width;
        let count = (end - rows.start).checked_mul(width).ok_or_else(too_large)?;
        for (plane, _) in self.planes.iter_mut().zip(&self.wanted).filter(|(_, wanted)| **wanted) {
            plane.drain(..gone);
            if plane.is_empty() && plane.capacity() < count {
                *plane = guard::plane(&name, count)?;
            }
            plane.resize(count, 0.0);
        }
        self.held = rows.start..end;
        let planes = &mut self.planes;
        let new = self.done.max(rows.start)..rows.end;
        match &mut self.pixels {
            Decoded::Exr(scan) => scan.decode(new, |line| {
                if line.y >= rows.start {
                    let start = (line.y - rows.start) * width + line.x;
                    line.floats(&mut planes[line.channel][start..]);
                }
            })?,
            Decoded::Raster(scan) if !new.is_empty() && self.wanted.contains(&true) => {
                let part = (new.start - rows.start) * width..(new.end - rows.start) * width;
                for (c, plane) in scan.rows(new)?.into_iter().enumerate().filter(|(c, _)| self.wanted[*c]) {
                    match part.len() == planes[c].len() {
                        true => planes[c] = plane,
                        false => planes[c][part.clone()].copy_from_slice(&plane),
                    }
                }
            }
            Decoded::Raster(_) => {}
        }
        self.done = self.done.max(rows.end);
        Ok(())
    }
}
