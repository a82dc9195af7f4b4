//! TIFF directories: the header of a file, classic or BigTIFF, and the entries that describe its first image. EXIF
//! blocks have the same structure.

use super::super::error::ImageError;
use super::super::source::{Input, ReadSeek};
use std::io::{Cursor, Read, SeekFrom};

/// A TIFF file that is open for reading.
pub(crate) struct TiffReader {
    name: String,
    reader: Box<dyn ReadSeek>,
    length: u64,
    big_endian: bool,
}

/// The entries of one image.
pub(crate) struct Directory {
    entries: Vec<Entry>,
}

struct Entry {
    tag: u16,
    kind: u16,
    count: u64,
    position: u64,
}

/// Bytes of a value of each type of the TIFF specification; 0 for types that do not exist.
const SIZES: [u64; 19] = [0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8];

/// Whether a file that begins with these bytes is a TIFF.
pub(crate) fn is_tiff(start: &[u8]) -> bool {
    [b"II\x2a\0", b"MM\0\x2a", b"II\x2b\0", b"MM\0\x2b"].iter().any(|magic| start.starts_with(*magic))
}

/// Returns the orientation, 1 to 8, that an EXIF block asks for.
pub(crate) fn exif_orientation(block: &[u8]) -> Option<u8> {
    let block = block.strip_prefix(b"Exif\0\0").unwrap_or(block);
    let length = block.len() as u64;
    let (mut reader, directory) =
        TiffReader::new(String::new(), Box::new(Cursor::new(block.to_vec())), length).ok()?;
    directory.orientation(&mut reader)
}

impl TiffReader {
    /// Opens a file and reads the directory of its first image.
    pub fn open(input: &Input) -> Result<(TiffReader, Directory), ImageError> {
        let (reader, length) = input.open()?;
        TiffReader::new(input.name(), reader, length)
    }

    fn new(
        name: String,
        reader: Box<dyn ReadSeek>,
        length: u64,
    ) -> Result<(TiffReader, Directory), ImageError> {
        let mut file = TiffReader { name, reader, length, big_endian: false };
        let start = file.bytes(0, 8)?;
        file.big_endian = start[0] == b'M';
        let big = start[2..4].contains(&43);
        if !is_tiff(&start) {
            return Err(file.damaged("its header is invalid"));
        }
        let first = if big { file.unsigned(8, 8)? } else { file.unsigned(4, 4)? };
        let directory = file.directory(first, big)?;
        Ok((file, directory))
    }

    /// The name that messages use.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Bytes of the file.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Whether numbers are stored with the most significant byte first.
    pub fn big_endian(&self) -> bool {
        self.big_endian
    }

    /// Returns the error that the file is damaged.
    pub fn damaged(&self, why: impl std::fmt::Display) -> ImageError {
        ImageError::damaged(&self.name, why)
    }

    /// Reads bytes; all of them have to be inside the file.
    pub fn bytes(&mut self, at: u64, count: u64) -> Result<Vec<u8>, ImageError> {
        if at.checked_add(count).is_none_or(|end| end > self.length) {
            return Err(self.damaged("it ends too early"));
        }
        let mut bytes = Vec::new();
        let read = self.reader.seek(SeekFrom::Start(at));
        read.and_then(|_| self.reader.by_ref().take(count).read_to_end(&mut bytes))
            .map_err(|e| ImageError::io("read", &self.name, &e))?;
        if bytes.len() as u64 != count {
            return Err(self.damaged("it ends too early"));
        }
        Ok(bytes)
    }

    fn unsigned(&mut self, at: u64, size: u64) -> Result<u64, ImageError> {
        let bytes = self.bytes(at, size)?;
        Ok(unsigned(&bytes, self.big_endian))
    }

    fn directory(&mut self, at: u64, big: bool) -> Result<Directory, ImageError> {
        let (head, size, offset) = if big { (8, 20, 8) } else { (2, 12, 4) };
        if at == 0 {
            return Err(self.damaged("it holds no image"));
        }
        let count = self.unsigned(at, head)?;
        let table = self.bytes(at + head, count.saturating_mul(size))?;
        let mut entries = Vec::new();
        for (i, entry) in table.chunks_exact(size as usize).enumerate() {
            let number = |from: u64, count: u64| {
                unsigned(&entry[from as usize..(from + count) as usize], self.big_endian)
            };
            let (tag, kind, count) = (number(0, 2) as u16, number(2, 2) as u16, number(4, offset));
            let bytes = SIZES.get(usize::from(kind)).copied().unwrap_or(0).saturating_mul(count);
            // Small values stand in the entry itself.
            let position = match bytes <= offset {
                true => at + head + i as u64 * size + 4 + offset,
                false => number(4 + offset, offset),
            };
            entries.push(Entry { tag, kind, count, position });
        }
        Ok(Directory { entries })
    }
}

fn unsigned(bytes: &[u8], big_endian: bool) -> u64 {
    let add = |sum: u64, &byte: &u8| sum << 8 | u64::from(byte);
    if big_endian { bytes.iter().fold(0, add) } else { bytes.iter().rev().fold(0, add) }
}

impl Directory {
    fn entry(&self, tag: u16) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.tag == tag)
    }

    /// Whether the directory has an entry with this tag.
    pub fn has(&self, tag: u16) -> bool {
        self.entry(tag).is_some()
    }

    /// Returns the bytes of an entry's value; empty if there is none.
    pub fn raw(&self, file: &mut TiffReader, tag: u16) -> Result<Vec<u8>, ImageError> {
        let Some(entry) = self.entry(tag) else { return Ok(Vec::new()) };
        let size = SIZES.get(usize::from(entry.kind)).copied().unwrap_or(0);
        file.bytes(entry.position, size.saturating_mul(entry.count))
    }

    /// Returns the numbers of an entry; empty if there is none or it has no whole numbers.
    pub fn numbers(&self, file: &mut TiffReader, tag: u16) -> Result<Vec<u64>, ImageError> {
        let bytes = self.raw(file, tag)?;
        let size = match self.entry(tag).map_or(0, |entry| entry.kind) {
            1 | 7 => 1,
            3 => 2,
            4 | 13 => 4,
            16 | 18 => 8,
            _ => return Ok(Vec::new()),
        };
        Ok(bytes.chunks_exact(size).map(|number| unsigned(number, file.big_endian)).collect())
    }

    /// Returns the first number of an entry.
    pub fn number(&self, file: &mut TiffReader, tag: u16) -> Result<Option<u64>, ImageError> {
        Ok(self.numbers(file, tag)?.first().copied())
    }

    /// Returns the fractions or floats of an entry.
    pub fn fractions(&self, file: &mut TiffReader, tag: u16) -> Result<Vec<f64>, ImageError> {
        let bytes = self.raw(file, tag)?;
        let number = |bytes: &[u8]| unsigned(bytes, file.big_endian);
        Ok(match self.entry(tag).map_or(0, |entry| entry.kind) {
            5 => bytes.chunks_exact(8).map(|f| number(&f[..4]) as f64 / number(&f[4..]) as f64).collect(),
            11 => bytes.chunks_exact(4).map(|f| f64::from(f32::from_bits(number(f) as u32))).collect(),
            12 => bytes.chunks_exact(8).map(|f| f64::from_bits(number(f))).collect(),
            _ => self.numbers(file, tag)?.iter().map(|&n| n as f64).collect(),
        })
    }

    /// Returns the orientation, 1 to 8, if the directory has one.
    pub fn orientation(&self, file: &mut TiffReader) -> Option<u8> {
        let number = self.number(file, 274).ok()??;
        (1..=8).contains(&number).then_some(number as u8)
    }
}
