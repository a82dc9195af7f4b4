//! TGA: true colour of 15 to 32 bits, grey and palettes, packed or not, with the alpha that the file declares.

use super::error::{ErrorKind, ImageError};
use super::file::Samples;
use super::guard;
use super::layout::{Alpha, Codes, Layout};
use super::source::{Input, ReadSeek};
use std::io::{Read, SeekFrom};

/// Bytes of the header.
const HEADER: u64 = 18;

/// Where the attribute type stands in the extension area.
const ATTRIBUTE_TYPE: u64 = 494;

/// What the header says.
pub(super) struct Tga {
    /// Columns and rows.
    pub size: [usize; 2],
    /// The channels that the pixels are decoded to.
    pub layout: Layout,
    kind: Kind,
    packed: bool,
    /// Bits of a stored pixel.
    bits: u8,
    /// The first palette entry's number, how many there are, and bits of an entry.
    palette: (usize, usize, u8),
    /// Where the palette begins.
    start: u64,
    /// Rows run upwards, columns to the left.
    up: bool,
    left: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Palette,
    Color,
    Grey,
}

/// Whether a file is a TGA: by its last bytes, or by its name, since old ones have no mark.
pub(super) fn is_tga(input: &Input) -> Result<bool, ImageError> {
    if matches!(input.extension().as_str(), "tga" | "icb" | "vda" | "vst") {
        return Ok(true);
    }
    let (mut reader, length) = input.open()?;
    Ok(footer(&mut reader, length).is_some())
}

/// The offset of the extension area, if the file has a footer.
fn footer(reader: &mut Box<dyn ReadSeek>, length: u64) -> Option<u64> {
    let mut footer = [0; 26];
    reader.seek(SeekFrom::Start(length.checked_sub(26)?)).ok()?;
    reader.read_exact(&mut footer).ok()?;
    let [a, b, c, d, ..] = footer;
    footer[8..].starts_with(b"TRUEVISION-XFILE").then_some(u32::from_le_bytes([a, b, c, d]).into())
}

impl Tga {
    /// Reads and checks the header.
    pub fn open(input: &Input) -> Result<Tga, ImageError> {
        let name = input.name();
        let (mut reader, length) = input.open()?;
        let mut header = [0; HEADER as usize];
        reader.read_exact(&mut header).map_err(|e| ImageError::io("read", &name, &e))?;
        let short = |at: usize| u16::from_le_bytes([header[at], header[at + 1]]);
        let [identity, mapped, number] = [header[0], header[1], header[2]];
        let [bits, descriptor] = [header[16], header[17]];
        let kind = match number {
            1 | 9 => Kind::Palette,
            2 | 10 => Kind::Color,
            3 | 11 => Kind::Grey,
            0 => return Err(ImageError::damaged(&name, "it holds no picture")),
            32 | 33 => {
                let message = format!("`{name}` cannot be read: TGA with Huffman compression");
                return Err(ImageError::new(ErrorKind::Unsupported, message));
            }
            _ => return Err(ImageError::damaged(&name, "its header is invalid")),
        };
        let palette = match mapped {
            1 => (short(3).into(), short(5).into(), header[7]),
            _ => (0, 0, 0),
        };
        let fits = match kind {
            Kind::Palette => {
                matches!(bits, 8 | 16) && palette.1 > 0 && matches!(palette.2, 8 | 15 | 16 | 24 | 32)
            }
            Kind::Color => matches!(bits, 15 | 16 | 24 | 32),
            Kind::Grey => matches!(bits, 8 | 16),
        };
        if !fits || mapped > 1 {
            let message =
                format!("`{name}` cannot be read: TGA of type {number} with {bits} bits for each pixel");
            return Err(ImageError::new(ErrorKind::Unsupported, message));
        }
        let (width, height) = (usize::from(short(12)), usize::from(short(14)));
        let [red_bits, alpha_bits] = [if kind == Kind::Palette { palette.2 } else { bits }, descriptor & 15];
        let possible = matches!((kind, red_bits), (Kind::Grey, 16) | (Kind::Color | Kind::Palette, 16 | 32));
        let attribute = attribute_type(&mut reader, length);
        let alpha = match attribute {
            Some(0..=2) => None,
            Some(4) => Some(true),
            Some(_) => Some(false),
            None => (alpha_bits > 0).then_some(false),
        };
        let alpha = alpha.filter(|_| possible);
        let count = if kind == Kind::Grey { 1 } else { 3 } + usize::from(alpha.is_some());
        let mut layout = Layout::simple(count, Samples::Byte);
        layout.alpha = alpha.map(|associated| Alpha { channel: count - 1, associated });
        guard::check_size(&name, width as u64, height as u64, count as u64, length)?;
        let packed = number >= 9;
        // A packet holds 128 pixels at most.
        let least = match packed {
            true => (width * height).div_ceil(128) * (1 + usize::from(bits.div_ceil(8))),
            false => width * height * usize::from(bits.div_ceil(8)),
        };
        if width == 0 || height == 0 {
            return Err(ImageError::damaged(&name, "it has no pixels"));
        }
        if (least as u64) > length {
            return Err(ImageError::damaged(&name, "it ends too early"));
        }
        Ok(Tga {
            size: [width, height],
            layout,
            kind,
            packed,
            bits,
            palette,
            start: HEADER + u64::from(identity),
            up: descriptor & 0x20 == 0,
            left: descriptor & 0x10 != 0,
        })
    }

    /// Decodes the pixels, from the top left.
    pub fn decode(&self, input: &Input) -> Result<Codes, ImageError> {
        let name = input.name();
        let read = |e: std::io::Error| ImageError::io("read", &name, &e);
        let early = || ImageError::damaged(&name, "it ends too early");
        let (mut reader, _) = input.open()?;
        reader.seek(SeekFrom::Start(self.start)).map_err(read)?;
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).map_err(read)?;
        let (first, entries, entry_bits) = self.palette;
        let map_length = entries * usize::from(entry_bits.div_ceil(8));
        let (map, data) = bytes.split_at_checked(map_length).ok_or_else(early)?;
        let count = self.layout.channels.len();
        let color = |bytes: &[u8], bits: u8| -> [u8; 4] {
            let mut out = [0, 0, 0, 255];
            match bits {
                8 => out[..3].fill(bytes[0]),
                15 | 16 if self.kind == Kind::Grey => {
                    out[..3].fill(bytes[0]);
                    out[3] = bytes[1];
                }
                15 | 16 => {
                    let code = u16::from_le_bytes([bytes[0], bytes[1]]);
                    let wide = |v: u16| ((u32::from(v & 31) * 255 * 2 + 31) / 62) as u8;
                    // The attribute bit of 16 bits is set where nothing is to be seen.
                    out = [
                        wide(code >> 10),
                        wide(code >> 5),
                        wide(code),
                        if code >> 15 == 1 { 0 } else { 255 },
                    ];
                }
                _ => {
                    out[..3].copy_from_slice(&[bytes[2], bytes[1], bytes[0]]);
                    out[3] = bytes.get(3).copied().unwrap_or(255);
                }
            }
            out
        };
        let entry_size = usize::from(entry_bits.div_ceil(8)).max(1);
        let table: Vec<[u8; 4]> = map.chunks_exact(entry_size).map(|e| color(e, entry_bits)).collect();
        let pixel_size = usize::from(self.bits.div_ceil(8));
        let pixel = |bytes: &[u8]| match self.kind {
            Kind::Palette => {
                let index = bytes.iter().rev().fold(0, |sum, &b| sum << 8 | usize::from(b));
                index.checked_sub(first).and_then(|i| table.get(i)).copied().unwrap_or([0, 0, 0, 255])
            }
            _ => color(bytes, self.bits),
        };
        let [width, height] = self.size;
        let mut out = vec![0; width * height * count];
        let mut at = 0;
        let mut put = |bytes: &[u8], times: usize| {
            let color = pixel(bytes);
            for _ in 0..times.min(width * height - at) {
                let (mut x, mut y) = (at % width, at / width);
                if self.left {
                    x = width - 1 - x;
                }
                if self.up {
                    y = height - 1 - y;
                }
                let to = &mut out[(y * width + x) * count..][..count];
                match count {
                    1 | 3 => to.copy_from_slice(&color[..count]),
                    2 => to.copy_from_slice(&[color[0], color[3]]),
                    _ => to.copy_from_slice(&color),
                }
                at += 1;
            }
            at < width * height
        };
        if !self.packed {
            let data = data.get(..width * height * pixel_size).ok_or_else(early)?;
            for bytes in data.chunks_exact(pixel_size) {
                put(bytes, 1);
            }
            return Ok(Codes::Byte(out));
        }
        let mut data = data;
        let mut take = |count: usize| -> Result<&[u8], ImageError> {
            let (taken, rest) = data.split_at_checked(count).ok_or_else(early)?;
            data = rest;
            Ok(taken)
        };
        loop {
            let head = take(1)?[0];
            let times = usize::from(head & 0x7f) + 1;
            let more = match head >> 7 {
                1 => put(take(pixel_size)?, times),
                _ => {
                    let mut more = true;
                    for _ in 0..times {
                        if more {
                            more = put(take(pixel_size)?, 1);
                        }
                    }
                    more
                }
            };
            if !more {
                return Ok(Codes::Byte(out));
            }
        }
    }
}

/// What the fourth number of a pixel is, from the extension area of TGA 2.0.
fn attribute_type(reader: &mut Box<dyn ReadSeek>, length: u64) -> Option<u8> {
    let area = footer(reader, length).filter(|&at| at > 0 && at + ATTRIBUTE_TYPE < length)?;
    let mut byte = [0];
    reader.seek(SeekFrom::Start(area + ATTRIBUTE_TYPE)).ok()?;
    reader.read_exact(&mut byte).ok()?;
    Some(byte[0])
}
