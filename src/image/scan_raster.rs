//! The pixels of PNG, JPEG and the like, from the top down: PNG row by row, the others from a picture that is decoded
//! as a whole.

use super::error::ImageError;
use super::layout::Codes;
use super::read_raster::{Decoder, Raster, bmp_reader, explain, greedy};
use super::source::{Input, ReadSeek};
use super::{guard, hdr, jpeg};
use ::image::{DynamicImage, ImageFormat, ImageReader, Limits};
use std::io::{BufReader, Cursor, Read};
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
    Whole(Codes),
}

impl<'f> RasterScan<'f> {
    /// Before the first row.
    pub fn new(raster: &'f Raster, input: &Input) -> Result<RasterScan<'f>, ImageError> {
        let name = input.name();
        let pixels = match raster.whole {
            Some(_) => Pixels::Later(input.clone()),
            None => {
                let (reader, _) = input.open()?;
                let mut decoder = png_decoder(reader, raster.limit);
                decoder.set_transformations(png::Transformations::EXPAND);
                let reader = guard::contain(|| decoder.read_info())
                    .ok_or_else(|| ImageError::damaged(&name, "its header is invalid"))?
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
        let width = raster.size[0];
        let planes = match pixels {
            Pixels::Rows(reader) => {
                let line = width * raster.layout.pixel_bytes() as usize;
                let mut bytes = vec![0; line * rows.len().max(1)];
                let damaged = || ImageError::damaged(name, "its pixel data is invalid");
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
                let codes = match raster.layout.sample_bytes() {
                    1 => Codes::Byte(bytes),
                    _ => {
                        let (pairs, _) = bytes.as_chunks::<2>();
                        Codes::Short(pairs.iter().map(|&pair| u16::from_be_bytes(pair)).collect())
                    }
                };
                raster.layout.planes(&codes, 0..rows.len() * width, raster.raw)
            }
            Pixels::Whole(codes) => {
                raster.layout.planes(codes, rows.start * width..rows.end * width, raster.raw)
            }
            Pixels::Later(_) => Vec::new(),
        };
        *next = rows.end;
        Ok(planes)
    }
}

/// What the decoder of PNG may use beside the picture, in bytes: rows of up to a million pixels, and blocks such as colour
/// profiles, which a few compressed bytes can make very large.
pub(super) const MAX_PNG_MEMORY: u64 = 64 << 20;

pub(super) fn png_decoder(
    reader: Box<dyn ReadSeek>,
    limit: u64,
) -> png::Decoder<BufReader<Box<dyn ReadSeek>>> {
    // Rows come one after another, so only the blocks beside the pixels could need much.
    let limits = png::Limits { bytes: limit.min(MAX_PNG_MEMORY) as usize };
    let mut decoder = png::Decoder::new_with_limits(BufReader::new(reader), limits);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder
}

impl Raster {
    /// Bytes that decoding takes, about: the whole picture and what the decoder makes of it, or a row.
    pub(super) fn working_memory(&self) -> u64 {
        let row = self.size[0] as u64 * self.layout.pixel_bytes();
        if self.whole.is_some() { 3 * row * self.size[1] as u64 } else { 2 * row + (1 << 20) }
    }

    /// The whole picture, turned.
    fn decode(&self, input: &Input) -> Result<Codes, ImageError> {
        let codes = match &self.decoder {
            Decoder::Tiff(tiff) => tiff.decode(input)?,
            Decoder::Tga(tga) => tga.decode(input)?,
            Decoder::Hdr(header) => {
                let reader = Cursor::new(hdr::usual(header, &all(input)?));
                self.decode_image(input, ImageReader::with_format(reader, ImageFormat::Hdr))?
            }
            Decoder::Image(ImageFormat::Jpeg) => {
                let bytes = all(input)?;
                if guard::contain(|| jpeg::lacks_pixels(&bytes, self.limit)) != Some(false) {
                    return Err(ImageError::damaged(&input.name(), "it ends too early"));
                }
                self.decode_image(input, ImageReader::with_format(Cursor::new(bytes), ImageFormat::Jpeg))?
            }
            Decoder::Image(ImageFormat::Bmp) => self.decode_image(input, bmp_reader(input)?)?,
            Decoder::Image(kind) => {
                let (reader, _) = input.open()?;
                self.decode_image(input, ImageReader::with_format(BufReader::new(reader), *kind))?
            }
        };
        let count = self.layout.channels.len();
        if codes.len() != self.stored[0] * self.stored[1] * count {
            return Err(ImageError::damaged(&input.name(), "its pixels are not what its header says"));
        }
        Ok(codes.oriented(self.stored, count, self.turned()))
    }

    fn decode_image(
        &self,
        input: &Input,
        mut reader: ImageReader<impl std::io::BufRead + std::io::Seek>,
    ) -> Result<Codes, ImageError> {
        let name = input.name();
        let mut limits = Limits::default();
        limits.max_alloc = Some(self.limit);
        reader.limits(limits);
        let image = guard::contain(|| reader.decode())
            .ok_or_else(|| ImageError::damaged(&name, "its pixel data is invalid"))?
            .map_err(|e| explain(&name, e))?;
        Ok(match image {
            DynamicImage::ImageLuma8(image) => Codes::Byte(image.into_raw()),
            DynamicImage::ImageLumaA8(image) => Codes::Byte(image.into_raw()),
            DynamicImage::ImageRgb8(image) => Codes::Byte(image.into_raw()),
            DynamicImage::ImageRgba8(image) => Codes::Byte(image.into_raw()),
            DynamicImage::ImageLuma16(image) => Codes::Short(image.into_raw()),
            DynamicImage::ImageLumaA16(image) => Codes::Short(image.into_raw()),
            DynamicImage::ImageRgb16(image) => Codes::Short(image.into_raw()),
            DynamicImage::ImageRgba16(image) => Codes::Short(image.into_raw()),
            other => Codes::Float(other.into_rgb32f().into_raw()),
        })
    }
}

/// All bytes of a file.
fn all(input: &Input) -> Result<Vec<u8>, ImageError> {
    let (mut reader, _) = input.open()?;
    let mut bytes = Vec::new();
    reader.read_to_end(&mut bytes).map_err(|e| ImageError::io("read", &input.name(), &e))?;
    Ok(bytes)
}

pub(super) fn explain_png(name: &str, error: png::DecodingError) -> ImageError {
    match error {
        png::DecodingError::IoError(e) => ImageError::io("read", name, &e),
        png::DecodingError::LimitsExceeded => greedy(name),
        other => ImageError::damaged(name, other),
    }
}
