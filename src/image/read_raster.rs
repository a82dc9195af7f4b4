//! PNG, JPEG, TIFF, HDR, BMP, TGA and WebP, through the `image` crate.
//!
//! Whole numbers are taken as sRGB and decoded to linear light, alpha as linear, and the colour is
//! then premultiplied, as the colours of EXR files are. Float files (HDR, float TIFF) are linear
//! already. With `raw` the numbers stay as stored, scaled to 0..1.

use super::error::{ErrorKind, ImageError};
use super::file::{Channel, Samples};
use super::source::Input;
use super::{color, guard};
use ::image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::io::BufReader;

/// What the header of such a file says.
pub(crate) struct Raster {
    /// Columns and rows.
    pub size: [usize; 2],
    /// The format's name.
    pub format: &'static str,
    kind: ImageFormat,
    color: ColorType,
    raw: bool,
    limit: u64,
}

const FORMATS: [(ImageFormat, &str); 7] = [
    (ImageFormat::Png, "PNG"),
    (ImageFormat::Jpeg, "JPEG"),
    (ImageFormat::Tiff, "TIFF"),
    (ImageFormat::Hdr, "Radiance HDR"),
    (ImageFormat::Bmp, "BMP"),
    (ImageFormat::Tga, "TGA"),
    (ImageFormat::WebP, "WebP"),
];

impl Raster {
    /// Reads and checks the header.
    pub fn open(input: &Input, raw: bool) -> Result<Raster, ImageError> {
        let name = input.name();
        let (reader, length) = input.open()?;
        let mut reader = ImageReader::new(BufReader::new(reader))
            .with_guessed_format()
            .map_err(|e| ImageError::io("read", &name, &e))?;
        // TGA alone has no mark at its start by which to know it.
        if reader.format().is_none() && input.extension() == "tga" {
            reader.set_format(ImageFormat::Tga);
        }
        let known = reader.format().and_then(|kind| FORMATS.iter().find(|(k, _)| *k == kind));
        let Some(&(kind, format)) = known else {
            let message = format!("`{name}` is no image of a format that is read");
            return Err(ImageError::new(ErrorKind::UnknownFormat, message)
                .hint("Formats: OpenEXR, PNG, JPEG, TIFF, Radiance HDR, BMP, TGA, WebP."));
        };
        reader.no_limits();
        let (size, color) = guard::contain(|| {
            let decoder = reader.into_decoder()?;
            Ok((decoder.dimensions(), decoder.color_type()))
        })
        .ok_or_else(|| ImageError::damaged(&name, "its header makes no sense"))?
        .map_err(|e| explain(&name, e))?;
        let (width, height) = (u64::from(size.0), u64::from(size.1));
        let pixel = u64::from(color.bytes_per_pixel());
        guard::check_size(&name, width, height, pixel, length)?;
        if width == 0 || height == 0 {
            return Err(ImageError::damaged(&name, "it has no pixels"));
        }
        // Room for the decoder's own buffers too.
        let limit = (width * height * pixel).saturating_mul(4) + (64 << 20);
        Ok(Raster { size: [size.0 as usize, size.1 as usize], format, kind, color, raw, limit })
    }

    /// `R G B A`, or for a grey image its luminance `Y`.
    pub fn channels(&self) -> Vec<Channel> {
        let names: &[&str] = match self.color.channel_count() {
            1 => &["Y"],
            2 => &["Y", "A"],
            3 => &["R", "G", "B"],
            _ => &["R", "G", "B", "A"],
        };
        let samples = match self.color.bytes_per_pixel() / self.color.channel_count() {
            1 => Samples::Byte,
            2 => Samples::Short,
            _ => Samples::Float,
        };
        let channel =
            |(index, name): (usize, &&str)| Channel { name: name.to_string(), part: 0, index, samples };
        names.iter().enumerate().map(channel).collect()
    }

    /// The planes of all channels.
    pub fn decode(&self, input: &Input) -> Result<Vec<Vec<f32>>, ImageError> {
        let name = input.name();
        let (reader, _) = input.open()?;
        let mut reader = ImageReader::with_format(BufReader::new(reader), self.kind);
        let mut limits = Limits::default();
        limits.max_alloc = Some(self.limit);
        reader.limits(limits);
        let image = guard::contain(|| reader.decode())
            .ok_or_else(|| ImageError::damaged(&name, "its pixels make no sense"))?
            .map_err(|e| explain(&name, e))?;
        if [image.width() as usize, image.height() as usize] != self.size || image.color() != self.color {
            return Err(ImageError::damaged(&name, "its pixels are not what its header says"));
        }
        Ok(self.planes(&image))
    }

    fn planes(&self, image: &DynamicImage) -> Vec<Vec<f32>> {
        let count = usize::from(self.color.channel_count());
        let alpha = self.color.has_alpha().then(|| count - 1);
        let is_alpha = |c: usize| Some(c) == alpha;
        let mut planes = Vec::with_capacity(count);
        if let Some(codes) = image.as_flat_samples_u8() {
            let samples = codes.as_slice();
            let plain = |c: usize| self.raw || is_alpha(c);
            for c in 0..count {
                planes.push(gather(samples, count, c, |v| {
                    if plain(c) { f32::from(v) / 255.0 } else { color::decode8(v) }
                }));
            }
        } else if let Some(codes) = image.as_flat_samples_u16() {
            let samples = codes.as_slice();
            for c in 0..count {
                planes.push(gather(samples, count, c, |v| {
                    if self.raw || is_alpha(c) { f32::from(v) / 65535.0 } else { color::decode16(v) }
                }));
            }
        } else {
            let samples = image.as_flat_samples_f32().map_or(&[][..], |s| s.samples);
            for c in 0..count {
                planes.push(gather(samples, count, c, |v| v));
            }
            return planes;
        }
        if let Some(a) = alpha
            && !self.raw
        {
            let (colors, alpha) = planes.split_at_mut(a);
            for plane in colors {
                plane.iter_mut().zip(&alpha[0]).for_each(|(c, a)| *c *= a);
            }
        }
        planes
    }
}

/// Component `c` of interleaved samples.
fn gather<T: Copy + Sync>(
    samples: &[T],
    count: usize,
    c: usize,
    convert: impl Fn(T) -> f32 + Sync + Send,
) -> Vec<f32> {
    use rayon::prelude::*;
    samples.par_chunks_exact(count).with_min_len(4096).map(|pixel| convert(pixel[c])).collect()
}

fn explain(name: &str, error: ::image::ImageError) -> ImageError {
    match error {
        ::image::ImageError::IoError(e) => ImageError::io("read", name, &e),
        ::image::ImageError::Limits(_) => ImageError::new(
            ErrorKind::TooLarge,
            format!("`{name}` needs more memory than its size justifies"),
        ),
        ::image::ImageError::Unsupported(e) => {
            ImageError::new(ErrorKind::Unsupported, format!("`{name}` cannot be read: {e}"))
        }
        other => ImageError::damaged(name, other),
    }
}
