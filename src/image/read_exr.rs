//! OpenEXR files: any channels, parts, tiles and compressions; decoded block by block, in parallel.
//!
//! The `exr` crate parses headers and decompresses blocks; which blocks are read, in which order, and
//! where their numbers go, is decided here, so that only the parts with wanted channels are touched
//! and what a file claims is checked before it is believed.

use super::error::{ErrorKind, ImageError};
use super::file::{Channel, Samples};
use super::source::{Input, ReadSeek};
use super::{Attributes, Metadata, guard};
use exr::block::UncompressedBlock;
use exr::block::chunk::{Chunk, CompressedBlock};
use exr::block::lines::LineIndex;
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, Compression, SampleType};
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData, compute_block_count};
use rayon::prelude::*;
use std::io::SeekFrom;

/// The header of an EXR file, checked.
pub(crate) struct Exr {
    meta: MetaData,
    /// The file's length in bytes.
    length: u64,
    /// Where the tables of block offsets begin.
    tables: u64,
    /// The least rectangle that holds all parts' data windows: left, top, width, height.
    pub window: (i64, i64, usize, usize),
}

/// The first four bytes of every EXR file.
pub(crate) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// A run of samples of one channel in one row: the channel, then its place in the data window.
pub(crate) struct Line<'a> {
    /// Place in the file's list of channels.
    pub channel: usize,
    /// Column in the union of the data windows.
    pub x: usize,
    /// Row in the union of the data windows.
    pub y: usize,
    /// The samples, in the machine's byte order.
    pub bytes: &'a [u8],
    /// What they are.
    pub samples: Samples,
}

impl Line<'_> {
    /// Writes the samples to the start of `row` as floats: halves and floats exactly, integers
    /// rounded to the nearest float.
    pub fn floats(&self, row: &mut [f32]) {
        fn fill<const N: usize>(row: &mut [f32], bytes: &[u8], convert: impl Fn([u8; N]) -> f32) {
            let (samples, _) = bytes.as_chunks::<N>();
            row.iter_mut().zip(samples).for_each(|(to, &sample)| *to = convert(sample));
        }
        match self.samples {
            Samples::Half => fill(row, self.bytes, |b| half::f16::from_ne_bytes(b).to_f32()),
            Samples::Uint => fill(row, self.bytes, |b| u32::from_ne_bytes(b) as f32),
            _ => fill(row, self.bytes, f32::from_ne_bytes),
        }
    }

    /// How many samples there are.
    pub fn len(&self) -> usize {
        self.bytes.len() / if self.samples == Samples::Half { 2 } else { 4 }
    }
}

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

    /// Decodes the channels for which `wanted` holds, and gives their rows to `sink`, in the file's
    /// order of blocks; each sample of each wanted channel once.
    pub fn decode(
        &self,
        input: &Input,
        channels: &[Channel],
        wanted: &[bool],
        mut sink: impl FnMut(Line<'_>),
    ) -> Result<(), ImageError> {
        let name = input.name();
        let (mut reader, _) = input.open()?;
        let mut table = self.tables;
        for (part, header) in self.meta.headers.iter().enumerate() {
            let mine: Vec<(usize, &Channel)> =
                channels.iter().enumerate().filter(|(i, c)| c.part == part && wanted[*i]).collect();
            if !mine.is_empty() {
                for (_, channel) in &mine {
                    if header.channels.list[channel.index].sampling != Vec2(1, 1) {
                        return Err(subsampled(&name, &channel.name));
                    }
                }
                if header.channels.list.iter().any(|c| c.sampling != Vec2(1, 1)) {
                    return Err(subsampled(&name, &mine[0].1.name));
                }
                self.decode_part(&name, &mut *reader, table, part, &mine, &mut sink)?;
            }
            table += 8 * header.chunk_count as u64;
        }
        Ok(())
    }

    fn decode_part(
        &self,
        name: &str,
        reader: &mut dyn ReadSeek,
        table: u64,
        part: usize,
        wanted: &[(usize, &Channel)],
        sink: &mut impl FnMut(Line<'_>),
    ) -> Result<(), ImageError> {
        let header = &self.meta.headers[part];
        let io = |e: std::io::Error| ImageError::io("read", name, &e);
        let blocks = blocks(header);
        // The blocks of the full resolution come first in the table, whatever smaller levels follow.
        reader.seek(SeekFrom::Start(table)).map_err(io)?;
        let mut offsets = vec![0u8; blocks.len() * 8];
        reader.read_exact(&mut offsets).map_err(io)?;
        let offsets: Vec<u64> = offsets
            .chunks_exact(8)
            .map(|b| u64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]))
            .collect();
        let mut place = vec![None; header.channels.list.len()];
        for (slot, channel) in wanted {
            place[channel.index] = Some((*slot, channel.samples));
        }
        let left = (i64::from(header.own_attributes.layer_position.x()) - self.window.0) as usize;
        let top = (i64::from(header.own_attributes.layer_position.y()) - self.window.1) as usize;
        // A batch gives every thread something to do, and no more than some 64 MB.
        let block_bytes = header.channels.bytes_per_pixel * blocks.first().map_or(1, |b| b.1.area());
        let batch = (64 << 20) / block_bytes.max(1);
        let batch = batch.clamp(1, 8 * rayon::current_num_threads());
        for (positions, offsets) in blocks.chunks(batch).zip(offsets.chunks(batch)) {
            let mut chunks = Vec::with_capacity(batch);
            for (&position, &offset) in positions.iter().zip(offsets) {
                if offset < self.tables || offset >= self.length {
                    return Err(ImageError::damaged(name, "a block of pixels is missing"));
                }
                if reader.stream_position().map_err(io)? != offset {
                    reader.seek(SeekFrom::Start(offset)).map_err(io)?;
                }
                let chunk = Chunk::read(&mut &mut *reader, &self.meta).map_err(|e| explain(name, e))?;
                chunks.push((position, chunk));
            }
            let decoded: Vec<Result<UncompressedBlock, ImageError>> = chunks
                .into_par_iter()
                .map(|(position, chunk)| self.decompress(name, part, position, chunk))
                .collect();
            for block in decoded {
                let block = block?;
                for (bytes, line) in LineIndex::lines_in_block(block.index, &header.channels) {
                    let Some((channel, samples)) = place[line.channel] else { continue };
                    let (x, y) = (left + line.position.x(), top + line.position.y());
                    sink(Line { channel, x, y, bytes: &block.data[bytes], samples });
                }
            }
        }
        Ok(())
    }

    fn decompress(
        &self,
        name: &str,
        part: usize,
        (position, size): (Vec2<usize>, Vec2<usize>),
        chunk: Chunk,
    ) -> Result<UncompressedBlock, ImageError> {
        if chunk.layer_index != part {
            return Err(ImageError::damaged(name, "a block of pixels belongs to another part"));
        }
        let header = &self.meta.headers[part];
        if !believable(header, &chunk, size) {
            return Err(ImageError::damaged(name, "a block of pixels claims an absurd size"));
        }
        let block = guard::contain(|| UncompressedBlock::decompress_chunk(chunk, &self.meta, false))
            .ok_or_else(|| ImageError::damaged(name, "a block of pixels makes no sense"))?
            .map_err(|e| explain(name, e))?;
        let bytes = size.area() * self.meta.headers[part].channels.bytes_per_pixel;
        let index = block.index;
        if index.pixel_position != position
            || index.pixel_size != size
            || index.level != Vec2(0, 0)
            || block.data.len() != bytes
        {
            return Err(ImageError::damaged(name, "a block of pixels is not where it belongs"));
        }
        Ok(block)
    }
}

/// Header attributes that say how a file is laid out, not what the picture is.
const STRUCTURE: [&str; 19] = [
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
    "tiles",
    "type",
    "version",
    "view",
];

/// Does a DWA block claim no more memory than its pixels can need? The decoder allocates whatever the
/// counters at its start say, before it looks at the data.
fn believable(header: &Header, chunk: &Chunk, size: Vec2<usize>) -> bool {
    if !matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)) {
        return true;
    }
    let bytes = match &chunk.compressed_block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        _ => return true,
    };
    // Channels are coded in squares of 8 by 8, so the edges count as whole squares.
    let padded = (size.width() + 7) * (size.height() + 7) * header.channels.bytes_per_pixel;
    let limit = 4 * padded as u64 + (1 << 16);
    if bytes.len() == size.area() * header.channels.bytes_per_pixel {
        return true; // stored as it is
    }
    let (counters, _) = bytes.as_chunks::<8>();
    counters.iter().take(10).all(|&counter| u64::from_le_bytes(counter) <= limit)
}

/// Positions and sizes of the blocks of a part's full resolution, in the order of its table.
fn blocks(header: &Header) -> Vec<(Vec2<usize>, Vec2<usize>)> {
    let Vec2(width, height) = header.layer_size;
    let Vec2(w, h) = match header.blocks {
        BlockDescription::ScanLines => Vec2(width, header.compression.scan_lines_per_block()),
        BlockDescription::Tiles(tiles) => tiles.tile_size,
    };
    if width == 0 || height == 0 || w == 0 || h == 0 {
        return Vec::new();
    }
    let mut list = Vec::new();
    for row in 0..compute_block_count(height, h) {
        for column in 0..compute_block_count(width, w) {
            let (x, y) = (column * w, row * h);
            list.push((Vec2(x, y), Vec2(w.min(width - x), h.min(height - y))));
        }
    }
    list
}

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
    // Parts far from one another would make an image of mostly nothing.
    guard::check_size(name, width, height, 4, length).map_err(|e| match meta.headers.len() {
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

fn subsampled(name: &str, channel: &str) -> ImageError {
    let message = format!("`{name}` stores `{channel}` with subsampled channels, which are not read");
    ImageError::new(ErrorKind::Unsupported, message)
        .hint("Convert it to full resolution first (luminance/chroma to RGB).")
}

fn explain(name: &str, error: exr::error::Error) -> ImageError {
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
