//! OpenEXR files: any channels, parts, tiles and compressions. Here the header; `scan_exr` has the pixels.
//!
//! The `exr` crate parses headers and decompresses blocks; which blocks are read, in which order, and
//! where their numbers go, is decided by us, so that only the parts with wanted channels are touched
//! and what a file claims is checked before it is believed.

use super::error::{ErrorKind, ImageError};
use super::file::{Channel, Samples};
use super::source::Input;
use super::{Attributes, Metadata, guard};
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, SampleType};
use exr::meta::header::Header;

/// The header of an EXR file, checked.
pub(crate) struct Exr {
    pub(super) meta: MetaData,
    /// The file's length in bytes.
    pub(super) length: u64,
    /// Where the tables of block offsets begin.
    pub(super) tables: u64,
    /// The least rectangle that holds all parts' data windows: left, top, width, height.
    pub window: (i64, i64, usize, usize),
}

/// The first four bytes of every EXR file.
pub(crate) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

impl Exr {
    /// Reads and checks the header.
    pub fn open(input: &Input) -> Result<Exr, ImageError> {
        let name = input.name();
        let (mut reader, length) = input.open()?;
        let meta = guard::contain(|| MetaData::read_from_buffered(&mut reader, false))
            .ok_or_else(|| ImageError::damaged(&name, "its header makes no sense"))?
            .map_err(|e| explain(&name, e))?;
        let tables = reader.stream_position().map_err(|e| ImageError::io("read", &name, &e))?;
        if meta.headers.is_empty() {
            return Err(ImageError::damaged(&name, "it has no parts"));
        }
        if meta.headers.iter().all(|h| h.deep) {
            return Err(deep(&name));
        }
        let mut blocks = 0u64;
        for header in &meta.headers {
            blocks = blocks.saturating_add(header.chunk_count as u64);
            if header.deep {
                continue;
            }
            let mut long_names = false;
            header.validate(meta.headers.len() > 1, &mut long_names, false).map_err(|e| explain(&name, e))?;
            let Vec2(width, height) = header.layer_size;
            let bytes = header.channels.bytes_per_pixel as u64;
            guard::check_size(&name, width as u64, height as u64, bytes, length)?;
        }
        if blocks.saturating_mul(8) > length.saturating_sub(tables) {
            return Err(ImageError::damaged(&name, "it ends before its table of blocks"));
        }
        let window = union(&name, &meta, length)?;
        Ok(Exr { meta, length, tables, window })
    }

    /// The parts' headers.
    pub fn headers(&self) -> &[Header] {
        &self.meta.headers
    }

    /// The channels of all parts that are not deep, under their full names: where the part's name
    /// carries the layer, it is put before the channel's.
    pub fn channels(&self) -> Vec<Channel> {
        let several = self.meta.headers.len() > 1;
        let mut list = Vec::new();
        for (part, header) in self.meta.headers.iter().enumerate().filter(|(_, h)| !h.deep) {
            let part_name = header.own_attributes.layer_name.as_ref().map(ToString::to_string);
            for (index, channel) in header.channels.list.iter().enumerate() {
                let own = channel.name.to_string();
                let name = match &part_name {
                    Some(layer) if several => full_name(layer, &own),
                    _ => own,
                };
                let samples = match channel.sample_type {
                    SampleType::F16 => Samples::Half,
                    SampleType::F32 => Samples::Float,
                    SampleType::U32 => Samples::Uint,
                };
                list.push(Channel { name, part, index, samples });
            }
        }
        list
    }

    /// Display window, aspect, and the attributes that describe the picture and not the file.
    pub fn metadata(&self) -> Metadata {
        let display = self.meta.headers[0].shared_attributes.display_window;
        let (left, top, width, height) = self.window;
        let origin = [left - i64::from(display.position.x()), top - i64::from(display.position.y())];
        let size = [display.size.width(), display.size.height()];
        let same = origin == [0, 0] && size == [width, height];
        let mut list: Vec<(String, AttributeValue)> = Vec::new();
        for header in &self.meta.headers {
            for (name, value) in header.all_named_attributes() {
                let name: String = name.iter().map(|&b| char::from(b)).collect();
                let known = list.iter().any(|(n, _)| *n == name);
                if !known && !STRUCTURE.contains(&name.as_str()) {
                    list.push((name, value));
                }
            }
        }
        list.sort_by(|a, b| a.0.cmp(&b.0));
        Metadata {
            // Windows lie within 2^30 of the origin, as the header's check demands.
            origin: origin.map(|v| v as i32),
            resolution: (!same && size[0] > 0 && size[1] > 0).then_some(size),
            display_origin: [display.position.x(), display.position.y()],
            pixel_aspect: self.meta.headers[0].shared_attributes.pixel_aspect,
            attributes: Attributes { list },
        }
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

/// The full name of a channel in a part that has a name of its own.
fn full_name(part: &str, channel: &str) -> String {
    let (p, c) = (part.to_lowercase(), channel.to_lowercase());
    let layer = c.rsplit_once('.').map_or("", |(layer, _)| layer);
    let ends_with = |long: &str, short: &str| {
        long == short || long.strip_suffix(short).is_some_and(|head| head.ends_with('.'))
    };
    if part.is_empty() || c == p || c.starts_with(&format!("{p}.")) || ends_with(&c, &p) {
        // The channel says it all already.
        channel.to_string()
    } else if !layer.is_empty() && ends_with(layer, &p) {
        channel.to_string()
    } else if !layer.is_empty() && ends_with(&p, layer) {
        format!("{part}.{}", &channel[layer.len() + 1..])
    } else if ends_with(&p, &c) {
        part.to_string()
    } else {
        format!("{part}.{channel}")
    }
}

/// The least rectangle with all data windows in it.
fn union(name: &str, meta: &MetaData, length: u64) -> Result<(i64, i64, usize, usize), ImageError> {
    let mut whole: Option<[i64; 4]> = None;
    for header in meta.headers.iter().filter(|h| !h.deep) {
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
    let channels: u64 = meta.headers.iter().filter(|h| !h.deep).map(|h| h.channels.list.len() as u64).sum();
    guard::check_size(name, width, height, 4 * channels, length).map_err(|e| match meta.headers.len() {
        1 => e,
        _ => e.hint("The rectangle around the data windows of all its parts is as large as that."),
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
        exr::error::Error::NotSupported(what) if what.contains("deep") => deep(name),
        exr::error::Error::NotSupported(what) => {
            ImageError::new(ErrorKind::Unsupported, format!("`{name}` cannot be read: {what}"))
        }
        exr::error::Error::Invalid(what) if what.contains("reference to") => {
            ImageError::damaged(name, "it ends too early")
        }
        other => ImageError::damaged(name, other),
    }
}
