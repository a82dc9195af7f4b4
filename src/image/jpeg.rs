//! Whether a JPEG stream has lost its end. Decoders fill what is missing with grey and say nothing.

use ::image::codecs::jpeg::JpegDecoder;
use ::image::{ImageDecoder, ImageResult};
use std::io::Cursor;

/// Whether the stream goes on to its end marker.
pub(super) fn is_complete(stream: &[u8]) -> bool {
    ends(stream).complete
}

/// How the markers of a stream go on.
struct Ends {
    complete: bool,
    /// Whether every part of the picture stands in the first scan, from top to bottom.
    sequential: bool,
}

fn ends(stream: &[u8]) -> Ends {
    let mut ends = Ends { complete: false, sequential: false };
    let mut at = 2;
    let mut scans = 0;
    while let Some(&byte) = stream.get(at) {
        // Between segments only filling is allowed; decoders skip anything.
        let Some(&marker) = stream.get(at + 1).filter(|_| byte == 0xff) else {
            at += 1;
            continue;
        };
        match marker {
            0xff => at += 1,
            0xd9 => {
                // A picture has a scan before its end.
                ends.complete = scans > 0;
                return ends;
            }
            0 | 1 | 0xd0..=0xd8 => at += 2,
            _ => {
                ends.sequential = match marker {
                    0xc0 | 0xc1 => true,
                    0xc2 => false,
                    0xda if scans > 0 => false,
                    _ => ends.sequential,
                };
                scans += usize::from(marker == 0xda);
                let Some(&[high, low]) = stream.get(at + 2..at + 4).and_then(|b| b.first_chunk()) else {
                    return ends;
                };
                at += 2 + usize::from(u16::from_be_bytes([high, low]));
            }
        }
    }
    ends
}

/// Whether pixels are missing. A stream without an end marker may still hold them all: then bytes that are added at
/// its end change nothing. A picture of more than `most` bytes is not decoded for that.
pub(super) fn lacks_pixels(stream: &[u8], most: u64) -> bool {
    let ends = ends(stream);
    if ends.complete {
        return false;
    }
    if !ends.sequential {
        return true;
    }
    let with = |filling: u8| -> ImageResult<Option<Vec<u8>>> {
        let stream = [stream, &vec![filling; 1 << 16][..], &[0xff, 0xd9]].concat();
        let decoder = JpegDecoder::new(Cursor::new(stream))?;
        if decoder.total_bytes() > most {
            return Ok(None);
        }
        let mut pixels = vec![0; decoder.total_bytes() as usize];
        decoder.read_image(&mut pixels)?;
        Ok(Some(pixels))
    };
    match (with(0x2a), with(0xd5)) {
        (Ok(Some(a)), Ok(Some(b))) => a != b,
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::image::ExtendedColorType;
    use ::image::codecs::jpeg::JpegEncoder;

    #[test]
    fn a_cut_is_found_wherever_it_is() {
        let pixels: Vec<u8> =
            (0..48 * 40 * 3u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        let mut stream = Vec::new();
        JpegEncoder::new_with_quality(&mut stream, 85)
            .encode(&pixels, 48, 40, ExtendedColorType::Rgb8)
            .unwrap();
        assert!(is_complete(&stream) && !lacks_pixels(&stream, 1 << 20));
        let scan = stream.windows(2).position(|w| w == [0xff, 0xda]).unwrap();
        for end in (scan..stream.len() - 4).step_by(97).chain([stream.len() - 8]) {
            assert!(lacks_pixels(&stream[..end], 1 << 20), "{end} of {}", stream.len());
        }
        // The end marker alone is not missed.
        assert!(!lacks_pixels(&stream[..stream.len() - 2], 1 << 20));
        // That of a thumbnail, in a segment, is not the picture's.
        let mut segment = vec![0xff, 0xd8, 0xff, 0xe1, 0, 6, 0xff, 0xda, 0xff, 0xd9];
        segment.extend(&stream[2..stream.len() / 2]);
        assert!(lacks_pixels(&segment, 1 << 20));
    }
}
