//! The pixels of an EXR file, block by block from the top, decompressed in parallel.

use super::error::ImageError;
use super::file::{Channel, Samples};
use super::read_exr::{Exr, explain};
use super::source::{Input, ReadSeek};
use super::{chunk_table, guard, sampled_blocks};
use crate::parallel::*;
use exr::math::Vec2;
use exr::meta::attribute::{Compression, IntegerBounds};
use exr::meta::header::Header;
use exr::meta::{BlockDescription, compute_block_count};
use std::io::{Read, SeekFrom};
use std::ops::Range;

/// A run of samples of one channel in one row: the channel, then its place in the data window.
pub(crate) struct Line<'a> {
    /// Place in the file's list of channels.
    pub channel: usize,
    /// Column in the union of the data windows.
    pub x: usize,
    /// Row in the union of the data windows.
    pub y: usize,
    /// Columns from one sample to the next.
    pub step: usize,
    /// The samples, in the machine's byte order.
    pub bytes: &'a [u8],
    /// What they are.
    pub samples: Samples,
}

impl Line<'_> {
    /// Writes the samples to `row`, from its start, as floats: halves and floats exactly, integers
    /// rounded to the nearest float. Each comes `step` columns after the one before.
    pub fn floats(&self, row: &mut [f32], step: usize) {
        fn fill<const N: usize>(
            row: &mut [f32],
            step: usize,
            bytes: &[u8],
            convert: impl Fn([u8; N]) -> f32,
        ) {
            let (samples, _) = bytes.as_chunks::<N>();
            match step {
                1 => row.iter_mut().zip(samples).for_each(|(to, &sample)| *to = convert(sample)),
                _ => row.iter_mut().step_by(step).zip(samples).for_each(|(to, &s)| *to = convert(s)),
            }
        }
        match self.samples {
            Samples::Half => fill(row, step, self.bytes, |b| half::f16::from_ne_bytes(b).to_f32()),
            Samples::Uint => fill(row, step, self.bytes, |b| u32::from_ne_bytes(b) as f32),
            _ => fill(row, step, self.bytes, f32::from_ne_bytes),
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
    parts: Vec<Part<'f>>,
    /// Where the blocks of all parts begin, if the file's tables do not say.
    rebuilt: Option<Vec<Vec<u64>>>,
}

/// How many blocks are decoded at a time, and how many bytes one has. A batch gives every thread something to do, and is
/// no more than some 16 MB if it need not be.
fn batch(header: &Header, blocks: &Blocks) -> (usize, usize) {
    let bytes = header.channels.bytes_per_pixel * blocks.size.area();
    let threads = crate::parallel::current_num_threads();
    (((16 << 20) / bytes.max(1)).clamp(2 * threads, 8 * threads), bytes)
}

/// Bytes that decoding takes, about: a batch of the largest part packed and unpacked, and what each thread needs.
pub(super) fn working_memory(exr: &Exr) -> u64 {
    let headers = exr.headers();
    let one = |header: &Header| {
        let (batch, bytes) = batch(header, &Blocks::of(header));
        (2 * batch + 2 * crate::parallel::current_num_threads()) as u64 * bytes as u64
    };
    headers.map(one).max().unwrap_or(0)
}

/// A part of the file with wanted channels.
struct Part<'f> {
    index: usize,
    header: &'f Header,
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
        for (index, part) in exr.parts.iter().enumerate() {
            if let (Some(header), Some(window)) = (part.readable(), exr.part_window(index)) {
                let mine = channels.iter().enumerate().filter(|(i, c)| c.part == index && wanted[*i]);
                let mut places = vec![None; header.channels.list.len()];
                for (slot, channel) in mine {
                    places[channel.index] = Some((slot, channel.samples));
                }
                if places.iter().any(Option::is_some) {
                    let blocks = Blocks::of(header);
                    parts.push(Part {
                        index,
                        header,
                        places,
                        left: window.left,
                        top: window.top,
                        batch: batch(header, &blocks).0,
                        blocks,
                        table,
                        next: 0,
                    });
                }
            }
            table = table.saturating_add(8 * part.chunk_count);
        }
        Ok(Scan { exr, name, reader, parts, rebuilt: None })
    }

    /// The row after the last one of the blocks that hold the row `row`: what has been touched once rows up to there
    /// are decoded.
    pub fn reach(&self, row: usize) -> usize {
        let reach = |part: &Part<'_>| {
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
        let Scan { exr, name, reader, parts, rebuilt } = self;
        parts.iter_mut().try_for_each(|part| part.decode(exr, name, &mut **reader, rebuilt, &rows, &mut sink))
    }
}

impl Part<'_> {
    fn decode(
        &mut self,
        exr: &Exr,
        name: &str,
        reader: &mut dyn ReadSeek,
        rebuilt: &mut Option<Vec<Vec<u64>>>,
        rows: &Range<usize>,
        sink: &mut impl FnMut(Line<'_>),
    ) -> Result<(), ImageError> {
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
        let mut offsets: Vec<u64> = offsets.iter().map(|bytes| u64::from_le_bytes(*bytes)).collect();
        let missing = |offset: &u64| *offset < exr.first_block() || *offset >= exr.length;
        if offsets.iter().any(missing) {
            let tables = rebuilt.get_or_insert_with(|| chunk_table::rebuild(exr, reader));
            offsets.copy_from_slice(&tables[self.index][range.clone()]);
        }
        if offsets.iter().any(missing) {
            return Err(ImageError::damaged(name, "a block of pixels is missing"));
        }
        for (indices, offsets) in range.clone().step_by(self.batch).zip(offsets.chunks(self.batch)) {
            let mut chunks = Vec::with_capacity(self.batch);
            for (block, &offset) in (indices..).zip(offsets) {
                if reader.stream_position().map_err(io)? != offset {
                    reader.seek(SeekFrom::Start(offset)).map_err(io)?;
                }
                chunks.push((self.blocks.at(block), self.packed(exr, name, block, reader)?));
            }
            let decoded: Vec<Result<Vec<u8>, ImageError>> = chunks
                .par_iter_mut()
                .map(|(place, packed)| decompress(self.header, name, *place, std::mem::take(packed)))
                .collect();
            for ((place, _), block) in chunks.iter().zip(decoded) {
                self.lines(*place, &block?, sink);
            }
        }
        self.next = range.end;
        Ok(())
    }

    /// Reads a block from where it begins, without decompressing it.
    fn packed(
        &self,
        exr: &Exr,
        name: &str,
        block: usize,
        reader: &mut dyn ReadSeek,
    ) -> Result<Vec<u8>, ImageError> {
        let mut number = || -> Result<i32, ImageError> {
            let mut bytes = [0; 4];
            reader.read_exact(&mut bytes).map_err(|e| ImageError::io("read", name, &e))?;
            Ok(i32::from_le_bytes(bytes))
        };
        let damaged = |why: &str| Err(ImageError::damaged(name, why));
        if exr.multipart && usize::try_from(number()?).ok() != Some(self.index) {
            return damaged("a block of pixels belongs to another part");
        }
        let at_home = match self.header.blocks {
            BlockDescription::ScanLines => {
                let row = self.blocks.at(block).0.y() as i64;
                i64::from(number()?) == i64::from(self.header.own_attributes.layer_position.y()) + row
            }
            BlockDescription::Tiles(_) => {
                let (x, y) = (block % self.blocks.columns, block / self.blocks.columns);
                [x as i64, y as i64, 0, 0].into_iter().try_fold(true, |same, wanted| {
                    Ok::<bool, ImageError>(i64::from(number()?) == wanted && same)
                })?
            }
        };
        if !at_home {
            return damaged("a block of pixels is not where it belongs");
        }
        let size = number()?;
        // What does not shrink is stored as it is.
        let most = self.blocks.size.area() * self.header.channels.bytes_per_pixel;
        let Some(size) = usize::try_from(size).ok().filter(|size| *size <= most) else {
            return damaged("a block of pixels claims an impossible size");
        };
        let mut packed = Vec::new();
        reader.take(size as u64).read_to_end(&mut packed).map_err(|e| ImageError::io("read", name, &e))?;
        if packed.len() != size {
            return damaged("it ends too early");
        }
        Ok(packed)
    }

    /// Gives the lines of a block to `sink`.
    fn lines(&self, (at, size): (Vec2<usize>, Vec2<usize>), block: &[u8], sink: &mut impl FnMut(Line<'_>)) {
        let mut from = 0;
        for row in at.y()..at.y() + size.height() {
            for (channel, place) in self.header.channels.list.iter().zip(&self.places) {
                let Vec2(step, step_y) = channel.sampling;
                if !row.is_multiple_of(step_y) {
                    continue;
                }
                let bytes = size.width() / step * channel.sample_type.bytes_per_sample();
                if let Some((channel, samples)) = *place {
                    let (x, y) = (self.left + at.x(), self.top + row);
                    sink(Line { channel, x, y, step, bytes: &block[from..from + bytes], samples });
                }
                from += bytes;
            }
        }
    }
}

/// The samples of a block, of which the part has just as many.
fn decompress(
    header: &Header,
    name: &str,
    (at, size): (Vec2<usize>, Vec2<usize>),
    packed: Vec<u8>,
) -> Result<Vec<u8>, ImageError> {
    let sampled = sampled_blocks::is_sampled(header);
    let rows = at.y()..at.y() + size.height();
    let bytes = match sampled {
        true => sampled_blocks::size(header, rows.clone()),
        false => size.area() * header.channels.bytes_per_pixel,
    };
    if !believable(header, &packed, bytes, size) {
        return Err(ImageError::damaged(name, "a block of pixels claims an impossible size"));
    }
    let unpack = || match sampled {
        true => sampled_blocks::decompress(header, packed, rows),
        false => {
            let position = Vec2(at.x() as i32, at.y() as i32);
            let section = IntegerBounds { position, size };
            header.compression.decompress_image_section_from_le(header, packed, section, false)
        }
    };
    let block = guard::contain(unpack)
        .ok_or_else(|| ImageError::damaged(name, "a block of pixels is invalid"))?
        .map_err(|e| explain(name, e))?;
    if block.len() != bytes {
        return Err(ImageError::damaged(name, "a block of pixels has the wrong size"));
    }
    Ok(block)
}

/// Does a DWA block claim no more memory than its pixels can need? The decoder allocates whatever the
/// counters at its start say, before it looks at the data.
fn believable(header: &Header, packed: &[u8], bytes: usize, size: Vec2<usize>) -> bool {
    if !matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)) || packed.len() == bytes {
        return true;
    }
    // Channels are coded in squares of 8 by 8, so the edges count as whole squares.
    let padded = (size.width() + 7) * (size.height() + 7) * header.channels.bytes_per_pixel;
    let limit = 4 * padded as u64 + (1 << 16);
    let (counters, _) = packed.as_chunks::<8>();
    counters.iter().take(10).all(|&counter| u64::from_le_bytes(counter) <= limit)
}

/// The blocks of a part's full resolution, in the order of its table: row by row, whatever the order in the file.
pub(super) struct Blocks {
    whole: Vec2<usize>,
    size: Vec2<usize>,
    columns: usize,
}

impl Blocks {
    /// Those of a part.
    pub fn of(header: &Header) -> Blocks {
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
    pub fn with(&self, rows: Range<usize>) -> Range<usize> {
        let height = self.size.height();
        let range = self.columns * (rows.start / height)..self.columns * rows.end.div_ceil(height);
        if rows.is_empty() { 0..0 } else { range }
    }

    /// The number of the one that begins at this column and row; `None` if none does.
    pub fn beginning(&self, [x, y]: [i64; 2]) -> Option<usize> {
        let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
        let inside = x < self.whole.width() && y < self.whole.height();
        let whole = x.is_multiple_of(self.size.width()) && y.is_multiple_of(self.size.height());
        (inside && whole).then(|| y / self.size.height() * self.columns + x / self.size.width())
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
