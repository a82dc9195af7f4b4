//! The chunks of a PNG that say how the picture is to be turned: an EXIF block of its own, or one that ImageMagick has
//! put into a text.

use super::error::ImageError;
use super::source::ReadSeek;
use super::tiff::exif_orientation;
use std::io::{self, Read, SeekFrom};

/// Longer blocks are not looked at.
const LONGEST: u32 = 1 << 20;

/// Returns the orientation, 1 to 8, that a PNG asks for, wherever in the file that stands.
///
/// # Errors
/// If the chunks end before the one that ends the file.
pub(super) fn orientation(name: &str, reader: &mut Box<dyn ReadSeek>) -> Result<Option<u8>, ImageError> {
    find(reader).map_err(|e| ImageError::io("read", name, &e))
}

fn find(reader: &mut Box<dyn ReadSeek>) -> io::Result<Option<u8>> {
    reader.seek(SeekFrom::Start(8))?;
    let mut found = None;
    loop {
        let mut head = [0; 8];
        reader.read_exact(&mut head)?;
        let [a, b, c, d, kind @ ..] = head;
        let length = u32::from_be_bytes([a, b, c, d]);
        let interesting = matches!(&kind, b"eXIf" | b"tEXt" | b"zTXt") && length <= LONGEST;
        if &kind == b"IEND" {
            return Ok(found);
        }
        if !interesting || found.is_some() {
            reader.seek(SeekFrom::Current(i64::from(length) + 4))?;
            continue;
        }
        let mut content = vec![0; length as usize];
        reader.read_exact(&mut content)?;
        reader.seek(SeekFrom::Current(4))?;
        let block = match &kind {
            b"eXIf" => Some(content),
            _ => text_profile(&content, &kind == b"zTXt"),
        };
        found = block.and_then(|block| exif_orientation(&block));
    }
}

/// The bytes of a text of the kind "Raw profile type exif": a name, a length, and hexadecimal digits.
fn text_profile(content: &[u8], packed: bool) -> Option<Vec<u8>> {
    let rest = content.strip_prefix(b"Raw profile type ")?;
    let rest = rest.strip_prefix(b"exif\0").or(rest.strip_prefix(b"APP1\0"))?;
    let mut text = Vec::new();
    match packed {
        true => {
            let data = rest.strip_prefix(&[0])?;
            flate2::read::ZlibDecoder::new(data).take(LONGEST.into()).read_to_end(&mut text).ok()?;
        }
        false => text.extend(rest),
    }
    let text = String::from_utf8(text).ok()?;
    let mut words = text.split_ascii_whitespace();
    let (_name, _length) = (words.next()?, words.next()?);
    let digits: Vec<u8> =
        words.flat_map(str::bytes).map(|d| (d as char).to_digit(16).map_or(16, |v| v as u8)).collect();
    Some(digits.chunks_exact(2).map(|pair| pair[0] << 4 | pair[1]).collect())
}
