//! Writing images: which format, and what every format has in common.

use super::Image;
use super::RasterWriter;
use super::atomic::NewFile;
use super::error::{ErrorKind, ImageError};
use super::write_exr::ExrWriter;
use std::io::Cursor;
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
                Some(e) => format!("cannot write `{path}`: unknown format `.{e}`"),
                None => format!("cannot write `{path}`: the name has no extension for the format"),
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
    /// Pictures: write `color` as it is, with no sRGB encoding and no division by alpha; whole numbers from 0 to 1.
    pub raw: bool,
    /// EXR and PNG: a word for the header that says which run the file comes from; see [`is_whole`](super::is_whole).
    pub stamp: Option<String>,
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
            stamp: None,
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
    let mut writer = Writer::create(path, image.height, options)?;
    writer.rows(image)?;
    writer.finish()
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
    check(name, image)?;
    match format {
        Format::Exr => {
            let mut bytes = Cursor::new(Vec::new());
            let mut writer = ExrWriter::new(name, image, image.height, options)?;
            writer.rows(image, &mut bytes)?;
            writer.finish(&mut bytes)?;
            Ok(bytes.into_inner())
        }
        _ => {
            let mut bytes = Cursor::new(Vec::new());
            let mut writer = RasterWriter::new(name, format, image, image.height, options)?;
            writer.rows(image, &mut bytes)?;
            writer.finish(&mut bytes)?;
            Ok(bytes.into_inner())
        }
    }
}

/// An image file that is written from the top down, a few rows at a time. It appears when it is finished, or not at
/// all.
pub struct Writer {
    file: NewFile,
    format: Format,
    options: WriteOptions,
    /// The rows of the whole.
    height: usize,
    content: Content,
}

/// What was written so far.
enum Content {
    Nothing,
    Exr(Box<ExrWriter>),
    Picture(Box<RasterWriter>),
}

impl Writer {
    /// Begins an image of so many rows.
    ///
    /// # Errors
    /// If the extension names no format, or the file can't be made.
    pub fn create(path: &Path, height: usize, options: &WriteOptions) -> Result<Writer, ImageError> {
        let format = match options.format {
            Some(format) => format,
            None => Format::of(path)?,
        };
        let file = NewFile::create(path)?;
        Ok(Writer { file, format, options: options.clone(), height, content: Content::Nothing })
    }

    /// Adds the next rows: an image with the same variables as the one before, that lies below it.
    ///
    /// # Errors
    /// If the format can't hold it, or the operating system refuses.
    pub fn rows(&mut self, rows: &Image<'_>) -> Result<(), ImageError> {
        let name = self.file.name().to_string();
        check(&name, rows)?;
        match (&mut self.content, self.format) {
            (Content::Nothing, Format::Exr) => {
                let mut writer = ExrWriter::new(&name, rows, self.height, &self.options)?;
                writer.rows(rows, &mut self.file)?;
                self.content = Content::Exr(Box::new(writer));
            }
            (Content::Nothing, format) => {
                // What can't be encoded is said before the rest is computed.
                let mut writer = RasterWriter::new(&name, format, rows, self.height, &self.options)?;
                writer.rows(rows, &mut self.file)?;
                self.content = Content::Picture(Box::new(writer));
            }
            (Content::Exr(writer), _) => writer.rows(rows, &mut self.file)?,
            (Content::Picture(writer), _) => writer.rows(rows, &mut self.file)?,
        }
        Ok(())
    }

    /// All rows are there: the file appears.
    ///
    /// # Errors
    /// If the format can't hold the image, or the operating system refuses. For a closed pipe
    /// [`ImageError::is_broken_pipe`] holds.
    pub fn finish(mut self) -> Result<(), ImageError> {
        let name = self.file.name().to_string();
        match self.content {
            Content::Nothing => return Err(unwritable(&name, "the image has no pixels")),
            Content::Exr(writer) => writer.finish(&mut self.file)?,
            Content::Picture(writer) => writer.finish(&mut self.file)?,
        }
        self.file.finish()
    }
}

/// Is it an image at all?
fn check(name: &str, image: &Image<'_>) -> Result<(), ImageError> {
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
    Ok(())
}

pub(crate) fn unwritable(name: &str, why: impl std::fmt::Display) -> ImageError {
    ImageError::new(ErrorKind::Unwritable, format!("cannot write `{name}`: {why}"))
}
