//! PNG, JPEG, TIFF, HDR, BMP, TGA and WebP: the picture, `color` and `alpha`, in the display window.
//!
//! Whole numbers are encoded to sRGB and clipped to 0..1, NaN as 0. `color` is premultiplied in memory;
//! where alpha is written, these formats want it divided out. Pixels of the display window for which
//! the image has no data are black and transparent; those outside it are left out.

use super::error::ImageError;
use super::write::{Format, WriteOptions, unwritable};
use super::{Image, color, stamp};
use crate::shape::Shape;
use ::image::codecs::{bmp, hdr, jpeg, png, tga, tiff, webp};
use ::image::{ExtendedColorType, ImageEncoder, ImageResult, Rgb};
use rayon::prelude::*;
use std::io::Cursor;

/// The picture: three planes of colour or one of grey three times, and alpha.
pub(super) struct Picture<'a> {
    color: [&'a [f32]; 3],
    alpha: Option<&'a [f32]>,
}

/// The bytes of the file.
pub(crate) fn encode(
    name: &str,
    format: Format,
    image: &Image<'_>,
    options: &WriteOptions,
) -> Result<Vec<u8>, ImageError> {
    let (picture, bits) = check(name, format, image, options)?;
    let [width, height] = image.resolution();
    let has_alpha = picture.alpha.is_some() && !matches!(format, Format::Jpeg | Format::Hdr);
    let count = if has_alpha { 4 } else { 3 };
    let whole = bits != 32;
    let pixels = pixels(image, &picture, count, whole && !options.raw);
    let bytes: Vec<u8> =
        match (bits, options.raw) {
            (8, raw) => codes(&pixels, count, |v, linear| {
                if raw || linear { color::quantize(v, 255) as u8 } else { color::encode8(v) }
            }),
            (16, raw) => codes(&pixels, count, |v, linear| {
                if raw || linear { color::quantize(v, 65535) } else { color::encode16(v) }
            })
            .into_iter()
            .flat_map(u16::to_ne_bytes)
            .collect(),
            _ => pixels.iter().flat_map(|v| v.to_ne_bytes()).collect(),
        };
    let kind = match (bits, count) {
        (8, 3) => ExtendedColorType::Rgb8,
        (8, _) => ExtendedColorType::Rgba8,
        (16, 3) => ExtendedColorType::Rgb16,
        (16, _) => ExtendedColorType::Rgba16,
        (_, 3) => ExtendedColorType::Rgb32F,
        _ => ExtendedColorType::Rgba32F,
    };
    let mut out = Cursor::new(Vec::new());
    let (w, h) = (width as u32, height as u32);
    let done: ImageResult<()> = match format {
        Format::Exr => unreachable!("EXR has a writer of its own"),
        Format::Png => png::PngEncoder::new(&mut out).write_image(&bytes, w, h, kind),
        Format::Jpeg => jpeg::JpegEncoder::new_with_quality(&mut out, options.quality.clamp(1, 100))
            .write_image(&bytes, w, h, kind),
        Format::Tiff => tiff::TiffEncoder::new(&mut out).write_image(&bytes, w, h, kind),
        Format::Bmp => bmp::BmpEncoder::new(&mut out).write_image(&bytes, w, h, kind),
        Format::Tga => tga::TgaEncoder::new(&mut out).write_image(&bytes, w, h, kind),
        Format::Webp => webp::WebPEncoder::new_lossless(&mut out).write_image(&bytes, w, h, kind),
        Format::Hdr => {
            // RGBE has no sign and no NaN; infinity becomes the largest number.
            let fit = |v: f32| if v.is_nan() { 0.0 } else { v.clamp(0.0, 1e38) };
            let rgb: Vec<Rgb<f32>> =
                pixels.chunks_exact(3).map(|p| Rgb([fit(p[0]), fit(p[1]), fit(p[2])])).collect();
            hdr::HdrEncoder::new(&mut out).encode(&rgb, width, height)
        }
    };
    done.map_err(|e| unwritable(name, e))?;
    match &options.stamp {
        Some(stamp) if format == Format::Png => Ok(stamp::into_png(out.into_inner(), stamp)),
        _ => Ok(out.into_inner()),
    }
}

/// The picture, and the bits of a component; or why the format cannot hold it.
pub(super) fn check<'a>(
    name: &str,
    format: Format,
    image: &'a Image<'_>,
    options: &WriteOptions,
) -> Result<(Picture<'a>, u8), ImageError> {
    let picture = picture(name, image)?;
    let bits = bits(name, format, options)?;
    let [width, height] = image.resolution();
    let largest = match format {
        Format::Jpeg | Format::Tga => 65535,
        Format::Webp => 16383,
        _ => 1 << 24,
    };
    if width.max(height) > largest || width.saturating_mul(height) > 1 << 31 {
        let why = format!("its display window, {width} x {height}, is too large for the format");
        return Err(unwritable(name, why));
    }
    Ok((picture, bits))
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
    let why = format!("the format has no components of {bits} bits, only of {}", list.join(", "));
    Err(unwritable(name, why))
}

/// The display window's pixels, interleaved.
fn pixels(image: &Image<'_>, picture: &Picture<'_>, count: usize, divide: bool) -> Vec<f32> {
    let [width, height] = image.resolution();
    let [left, top] = image.metadata.origin.map(i64::from);
    let mut pixels = vec![0f32; width * height * count];
    pixels.par_chunks_exact_mut(width * count).enumerate().for_each(|(row, line)| {
        let y = row as i64 - top;
        if y < 0 || y >= image.height as i64 {
            return;
        }
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
