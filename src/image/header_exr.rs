//! The header of an EXR file, attribute by attribute.
//!
//! The `exr` crate refuses a whole file for one part with a compression, a type or a channel that it does not know.
//! So the header is split here into parts and attributes, and each part is given to the crate by itself.

use super::error::ImageError;
use exr::io::PeekRead;
use exr::meta::Requirements;
use exr::meta::attribute::{ChannelDescription, ChannelList};
use exr::meta::header::Header;
use std::io::{self, Read};

/// The longest name of an attribute, a type or a channel.
const MAX_NAME: usize = 255;

/// Header flags: tiles, long names, deep data, several parts.
const KNOWN_FLAGS: u32 = TILED | 0x400 | DEEP | MULTIPART;
const TILED: u32 = 0x200;
const DEEP: u32 = 0x800;
const MULTIPART: u32 = 0x1000;

/// Text in a file: UTF-8, as the format has it, or else one character a byte.
pub(super) fn text(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_string(),
        Err(_) => bytes.iter().map(|&b| char::from(b)).collect(),
    }
}

/// One attribute as the file has it.
struct Attribute {
    name: Vec<u8>,
    kind: Vec<u8>,
    value: Vec<u8>,
}

/// One part's header.
pub(super) struct RawPart {
    attributes: Vec<Attribute>,
}

/// The header of a whole file.
pub(super) struct RawHeader {
    /// Are blocks of pixels marked with the number of their part?
    pub multipart: bool,
    /// The kind of storage, where the file's flags say it: in a file of one part that is not deep.
    kind: Option<&'static str>,
    requirements: Requirements,
    pub parts: Vec<RawPart>,
}

impl RawHeader {
    /// Reads the header, up to the tables of blocks; `length` is the file's.
    pub fn read(name: &str, reader: &mut impl Read, length: u64) -> Result<RawHeader, ImageError> {
        let io = |e: io::Error| ImageError::io("read", name, &e);
        let mut start = [0; 8];
        reader.read_exact(&mut start).map_err(io)?;
        let flags = u32::from_le_bytes([start[4], start[5], start[6], start[7]]);
        let requirements = Requirements::read(&mut &start[4..]);
        let requirements = match requirements {
            Ok(requirements) if flags & !0xff & !KNOWN_FLAGS == 0 => requirements,
            _ => return Err(newer(name)),
        };
        requirements.validate().map_err(|e| match e {
            exr::error::Error::NotSupported(_) => newer(name),
            other => ImageError::damaged(name, other),
        })?;
        let multipart = flags & MULTIPART != 0;
        let kind = match flags & (MULTIPART | DEEP | TILED) {
            0 => Some("scanlineimage"),
            TILED => Some("tiledimage"),
            _ => None,
        };
        let mut parts = Vec::new();
        while let Some(part) = RawPart::read(name, reader, length)? {
            parts.push(part);
            if !multipart {
                break;
            }
        }
        if parts.is_empty() {
            return Err(ImageError::damaged(name, "it has no parts"));
        }
        Ok(RawHeader { multipart, kind, requirements, parts })
    }

    /// The part as the crate understands it. A compression or a type that it does not know is replaced by a known
    /// one, so that the rest of the part can be described.
    pub fn understood(&self, part: &RawPart) -> exr::error::Result<Header> {
        let mut bytes = Vec::new();
        for attribute in &part.attributes {
            let value: &[u8] = match (&attribute.name[..], &attribute.kind[..]) {
                (b"compression", _) if part.unknown_compression().is_some() => &[0],
                (b"type", b"string") if self.kind.is_some() => self.kind.unwrap_or_default().as_bytes(),
                (b"type", _) if self.unknown_type(part).is_some() => b"scanlineimage",
                _ => &attribute.value,
            };
            for text in [&attribute.name, &attribute.kind] {
                bytes.extend_from_slice(text);
                bytes.push(0);
            }
            bytes.extend_from_slice(&(value.len() as i32).to_le_bytes());
            bytes.extend_from_slice(value);
        }
        bytes.push(0);
        Header::read(&mut PeekRead::new(&bytes[..]), &self.requirements, false)
    }
}

impl RawHeader {
    /// The kind of storage of a part, if it is none of the four of the format.
    pub fn unknown_type(&self, part: &RawPart) -> Option<String> {
        let known = ["scanlineimage", "tiledimage", "deepscanline", "deeptile"];
        part.text("type").filter(|kind| self.kind.is_none() && !known.contains(&kind.as_str()))
    }
}

fn newer(name: &str) -> ImageError {
    let message = format!("`{name}` needs a newer version of OpenEXR");
    ImageError::new(super::ErrorKind::Unsupported, message)
}

impl RawPart {
    /// Reads up to the empty name that ends a part; `None` if there is nothing before it.
    fn read(name: &str, reader: &mut impl Read, length: u64) -> Result<Option<RawPart>, ImageError> {
        let io = |e: io::Error| ImageError::io("read", name, &e);
        let mut attributes = Vec::new();
        loop {
            let own = null_terminated(name, reader)?;
            if own.is_empty() {
                return Ok(Some(RawPart { attributes }).filter(|part| !part.attributes.is_empty()));
            }
            let kind = null_terminated(name, reader)?;
            let mut size = [0; 4];
            reader.read_exact(&mut size).map_err(io)?;
            let size = u64::from(u32::from_le_bytes(size));
            if size > length || size > i32::MAX as u64 || kind.is_empty() {
                return Err(ImageError::damaged(name, "its header is invalid"));
            }
            let mut value = Vec::new();
            reader.by_ref().take(size).read_to_end(&mut value).map_err(io)?;
            if value.len() as u64 != size {
                return Err(ImageError::damaged(name, "it ends too early"));
            }
            attributes.push(Attribute { name: own, kind, value });
        }
    }

    fn value(&self, name: &[u8], kind: &[u8]) -> Option<&[u8]> {
        let own = self.attributes.iter().find(|a| a.name == name && a.kind == kind);
        own.map(|a| &a.value[..])
    }

    /// The value of a text attribute.
    pub fn text(&self, name: &str) -> Option<String> {
        self.value(name.as_bytes(), b"string").map(text)
    }

    /// The texts of an attribute that is a list of them.
    pub fn texts(&self, name: &str) -> Vec<String> {
        let mut rest = self.value(name.as_bytes(), b"stringvector").unwrap_or_default();
        let mut list = Vec::new();
        while let Some((size, tail)) = rest.split_first_chunk::<4>() {
            let Some((own, tail)) = tail.split_at_checked(u32::from_le_bytes(*size) as usize) else { break };
            list.push(text(own));
            rest = tail;
        }
        list
    }

    /// How many blocks the part says that it has.
    pub fn chunk_count(&self) -> Option<u64> {
        let bytes: [u8; 4] = self.value(b"chunkCount", b"int")?.try_into().ok()?;
        u64::try_from(i32::from_le_bytes(bytes)).ok()
    }

    fn compression(&self) -> Option<u8> {
        self.value(b"compression", b"compression")?.first().copied()
    }

    /// The compression, if it is one that the crate does not know at all.
    fn unknown_compression(&self) -> Option<String> {
        match self.compression()? {
            0..=11 => None,
            12 => Some("LJ2K compression".into()),
            13 => Some("ZSTD compression".into()),
            number => Some(format!("compression number {number}, which is unknown")),
        }
    }

    /// The compression that is not read, if it is one.
    pub fn unread_compression(&self) -> Option<String> {
        match self.compression()? {
            10 => Some("HTJ2K256 compression".into()),
            11 => Some("HTJ2K32 compression".into()),
            _ => self.unknown_compression(),
        }
    }

    /// The names of its channels, as far as they can be read, and the numbers of their samples' types.
    fn channels(&self) -> Vec<(String, u32)> {
        let mut rest = self.value(b"channels", b"chlist").unwrap_or_default();
        let mut list = Vec::new();
        while let Some(end) = rest.iter().position(|&b| b == 0).filter(|&end| end > 0) {
            // The type of the samples, a flag, three bytes of padding, and how they are spaced.
            let Some((about, tail)) = rest[end + 1..].split_at_checked(16) else { break };
            list.push((text(&rest[..end]), u32::from_le_bytes([about[0], about[1], about[2], about[3]])));
            rest = tail;
        }
        list
    }

    /// The names of its channels, as far as they can be read.
    pub fn channel_names(&self) -> Vec<String> {
        self.channels().into_iter().map(|(name, _)| name).collect()
    }

    /// A channel whose samples are neither halves nor floats nor integers.
    pub fn unknown_samples(&self) -> Option<String> {
        self.channels().into_iter().find(|(_, kind)| *kind > 2).map(|(name, _)| name)
    }
}

/// Reads a name in the header of a file, up to the byte 0 that ends it.
fn null_terminated(file: &str, reader: &mut impl Read) -> Result<Vec<u8>, ImageError> {
    let mut name = Vec::new();
    loop {
        let mut byte = [0];
        reader.read_exact(&mut byte).map_err(|e| ImageError::io("read", file, &e))?;
        match byte[0] {
            0 => return Ok(name),
            _ if name.len() == MAX_NAME => {
                return Err(ImageError::damaged(file, "a name in its header is too long"));
            }
            b => name.push(b),
        }
    }
}

/// Checks a part that the crate has understood, subsampled channels aside.
pub(super) fn check(header: &Header, multipart: bool) -> exr::error::Result<()> {
    let whole = |c: &ChannelDescription| ChannelDescription { sampling: exr::math::Vec2(1, 1), ..c.clone() };
    let full = header.channels.list.iter().map(whole).collect();
    let like = Header { channels: ChannelList::new(full), ..header.clone() };
    like.validate(multipart, &mut false, false)
}
