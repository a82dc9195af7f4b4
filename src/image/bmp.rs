//! BMP files with the headers of OS/2 2, in the form that the `image` crate knows.

use super::error::{ErrorKind, ImageError};

/// Bytes before the header of the picture.
const FILE_HEADER: usize = 14;

/// Bytes of the header that Windows has used since version 3; that of OS/2 begins with the same numbers.
const USUAL: u32 = 40;

/// The file with the usual header in the place of one of OS/2 2; `None`: it has another header.
pub(super) fn usual(name: &str, bytes: &[u8]) -> Result<Option<Vec<u8>>, ImageError> {
    let number =
        |at: usize| bytes.get(at..at + 4).and_then(|b| b.first_chunk()).map(|&b| u32::from_le_bytes(b));
    let (Some(offset), Some(size)) = (number(10), number(FILE_HEADER)) else { return Ok(None) };
    if !bytes.starts_with(b"BM") || !matches!(size, 16 | 64) {
        return Ok(None);
    }
    let header = bytes.get(FILE_HEADER..FILE_HEADER + size as usize);
    let header = header.ok_or_else(|| ImageError::damaged(name, "it ends too early"))?;
    let mut usual = header[..header.len().min(USUAL as usize)].to_vec();
    usual.resize(USUAL as usize, 0);
    usual[..4].copy_from_slice(&USUAL.to_le_bytes());
    if let method @ 3.. = u32::from_le_bytes([usual[16], usual[17], usual[18], usual[19]]) {
        let method = match method {
            3 => "Huffman",
            4 => "24-bit RLE",
            _ => "unknown",
        };
        let message = format!("`{name}` cannot be read: OS/2 BMP with {method} compression");
        return Err(ImageError::new(ErrorKind::Unsupported, message));
    }
    let mut file = bytes[..FILE_HEADER].to_vec();
    let moved = i64::from(offset) + i64::from(USUAL) - i64::from(size);
    file[10..].copy_from_slice(&(moved.max(0) as u32).to_le_bytes());
    Ok(Some([&file[..], &usual, &bytes[FILE_HEADER + size as usize..]].concat()))
}
