//! JPEG inside TIFF: streams that share tables, and the old style, whose tables stand in the directory.

use super::super::error::ImageError;
use super::super::jpeg::{is_complete, lacks_pixels};
use super::directory::{Directory, TiffReader};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// A decoded stream: interleaved samples of 8 bits, in the stream's own colour space.
pub(super) struct Picture {
    pub size: [usize; 2],
    pub components: usize,
    pub samples: Vec<u8>,
}

/// Decodes a stream of at most `most` samples. `tables` is a stream of tables alone, or empty.
pub(super) fn decode(tables: &[u8], stream: &[u8], most: usize) -> Result<Picture, String> {
    if !stream.starts_with(&[0xff, 0xd8]) {
        return Err("its JPEG data is invalid".into());
    }
    let tables = tables.strip_suffix(&[0xff, 0xd9]).unwrap_or(tables);
    let joined = match tables.starts_with(&[0xff, 0xd8]) {
        true => [tables, &stream[2..]].concat(),
        false => stream.to_vec(),
    };
    if lacks_pixels(&joined, most as u64) {
        return Err("it ends too early".into());
    }
    let options = DecoderOptions::default().set_max_width(1 << 16).set_max_height(1 << 16);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(joined), options);
    decoder.decode_headers().map_err(|e| e.to_string())?;
    let size = decoder.dimensions().ok_or("its JPEG data is invalid")?;
    let space = decoder.input_colorspace().unwrap_or(ColorSpace::Luma);
    let components = space.num_components();
    if size.0.saturating_mul(size.1).saturating_mul(components) > most {
        return Err("the JPEG inside is larger than its strip".into());
    }
    decoder.set_options(options.jpeg_set_out_colorspace(space));
    let samples = decoder.decode().map_err(|e| e.to_string())?;
    if samples.len() != size.0 * size.1 * components {
        return Err("its JPEG data is invalid".into());
    }
    Ok(Picture { size: [size.0, size.1], components, samples })
}

/// What the frame of an old-style stream is made of.
pub(super) struct OldFrame {
    pub size: [usize; 2],
    pub components: usize,
    pub subsampling: [usize; 2],
    /// Rows of a strip.
    pub rows: usize,
}

/// Makes one stream of an image in the old style (compression 6).
pub(super) fn old_stream(
    file: &mut TiffReader,
    directory: &Directory,
    frame: &OldFrame,
    strips: &[(u64, u64)],
) -> Result<Vec<u8>, ImageError> {
    let whole = directory.number(file, 513)?.filter(|&at| at > 0 && at < file.length());
    if let Some(at) = whole {
        let given = directory.number(file, 514)?.filter(|&length| length > 0);
        let rest = file.length() - at;
        let mut stream = file.bytes(at, given.unwrap_or(rest).min(rest))?;
        if stream.starts_with(&[0xff, 0xd8]) {
            if let Some(scan) = scan_start(&stream) {
                // The scans may lie outside of the length that is given.
                if scan + 2 >= stream.len() {
                    for &(at, length) in strips {
                        stream.extend(file.bytes(at, length)?);
                    }
                } else if !is_complete(&stream) {
                    stream = file.bytes(at, rest)?;
                }
                return Ok(stream);
            }
            let end = stream.strip_suffix(&[0xff, 0xd9]).map_or(stream.len(), <[u8]>::len);
            stream.truncate(end);
            return add_strips(file, stream, frame, strips);
        }
    }
    let mut stream = vec![0xff, 0xd8];
    let segment = |stream: &mut Vec<u8>, marker: u8, content: &[u8]| {
        stream.extend([0xff, marker]);
        stream.extend((content.len() as u16 + 2).to_be_bytes());
        stream.extend(content);
    };
    for (i, at) in directory.numbers(file, 519)?.into_iter().enumerate() {
        let table = file.bytes(at, 64)?;
        segment(&mut stream, 0xdb, &[&[i as u8], &table[..]].concat());
    }
    for (class, tag) in [(0u8, 520), (0x10, 521)] {
        for (i, at) in directory.numbers(file, tag)?.into_iter().enumerate() {
            let counts = file.bytes(at, 16)?;
            let values = file.bytes(at + 16, counts.iter().map(|&c| u64::from(c)).sum())?;
            segment(&mut stream, 0xc4, &[&[class | i as u8], &counts[..], &values[..]].concat());
        }
    }
    let [width, height] = frame.size;
    let mut header = vec![8];
    header.extend((height as u16).to_be_bytes());
    header.extend((width as u16).to_be_bytes());
    header.push(frame.components as u8);
    for i in 0..frame.components as u8 {
        let [across, down] = if i == 0 { frame.subsampling } else { [1, 1] };
        header.extend([i + 1, (across << 4 | down) as u8, i]);
    }
    segment(&mut stream, 0xc0, &header);
    add_strips(file, stream, frame, strips)
}

/// Adds the scan that the strips hold; each strip begins anew, as after a restart mark.
fn add_strips(
    file: &mut TiffReader,
    mut stream: Vec<u8>,
    frame: &OldFrame,
    strips: &[(u64, u64)],
) -> Result<Vec<u8>, ImageError> {
    let [across, down] = if frame.components == 1 { [1, 1] } else { frame.subsampling };
    let units = frame.size[0].div_ceil(8 * across) * frame.rows.div_ceil(8 * down);
    if strips.len() > 1 {
        stream.extend([0xff, 0xdd, 0, 4]);
        stream.extend((units as u16).to_be_bytes());
    }
    stream.extend([0xff, 0xda, 0, 6 + 2 * frame.components as u8, frame.components as u8]);
    for i in 0..frame.components as u8 {
        stream.extend([i + 1, i << 4 | i]);
    }
    stream.extend([0, 63, 0]);
    for (i, &(at, length)) in strips.iter().enumerate() {
        let bytes = file.bytes(at, length)?;
        let bytes = bytes.strip_suffix(&[0xff, 0xd9]).unwrap_or(&bytes);
        if i > 0 {
            stream.extend([0xff, 0xd0 + (i as u8 - 1) % 8]);
        }
        stream.extend(bytes);
    }
    stream.extend([0xff, 0xd9]);
    Ok(stream)
}

/// Returns where the first scan of a stream begins, behind its header.
fn scan_start(stream: &[u8]) -> Option<usize> {
    let mut at = 2;
    loop {
        let &[0xff, marker, high, low] = stream.get(at..at + 4)? else { return None };
        at += 2 + usize::from(u16::from_be_bytes([high, low]));
        if marker == 0xda {
            return (at <= stream.len()).then_some(at);
        }
    }
}
