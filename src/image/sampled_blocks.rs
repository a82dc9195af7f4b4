//! Blocks of parts with subsampled channels, whose rows are of different lengths.
//!
//! The `exr` crate decompresses blocks in which all channels have all pixels. Others are given to it in a form that it
//! knows: as plain bytes where the compression sees no more than bytes, or channel by channel.

use exr::error::{Error, Result};
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{
    ChannelDescription, ChannelList, Compression, IntegerBounds, LineOrder, SampleType, Text,
};
use exr::meta::header::Header;
use std::ops::Range;

/// Has the part channels with fewer samples than pixels?
pub(super) fn is_sampled(header: &Header) -> bool {
    header.channels.list.iter().any(|c| c.sampling != Vec2(1, 1))
}

/// Whether the part's blocks can be decompressed; else why not.
pub(super) fn check(header: &Header) -> std::result::Result<(), String> {
    if !is_sampled(header) {
        return Ok(());
    }
    let Vec2(left, top) = header.own_attributes.layer_position;
    let Vec2(width, height) = header.layer_size;
    for channel in &header.channels.list {
        let Vec2(x, y) = channel.sampling;
        let divides = |all: usize, start: i32, step: usize| {
            step > 0 && step < 1 << 16 && all.is_multiple_of(step) && start.rem_euclid(step as i32) == 0
        };
        if header.blocks != BlockDescription::ScanLines
            || !divides(width, left, x)
            || !divides(height, top, y)
        {
            return Err("its subsampled channels do not fit its data window".into());
        }
    }
    let lines = header.compression.scan_lines_per_block();
    let fits = match header.compression {
        Compression::Uncompressed | Compression::RLE | Compression::ZIP1 | Compression::ZIP16 => true,
        // The crate wants whole bytes a pixel, and blocks that begin with a row of every channel.
        _ => header.channels.list.iter().all(|c| lines.is_multiple_of(c.sampling.y())),
    };
    let b44 = matches!(header.compression, Compression::B44 | Compression::B44A);
    let samples = |c: &ChannelDescription| (width / c.sampling.x()) * (height / c.sampling.y());
    let bytes =
        header.channels.list.iter().map(|c| samples(c) * c.sample_type.bytes_per_sample()).sum::<usize>();
    if fits && (b44 || is_plain(header) || bytes.is_multiple_of((width * height).max(1))) {
        return Ok(());
    }
    Err(format!("its channels are subsampled, which is not read with {}", header.compression))
}

/// Does the compression see no more than bytes?
fn is_plain(header: &Header) -> bool {
    header.compression.scan_lines_per_block() == 1 || header.compression == Compression::ZIP16
}

/// How many samples a channel has in a row of the data window; none in most rows of one that is subsampled.
pub(super) fn samples_in(header: &Header, channel: &ChannelDescription, row: usize) -> usize {
    match row.is_multiple_of(channel.sampling.y()) {
        true => header.layer_size.width() / channel.sampling.x(),
        false => 0,
    }
}

/// Bytes of some rows.
pub(super) fn size(header: &Header, rows: Range<usize>) -> usize {
    let row = |row| {
        let channels = header.channels.list.iter();
        channels.map(|c| samples_in(header, c, row) * c.sample_type.bytes_per_sample()).sum::<usize>()
    };
    rows.map(row).sum()
}

/// The samples of a block of these rows: row after row, and in each channel after channel.
pub(super) fn decompress(header: &Header, packed: Vec<u8>, rows: Range<usize>) -> Result<Vec<u8>> {
    let bytes = size(header, rows.clone());
    if packed.len() == bytes {
        return Ok(packed);
    }
    let Vec2(width, _) = header.layer_size;
    match header.compression {
        Compression::B44 | Compression::B44A => by_channel(header, &packed, rows),
        _ if is_plain(header) => {
            let plain = ChannelDescription::new(Text::default(), SampleType::F16, false);
            one_block(header, ChannelList::new([plain].into_iter().collect()), Vec2(bytes / 2, 1), packed)
        }
        _ => {
            let size = Vec2(width, rows.len());
            let list = ChannelList { bytes_per_pixel: bytes / size.area(), ..header.channels.clone() };
            one_block(header, list, size, packed)
        }
    }
}

/// Decompresses the only block of a part like this one with other channels.
fn one_block(header: &Header, channels: ChannelList, size: Vec2<usize>, packed: Vec<u8>) -> Result<Vec<u8>> {
    let like =
        Header { layer_size: size, channels, ..Header::new(Text::default(), size, Default::default()) }
            .with_encoding(header.compression, BlockDescription::ScanLines, LineOrder::Increasing);
    let section = IntegerBounds { position: Vec2(0, 0), size };
    header.compression.decompress_image_section_from_le(&like, packed, section, false)
}

/// B44 packs channel after channel, halves in squares of 4 by 4, other samples as they are.
fn by_channel(header: &Header, packed: &[u8], rows: Range<usize>) -> Result<Vec<u8>> {
    let short = || Error::Invalid("not enough data".into());
    let mut rest = packed;
    let mut channels = Vec::new();
    for channel in &header.channels.list {
        let height = rows.clone().filter(|&row| samples_in(header, channel, row) > 0).count();
        let size = Vec2(header.layer_size.width() / channel.sampling.x(), height);
        let plain = size.area() * channel.sample_type.bytes_per_sample();
        let length = match channel.sample_type {
            SampleType::F16 => squares(rest, size).ok_or_else(short)?,
            _ => plain,
        };
        let (own, tail) = rest.split_at_checked(length).ok_or_else(short)?;
        rest = tail;
        if channel.sample_type != SampleType::F16 || plain == 0 {
            channels.push(own.to_vec());
            continue;
        }
        let mut own = own.to_vec();
        if own.len() == plain {
            // Else it would be taken for samples that are not packed. More than the squares is not looked at.
            own.push(0);
        }
        let full = ChannelDescription { sampling: Vec2(1, 1), ..channel.clone() };
        channels.push(one_block(header, ChannelList::new([full].into_iter().collect()), size, own)?);
    }
    let mut bytes = Vec::with_capacity(size(header, rows.clone()));
    let mut places = vec![0; channels.len()];
    for row in rows {
        for ((channel, samples), place) in header.channels.list.iter().zip(&channels).zip(&mut places) {
            let count = samples_in(header, channel, row) * channel.sample_type.bytes_per_sample();
            bytes.extend_from_slice(samples.get(*place..*place + count).ok_or_else(short)?);
            *place += count;
        }
    }
    Ok(bytes)
}

/// How many bytes the squares of a channel of that size take; `None` if there are fewer.
fn squares(packed: &[u8], size: Vec2<usize>) -> Option<usize> {
    let count = size.width().div_ceil(4) * size.height().div_ceil(4);
    (0..count).try_fold(0, |at, _| {
        // A square of one number takes 3 bytes.
        let flat = *packed.get(at + 2)? >= 13 << 2;
        Some(at + if flat { 3 } else { 14 })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(compression: Compression, channels: &[(&str, SampleType, usize)]) -> Header {
        let list = channels.iter().map(|&(name, kind, step)| ChannelDescription {
            sampling: Vec2(step, step),
            ..ChannelDescription::named(name, kind)
        });
        Header::new(Text::default(), (16, 8), list.collect()).with_encoding(
            compression,
            BlockDescription::ScanLines,
            LineOrder::Increasing,
        )
    }

    #[test]
    fn what_cannot_be_decompressed_is_known_before() {
        use SampleType::{F16, F32};
        let mask = [("B", F16, 1), ("G", F16, 1), ("R", F16, 1), ("mask", F16, 2)];
        let chroma = [("BY", F16, 2), ("RY", F16, 2), ("Y", F16, 1)];
        for compression in [Compression::Uncompressed, Compression::RLE, Compression::ZIP16, Compression::B44]
        {
            assert_eq!(check(&header(compression, &mask)), Ok(()));
            assert_eq!(check(&header(compression, &chroma)), Ok(()));
        }
        for compression in [Compression::PIZ, Compression::PXR24, Compression::DWAA(None)] {
            assert_eq!(check(&header(compression, &chroma)), Ok(()));
            assert!(check(&header(compression, &mask)).unwrap_err().contains("subsampled"));
        }
        // 3 divides no width of 16.
        assert!(check(&header(Compression::RLE, &[("Y", F32, 3)])).unwrap_err().contains("data window"));
        let mut moved = header(Compression::RLE, &chroma);
        moved.own_attributes.layer_position = Vec2(-3, 0);
        assert!(check(&moved).unwrap_err().contains("data window"));
        moved.own_attributes.layer_position = Vec2(-4, 2);
        assert_eq!(check(&moved), Ok(()));
        assert_eq!(size(&moved, 0..2), 2 * 16 * 2 + 2 * 8 * 2);
    }
}
