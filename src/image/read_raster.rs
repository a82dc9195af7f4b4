//! PNG, JPEG, TIFF, HDR, BMP, TGA and WebP: here the header; `scan_raster` has the pixels. TIFF and TGA have readers of
//! their own, the others are read by the `image` crate.
//!
//! Whole numbers are taken as sRGB and decoded to linear light, alpha as linear, and the colour is
//! multiplied by alpha unless the file says that it is already, as the colours of EXR files are. Floats (HDR, float
//! TIFF) are linear. The picture is turned as its EXIF orientation says. With `raw` the numbers stay as they are
//! stored, scaled to 0..1, and where they are stored.

use super::error::{ErrorKind, ImageError};
use super::file::{Channel, Samples};
use super::layout::{Layout, oriented_size};
use super::scan_raster::MAX_PNG_MEMORY;
use super::source::Input;
use super::tga::Tga;
use super::tiff::Tiff;
use super::{bmp, guard, hdr, png_chunks, tga, tiff};
use ::image::{ImageDecoder, ImageFormat, ImageReader, Limits};
use std::io::{BufReader, Cursor, Read};

/// What the header of such a file says.
pub(crate) struct Raster {
    /// Columns and rows, turned.
    pub size: [usize; 2],
    /// The format's name.
    pub format: &'static str,
    /// Why it has to be decoded as a whole; `None`: row by row.
    pub whole: Option<&'static str>,
    pub(super) layout: Layout,
    pub(super) decoder: Decoder,
    /// Columns and rows as they are stored.
    pub(super) stored: [usize; 2],
    /// The orientation that the file asks for, 1 to 8 as in EXIF.
    pub(super) orientation: u8,
    pub(super) raw: bool,
    /// Bytes that decoding may take.
    pub(super) limit: u64,
}

/// What decodes the pixels.
pub(super) enum Decoder {
    Image(ImageFormat),
    Tiff(Box<Tiff>),
    Tga(Box<Tga>),
    Hdr(hdr::Header),
}

const FORMATS: [(ImageFormat, &str); 4] = [
    (ImageFormat::Png, "PNG"),
    (ImageFormat::Jpeg, "JPEG"),
    (ImageFormat::Bmp, "BMP"),
    (ImageFormat::WebP, "WebP"),
];

impl Raster {
    /// Reads and checks the header.
    pub fn open(input: &Input, raw: bool) -> Result<Raster, ImageError> {
        let name = input.name();
        let (reader, length) = input.open()?;
        let mut start = Vec::new();
        let read = reader.take(hdr::LONGEST_HEADER).read_to_end(&mut start);
        read.map_err(|e| ImageError::io("read", &name, &e))?;
        let (format, stored, layout, decoder, orientation) = if tiff::is_tiff(&start) {
            let tiff = Tiff::open(input)?;
            let orientation = tiff.orientation;
            ("TIFF", tiff.size, tiff.layout.clone(), Decoder::Tiff(Box::new(tiff)), orientation)
        } else if hdr::is_hdr(&start) {
            let header = hdr::header(&name, &start)?;
            let layout = Layout::simple(3, Samples::Float);
            ("Radiance HDR", header.size, layout, Decoder::Hdr(header), 1)
        } else if let Ok(kind) = ::image::guess_format(&start)
            && let Some(&(_, format)) = FORMATS.iter().find(|(k, _)| *k == kind)
        {
            if kind == ImageFormat::WebP && riff_length(&start) > length {
                return Err(ImageError::damaged(&name, "it ends too early"));
            }
            let (size, layout, orientation) = header_of(input, kind)?;
            (format, size, layout, Decoder::Image(kind), orientation)
        } else if tga::is_tga(input)? {
            let tga = Tga::open(input)?;
            ("TGA", tga.size, tga.layout.clone(), Decoder::Tga(Box::new(tga)), 1)
        } else {
            let message = format!("`{name}` is not an image in a format that pse reads");
            return Err(ImageError::new(ErrorKind::UnknownFormat, message)
                .hint("Formats: OpenEXR, PNG, JPEG, TIFF, Radiance HDR, BMP, TGA, WebP."));
        };
        let [width, height] = stored.map(|n| n as u64);
        guard::check_size(&name, width, height, layout.pixel_bytes(), length)?;
        if width == 0 || height == 0 {
            return Err(ImageError::damaged(&name, "it has no pixels"));
        }
        // Room for the decoder's own buffers too.
        let limit = (width * height * layout.pixel_bytes()).saturating_mul(4) + (64 << 20);
        // An HDR's order of rows is part of how it is stored.
        let turned = if raw { 1 } else { orientation };
        let whole = match decoder {
            Decoder::Image(ImageFormat::Png) if turned != 1 => Some("the picture must be rotated"),
            Decoder::Image(ImageFormat::Png) if is_interlaced(input, &name)? => {
                Some("the rows of an interlaced PNG are complete at its end only")
            }
            Decoder::Image(ImageFormat::Png) => None,
            _ => Some("only EXR and PNG are decoded row by row"),
        };
        if whole.is_some() {
            guard::check_decoded(&name, [width, height], layout.channels.len() as u64, length)?;
        }
        let turned = if let Decoder::Hdr(header) = &decoder { header.orientation } else { turned };
        let size = oriented_size(stored, turned);
        Ok(Raster { size, format, whole, layout, decoder, stored, orientation, raw, limit })
    }

    /// The channels: `R G B A`, or for a grey image its luminance `Y`; a TIFF may have further ones.
    pub fn channels(&self) -> Vec<Channel> {
        self.layout.list()
    }

    /// How the stored picture is turned, as an EXIF orientation.
    pub(super) fn turned(&self) -> u8 {
        match &self.decoder {
            Decoder::Hdr(header) => header.orientation,
            _ if self.raw => 1,
            _ => self.orientation,
        }
    }

    /// What may surprise of how it is stored; each a sentence.
    pub(super) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let turn = match self.orientation {
            2 => "mirrored left to right",
            3 => "rotated by 180 degrees",
            4 => "mirrored top to bottom",
            5 => "mirrored left to right, then rotated by 90 degrees to the left",
            6 => "rotated by 90 degrees to the right",
            7 => "mirrored left to right, then rotated by 90 degrees to the right",
            8 => "rotated by 90 degrees to the left",
            _ => "",
        };
        if !turn.is_empty() {
            let [width, height] = self.stored;
            notes.push(match self.raw {
                false => format!(
                    "Orientation {} of the file is applied: its {width} x {height} pixels are {turn}.",
                    self.orientation
                ),
                true => format!(
                    "Orientation {} of the file (its pixels {turn}) is not applied, because of --raw.",
                    self.orientation
                ),
            });
        }
        if self.layout.alpha.is_some_and(|alpha| alpha.associated) {
            notes.push("The stored colour is already multiplied by alpha, as the file says.".into());
        }
        notes
    }
}

/// The length of a WebP file, as its first bytes declare it.
fn riff_length(start: &[u8]) -> u64 {
    start.get(4..8).and_then(|b| b.first_chunk()).map_or(0, |&b| 8 + u64::from(u32::from_le_bytes(b)))
}

/// Size, channels and orientation of a picture that the `image` crate decodes.
fn header_of(input: &Input, kind: ImageFormat) -> Result<([usize; 2], Layout, u8), ImageError> {
    let name = input.name();
    let contained = guard::contain(|| {
        let mut decoder: Box<dyn ImageDecoder> = match kind {
            ImageFormat::Bmp => Box::new(bmp_reader(input)?.into_decoder().map_err(|e| explain(&name, e))?),
            _ => {
                let (reader, _) = input.open()?;
                let mut reader = ImageReader::with_format(BufReader::new(reader), kind);
                reader.no_limits();
                if kind == ImageFormat::Png {
                    // Its colour profile is packed, and read here though nobody asks for it.
                    let mut limits = Limits::no_limits();
                    limits.max_alloc = Some(MAX_PNG_MEMORY);
                    reader.limits(limits);
                }
                Box::new(reader.into_decoder().map_err(|e| explain(&name, e))?)
            }
        };
        let (width, height) = decoder.dimensions();
        let block = match kind {
            ImageFormat::Jpeg | ImageFormat::WebP => decoder.exif_metadata().ok().flatten(),
            _ => None,
        };
        let orientation = block.and_then(|block| tiff::exif_orientation(&block));
        Ok(([width as usize, height as usize], decoder.color_type(), orientation))
    });
    let (size, color, mut orientation) =
        contained.ok_or_else(|| ImageError::damaged(&name, "its header is invalid"))??;
    if kind == ImageFormat::Png {
        orientation = png_chunks::orientation(&name, &mut input.open()?.0)?;
    }
    let samples = match color.bytes_per_pixel() / color.channel_count() {
        1 => Samples::Byte,
        2 => Samples::Short,
        _ => Samples::Float,
    };
    Ok((size, Layout::simple(color.channel_count().into(), samples), orientation.unwrap_or(1)))
}

/// A reader of a BMP file, whatever its header.
pub(super) fn bmp_reader(
    input: &Input,
) -> Result<ImageReader<BufReader<Box<dyn super::source::ReadSeek>>>, ImageError> {
    let name = input.name();
    let (mut reader, _) = input.open()?;
    let mut start = [0; 18];
    let read = reader.read_exact(&mut start).and_then(|()| reader.rewind());
    read.map_err(|e| ImageError::io("read", &name, &e))?;
    if matches!(start[14..], [16 | 64, 0, 0, 0]) {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).map_err(|e| ImageError::io("read", &name, &e))?;
        if let Some(usual) = bmp::usual(&name, &bytes)? {
            reader = Box::new(Cursor::new(usual));
        }
    }
    let mut reader = ImageReader::with_format(BufReader::new(reader), ImageFormat::Bmp);
    reader.no_limits();
    Ok(reader)
}

/// Whether the rows of a PNG come in several passes; also checks that its bytes can hold its rows.
fn is_interlaced(input: &Input, name: &str) -> Result<bool, ImageError> {
    let (reader, length) = input.open()?;
    let mut decoder = super::scan_raster::png_decoder(reader, MAX_PNG_MEMORY);
    let header = |about: &png::Info<'_>| {
        let row = about.bits_per_pixel() as u64 * u64::from(about.width);
        (about.interlaced, guard::fits_deflate(row, about.height.into(), length))
    };
    let (interlaced, fits) = guard::contain(|| decoder.read_header_info().map(header))
        .ok_or_else(|| ImageError::damaged(name, "its header is invalid"))?
        .map_err(|e| super::scan_raster::explain_png(name, e))?;
    if !fits {
        return Err(ImageError::damaged(name, "it ends too early"));
    }
    Ok(interlaced)
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
