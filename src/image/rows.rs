//! A file's variables a few rows at a time, so that an image need not be in memory as a whole.

use super::RasterScan;
use super::bind::Candidate;
use super::chroma::{self, LuminanceChroma};
use super::error::{ErrorKind, ImageError};
use super::file::{Channel, File, Source};
use super::scan_exr::{Scan, working_memory};
use super::source::Input;
use super::{Image, Variable, guard};
use crate::shape::Shape;
use std::borrow::Cow;
use std::ops::Range;

/// Reads some variables of a file, from the top down.
///
/// EXR and PNG files are decoded up to the requested rows; other formats are decoded as a whole at the first row.
pub struct Rows<'f> {
    file: &'f File,
    variables: Vec<Stored>,
    /// How many rows about those that are asked for have to be known.
    margin: usize,
    wanted: Vec<bool>,
    pixels: Decoded<'f>,
    /// A plane for each wanted channel of the file, of the rows that are in memory.
    planes: Vec<Vec<f32>>,
    /// Which rows those are.
    held: Range<usize>,
    /// The rows before this one have been decoded.
    done: usize,
}

/// A variable, and how it lies in the file.
struct Stored {
    name: String,
    shape: Shape,
    channels: Vec<usize>,
    /// How its three channels become a colour, if they are luminance and chroma.
    chroma: Option<LuminanceChroma>,
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
            variables.push(Stored {
                name: name.to_string(),
                shape: found.shape.clone(),
                channels: found.channels.clone(),
                chroma: self.luminance_chroma(found),
            });
        }
        self.rows_of(variables, wanted)
    }

    /// How the channels of such a variable become a colour.
    fn luminance_chroma(&self, candidate: &Candidate) -> Option<LuminanceChroma> {
        let Source::Exr(exr) = &self.source else { return None };
        let &[_, ry, by] = candidate.channels.get(..3).filter(|_| candidate.luminance_chroma)? else {
            return None;
        };
        let part = self.channels[ry].part;
        Some(LuminanceChroma {
            weights: chroma::weights(exr.chromaticities(part)),
            sampling: [ry, by].map(|c| self.channels[c].sampling),
            window: exr.part_window(part)?,
        })
    }

    /// Prepares to read all channels that can be read, each as a scalar under its full name, whatever programs would
    /// call it.
    ///
    /// # Errors
    /// If the file cannot be opened.
    pub fn channel_rows(&self) -> Result<Rows<'_>, ImageError> {
        let read: Vec<bool> = self.channels.iter().map(|c| c.unread.is_none()).collect();
        let variables = self.channels.iter().enumerate().filter(|(i, _)| read[*i]);
        let stored = |(i, c): (usize, &Channel)| Stored {
            name: c.name.clone(),
            shape: Shape::Scalar,
            channels: vec![i],
            chroma: None,
        };
        self.rows_of(variables.map(stored).collect(), read)
    }

    fn rows_of(&self, variables: Vec<Stored>, wanted: Vec<bool>) -> Result<Rows<'_>, ImageError> {
        let pixels = match &self.source {
            Source::Exr(exr) => Decoded::Exr(Scan::new(exr, &self.input, &self.channels, &wanted)?),
            Source::Raster(raster) => Decoded::Raster(RasterScan::new(raster, &self.input)?),
        };
        let planes = vec![Vec::new(); wanted.len()];
        let margin = variables.iter().filter_map(|v| v.chroma.as_ref()).map(LuminanceChroma::margin).max();
        let margin = margin.unwrap_or(0);
        Ok(Rows { file: self, variables, margin, wanted, pixels, planes, held: 0..0, done: 0 })
    }

    /// Whether rows can be read one after another, without the whole picture in memory.
    pub fn streams(&self) -> bool {
        self.whole().is_none()
    }

    /// Whether lower rows can be read without those above.
    pub fn seeks(&self) -> bool {
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

    /// The reason if its pixels must be in memory as a whole.
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
        let outer = rows.start.saturating_sub(self.margin)..height.min(rows.end + self.margin);
        assert!(outer.start >= self.held.start && rows.end <= height, "rows are read from the top down");
        let decoded = self.decode(&outer);
        // Of a file that somebody writes to at the same time no error and no number means anything.
        self.file.unchanged()?;
        decoded?;
        let about = self.file.metadata();
        let mut metadata = about.clone();
        if rows != (0..height) {
            metadata.resolution = Some(about.resolution.unwrap_or([width, height]));
            metadata.origin[1] += rows.start as i32;
        }
        let held = self.held.start;
        let color = |v: &Stored| {
            let chroma = v.chroma.as_ref()?;
            let planes = std::array::from_fn(|i| &self.planes[v.channels[i]][..]);
            Some(chroma.color(planes, width, held, rows.clone()))
        };
        let mut colors: Vec<Option<[Vec<f32>; 3]>> = self.variables.iter().map(color).collect();
        // The whole image takes the planes with it, each with its last user.
        let last = rows == (0..height);
        let mut uses = vec![0usize; self.planes.len()];
        let plain = self.variables.iter().filter(|v| v.chroma.is_none());
        plain.flat_map(|v| &v.channels).for_each(|&c| uses[c] += 1);
        let part = (rows.start - held) * width..(rows.end - held) * width;
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
            .zip(&mut colors)
            .map(|(stored, color)| Variable {
                name: stored.name.clone(),
                shape: stored.shape.clone(),
                planes: match color.take() {
                    Some(planes) => planes.into_iter().map(Cow::Owned).collect(),
                    None => stored.channels.iter().map(|&c| Cow::Owned(plane(c))).collect(),
                },
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
                    line.floats(&mut planes[line.channel][start..], line.step);
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
