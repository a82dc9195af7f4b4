//! PNG, JPEG, TIFF, HDR, BMP, TGA and WebP: the picture, `color` and `alpha`, in the display window.
//!
//! Whole numbers are encoded to sRGB and clipped to 0..1, NaN as 0. `color` is premultiplied in memory;
//! where alpha is written, it is divided out, also of floats, and a TIFF says so in a tag. Pixels of the display window for which
//! the image has no data are black and transparent; those outside it are left out.

use super::error::ImageError;
use super::write::{Format, WriteOptions, unwritable};
use super::write_png::PngWriter;
use super::write_tiff;
use super::{Image, color};
use crate::parallel::*;
use crate::shape::Shape;
use ::image::codecs::{bmp, hdr, jpeg, tga, webp};
use ::image::error::{EncodingError, ImageFormatHint};
use ::image::{ExtendedColorType, ImageEncoder, ImageFormat, ImageResult, Rgb};
use std::io::{BufWriter, Seek, Write};
use std::ops::Range;
use tiff::tags::ExtraSamples;

/// The picture: three planes of colour or one of grey three times, and alpha.
struct Picture<'a> {
    color: [&'a [f32]; 3],
    alpha: Option<&'a [f32]>,
}

/// A picture that is written from the top down: PNG row by row; of other formats the codes are kept until the end.
pub(crate) struct RasterWriter {
    name: String,
    format: Format,
    options: WriteOptions,
    /// The display window.
    size: [usize; 2],
    /// Components of a pixel, and bits of a component.
    count: usize,
    bits: u8,
    /// The row of the display window after the last one that came.
    row: usize,
    sink: Sink,
}

enum Sink {
    Png(Box<PngWriter>),
    Whole(Vec<u8>),
}

impl RasterWriter {
    /// Begins the picture of an image of so many rows, of which `first` are the first; or tells why the format cannot
    /// hold it.
    pub fn new(
        name: &str,
        format: Format,
        first: &Image<'_>,
        height: usize,
        options: &WriteOptions,
    ) -> Result<RasterWriter, ImageError> {
        let picture = picture(name, first)?;
        let bits = bits(name, format, options)?;
        let size = first.metadata.resolution.unwrap_or([first.width, height]);
        let largest = match format {
            Format::Jpeg | Format::Tga => 65535,
            Format::Webp => 16383,
            _ => 1 << 24,
        };
        let [w, h] = size;
        if w.max(h) > largest || w.saturating_mul(h) > 1 << 31 {
            let why = format!("its display window, {w} x {h}, is too large for the format");
            return Err(unwritable(name, why));
        }
        let alpha = picture.alpha.is_some() && !matches!(format, Format::Jpeg | Format::Hdr);
        let count = if alpha { 4 } else { 3 };
        let sink = match format {
            Format::Png => {
                Sink::Png(Box::new(PngWriter::new(name, size, alpha, bits, options.stamp.as_deref())?))
            }
            _ => {
                let mut codes = Vec::new();
                let room = codes.try_reserve_exact(w * h * count * usize::from(bits / 8));
                room.map_err(|_| {
                    unwritable(name, "not enough memory; the format can only be written as a whole")
                })?;
                Sink::Whole(codes)
            }
        };
        let (name, options) = (name.to_string(), options.clone());
        Ok(RasterWriter { name, format, options, size, count, bits, row: 0, sink })
    }

    /// Adds the next rows.
    pub fn rows(&mut self, image: &Image<'_>, out: &mut impl Write) -> Result<(), ImageError> {
        let picture = picture(&self.name, image)?;
        let top = i64::from(image.metadata.origin[1]);
        let inside = |row: i64| row.clamp(0, self.size[1] as i64) as usize;
        let rows = inside(top)..inside(top + image.height as i64);
        self.blank(rows.start, out)?;
        let pixels = pixels(image, &picture, self.size[0], rows.clone(), self.count, !self.options.raw);
        let raw = self.options.raw;
        let codes: Vec<u8> = match self.bits {
            8 => codes(&pixels, self.count, |v, linear| {
                if raw || linear { color::quantize(v, 255) as u8 } else { color::encode8(v) }
            }),
            16 => codes(&pixels, self.count, |v, linear| {
                if raw || linear { color::quantize(v, 65535) } else { color::encode16(v) }
            })
            .into_iter()
            .flat_map(u16::to_ne_bytes)
            .collect(),
            _ => pixels.iter().flat_map(|v| v.to_ne_bytes()).collect(),
        };
        self.row = self.row.max(rows.end);
        self.put(&codes, out)
    }

    /// Rows without data, before this one.
    fn blank(&mut self, row: usize, out: &mut impl Write) -> Result<(), ImageError> {
        let line = vec![0; self.size[0] * self.count * usize::from(self.bits / 8)];
        while self.row < row {
            self.put(&line, out)?;
            self.row += 1;
        }
        Ok(())
    }

    fn put(&mut self, codes: &[u8], out: &mut impl Write) -> Result<(), ImageError> {
        match &mut self.sink {
            Sink::Png(writer) => writer.rows(codes, out),
            Sink::Whole(whole) => {
                whole.extend_from_slice(codes);
                Ok(())
            }
        }
    }

    /// Ends the file.
    pub fn finish(mut self, out: &mut (impl Write + Seek)) -> Result<(), ImageError> {
        self.blank(self.size[1], out)?;
        let RasterWriter { name, format, options, size, count, bits, sink, .. } = self;
        let bytes = match sink {
            Sink::Png(writer) => return writer.finish(out),
            Sink::Whole(bytes) => bytes,
        };
        let kind = if count == 3 { ExtendedColorType::Rgb8 } else { ExtendedColorType::Rgba8 };
        let mut out = BufWriter::new(out);
        let (w, h) = (size[0] as u32, size[1] as u32);
        let done: ImageResult<()> = match format {
            Format::Exr | Format::Png => unreachable!("they have separate writers"),
            Format::Jpeg => jpeg::JpegEncoder::new_with_quality(&mut out, options.quality.clamp(1, 100))
                .write_image(&bytes, w, h, kind),
            Format::Tiff => {
                let alpha = match options.raw {
                    true => ExtraSamples::AssociatedAlpha,
                    false => ExtraSamples::UnassociatedAlpha,
                };
                let alpha = (count == 4).then_some(alpha);
                let written = write_tiff::write(&mut out, size, bits, alpha, &bytes);
                written.map_err(|e| match e {
                    tiff::TiffError::IoError(e) => ::image::ImageError::IoError(e),
                    other => ::image::ImageError::Encoding(EncodingError::new(
                        ImageFormatHint::Exact(ImageFormat::Tiff),
                        other,
                    )),
                })
            }
            Format::Bmp => bmp::BmpEncoder::new(&mut out).write_image(&bytes, w, h, kind),
            Format::Tga => tga::TgaEncoder::new(&mut out).write_image(&bytes, w, h, kind),
            Format::Webp => webp::WebPEncoder::new_lossless(&mut out).write_image(&bytes, w, h, kind),
            Format::Hdr => {
                // RGBE has no sign and no NaN; infinity becomes the largest number.
                let fit = |v: f32| if v.is_nan() { 0.0 } else { v.clamp(0.0, 1e38) };
                let (numbers, _) = bytes.as_chunks::<4>();
                let (pixels, _) = numbers.as_chunks::<3>();
                let rgb: Vec<Rgb<f32>> =
                    pixels.iter().map(|p| Rgb(p.map(|v| fit(f32::from_ne_bytes(v))))).collect();
                hdr::HdrEncoder::new(&mut out).encode(&rgb, size[0], size[1])
            }
        };
        done.and_then(|()| Ok(out.flush()?)).map_err(|e| match e {
            ::image::ImageError::IoError(e) => ImageError::io("write", &name, &e),
            other => unwritable(&name, other),
        })
    }
}

fn picture<'a>(name: &str, image: &'a Image<'_>) -> Result<Picture<'a>, ImageError> {
    let Some(color) = image.variable("color") else {
        let names: Vec<String> = image.variables.iter().map(|v| format!("`{}`", v.name)).collect();
        return Err(unwritable(name, "the image has no `color`")
            .hint(format!("It has {}; an .exr file holds any variable.", names.join(", "))));
    };
    let plane = |i: usize| color.planes[i].as_ref();
    let alpha = image.variable("alpha").filter(|a| a.shape.is_scalar()).map(|a| a.planes[0].as_ref());
    match color.shape {
        Shape::Scalar => Ok(Picture { color: [plane(0); 3], alpha }),
        Shape::Vector(3) => Ok(Picture { color: [plane(0), plane(1), plane(2)], alpha }),
        Shape::Vector(4) => {
            Ok(Picture { color: [plane(0), plane(1), plane(2)], alpha: alpha.or(Some(plane(3))) })
        }
        ref other => Err(unwritable(name, format!("`color` is {other}, not a scalar or a vector of 3 or 4"))),
    }
}

fn bits(name: &str, format: Format, options: &WriteOptions) -> Result<u8, ImageError> {
    let can: &[u8] = match format {
        Format::Png => &[8, 16],
        Format::Tiff => &[8, 16, 32],
        Format::Hdr | Format::Exr => &[32],
        _ => &[8],
    };
    let bits = options.bits.unwrap_or(can[0]);
    if can.contains(&bits) {
        return Ok(bits);
    }
    let list: Vec<String> = can.iter().map(u8::to_string).collect();
    let why = format!("the format does not support {bits} bits per component, only {}", list.join(", "));
    Err(unwritable(name, why))
}

/// The pixels of these rows of the display window, so wide and interleaved.
fn pixels(
    image: &Image<'_>,
    picture: &Picture<'_>,
    width: usize,
    rows: Range<usize>,
    count: usize,
    divide: bool,
) -> Vec<f32> {
    let [left, top] = image.metadata.origin.map(i64::from);
    let mut pixels = vec![0f32; width * rows.len() * count];
    pixels.par_chunks_exact_mut(width * count).zip(rows).for_each(|(line, row)| {
        let y = row as i64 - top;
        for (column, pixel) in line.chunks_exact_mut(count).enumerate() {
            let x = column as i64 - left;
            if x < 0 || x >= image.width as i64 {
                continue;
            }
            let at = y as usize * image.width + x as usize;
            let alpha = picture.alpha.filter(|_| count == 4).map(|plane| plane[at]);
            for (to, plane) in pixel.iter_mut().zip(picture.color) {
                *to = match alpha {
                    Some(a) if divide && a > 0.0 => plane[at] / a,
                    _ => plane[at],
                };
            }
            if let Some(a) = alpha {
                pixel[3] = a;
            }
        }
    });
    pixels
}

/// Interleaved codes; `encode` is told whether the component is alpha, which is linear.
fn codes<T: Send>(pixels: &[f32], count: usize, encode: impl Fn(f32, bool) -> T + Sync) -> Vec<T> {
    pixels.par_iter().with_min_len(4096).enumerate().map(|(i, &v)| encode(v, i % count == 3)).collect()
}
