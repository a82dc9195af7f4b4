//! The pixels of an EXR file, block by block from the top, decompressed in parallel.

use super::error::{ErrorKind, ImageError};
use super::file::{Channel, Samples};
use super::guard;
use super::read_exr::{Exr, explain};
use super::source::{Input, ReadSeek};
use exr::block::UncompressedBlock;
use exr::block::chunk::{Chunk, CompressedBlock};
use exr::block::lines::LineIndex;
use exr::math::Vec2;
use exr::meta::attribute::Compression;
use exr::meta::header::Header;
use exr::meta::{BlockDescription, compute_block_count};
use rayon::prelude::*;
use std::io::SeekFrom;
use std::ops::Range;

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

/// A way through the wanted channels of a file, from the top down.
pub(crate) struct Scan<'f> {
    exr: &'f Exr,
    name: String,
    reader: Box<dyn ReadSeek>,
    parts: Vec<Part>,
}

/// How many blocks are decoded at a time, and how many bytes one has. A batch gives every thread something to do, and is
/// no more than some 16 MB if it need not be.
fn batch(header: &Header, blocks: &Blocks) -> (usize, usize) {
    let bytes = header.channels.bytes_per_pixel * blocks.size.area();
    let threads = rayon::current_num_threads();
    (((16 << 20) / bytes.max(1)).clamp(2 * threads, 8 * threads), bytes)
}

/// Bytes that decoding takes, about: a batch of the largest part packed and unpacked, and what each thread needs.
pub(super) fn working_memory(exr: &Exr) -> u64 {
    let headers = exr.headers().iter().filter(|header| !header.deep);
    let one = |header: &Header| {
        let (batch, bytes) = batch(header, &Blocks::of(header));
        (2 * batch + 2 * rayon::current_num_threads()) as u64 * bytes as u64
    };
    headers.map(one).max().unwrap_or(0)
}

/// A part of the file with wanted channels.
struct Part {
    index: usize,
    /// For each of its channels: the place in the file's list, if it is wanted.
    places: Vec<Option<(usize, Samples)>>,
    /// Where its data window lies in the union of all.
    left: usize,
    top: usize,
    blocks: Blocks,
    /// Where its table of block offsets begins.
    table: u64,
    /// The blocks before this one are done.
    next: usize,
    /// How many blocks are decoded at a time.
    batch: usize,
}

impl<'f> Scan<'f> {
    /// Before the first row; only the channels for which `wanted` holds will be decoded.
    pub fn new(
        exr: &'f Exr,
        input: &Input,
        channels: &[Channel],
        wanted: &[bool],
    ) -> Result<Scan<'f>, ImageError> {
        let name = input.name();
        let (reader, _) = input.open()?;
        let mut table = exr.tables;
        let mut parts = Vec::new();
        for (index, header) in exr.headers().iter().enumerate() {
            let mine = channels.iter().enumerate().filter(|(i, c)| c.part == index && wanted[*i]);
            let mut places = vec![None; header.channels.list.len()];
            for (slot, channel) in mine {
                if header.channels.list.iter().any(|c| c.sampling != Vec2(1, 1)) {
                    return Err(subsampled(&name, &channel.name));
                }
                places[channel.index] = Some((slot, channel.samples));
            }
            if places.iter().any(Option::is_some) {
                let blocks = Blocks::of(header);
                let position = header.own_attributes.layer_position;
                parts.push(Part {
                    index,
                    places,
                    left: (i64::from(position.x()) - exr.window.0) as usize,
                    top: (i64::from(position.y()) - exr.window.1) as usize,
                    batch: batch(header, &blocks).0,
                    blocks,
                    table,
                    next: 0,
                });
            }
            table += 8 * header.chunk_count as u64;
        }
        Ok(Scan { exr, name, reader, parts })
    }

    /// The row after the last one of the blocks that hold the row `row`: what has been touched once rows up to there
    /// are decoded.
    pub fn reach(&self, row: usize) -> usize {
        let reach = |part: &Part| {
            // Of a part that lies further down nothing is touched yet, however far that is.
            if row <= part.top {
                return 0;
            }
            let inside = row.saturating_sub(part.top).min(part.blocks.whole.height());
            let height = part.blocks.size.height().max(1);
            part.top + (inside.div_ceil(height) * height).min(part.blocks.whole.height())
        };
        self.parts.iter().map(reach).max().unwrap_or(0)
    }

    /// Decodes the blocks that hold some of these rows and are not decoded yet, and gives their lines to `sink`, each
    /// once. Rows must not be asked for from further up than before.
    pub fn decode(&mut self, rows: Range<usize>, mut sink: impl FnMut(Line<'_>)) -> Result<(), ImageError> {
        let Scan { exr, name, reader, parts } = self;
        parts.iter_mut().try_for_each(|part| part.decode(exr, name, &mut **reader, &rows, &mut sink))
    }
}

impl Part {
    fn decode(
        &mut self,
        exr: &Exr,
        name: &str,
        reader: &mut dyn ReadSeek,
        rows: &Range<usize>,
        sink: &mut impl FnMut(Line<'_>),
    ) -> Result<(), ImageError> {
        let header = &exr.headers()[self.index];
        let io = |e: std::io::Error| ImageError::io("read", name, &e);
        let inside = |row: usize| row.saturating_sub(self.top).min(self.blocks.whole.height());
        let range = self.blocks.with(inside(rows.start)..inside(rows.end));
        let range = range.start.max(self.next)..range.end.max(self.next);
        if range.is_empty() {
            return Ok(());
        }
        // The blocks of the full resolution come first in the table, whatever smaller levels follow.
        reader.seek(SeekFrom::Start(self.table + 8 * range.start as u64)).map_err(io)?;
        let mut offsets = vec![0u8; range.len() * 8];
        reader.read_exact(&mut offsets).map_err(io)?;
        let (offsets, _) = offsets.as_chunks::<8>();
        for (indices, offsets) in range.clone().step_by(self.batch).zip(offsets.chunks(self.batch)) {
            let mut chunks = Vec::with_capacity(self.batch);
            for (block, &offset) in (indices..).zip(offsets) {
                let offset = u64::from_le_bytes(offset);
                if offset < exr.tables || offset >= exr.length {
                    return Err(ImageError::damaged(name, "a block of pixels is missing"));
                }
                if reader.stream_position().map_err(io)? != offset {
                    reader.seek(SeekFrom::Start(offset)).map_err(io)?;
                }
                let chunk = Chunk::read(&mut &mut *reader, &exr.meta).map_err(|e| explain(name, e))?;
                chunks.push((self.blocks.at(block), chunk));
            }
            let decoded: Vec<Result<UncompressedBlock, ImageError>> = chunks
                .into_par_iter()
                .map(|(place, chunk)| decompress(exr, name, self.index, place, chunk))
                .collect();
            for block in decoded {
                let block = block?;
                for (bytes, line) in LineIndex::lines_in_block(block.index, &header.channels) {
                    let Some((channel, samples)) = self.places[line.channel] else { continue };
                    let (x, y) = (self.left + line.position.x(), self.top + line.position.y());
                    sink(Line { channel, x, y, bytes: &block.data[bytes], samples });
                }
            }
        }
        self.next = range.end;
        Ok(())
    }
}

fn decompress(
    exr: &Exr,
    name: &str,
    part: usize,
    (position, size): (Vec2<usize>, Vec2<usize>),
    chunk: Chunk,
) -> Result<UncompressedBlock, ImageError> {
    if chunk.layer_index != part {
        return Err(ImageError::damaged(name, "a block of pixels belongs to another part"));
    }
    let header = &exr.headers()[part];
    if !believable(header, &chunk, size) {
        return Err(ImageError::damaged(name, "a block of pixels claims an absurd size"));
    }
    let block = guard::contain(|| UncompressedBlock::decompress_chunk(chunk, &exr.meta, false))
        .ok_or_else(|| ImageError::damaged(name, "a block of pixels makes no sense"))?
        .map_err(|e| explain(name, e))?;
    let bytes = size.area() * header.channels.bytes_per_pixel;
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

/// The blocks of a part's full resolution, in the order of its table: row by row, whatever the order in the file.
struct Blocks {
    whole: Vec2<usize>,
    size: Vec2<usize>,
    columns: usize,
}

impl Blocks {
    fn of(header: &Header) -> Blocks {
        let whole = header.layer_size;
        let size = match header.blocks {
            BlockDescription::ScanLines => {
                Vec2(whole.width(), header.compression.scan_lines_per_block().min(whole.height()))
            }
            BlockDescription::Tiles(tiles) => tiles.tile_size,
        };
        // A side of 0 is no block, and no division by it.
        let size = Vec2(size.width().max(1), size.height().max(1));
        Blocks { whole, size, columns: compute_block_count(whole.width(), size.width()) }
    }

    /// Those that hold some of these rows.
    fn with(&self, rows: Range<usize>) -> Range<usize> {
        let height = self.size.height();
        let range = self.columns * (rows.start / height)..self.columns * rows.end.div_ceil(height);
        if rows.is_empty() { 0..0 } else { range }
    }

    /// The place and size of one.
    fn at(&self, index: usize) -> (Vec2<usize>, Vec2<usize>) {
        let (x, y) = (index % self.columns * self.size.width(), index / self.columns * self.size.height());
        let size = Vec2(
            self.size.width().min(self.whole.width() - x),
            self.size.height().min(self.whole.height() - y),
        );
        (Vec2(x, y), size)
    }
}

fn subsampled(name: &str, channel: &str) -> ImageError {
    let message = format!("`{name}` stores `{channel}` with subsampled channels, which are not read");
    ImageError::new(ErrorKind::Unsupported, message)
        .hint("Convert it to full resolution first (luminance/chroma to RGB).")
}
