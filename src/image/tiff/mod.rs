//! TIFF: what the directory of the first image says, and its pixels.
//!
//! Strips and tiles, chunky or planar, of whole numbers of 1 to 32 and 64 bits and floats of 16, 24, 32 and 64; the
//! other modules have the compressions, the samples and the colours. What is not read is refused by its name.

mod chunks;
mod codec;
mod color;
mod directory;
mod fax;
mod jpeg;
mod samples;

pub(super) use directory::{exif_orientation, is_tiff};

use super::error::{ErrorKind, ImageError};
use super::file::Samples;
use super::guard;
use super::layout::{Alpha, Layout};
use super::source::Input;
use codec::Compression;
use color::Photometric;
use directory::{Directory, TiffReader};
use samples::{Kind, Storage};

/// The first image of a TIFF file, as its directory describes it.
pub(super) struct Tiff {
    /// Columns and rows as they are stored.
    pub size: [usize; 2],
    /// The channels that the pixels are decoded to.
    pub layout: Layout,
    /// The orientation, from 1 to 8.
    pub orientation: u8,
    compression: Compression,
    photometric: Photometric,
    storage: Storage,
    /// Samples of a pixel, with the extra ones.
    count: usize,
    planar: bool,
    reversed: bool,
    two_dimensional: bool,
    /// Columns and rows of a strip or tile.
    chunk: [usize; 2],
    tiled: bool,
    /// Luminance samples for each chroma sample, across and down.
    subsampling: [usize; 2],
}

/// The error that a feature is not read.
fn unsupported(name: &str, feature: impl std::fmt::Display) -> ImageError {
    ImageError::new(ErrorKind::Unsupported, format!("`{name}` cannot be read: TIFF with {feature}"))
}

impl Tiff {
    /// Reads and checks the directory.
    pub fn open(input: &Input) -> Result<Tiff, ImageError> {
        let (mut file, directory) = TiffReader::open(input)?;
        Tiff::new(&mut file, &directory)
    }

    fn new(file: &mut TiffReader, directory: &Directory) -> Result<Tiff, ImageError> {
        let name = file.name().to_string();
        let refuse = |feature: String| unsupported(&name, feature);
        let mut number = |tag: u16| directory.number(file, tag);
        let (Some(width), Some(height)) = (number(256)?, number(257)?) else {
            return Err(ImageError::damaged(&name, "its size is missing"));
        };
        let compression = Compression::of(number(259)?.unwrap_or(1))
            .map_err(|method| refuse(format!("{method} compression")))?;
        let predictor = number(317)?.unwrap_or(1);
        let given = number(277)?;
        let photometric = number(262)?;
        let planar = number(284)? == Some(2);
        let reversed = number(266)? == Some(2) && compression.reversible();
        let two_dimensional = number(292)?.unwrap_or(0) & 1 == 1;
        let ink_set = number(332)?.unwrap_or(1);
        let bits = directory.numbers(file, 258)?;
        let formats = directory.numbers(file, 339)?;
        let count = match given {
            Some(count) => count,
            None if bits.len() > 1 => bits.len() as u64,
            None if matches!(photometric, Some(2 | 6 | 8)) => 3,
            None => 1,
        };
        if count == 0 || count > 4096 {
            return Err(refuse(format!("{count} samples for each pixel")));
        }
        let count = count as usize;
        let mut same = bits.iter().take(count);
        let first = same.next().copied().unwrap_or(if compression == Compression::OldJpeg { 8 } else { 1 });
        if same.any(|&b| b != first) {
            return Err(refuse("samples of different sizes".into()));
        }
        let format = formats.first().copied().unwrap_or(1);
        if formats.iter().take(count).any(|&f| f != format) {
            return Err(refuse("samples of different kinds".into()));
        }
        let kind = match format {
            2 => Kind::Signed,
            3 => Kind::Float,
            5 | 6 => return Err(refuse("complex numbers".into())),
            _ => Kind::Unsigned,
        };
        let eight = matches!(compression, Compression::Jpeg | Compression::OldJpeg | Compression::Webp);
        let fax =
            matches!(compression, Compression::Huffman { .. } | Compression::Group3 | Compression::Group4);
        // Compressions of pictures have no predictor, whatever the tag says.
        let predictor = if eight || fax { 1 } else { predictor };
        let storage =
            Storage { kind, bits: first.min(65) as usize, big_endian: file.big_endian(), predictor };
        storage.check().map_err(refuse)?;
        if eight && (storage.bits != 8 || kind != Kind::Unsigned) {
            return Err(refuse(format!("{} bits inside of JPEG or WebP", storage.bits)));
        }
        if fax && (storage.bits != 1 || count > 1 && !planar) {
            return Err(refuse("fax compression of more than one bit for each pixel".into()));
        }
        let photometric = Photometric::of(file, directory, photometric, count, &storage, ink_set)?;
        let subsampling = match (&photometric, directory.numbers(file, 530)?.as_slice()) {
            (Photometric::YCbCr(_), &[across, down, ..]) => [across, down],
            (Photometric::YCbCr(_), _) => [2, 2],
            _ => [1, 1],
        };
        if !subsampling.iter().all(|s| matches!(s, 1 | 2 | 4)) {
            return Err(refuse("this subsampling of its chroma".into()));
        }
        // JPEG decoders give the full resolution, and so does WebP.
        let subsampling = if eight { [1, 1] } else { subsampling.map(|s| s as usize) };
        if subsampling != [1, 1] && (planar || count != 3 || storage.bits != 8 || predictor > 1) {
            return Err(refuse(
                "subsampled chroma in planes, beside other samples, of other than 8 bits or with a predictor"
                    .into(),
            ));
        }
        let tiled = directory.has(322) && directory.has(323);
        let mut number = |tag: u16| directory.number(file, tag);
        let chunk = match tiled {
            true => [number(322)?.unwrap_or(0), number(323)?.unwrap_or(0)],
            false => [width, number(278)?.filter(|&rows| rows > 0).unwrap_or(height).min(height)],
        };
        let orientation = directory.orientation(file).unwrap_or(1);
        let layout = layout(file, directory, &photometric, &storage, count)?;
        let pixel = layout.channels.len() as u64 * layout.sample_bytes();
        guard::check_size(&name, width, height, pixel, file.length())?;
        let stored = (count * storage.bits) as u64;
        guard::check_bits(&name, chunk[0], chunk[1], stored, file.length())?;
        if width == 0 || height == 0 || chunk.contains(&0) {
            return Err(ImageError::damaged(&name, "it has no pixels"));
        }
        if compression == Compression::None {
            let room = width.saturating_mul(height).saturating_mul(stored) / 8;
            if subsampling == [1, 1] && room > file.length() {
                return Err(ImageError::damaged(&name, "it ends too early"));
            }
        }
        Ok(Tiff {
            size: [width as usize, height as usize],
            layout,
            orientation,
            compression,
            photometric,
            storage,
            count,
            planar,
            reversed,
            two_dimensional,
            chunk: chunk.map(|c| c as usize),
            tiled,
            subsampling,
        })
    }
}

/// The channels: those of the colour, the first extra sample that is alpha, and the other extra samples by number.
fn layout(
    file: &mut TiffReader,
    directory: &Directory,
    photometric: &Photometric,
    storage: &Storage,
    count: usize,
) -> Result<Layout, ImageError> {
    let own = photometric.samples();
    let names = photometric.channels();
    let extra = directory.numbers(file, 338)?;
    let listed = directory.has(338);
    let mut alpha = None;
    let mut channels: Vec<String> = names.iter().map(|n| n.to_string()).collect();
    for i in own..count {
        let associated = match extra.get(i - own) {
            Some(1) => Some(true),
            Some(2 | 999) => Some(false),
            // Many writers leave the tag out: whole numbers are then not multiplied, floats are.
            None if !listed && i == own && matches!((own, count), (1, 2) | (3, 4)) => {
                Some(storage.kind == Kind::Float)
            }
            _ => None,
        };
        match associated.filter(|_| alpha.is_none()) {
            Some(associated) => {
                alpha = Some(Alpha { channel: channels.len(), associated });
                channels.push("A".into());
            }
            None => channels.push(format!("sample{}", i + 1)),
        }
    }
    let samples = match (storage.kind, storage.bits) {
        (Kind::Float, 16) => Samples::Half,
        (Kind::Float, 64) => Samples::Double,
        (Kind::Float, _) => Samples::Float,
        (_, 8) => Samples::Byte,
        (_, 16) => Samples::Short,
        (_, bits) => Samples::Bits(bits as u8),
    };
    let decoded = photometric.decoded(storage);
    Ok(Layout { channels, samples, alpha, decoded, linear: photometric.linear(storage) })
}
