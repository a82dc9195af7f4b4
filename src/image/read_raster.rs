//! PNG, JPEG, TIFF, HDR, BMP, TGA and WebP, through the `image` crate: here the header; `scan_raster` has the pixels.
//!
//! Whole numbers are taken as sRGB and decoded to linear light, alpha as linear, and the colour is
//! then premultiplied, as the colours of EXR files are. Float files (HDR, float TIFF) are linear
//! already. With `raw` the numbers stay as stored, scaled to 0..1.

use super::error::{ErrorKind, ImageError};
use super::file::{Channel, Samples};
use super::guard;
use super::scan_raster::rows_of_png;
use super::source::Input;
use ::image::{ColorType, ImageDecoder, ImageFormat, ImageReader};
use std::io::BufReader;

/// What the header of such a file says.
pub(crate) struct Raster {
    /// Columns and rows.
    pub size: [usize; 2],
    /// The format's name.
    pub format: &'static str,
    /// Why it has to be decoded as a whole; `None`: row by row.
    pub whole: Option<&'static str>,
    pub(super) kind: ImageFormat,
    pub(super) color: ColorType,
    pub(super) raw: bool,
    /// Bytes that decoding may take.
    pub(super) limit: u64,
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
        let whole = match kind {
            ImageFormat::Png => rows_of_png(input, &name)?,
            _ => Some("only EXR and PNG are decoded row by row"),
        };
        if whole.is_some() {
            guard::check_decoded(&name, [width, height], u64::from(color.channel_count()), length)?;
        }
        Ok(Raster { size: [size.0 as usize, size.1 as usize], format, whole, kind, color, raw, limit })
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
}

pub(super) fn explain(name: &str, error: ::image::ImageError) -> ImageError {
    match error {
        ::image::ImageError::IoError(e) => ImageError::io("read", name, &e),
        ::image::ImageError::Limits(_) => greedy(name),
        ::image::ImageError::Unsupported(e) => {
            ImageError::new(ErrorKind::Unsupported, format!("`{name}` cannot be read: {e}"))
        }
        other => ImageError::damaged(name, other),
    }
}

/// A file whose decoding would take more memory than its pixels can need.
pub(super) fn greedy(name: &str) -> ImageError {
    ImageError::new(ErrorKind::TooLarge, format!("`{name}` needs more memory than its size justifies"))
}
