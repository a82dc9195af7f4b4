//! OpenEXR files of one part: every variable as channels, compressed in parallel, the same bytes each time.
//!
//! The header and the table of blocks are laid out here, attributes sorted by name; the `exr` crate's own
//! writer orders them by a randomly seeded hash. Its compressors are used as they are.

use super::error::ImageError;
use super::header_exr;
use super::names::{identifier, last_field};
use super::stamp::{NAME, SOFTWARE, SOFTWARE_ATTRIBUTE};
use super::write::{Compression, WriteOptions, unwritable};
use super::{Image, Variable};
use crate::parallel::*;
use crate::shape::Shape;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{
    self, AttributeValue, ChannelDescription, ChannelList, IntegerBounds, LineOrder, SampleType, Text,
};
use exr::meta::header::Header;
use smallvec::SmallVec;
use std::collections::{HashMap, HashSet};
use std::io::{self, Seek, SeekFrom, Write};

/// A channel to be written.
struct Channel {
    name: String,
    /// Its variable and plane in the image.
    plane: (usize, usize),
    half: bool,
}

/// A file that is written block by block from the top.
pub(crate) struct ExrWriter {
    name: String,
    header: Header,
    channels: Vec<Channel>,
    /// Magic number and attributes; they go into the file with the first rows.
    start: Vec<u8>,
    /// Where each block begins.
    offsets: Vec<u64>,
    /// Bytes written so far.
    length: u64,
    /// The row after the last one that came.
    row: usize,
    /// The samples of rows that do not fill a block yet.
    pending: Vec<u8>,
}

impl ExrWriter {
    /// Settles the header of a file of so many rows; `first` holds the first ones.
    pub fn new(
        name: &str,
        first: &Image<'_>,
        height: usize,
        options: &WriteOptions,
    ) -> Result<ExrWriter, ImageError> {
        let crypto = cryptomattes(first);
        let layers: HashSet<&str> = crypto.values().map(|matte| matte.layer.as_str()).collect();
        let mut channels = Vec::new();
        for (index, variable) in first.variables.iter().enumerate() {
            let owner = owner(variable);
            let is_crypto = unnumbered(owner).any(|layer| layers.contains(layer));
            let exact = is_crypto || matches!(owner, "surface" | "point" | "depth");
            if has_empty(&variable.shape) {
                let why = format!("`{}` holds an empty vector, which has no channels", variable.name);
                return Err(unwritable(name, why));
            }
            let names = channel_names(variable, is_crypto);
            for (i, channel) in names.into_iter().enumerate() {
                // A grey colour fills three channels from one plane.
                let plane = (index, i.min(variable.planes.len() - 1));
                channels.push(Channel { name: channel, plane, half: options.half && !exact });
            }
        }
        if channels.is_empty() {
            return Err(unwritable(name, "the image has no variables"));
        }
        channels.sort_by(|a, b| a.name.as_bytes().cmp(b.name.as_bytes()));
        if let Some(pair) = channels.windows(2).find(|pair| pair[0].name == pair[1].name) {
            let why = format!("two variables would be the channel `{}`", pair[0].name);
            return Err(unwritable(name, why).hint("Rename or remove one of them."));
        }
        let header = header(name, first, height, &channels, options.compression)?;
        let mut attributes = attributes(first, &header, &crypto);
        if let Some(stamp) = options.stamp.as_deref().and_then(Text::new_or_none) {
            attributes.push((NAME.into(), AttributeValue::Text(stamp)));
            attributes.sort_by(|a, b| a.0.as_bytes().cmp(b.0.as_bytes()));
        }
        let long = |text: &str| text.len() > 31;
        let attribute_long = attributes.iter().any(|(n, v)| long(n) || v.kind_name().len() > 31);
        let too_long =
            channels.iter().map(|c| &c.name).chain(attributes.iter().map(|a| &a.0)).find(|n| n.len() > 255);
        if let Some(text) = too_long {
            return Err(unwritable(name, format!("a name is longer than 255 letters: `{text}`")));
        }
        // Magic number and version 2, with a flag for names of more than 31 letters.
        let mut start = super::read_exr::MAGIC.to_vec();
        let flags = if attribute_long || channels.iter().any(|c| long(&c.name)) { 0x400u32 } else { 0 };
        start.extend((2 | flags).to_le_bytes());
        for (attribute_name, value) in &attributes {
            attribute::write(attribute_name.as_bytes(), value, &mut start)
                .map_err(|e| unwritable(name, e))?;
        }
        start.push(0);
        let (name, offsets, pending) = (name.to_string(), Vec::new(), Vec::new());
        Ok(ExrWriter { name, header, channels, start, offsets, length: 0, row: 0, pending })
    }

    /// Adds rows, and writes the blocks that they fill.
    pub fn rows(&mut self, rows: &Image<'_>, out: &mut impl Write) -> Result<(), ImageError> {
        let io = |e: io::Error| ImageError::io("write", &self.name, &e);
        let height = self.header.layer_size.height();
        let lines = self.header.compression.scan_lines_per_block();
        if self.row == 0 {
            // The table of blocks follows the header; it is filled in the end.
            self.length = (self.start.len() + 8 * height.div_ceil(lines)) as u64;
            out.write_all(&self.start).map_err(io)?;
            out.write_all(&vec![0; 8 * height.div_ceil(lines)]).map_err(io)?;
        }
        let samples = |row: usize, bytes: &mut Vec<u8>| {
            for channel in &self.channels {
                let (variable, plane) = channel.plane;
                let samples = &rows.variables[variable].planes[plane][row * rows.width..][..rows.width];
                if channel.half {
                    bytes.extend(samples.iter().flat_map(|&v| half::f16::from_f32(v).to_ne_bytes()));
                } else {
                    bytes.extend_from_slice(bytemuck::cast_slice(samples));
                }
            }
        };
        // Blocks of the whole image, some of whose rows may have come before, or are still to come.
        let first = self.row;
        let end = first + rows.height;
        let full = if end == height { end.div_ceil(lines) } else { end / lines };
        let begun = std::mem::take(&mut self.pending);
        let header = &self.header;
        let packed: Vec<Result<(i32, Vec<u8>), ImageError>> = (first / lines..full)
            .into_par_iter()
            .map(|block| {
                let top = block * lines;
                let count = lines.min(height - top);
                let mut bytes = if top < first { begun.clone() } else { Vec::new() };
                bytes.reserve_exact(header.channels.bytes_per_pixel * rows.width * count - bytes.len());
                (top.max(first)..top + count).for_each(|row| samples(row - first, &mut bytes));
                let section = IntegerBounds { position: Vec2(0, top as i32), size: Vec2(rows.width, count) };
                let packed = header.compression.compress_image_section_to_le(header, bytes, section);
                let row = header.own_attributes.layer_position.y() + top as i32;
                Ok((row, packed.map_err(|e| unwritable(&self.name, e))?))
            })
            .collect();
        // What is left begins the next block.
        if full * lines < end {
            if full * lines < first {
                self.pending = begun;
            }
            (first.max(full * lines)..end).for_each(|row| samples(row - first, &mut self.pending));
        }
        for block in packed {
            let (row, bytes) = block?;
            self.offsets.push(self.length);
            self.length += 8 + bytes.len() as u64;
            out.write_all(&row.to_le_bytes()).map_err(io)?;
            out.write_all(&(bytes.len() as i32).to_le_bytes()).map_err(io)?;
            out.write_all(&bytes).map_err(io)?;
        }
        self.row = end;
        Ok(())
    }

    /// Fills the table of blocks.
    pub fn finish(self, out: &mut (impl Write + Seek)) -> Result<(), ImageError> {
        let height = self.header.layer_size.height();
        if self.row != height {
            return Err(unwritable(&self.name, format!("it has {} rows of {height}", self.row)));
        }
        let table: Vec<u8> = self.offsets.iter().flat_map(|o| o.to_le_bytes()).collect();
        out.seek(SeekFrom::Start(self.start.len() as u64))
            .and_then(|_| out.write_all(&table))
            .and_then(|()| out.seek(SeekFrom::End(0)))
            .map_err(|e| ImageError::io("write", &self.name, &e))?;
        Ok(())
    }
}

/// The names of a variable's channels: `R G B (A)` for `color`, `A` for `alpha`, `.x .y .z .w` for short
/// vectors, numbers for others.
fn channel_names(variable: &Variable<'_>, crypto: bool) -> Vec<String> {
    let letters = |prefix: &str, set: &str, n: u32| {
        set.chars().take(n as usize).map(|c| format!("{prefix}{c}")).collect::<Vec<String>>()
    };
    let dotted = format!("{}.", variable.name);
    match (variable.name.as_str(), &variable.shape) {
        ("color", Shape::Scalar) => letters("", "RGB", 3),
        ("color", Shape::Vector(n @ 3..=4)) => letters("", "RGBA", *n),
        ("alpha", Shape::Scalar) => vec!["A".into()],
        (name, Shape::Scalar) => vec![name.to_string()],
        (_, Shape::Vector(4)) if crypto => letters(&dotted, "rgba", 4),
        (_, Shape::Vector(n @ 2..=4)) => letters(&dotted, "xyzw", *n),
        (name, shape) => {
            let mut names = Vec::new();
            number(name, shape, &mut names);
            names
        }
    }
}

/// The variable's name. A scalar may be a channel of another one, when a file's channels are written as they are.
fn owner<'v>(variable: &'v Variable<'_>) -> &'v str {
    match variable.name.rsplit_once('.') {
        Some((owner, letter)) if variable.shape.is_scalar() && letter.len() == 1 => owner,
        _ => &variable.name,
    }
}

fn number(prefix: &str, shape: &Shape, names: &mut Vec<String>) {
    if shape.is_scalar() {
        names.push(prefix.to_string());
    }
    for (i, element) in shape.elements().enumerate() {
        number(&format!("{prefix}.{}", i + 1), &element, names);
    }
}

fn has_empty(shape: &Shape) -> bool {
    shape.is_empty() || !shape.is_scalar() && shape.elements().any(|e| has_empty(&e))
}

fn header(
    name: &str,
    image: &Image<'_>,
    rows: usize,
    channels: &[Channel],
    compression: Compression,
) -> Result<Header, ImageError> {
    let mut list: SmallVec<[ChannelDescription; 5]> = SmallVec::new();
    for channel in channels {
        list.push(ChannelDescription {
            name: Text::from_slice_unchecked(channel.name.as_bytes()),
            sample_type: if channel.half { SampleType::F16 } else { SampleType::F32 },
            quantize_linearly: false,
            sampling: Vec2(1, 1),
        });
    }
    let about = &image.metadata;
    let place = |axis: usize| {
        let start = i64::from(about.display_origin[axis]) + i64::from(about.origin[axis]);
        let size = [image.width, rows][axis] as i64;
        let within = start > -(1 << 29) && start + size < (1 << 29);
        within
            .then_some(start as i32)
            .ok_or_else(|| unwritable(name, "its data window is too far from the origin"))
    };
    let position = Vec2(place(0)?, place(1)?);
    let [width, height] = image.metadata.resolution.unwrap_or([image.width, rows]);
    if width.max(height) >= 1 << 29 {
        return Err(unwritable(name, "its display window is too large"));
    }
    use attribute::Compression as Exr;
    let compression = match compression {
        Compression::None => Exr::Uncompressed,
        Compression::Rle => Exr::RLE,
        Compression::Zips => Exr::ZIP1,
        Compression::Zip => Exr::ZIP16,
        Compression::Piz => Exr::PIZ,
    };
    let mut header = Header::new(Text::default(), (image.width, rows), list).with_encoding(
        compression,
        BlockDescription::ScanLines,
        LineOrder::Increasing,
    );
    header.own_attributes.layer_position = position;
    header.shared_attributes.display_window = IntegerBounds {
        position: Vec2(about.display_origin[0], about.display_origin[1]),
        size: Vec2(width, height),
    };
    Ok(header)
}

/// All attributes of the header, sorted by name.
fn attributes(
    image: &Image<'_>,
    header: &Header,
    crypto: &HashMap<String, Cryptomatte>,
) -> Vec<(String, AttributeValue)> {
    let aspect = image.metadata.pixel_aspect;
    let window = header.shared_attributes.display_window;
    let mut list: Vec<(String, AttributeValue)> = vec![
        ("channels".into(), AttributeValue::ChannelList(ChannelList::new(header.channels.list.clone()))),
        ("compression".into(), AttributeValue::Compression(header.compression)),
        ("dataWindow".into(), AttributeValue::IntegerBounds(header.data_window())),
        ("displayWindow".into(), AttributeValue::IntegerBounds(window)),
        ("lineOrder".into(), AttributeValue::LineOrder(LineOrder::Increasing)),
        ("pixelAspectRatio".into(), AttributeValue::F32(if aspect > 0.0 { aspect } else { 1.0 })),
        // Not the input's: who reads this file asks what wrote it.
        (SOFTWARE_ATTRIBUTE.into(), AttributeValue::Text(SOFTWARE.into())),
    ];
    let own = list.len();
    for (name, value) in &image.metadata.attributes.list {
        let stale = name.is_empty() || list[..own].iter().any(|(n, _)| n == name);
        // A cryptomatte's names go only with its channels, which have lost the layer's prefix.
        let value = match name.strip_prefix("cryptomatte/").and_then(|rest| rest.split_once('/')) {
            Some((id, field)) => match crypto.get(id) {
                Some(matte) if matte.written && field == "name" => {
                    AttributeValue::Text(Text::from_slice_unchecked(matte.layer.as_bytes()))
                }
                Some(matte) if matte.written => value.clone(),
                _ => continue,
            },
            None => value.clone(),
        };
        if !stale {
            list.push((name.clone(), value));
        }
    }
    for (name, value) in [
        ("screenWindowCenter", AttributeValue::FloatVec2(Vec2(0.0, 0.0))),
        ("screenWindowWidth", AttributeValue::F32(1.0)),
    ] {
        if list.iter().all(|(n, _)| n != name) {
            list.push((name.into(), value));
        }
    }
    list.sort_by(|a, b| a.0.as_bytes().cmp(b.0.as_bytes()));
    list
}

/// A cryptomatte that the input's header describes.
struct Cryptomatte {
    /// What its variables are called, without the number: `CryptoObject`.
    layer: String,
    written: bool,
}

/// What a variable may be called without the number behind it: all that is left of it without some of its last digits.
fn unnumbered(variable: &str) -> impl Iterator<Item = &str> {
    let word = variable.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    (word..=variable.len()).map(|end| &variable[..end])
}

/// The cryptomattes by the identifiers that their attributes have.
fn cryptomattes(image: &Image<'_>) -> HashMap<String, Cryptomatte> {
    let layers: HashSet<&str> = image.variables.iter().flat_map(|v| unnumbered(owner(v))).collect();
    let of = |(name, value): &(String, AttributeValue)| {
        let id = name.strip_prefix("cryptomatte/")?.strip_suffix("/name")?.to_string();
        let AttributeValue::Text(text) = value else { return None };
        let layer = identifier(last_field(&header_exr::text(text.as_slice())));
        let written = layers.contains(layer.as_str());
        Some((id, Cryptomatte { layer, written }))
    };
    image.metadata.attributes.list.iter().filter_map(of).collect()
}
