//! Writing images: which format, and what every format has in common.

use super::error::{ErrorKind, ImageError};
use super::{Image, atomic, write_exr, write_raster};
use std::io::Write;
use std::path::Path;

/// A file format that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// OpenEXR: every variable, as floats.
    Exr,
    /// PNG, 8 or 16 bits.
    Png,
    /// JPEG, 8 bits, no alpha.
    Jpeg,
    /// TIFF, 8 or 16 bits, or 32-bit float (linear).
    Tiff,
    /// Radiance HDR: linear, no alpha.
    Hdr,
    /// BMP, 8 bits.
    Bmp,
    /// TGA, 8 bits.
    Tga,
    /// WebP without loss, 8 bits.
    Webp,
}

/// Extensions and what they mean, in the order in which messages list them.
const EXTENSIONS: [(&str, Format); 10] = [
    ("exr", Format::Exr),
    ("png", Format::Png),
    ("jpg", Format::Jpeg),
    ("jpeg", Format::Jpeg),
    ("tif", Format::Tiff),
    ("tiff", Format::Tiff),
    ("hdr", Format::Hdr),
    ("bmp", Format::Bmp),
    ("tga", Format::Tga),
    ("webp", Format::Webp),
];

impl Format {
    /// The format that a path's extension names, in any case; `-`, standard output, is EXR.
    ///
    /// # Errors
    /// If the extension names none, with those that there are.
    pub fn of(path: &Path) -> Result<Format, ImageError> {
        if path.as_os_str() == "-" {
            return Ok(Format::Exr);
        }
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let found = EXTENSIONS.iter().find(|(e, _)| Some(*e) == extension.as_deref());
        found.map(|(_, format)| *format).ok_or_else(|| {
            let path = path.display();
            let message = match extension {
                Some(e) => format!("cannot write `{path}`: `.{e}` is no format that is written"),
                None => format!("cannot write `{path}`: its name has no extension to tell the format"),
            };
            let list: Vec<String> = EXTENSIONS.iter().map(|(e, _)| format!(".{e}")).collect();
            ImageError::new(ErrorKind::UnknownFormat, message).hint(format!("Formats: {}.", list.join(" ")))
        })
    }
}

/// How an EXR file is compressed; all without loss.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// Not at all.
    None,
    /// Run lengths.
    Rle,
    /// Deflate, row by row.
    Zips,
    /// Deflate, sixteen rows at a time.
    #[default]
    Zip,
    /// Wavelets; good for grainy images.
    Piz,
}

/// How to write.
#[derive(Clone, Debug)]
pub struct WriteOptions {
    /// The format; `None`: the extension tells.
    pub format: Option<Format>,
    /// EXR: store 16-bit floats, but for `surface`, `point`, `depth` and cryptomattes, whose exact
    /// values matter.
    pub half: bool,
    /// EXR: the compression.
    pub compression: Compression,
    /// PNG and TIFF: bits for each component, 8 or 16 (TIFF also 32, as floats); `None`: 8.
    pub bits: Option<u8>,
    /// JPEG: 1 to 100.
    pub quality: u8,
    /// Formats with whole numbers: write `color` as it is, 0..1, with no sRGB encoding and no
    /// un-premultiplication.
    pub raw: bool,
}

impl Default for WriteOptions {
    fn default() -> WriteOptions {
        WriteOptions {
            format: None,
            half: false,
            compression: Compression::Zip,
            bits: None,
            quality: 92,
            raw: false,
        }
    }
}

/// Writes an image to a file, which appears whole or not at all, or for `-` to standard output.
///
/// The same image and options give the same bytes.
///
/// # Errors
/// If the extension names no format, the format can't hold the image, or the operating system
/// refuses. For a closed pipe [`ImageError::is_broken_pipe`] holds.
pub fn write(path: &Path, image: &Image<'_>, options: &WriteOptions) -> Result<(), ImageError> {
    let format = match options.format {
        Some(format) => format,
        None => Format::of(path)?,
    };
    let name = match path.as_os_str() == "-" {
        true => "standard output".to_string(),
        false => path.display().to_string(),
    };
    let bytes = encode(&name, format, image, options)?;
    if path.as_os_str() != "-" {
        return atomic::write_file(path, &bytes);
    }
    let mut out = std::io::stdout().lock();
    out.write_all(&bytes).and_then(|()| out.flush()).map_err(|e| ImageError::io("write", &name, &e))
}

/// The bytes of a file; `name` is what messages call it.
///
/// # Errors
/// If the format can't hold the image.
pub fn encode(
    name: &str,
    format: Format,
    image: &Image<'_>,
    options: &WriteOptions,
) -> Result<Vec<u8>, ImageError> {
    let refuse = |why: String| Err(unwritable(name, why));
    if image.width == 0 || image.height == 0 {
        return refuse("the image has no pixels".into());
    }
    for (i, variable) in image.variables.iter().enumerate() {
        let cells = variable.shape.cells();
        let whole = variable.planes.iter().all(|p| p.len() == image.width * image.height);
        if variable.planes.len() != cells || !whole {
            return refuse(format!("the planes of `{}` do not fit its shape and the image", variable.name));
        }
        if image.variables[..i].iter().any(|v| v.name == variable.name) {
            return refuse(format!("it would hold `{}` twice", variable.name));
        }
    }
    match format {
        Format::Exr => write_exr::encode(name, image, options),
        _ => write_raster::encode(name, format, image, options),
    }
}

pub(crate) fn unwritable(name: &str, why: impl std::fmt::Display) -> ImageError {
    ImageError::new(ErrorKind::Unwritable, format!("cannot write `{name}`: {why}"))
}
