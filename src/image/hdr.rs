//! The header of Radiance HDR files, of any program and any order of rows; the pixels are the `image` crate's.

use super::error::{ErrorKind, ImageError};

/// What the header says.
pub(super) struct Header {
    /// Columns and rows as they are stored.
    pub size: [usize; 2],
    /// How the stored rows lie in the picture, as an EXIF orientation.
    pub orientation: u8,
    /// Bytes of the header.
    pub length: usize,
}

/// The greatest header that is read.
pub(super) const LONGEST_HEADER: u64 = 1 << 16;

/// Whether a file that begins with these bytes is an HDR picture.
pub(super) fn is_hdr(start: &[u8]) -> bool {
    let format = b"FORMAT=32-bit_rle_";
    start.starts_with(b"#?RADIANCE")
        || start.starts_with(b"#?RGBE")
        || start.starts_with(b"#?") && start.windows(format.len()).any(|part| part == format)
}

/// Reads the header at the start of these bytes.
pub(super) fn header(name: &str, start: &[u8]) -> Result<Header, ImageError> {
    let damaged = || ImageError::damaged(name, "its header is invalid");
    let mut length = 0;
    let mut line = || -> Result<String, ImageError> {
        let rest = &start[length..];
        let end = rest.iter().position(|&b| b == b'\n').ok_or_else(damaged)?;
        length += end + 1;
        Ok(String::from_utf8_lossy(&rest[..end]).trim_end().to_string())
    };
    loop {
        let text = line()?;
        if text.is_empty() {
            break;
        }
        if let Some(format) = text.strip_prefix("FORMAT=").filter(|f| f.trim() != "32-bit_rle_rgbe") {
            let message = format!("`{name}` cannot be read: HDR of the format {}", format.trim());
            return Err(ImageError::new(ErrorKind::Unsupported, message));
        }
    }
    let resolution = line()?;
    let words: Vec<&str> = resolution.split_whitespace().collect();
    let &[first, rows, second, columns] = &words[..] else { return Err(damaged()) };
    let number = |text: &str| text.parse::<u32>().map(|n| n as usize).map_err(|_| damaged());
    // Rows may run along y or x, in either direction; `-Y` is from the top, `+X` from the left.
    let orientation = match (first, second) {
        ("-Y", "+X") => 1,
        ("-Y", "-X") => 2,
        ("+Y", "-X") => 3,
        ("+Y", "+X") => 4,
        ("+X", "-Y") => 5,
        ("-X", "-Y") => 6,
        ("-X", "+Y") => 7,
        ("+X", "+Y") => 8,
        _ => return Err(damaged()),
    };
    Ok(Header { size: [number(columns)?, number(rows)?], orientation, length })
}

/// The file with the usual header, for a decoder that knows no other.
pub(super) fn usual(header: &Header, bytes: &[u8]) -> Vec<u8> {
    let [columns, rows] = header.size;
    let start = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {rows} +X {columns}\n");
    [start.as_bytes(), &bytes[header.length..]].concat()
}
