//! OpenEXR files: any channels, parts, tiles and compressions. Here the header; `scan_exr` has the pixels.
//!
//! The `exr` crate parses each part's attributes and decompresses blocks; which blocks are read, in which order, and
//! where their numbers go, is decided by us, so that only the parts with wanted channels are touched
//! and what a file claims is checked before it is believed. A part or a channel that is not read is listed with the
//! reason, and does not keep the others from being read.

use super::bind::ChannelName;
use super::chroma::Window;
use super::error::{ErrorKind, ImageError};
use super::file::{Channel, Samples};
use super::header_exr::{self, RawHeader, RawPart};
use super::part_names::{self, PartNames};
use super::source::Input;
use super::{Attributes, Metadata, guard, sampled_blocks};
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, Chromaticities, SampleType};
use exr::meta::header::Header;
use std::collections::BTreeMap;
use std::io::Read;

/// The header of an EXR file, checked.
pub(crate) struct Exr {
    pub(super) parts: Vec<ExrPart>,
    /// Are blocks marked with the number of their part?
    pub(super) multipart: bool,
    /// The file's length in bytes.
    pub(super) length: u64,
    /// Where the tables of block offsets begin.
    pub(super) tables: u64,
    /// The least rectangle that holds all parts' data windows: left, top, width, height.
    pub window: (i64, i64, usize, usize),
    /// How its channels are called.
    names: Vec<ChannelName>,
}

/// A part of the file.
pub(crate) struct ExrPart {
    /// Its name; empty if it has none.
    pub name: String,
    /// The compression, where it is one that is not read.
    pub unread_compression: Option<String>,
    /// What it says of itself; `None` if that makes no sense.
    pub header: Option<Header>,
    /// Why it is not read, if it is not.
    pub refusal: Option<Refusal>,
    /// How many blocks it has.
    pub chunk_count: u64,
}

/// Why a part is not read.
pub(crate) struct Refusal {
    /// A clause that follows "… is not read: ".
    pub why: String,
    /// The error for a file that has nothing else.
    error: ImageError,
}

/// The first four bytes of every EXR file.
pub(crate) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

impl Exr {
    /// Reads and checks the header.
    pub fn open(input: &Input) -> Result<Exr, ImageError> {
        let name = input.name();
        let (reader, length) = input.open()?;
        let mut reader = Counting { reader, count: 0 };
        let raw = RawHeader::read(&name, &mut reader, length)?;
        let tables = reader.count;
        let parts: Vec<ExrPart> = raw.parts.iter().map(|part| open_part(&name, &raw, part, length)).collect();
        if parts.iter().all(|part| part.refusal.is_some()) {
            return Err(nothing_to_read(&name, parts));
        }
        let blocks = parts.iter().fold(0u64, |sum, part| sum.saturating_add(part.chunk_count));
        if blocks.saturating_mul(8) > length.saturating_sub(tables) {
            return Err(ImageError::damaged(&name, "it ends before its table of blocks"));
        }
        let window = union(&name, &parts, length)?;
        let names = channel_names(&raw, &parts);
        Ok(Exr { parts, multipart: raw.multipart, length, tables, window, names })
    }

    /// Where the first block may begin, behind the tables.
    pub fn first_block(&self) -> u64 {
        let blocks = self.parts.iter().fold(0u64, |sum, part| sum.saturating_add(part.chunk_count));
        self.tables.saturating_add(blocks.saturating_mul(8))
    }

    /// The headers of the parts that are read.
    pub fn headers(&self) -> impl Iterator<Item = &Header> {
        self.parts.iter().filter_map(ExrPart::readable)
    }

    /// How the channels are called, in the order of [`Exr::channels`].
    pub fn names(&self) -> &[ChannelName] {
        &self.names
    }

    /// The channels of all parts, with the reason for those that are not read.
    pub fn channels(&self) -> Vec<Channel> {
        let of = |name: &ChannelName| {
            let part = &self.parts[name.part];
            let stored = part.header.as_ref().and_then(|h| h.channels.list.get(name.index));
            let samples = match stored.map(|c| c.sample_type) {
                Some(SampleType::F16) => Samples::Half,
                Some(SampleType::F32) => Samples::Float,
                Some(SampleType::U32) => Samples::Uint,
                None => Samples::Unknown,
            };
            let sampling = stored.map_or([1, 1], |c| [c.sampling.x(), c.sampling.y()]);
            let unread = match &part.refusal {
                Some(refusal) => Some(refusal.why.clone()),
                None if sampling != [1, 1] => {
                    Some(format!("it is subsampled ({} x {})", sampling[0], sampling[1]))
                }
                None => None,
            };
            Channel { name: name.full.clone(), part: name.part, index: name.index, samples, unread, sampling }
        };
        self.names.iter().map(of).collect()
    }

    /// Where a part lies in the rectangle of all.
    pub fn part_window(&self, part: usize) -> Option<Window> {
        let header = self.parts[part].readable()?;
        let position = header.own_attributes.layer_position;
        Some(Window {
            left: (i64::from(position.x()) - self.window.0) as usize,
            top: (i64::from(position.y()) - self.window.1) as usize,
            width: header.layer_size.width(),
            height: header.layer_size.height(),
        })
    }

    /// The primaries of a part, if the file has any.
    pub fn chromaticities(&self, part: usize) -> Option<Chromaticities> {
        self.parts[part].header.as_ref()?.shared_attributes.chromaticities
    }

    /// Display window, aspect, and the attributes that describe the picture and not the file.
    pub fn metadata(&self) -> Metadata {
        let Some(first) = self.headers().next() else { return Metadata::default() };
        let display = first.shared_attributes.display_window;
        let (left, top, width, height) = self.window;
        let origin = [left - i64::from(display.position.x()), top - i64::from(display.position.y())];
        let size = [display.size.width(), display.size.height()];
        let same = origin == [0, 0] && size == [width, height];
        // Of parts that differ, the first counts.
        let mut named: BTreeMap<String, AttributeValue> = BTreeMap::new();
        for header in self.headers() {
            for (name, value) in header.all_named_attributes() {
                let name = header_exr::text(name);
                if !STRUCTURE.contains(&name.as_str()) {
                    named.entry(name).or_insert(value);
                }
            }
        }
        Metadata {
            // Windows lie within 2^30 of the origin, as the header's check demands.
            origin: origin.map(|v| v as i32),
            resolution: (!same && size[0] > 0 && size[1] > 0).then_some(size),
            display_origin: [display.position.x(), display.position.y()],
            pixel_aspect: first.shared_attributes.pixel_aspect,
            attributes: Attributes { list: named.into_iter().collect() },
        }
    }
}

impl ExrPart {
    /// What it says of itself, if it is read.
    pub fn readable(&self) -> Option<&Header> {
        self.header.as_ref().filter(|_| self.refusal.is_none())
    }
}

/// Reads, and knows how far it has come.
struct Counting<R> {
    reader: R,
    count: u64,
}

impl<R: Read> Read for Counting<R> {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        let read = self.reader.read(bytes)?;
        self.count += read as u64;
        Ok(read)
    }
}

/// Header attributes that say how a file is laid out or which run it comes from, not what the picture is.
const STRUCTURE: [&str; 20] = [
    "BlenderMultiChannel",
    "channels",
    "chunkCount",
    "compression",
    "dataWindow",
    "displayWindow",
    "dwaCompressionLevel",
    "envmap",
    "lineOrder",
    "maxSamplesPerPixel",
    "multiView",
    "name",
    "originalDataWindow",
    "pixelAspectRatio",
    "preview",
    super::stamp::NAME,
    "tiles",
    "type",
    "version",
    "view",
];

/// A part, and whether it can be read.
fn open_part(name: &str, raw: &RawHeader, part: &RawPart, length: u64) -> ExrPart {
    let understood = guard::contain(|| raw.understood(part));
    let unread_compression = part.unread_compression();
    let (header, refusal) = match understood {
        Some(Ok(header)) => {
            let refusal = refusal(name, raw, part, &header, length);
            (Some(header), refusal)
        }
        Some(Err(e)) => {
            let unknown =
                part.unknown_samples().map(|c| format!("the samples of `{c}` are of an unknown type"));
            (
                None,
                Some(
                    unknown.map_or_else(|| Refusal::damaged(explain(name, e)), |why| Refusal::of(name, why)),
                ),
            )
        }
        None => (None, Some(Refusal::damaged(ImageError::damaged(name, "its header is invalid")))),
    };
    let computed = header.as_ref().filter(|_| refusal.is_none()).map(|h| h.chunk_count as u64);
    let chunk_count = computed.or(part.chunk_count()).unwrap_or(0);
    ExrPart { name: part.text("name").unwrap_or_default(), unread_compression, header, refusal, chunk_count }
}

/// Why a part whose header makes sense is not read, if it is not.
fn refusal(name: &str, raw: &RawHeader, part: &RawPart, header: &Header, length: u64) -> Option<Refusal> {
    let unsupported = |why: String, hint: &str| {
        let refusal = Refusal::of(name, why);
        Some(Refusal { error: refusal.error.hint(hint), ..refusal })
    };
    if header.deep {
        return Some(Refusal {
            why: "it holds deep data (several samples a pixel)".into(),
            error: deep(name),
        });
    }
    if let Some(compression) = part.unread_compression() {
        return unsupported(format!("it has {compression}"), "Save it with ZIP compression.");
    }
    if let Some(kind) = raw.unknown_type(part) {
        return unsupported(format!("it is of an unknown type, `{kind}`"), "Save it as scan lines.");
    }
    if let Err(error) = header_exr::check(header, raw.multipart) {
        return Some(Refusal::damaged(explain(name, error)));
    }
    let Vec2(width, height) = header.layer_size;
    let bytes = header.channels.bytes_per_pixel as u64;
    if let Err(error) = guard::check_size(name, width as u64, height as u64, bytes, length) {
        return Some(Refusal { why: "it claims more pixels than the file can hold".into(), error });
    }
    match sampled_blocks::check(header) {
        Ok(()) => None,
        Err(why) => unsupported(why, "Convert it to full resolution first."),
    }
}

impl Refusal {
    /// A part that uses what is not supported.
    fn of(name: &str, why: String) -> Refusal {
        let error = ImageError::new(ErrorKind::Unsupported, format!("`{name}` is not read: {why}"));
        Refusal { why, error }
    }

    fn damaged(error: ImageError) -> Refusal {
        Refusal { why: "its header is invalid".into(), error }
    }
}

/// The error of a file no part of which is read.
fn nothing_to_read(name: &str, parts: Vec<ExrPart>) -> ImageError {
    let mut reasons = parts.into_iter().filter_map(|part| Some((part.name, part.refusal?)));
    let Some((first_name, first)) = reasons.next() else {
        return ImageError::damaged(name, "it has no parts");
    };
    let others: Vec<(String, Refusal)> = reasons.filter(|(_, other)| other.why != first.why).collect();
    if others.is_empty() {
        return first.error;
    }
    let message = format!("`{name}` has no part that can be read");
    let mut error = ImageError::new(ErrorKind::Unsupported, message);
    for (part, refusal) in std::iter::once((first_name, first)).chain(others) {
        error = error.hint(format!("`{part}`: {}.", refusal.why));
    }
    error
}

/// What the channels of all parts are called.
fn channel_names(raw: &RawHeader, parts: &[ExrPart]) -> Vec<ChannelName> {
    let names = raw.parts.iter().zip(parts).map(|(raw, part)| PartNames {
        name: part.name.clone(),
        view: raw.text("view"),
        views: raw.texts("multiView"),
        channels: match &part.header {
            Some(header) => {
                header.channels.list.iter().map(|c| header_exr::text(c.name.as_slice())).collect()
            }
            None => raw.channel_names(),
        },
    });
    let mut list = part_names::name(&names.collect::<Vec<_>>());
    for name in &mut list {
        let part = &parts[name.part];
        name.unread = part.refusal.is_some();
        let stored = part.header.as_ref().and_then(|h| h.channels.list.get(name.index));
        name.subsampled = stored.is_some_and(|c| c.sampling != Vec2(1, 1));
    }
    list
}

/// The least rectangle with the data windows of all parts that are read in it.
fn union(name: &str, parts: &[ExrPart], length: u64) -> Result<(i64, i64, usize, usize), ImageError> {
    let mut whole: Option<[i64; 4]> = None;
    let read = || parts.iter().filter_map(ExrPart::readable);
    for header in read() {
        let Vec2(x, y) = header.own_attributes.layer_position;
        let Vec2(w, h) = header.layer_size;
        let one = [i64::from(x), i64::from(y), i64::from(x) + w as i64, i64::from(y) + h as i64];
        whole = Some(match whole {
            None => one,
            Some(a) => [a[0].min(one[0]), a[1].min(one[1]), a[2].max(one[2]), a[3].max(one[3])],
        });
    }
    let [left, top, right, bottom] = whole.unwrap_or_default();
    let (width, height) = ((right - left) as u64, (bottom - top) as u64);
    if width == 0 || height == 0 {
        return Err(ImageError::damaged(name, "it has no pixels"));
    }
    // Each channel becomes numbers for the whole rectangle: of parts far from one another, or of one that lies about its width, an
    // image of mostly nothing.
    let channels: u64 = read().map(|h| h.channels.list.len() as u64).sum();
    guard::check_size(name, width, height, 4 * channels, length).map_err(|e| match read().count() {
        1 => e,
        _ => e.hint("That is the size of the rectangle around the data windows of all its parts."),
    })?;
    Ok((left, top, width as usize, height as usize))
}

fn deep(name: &str) -> ImageError {
    ImageError::new(
        ErrorKind::Unsupported,
        format!("`{name}` holds deep data (several samples a pixel), which is not read"),
    )
    .hint("Flatten it first, or render flat passes.")
}

pub(super) fn explain(name: &str, error: exr::error::Error) -> ImageError {
    match error {
        exr::error::Error::Io(e) => ImageError::io("read", name, &e),
        exr::error::Error::NotSupported(what) => {
            ImageError::new(ErrorKind::Unsupported, format!("`{name}` cannot be read: {what}"))
        }
        exr::error::Error::Invalid(what) if what.contains("reference to") => {
            ImageError::damaged(name, "it ends too early")
        }
        other => ImageError::damaged(name, other),
    }
}
