//! The compressions of TIFF strips and tiles.

use super::fax::{self, Coding};
use std::io::Read;

/// A compression that is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Compression {
    None,
    Huffman { word: bool },
    Group3,
    Group4,
    Lzw,
    OldJpeg,
    Jpeg,
    Deflate,
    PackBits,
    Zstd,
    Lzma,
    Webp,
}

impl Compression {
    /// The compression with this number, or the name of one that is not read.
    pub fn of(number: u64) -> Result<Compression, String> {
        Ok(match number {
            0 | 1 => Compression::None,
            2 => Compression::Huffman { word: false },
            3 => Compression::Group3,
            4 => Compression::Group4,
            5 => Compression::Lzw,
            6 => Compression::OldJpeg,
            7 => Compression::Jpeg,
            8 | 32946 => Compression::Deflate,
            32771 => Compression::Huffman { word: true },
            32773 => Compression::PackBits,
            34925 => Compression::Lzma,
            50000 => Compression::Zstd,
            50001 => Compression::Webp,
            _ => {
                return Err(match number {
                    9 | 10 => "JBIG".into(),
                    32766 => "NeXT".into(),
                    32809 => "ThunderScan".into(),
                    32895..=32898 => "IT8".into(),
                    32908 => "PixarFilm".into(),
                    32909 => "PixarLog".into(),
                    33003..=33005 | 34712 => "JPEG 2000".into(),
                    34661 => "JBIG".into(),
                    34676 | 34677 => "SGILog".into(),
                    34887 => "LERC".into(),
                    34892 => "lossy JPEG of DNG".into(),
                    34933 | 50002 | 52546 => "JPEG XL".into(),
                    _ => format!("number {number}"),
                });
            }
        })
    }

    /// Whether the bytes of a file with the lowest bit first have to be reversed.
    pub fn reversible(self) -> bool {
        !matches!(self, Compression::Jpeg | Compression::OldJpeg | Compression::Webp)
    }
}

/// Kilobytes that an LZMA decoder may take: twice the greatest dictionary of usual settings.
const LZMA_LIMIT: u32 = 128 << 10;

/// What decoding a strip or tile depends on.
pub(super) struct Packing {
    pub compression: Compression,
    /// Bit 0 of T4Options: rows of Group 3 may refer to the row above.
    pub two_dimensional: bool,
    /// Columns and rows to decode.
    pub size: [usize; 2],
    /// Bytes to decode.
    pub length: usize,
}

/// Decodes a strip or tile; JPEG and WebP have functions of their own.
pub(super) fn decode(packing: &Packing, bytes: &[u8]) -> Result<Vec<u8>, String> {
    let [width, rows] = packing.size;
    let length = packing.length;
    let coding = match packing.compression {
        Compression::Huffman { word } => Coding::Aligned(if word { 16 } else { 8 }),
        Compression::Group3 => Coding::Group3 { two: packing.two_dimensional },
        Compression::Group4 => Coding::Group4,
        compression => {
            let mut out = vec![0; length];
            let filled = match compression {
                Compression::Lzw => lzw(bytes, &mut out)?,
                Compression::Deflate => fill(flate2::read::ZlibDecoder::new(bytes), &mut out)?,
                Compression::PackBits => pack_bits(bytes, &mut out),
                Compression::Zstd => {
                    let decoder = ruzstd::decoding::StreamingDecoder::new(bytes);
                    fill(decoder.map_err(|e| e.to_string())?, &mut out)?
                }
                Compression::Lzma => {
                    fill(lzma_rust2::XzReader::new_mem_limit(bytes, false, LZMA_LIMIT), &mut out)?
                }
                _ => {
                    let count = bytes.len().min(length);
                    out[..count].copy_from_slice(&bytes[..count]);
                    count
                }
            };
            return if filled == length { Ok(out) } else { Err("it ends too early".into()) };
        }
    };
    fax::decode(bytes, coding, width, rows).map_err(String::from)
}

/// Fills the buffer as far as the reader goes.
fn fill(mut reader: impl Read, out: &mut [u8]) -> Result<usize, String> {
    let mut filled = 0;
    while filled < out.len() {
        match reader.read(&mut out[filled..]) {
            Ok(0) => break,
            Ok(count) => filled += count,
            Err(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => break,
            Err(e) => return Err(e.to_string()),
        }
    }
    Ok(filled)
}

fn lzw(bytes: &[u8], out: &mut [u8]) -> Result<usize, String> {
    // Writers before TIFF 5 put the lowest bit first: their clear code, 256, begins with a byte of 0.
    let old = bytes.first() == Some(&0) && bytes.get(1).is_some_and(|b| b & 1 == 1);
    let mut decoder = match old {
        true => weezl::decode::Decoder::new(weezl::BitOrder::Lsb, 8),
        false => weezl::decode::Decoder::with_tiff_size_switch(weezl::BitOrder::Msb, 8),
    };
    let (mut read, mut filled) = (0, 0);
    while filled < out.len() {
        let step = decoder.decode_bytes(&bytes[read..], &mut out[filled..]);
        read += step.consumed_in;
        filled += step.consumed_out;
        match step.status {
            Ok(weezl::LzwStatus::Ok) if step.consumed_in + step.consumed_out > 0 => {}
            Ok(_) => break,
            Err(e) => return Err(e.to_string()),
        }
    }
    Ok(filled)
}

fn pack_bits(mut bytes: &[u8], out: &mut [u8]) -> usize {
    let mut filled = 0;
    while filled < out.len() {
        let Some((&head, rest)) = bytes.split_first() else { break };
        let room = out.len() - filled;
        match head {
            0..=127 => {
                let count = (usize::from(head) + 1).min(rest.len());
                let used = count.min(room);
                out[filled..filled + used].copy_from_slice(&rest[..used]);
                filled += used;
                bytes = &rest[count..];
            }
            128 => bytes = rest,
            _ => {
                let Some((&value, rest)) = rest.split_first() else { break };
                let count = (257 - usize::from(head)).min(room);
                out[filled..filled + count].fill(value);
                filled += count;
                bytes = rest;
            }
        }
    }
    filled
}
