//! The pixels of PNG, JPEG and the like, from the top down: PNG row by row, the others from a picture that is decoded
//! as a whole.

use super::error::ImageError;
use super::read_raster::{Raster, explain};
use super::source::{Input, ReadSeek};
use super::{color, guard};
use ::image::{DynamicImage, ImageReader, Limits};
use rayon::prelude::*;
use std::borrow::Cow;
use std::io::BufReader;
use std::ops::Range;

/// A way through a picture from the top down.
pub(crate) struct RasterScan<'f> {
    raster: &'f Raster,
    name: String,
    pixels: Pixels,
    /// The first row that has not been read yet.
    next: usize,
}

enum Pixels {
    Rows(Box<png::Reader<BufReader<Box<dyn ReadSeek>>>>),
    /// To be decoded when the first row is wanted.
    Later(Input),
    Whole(DynamicImage),
}

/// Interleaved samples of some rows.
enum Codes<'a> {
    Byte(Cow<'a, [u8]>),
    Short(Cow<'a, [u16]>),
    Float(&'a [f32]),
}

impl<'f> RasterScan<'f> {
    /// Before the first row.
    pub fn new(raster: &'f Raster, input: &Input) -> Result<RasterScan<'f>, ImageError> {
        let name = input.name();
        let pixels = match raster.whole {
            Some(_) => Pixels::Later(input.clone()),
            None => {
                let (reader, _) = input.open()?;
                let mut decoder = decoder(reader, raster.limit);
                decoder.set_transformations(png::Transformations::EXPAND);
                let reader = guard::contain(|| decoder.read_info())
                    .ok_or_else(|| ImageError::damaged(&name, "its header makes no sense"))?
                    .map_err(|e| explain_png(&name, e))?;
                Pixels::Rows(Box::new(reader))
            }
        };
        Ok(RasterScan { raster, name, pixels, next: 0 })
    }

    /// The planes of all channels in these rows, which lie below those of the call before.
    pub fn rows(&mut self, rows: Range<usize>) -> Result<Vec<Vec<f32>>, ImageError> {
        if let Pixels::Later(input) = &self.pixels {
            self.pixels = Pixels::Whole(self.raster.decode(input)?);
        }
        let RasterScan { raster, name, pixels, next } = self;
        let pixel = usize::from(raster.color.bytes_per_pixel());
        let codes = match pixels {
            Pixels::Rows(reader) => {
                let line = raster.size[0] * pixel;
                let mut bytes = vec![0; line * rows.len().max(1)];
                let damaged = || ImageError::damaged(name, "its pixels make no sense");
                guard::contain(|| {
                    let read = |reader: &mut png::Reader<_>, line: &mut [u8]| {
                        let row = reader.read_row(line).map_err(|e| explain_png(name, e))?;
                        row.map(drop).ok_or_else(|| ImageError::damaged(name, "it ends too early"))
                    };
                    // Rows above are read to no end.
                    (*next..rows.start).try_for_each(|_| read(reader, &mut bytes[..line]))?;
                    bytes.chunks_exact_mut(line).take(rows.len()).try_for_each(|line| read(reader, line))?;
                    if rows.end == raster.size[1] {
                        // What comes behind the last row is looked at too.
                        reader.next_row().map_err(|e| explain_png(name, e))?;
                    }
                    Ok(())
                })
                .ok_or_else(damaged)??;
                match pixel / usize::from(raster.color.channel_count()) {
                    1 => Codes::Byte(bytes.into()),
                    _ => {
                        let (pairs, _) = bytes.as_chunks::<2>();
                        Codes::Short(pairs.iter().map(|&pair| u16::from_be_bytes(pair)).collect())
                    }
                }
            }
            Pixels::Whole(image) => part(image, rows.start * raster.size[0]..rows.end * raster.size[0]),
            Pixels::Later(_) => Codes::Float(&[]),
        };
        *next = rows.end;
        Ok(planes(raster, &codes))
    }
}

/// Is it a PNG whose rows stand one after another? Else why not.
pub(super) fn rows_of_png(input: &Input, name: &str) -> Result<Option<&'static str>, ImageError> {
    let (reader, length) = input.open()?;
    let mut decoder = decoder(reader, 64 << 20);
    let header = |about: &png::Info<'_>| {
        let row = about.bits_per_pixel() as u64 * u64::from(about.width);
        (about.interlaced, guard::fits_deflate(row, about.height.into(), length))
    };
    let (interlaced, fits) = guard::contain(|| decoder.read_header_info().map(header))
        .ok_or_else(|| ImageError::damaged(name, "its header makes no sense"))?
        .map_err(|e| explain_png(name, e))?;
    if !fits {
        return Err(ImageError::damaged(name, "it ends too early"));
    }
    Ok(interlaced.then_some("the rows of an interlaced PNG are complete at its end only"))
}

fn decoder(reader: Box<dyn ReadSeek>, limit: u64) -> png::Decoder<BufReader<Box<dyn ReadSeek>>> {
    let limits = png::Limits { bytes: limit as usize };
    let mut decoder = png::Decoder::new_with_limits(BufReader::new(reader), limits);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder
}

impl Raster {
    /// Bytes that decoding takes, about: the whole picture and what the decoder makes of it, or a row.
    pub(super) fn working_memory(&self) -> u64 {
        let row = self.size[0] as u64 * u64::from(self.color.bytes_per_pixel());
        if self.whole.is_some() { 3 * row * self.size[1] as u64 } else { 2 * row + (1 << 20) }
    }

    /// The whole picture, as it is stored.
    pub(super) fn decode(&self, input: &Input) -> Result<DynamicImage, ImageError> {
        let name = input.name();
        let (reader, _) = input.open()?;
        let mut reader = ImageReader::with_format(BufReader::new(reader), self.kind);
        let mut limits = Limits::default();
        limits.max_alloc = Some(self.limit);
        reader.limits(limits);
        let image = guard::contain(|| reader.decode())
            .ok_or_else(|| ImageError::damaged(&name, "its pixels make no sense"))?
            .map_err(|e| explain(&name, e))?;
        match [image.width() as usize, image.height() as usize] == self.size && image.color() == self.color {
            true => Ok(image),
            false => Err(ImageError::damaged(&name, "its pixels are not what its header says")),
        }
    }
}

/// The codes of these pixels.
fn part(image: &DynamicImage, pixels: Range<usize>) -> Codes<'_> {
    let count = usize::from(image.color().channel_count());
    let range = pixels.start * count..pixels.end * count;
    if let Some(codes) = image.as_flat_samples_u8() {
        Codes::Byte(codes.samples[range].into())
    } else if let Some(codes) = image.as_flat_samples_u16() {
        Codes::Short(codes.samples[range].into())
    } else {
        Codes::Float(image.as_flat_samples_f32().map_or(&[][..], |s| &s.samples[range]))
    }
}

/// The numbers that programs see.
fn planes(raster: &Raster, codes: &Codes<'_>) -> Vec<Vec<f32>> {
    let count = usize::from(raster.color.channel_count());
    let alpha = raster.color.has_alpha().then(|| count - 1);
    let plain = |c: usize| raster.raw || Some(c) == alpha;
    let plane = |c: usize| match codes {
        Codes::Byte(codes) if plain(c) => gather(codes, count, c, |v| f32::from(v) / 255.0),
        Codes::Byte(codes) => gather(codes, count, c, color::decode8),
        Codes::Short(codes) if plain(c) => gather(codes, count, c, |v| f32::from(v) / 65535.0),
        Codes::Short(codes) => gather(codes, count, c, color::decode16),
        Codes::Float(numbers) => gather(numbers, count, c, |v| v),
    };
    let mut planes: Vec<Vec<f32>> = (0..count).map(plane).collect();
    if let Some(a) = alpha.filter(|_| !raster.raw && !matches!(codes, Codes::Float(_))) {
        let (colors, alpha) = planes.split_at_mut(a);
        for plane in colors {
            plane.iter_mut().zip(&alpha[0]).for_each(|(c, a)| *c *= a);
        }
    }
    planes
}

/// Component `c` of interleaved samples.
fn gather<T: Copy + Sync>(
    samples: &[T],
    count: usize,
    c: usize,
    convert: impl Fn(T) -> f32 + Sync + Send,
) -> Vec<f32> {
    samples.par_chunks_exact(count).with_min_len(4096).map(|pixel| convert(pixel[c])).collect()
}

fn explain_png(name: &str, error: png::DecodingError) -> ImageError {
    match error {
        png::DecodingError::IoError(e) => ImageError::io("read", name, &e),
        png::DecodingError::LimitsExceeded => super::read_raster::greedy(name),
        other => ImageError::damaged(name, other),
    }
}
