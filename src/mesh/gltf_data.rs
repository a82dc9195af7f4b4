//! The numbers of a glTF file: its buffers, and the accessors that say where in them what is.
//!
//! Every range is looked at before it is read, and a buffer is only opened when something in it is needed.

use super::gltf_json::{Document, extension, index, list, required, text};
use super::read::{Wrong, reserve};
use crate::files::{self, Folders};
use crate::image::{Content, recorded};
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::{percent_decode, percent_decode_str};
use serde_json::Value;
use std::borrow::Cow;
use std::cell::OnceCell;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// Values of an accessor without bytes of its own, all of which are 0; only a file that is made to hurt has more.
const ZEROS: usize = 1 << 24;

/// A type of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum DataType {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl DataType {
    /// The type of that number.
    fn of(code: usize) -> Result<DataType, Wrong> {
        Ok(match code {
            5120 => DataType::I8,
            5121 => DataType::U8,
            5122 => DataType::I16,
            5123 => DataType::U16,
            5125 => DataType::U32,
            5126 => DataType::F32,
            _ => return Err(format!("`componentType` is {code}, which is not a type of numbers")),
        })
    }

    /// Its bytes.
    fn size(self) -> usize {
        match self {
            DataType::I8 | DataType::U8 => 1,
            DataType::I16 | DataType::U16 => 2,
            DataType::U32 | DataType::F32 => 4,
        }
    }
}

/// The document with the bytes of its buffers, as far as they were needed.
pub(super) struct Buffers<'a> {
    document: &'a Document,
    /// The binary piece of the file.
    own: Option<&'a [u8]>,
    path: &'a Path,
    read: Vec<OnceCell<Cow<'a, [u8]>>>,
}

impl<'a> Buffers<'a> {
    /// The buffers of the file at `path`, whose own binary piece is `own`.
    pub fn new(document: &'a Document, own: Option<&'a [u8]>, path: &'a Path) -> Buffers<'a> {
        let read = document.all("buffers").iter().map(|_| OnceCell::new()).collect();
        Buffers { document, own, path, read }
    }

    /// The bytes of a buffer: the file's own piece, those beside the file, or those within the JSON.
    fn buffer(&self, number: usize) -> Result<&[u8], Wrong> {
        let buffer = self.document.one("buffers", number)?;
        if let Some(bytes) = self.read[number].get() {
            return Ok(bytes);
        }
        let length = required(buffer, "byteLength").map_err(|wrong| format!("buffer {number}: {wrong}"))?;
        let bytes = match (text(buffer, "uri"), self.own) {
            (Some(uri), _) => Cow::Owned(fetch(uri, self.path, length)?),
            (None, Some(own)) if number == 0 => Cow::Borrowed(own),
            (None, _) if number == 0 => return Err("its binary chunk is missing".into()),
            (None, _) => return Err(format!("buffer {number} has no data and no `uri`")),
        };
        if bytes.len() < length {
            let has = bytes.len();
            return Err(format!("buffer {number} has {has} bytes, but should have {length}"));
        }
        Ok(self.read[number].get_or_init(|| bytes))
    }

    /// The bytes of a view from an offset on, and how far its entries lie apart, if it says so.
    fn view(&self, number: usize, offset: usize) -> Result<(&[u8], Option<usize>), Wrong> {
        let view = self.document.one("bufferViews", number)?;
        let what = |wrong: Wrong| format!("buffer view {number}: {wrong}");
        let buffer = required(view, "buffer").map_err(what)?;
        let length = required(view, "byteLength").map_err(what)?;
        let start = index(view, "byteOffset").map_err(what)?.unwrap_or(0);
        let bytes = self.buffer(buffer).map_err(|wrong| {
            // The buffer of compressed data is another one, which only the extension names.
            match extension(view, "EXT_meshopt_compression").or(extension(view, "KHR_meshopt_compression")) {
                Some(_) => "its numbers are compressed (meshopt_compression), which pse does not read".into(),
                None => wrong,
            }
        })?;
        let range = start.checked_add(length).and_then(|end| bytes.get(start..end));
        let bytes = range.and_then(|bytes| bytes.get(offset..));
        let bytes = bytes.ok_or_else(|| format!("buffer view {number} is outside its buffer"))?;
        Ok((bytes, index(view, "byteStride").map_err(what)?))
    }

    /// The number of entries of an accessor.
    pub fn count(&self, number: usize) -> Result<usize, Wrong> {
        let accessor = self.document.one("accessors", number)?;
        required(accessor, "count").map_err(|wrong| format!("accessor {number}: {wrong}"))
    }

    /// The indices of vertices that an accessor holds.
    pub fn indices(&self, number: usize) -> Result<Vec<u32>, Wrong> {
        let accessor = self.document.one("accessors", number)?;
        let kind = DataType::of(required(accessor, "componentType")?)
            .map_err(|wrong| format!("accessor {number}: {wrong}"))?;
        if !matches!(kind, DataType::U8 | DataType::U16 | DataType::U32) {
            return Err(format!("accessor {number} has indices that may be negative or fractions"));
        }
        Ok(self.numbers::<1>(number)?.into_iter().map(|[i]| i as u32).collect())
    }

    /// The numbers of an accessor, so many for each entry.
    pub fn numbers<const N: usize>(&self, number: usize) -> Result<Vec<[f64; N]>, Wrong> {
        let accessor = self.document.one("accessors", number)?;
        let what = |wrong: Wrong| format!("accessor {number}: {wrong}");
        let kind = DataType::of(required(accessor, "componentType").map_err(what)?).map_err(what)?;
        let has = text(accessor, "type").ok_or_else(|| what("`type` is missing".into()))?;
        let normalized = accessor.get("normalized").and_then(Value::as_bool).unwrap_or(false);
        let wanted = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
        if has != wanted {
            return Err(format!("accessor {number} is of type {has}, where {wanted} is needed"));
        }
        let count = required(accessor, "count").map_err(what)?;
        let short = || format!("accessor {number} has {count} entries, but not the bytes for them");
        let mut values = Vec::new();
        match index(accessor, "bufferView").map_err(what)? {
            Some(view) => {
                let offset = index(accessor, "byteOffset").map_err(what)?.unwrap_or(0);
                let (bytes, stride) = self.view(view, offset)?;
                let width = N * kind.size();
                let stride = stride.unwrap_or(width);
                let last = count.checked_sub(1).and_then(|n| n.checked_mul(stride)?.checked_add(width));
                if last.is_some_and(|n| n > bytes.len()) || (count > 0 && (last.is_none() || stride == 0)) {
                    return Err(short());
                }
                reserve(&mut values, count)?;
                values.extend((0..count).map(|i| entry(&bytes[i * stride..][..width], kind, normalized)));
            }
            None if count > ZEROS => return Err(short()),
            // The specification: without a view all are zeros.
            None => values.resize(count, [0.0; N]),
        }
        if let Some(sparse) = accessor.get("sparse") {
            self.replace(&mut values, sparse, kind, normalized)
                .map_err(|wrong| format!("accessor {number}, which is sparse: {wrong}"))?;
        }
        Ok(values)
    }

    /// Replaces some entries by others.
    fn replace<const N: usize>(
        &self,
        values: &mut [[f64; N]],
        sparse: &Value,
        kind: DataType,
        normalized: bool,
    ) -> Result<(), Wrong> {
        let count = required(sparse, "count")?;
        let part = |name: &str| sparse.get(name).ok_or_else(|| format!("`{name}` is missing"));
        let (indices, new) = (part("indices")?, part("values")?);
        let index_kind = DataType::of(required(indices, "componentType")?)?;
        if !matches!(index_kind, DataType::U8 | DataType::U16 | DataType::U32) {
            return Err("its indices may be negative or fractions".into());
        }
        let view = |of: &Value| self.view(required(of, "bufferView")?, index(of, "byteOffset")?.unwrap_or(0));
        let ((places, _), (bytes, _)) = (view(indices)?, view(new)?);
        let width = N * kind.size();
        if count > places.len() / index_kind.size() || count > bytes.len() / width {
            return Err(format!("it has {count} entries, but not the bytes for them"));
        }
        let places = places.chunks_exact(index_kind.size()).take(count);
        for (place, new) in places.zip(bytes.chunks_exact(width)) {
            let [place] = entry(place, index_kind, false);
            let value = values.get_mut(place as usize).ok_or_else(|| format!("there is no entry {place}"))?;
            *value = entry(new, kind, normalized);
        }
        Ok(())
    }
}

/// The numbers of an entry, whose bytes are there.
fn entry<const N: usize>(bytes: &[u8], kind: DataType, normalized: bool) -> [f64; N] {
    let scale = |value: f64, most: f64| if normalized { (value / most).max(-1.0) } else { value };
    std::array::from_fn(|i| {
        let b = &bytes[i * kind.size()..][..kind.size()];
        match kind {
            DataType::I8 => scale(f64::from(b[0] as i8), 127.0),
            DataType::U8 => scale(f64::from(b[0]), 255.0),
            DataType::I16 => scale(f64::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
            DataType::U16 => scale(f64::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
            DataType::U32 => f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            DataType::F32 => f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        }
    })
}

/// The file beside the one at `path` that a URI names.
pub(super) fn beside(uri: &str, path: &Path) -> Result<PathBuf, Wrong> {
    let name = percent_decode_str(uri).decode_utf8().map_err(|_| format!("`{uri}` is not a file name"))?;
    let name = Path::new(&*name);
    let plain = |part| matches!(part, Component::Normal(_) | Component::CurDir);
    if uri.contains(':') || !name.components().all(plain) {
        return Err(format!("it refers to `{uri}`; only files beside it or in folders there are read"));
    }
    Ok(path.parent().unwrap_or(Path::new("")).join(name))
}

/// The longest .gltf file of which the companions are looked for.
const MAX_JSON: u64 = 1 << 30;

/// The data files that a .gltf file names, as far as it can be read.
pub fn companions(path: &Path) -> Vec<PathBuf> {
    let bytes = files::regular(path).and_then(|file| files::read_all(file, MAX_JSON));
    let Ok(bytes) = bytes else { return Vec::new() };
    let Ok(root) = serde_json::from_slice::<Value>(&super::text::utf8(&bytes)) else { return Vec::new() };
    let uris = list(&root, "buffers").iter().filter_map(|buffer| text(buffer, "uri"));
    uris.filter(|uri| !uri.starts_with("data:")).filter_map(|uri| beside(uri, path).ok()).collect()
}

/// The bytes that a URI stands for, `length` at most if it is a file's: those in it, or those of a regular file beside the
/// one at `path`. Nothing is fetched from elsewhere, by links either.
fn fetch(uri: &str, path: &Path, length: usize) -> Result<Vec<u8>, Wrong> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (about, data) = data.split_once(',').ok_or("a buffer in the file has no data after a comma")?;
        if !about.ends_with(";base64") {
            return Ok(percent_decode(data.as_bytes()).collect());
        }
        // The `=` at the end may be missing.
        let config = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
        let decoded = GeneralPurpose::new(&STANDARD, config).decode(data);
        return decoded.map_err(|e| format!("a buffer in the file is not base64: {e}"));
    }
    let file = beside(uri, path)?;
    let fail = |e: std::io::Error| format!("its data are in `{}`: {e}", file.display());
    let folder = |path: &Path| path.parent().unwrap_or(Path::new("")).to_path_buf();
    let mut folders = vec![folder(path)];
    // A mesh that is a link may have its data beside the link or beside the file.
    folders.extend(path.canonicalize().ok().map(|real| folder(&real)));
    let source = recorded(&file, Content::Data, Folders::new(folders).open(&file)).map_err(fail)?;
    let available = source.metadata().map_err(fail)?.len().min(length as u64) as usize;
    let mut bytes = Vec::new();
    reserve(&mut bytes, available)?;
    source.take(available as u64).read_to_end(&mut bytes).map_err(fail)?;
    Ok(bytes)
}
