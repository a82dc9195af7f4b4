//! The numbers of a glTF file: its buffers, and the accessors that say where in them what is.
//!
//! The crate `gltf` knows what the JSON means and that its references hold, but its own readers of accessors take the
//! bytes to be there, and stop the program where they are not. Here every range is looked at before it is read.

use super::read::{Wrong, reserve};
use crate::files::{self, Folders};
use crate::image::{Content, recorded};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use gltf::accessor::DataType;
use gltf::buffer;
use percent_encoding::percent_decode_str;
use std::borrow::Cow;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// Values of an accessor without bytes of its own, all of which are 0; only a file that is made to hurt has more.
const ZEROS: usize = 1 << 24;

/// The bytes of all buffers.
pub(super) struct Buffers<'a> {
    list: Vec<Cow<'a, [u8]>>,
}

impl<'a> Buffers<'a> {
    /// Reads the buffers: the file's own piece, those beside the file at `path`, and those within the JSON.
    pub fn read(document: &gltf::Document, own: Option<&'a [u8]>, path: &Path) -> Result<Buffers<'a>, Wrong> {
        let mut list = Vec::new();
        for buffer in document.buffers() {
            let bytes = match buffer.source() {
                buffer::Source::Bin => Cow::Borrowed(own.ok_or("its binary piece is missing")?),
                buffer::Source::Uri(uri) => Cow::Owned(fetch(uri, path, buffer.length())?),
            };
            if bytes.len() < buffer.length() {
                let (has, index) = (bytes.len(), buffer.index());
                return Err(format!("buffer {index} has {has} bytes, but should have {}", buffer.length()));
            }
            list.push(bytes);
        }
        Ok(Buffers { list })
    }

    /// The bytes of a view from an offset on, and how far its entries lie apart, if it says so.
    fn view(&self, view: &buffer::View<'_>, offset: usize) -> Result<(&[u8], Option<usize>), Wrong> {
        let bytes = self.list.get(view.buffer().index()).ok_or("a buffer is missing")?;
        let range = view.offset().checked_add(view.length()).and_then(|end| bytes.get(view.offset()..end));
        let bytes = range.and_then(|bytes| bytes.get(offset..));
        let what = || format!("buffer view {} lies outside of its buffer", view.index());
        Ok((bytes.ok_or_else(what)?, view.stride()))
    }

    /// The numbers of an accessor, so many for each entry.
    pub fn numbers<const N: usize>(&self, accessor: &gltf::Accessor<'_>) -> Result<Vec<[f64; N]>, Wrong> {
        let (index, count) = (accessor.index(), accessor.count());
        let has = accessor.dimensions().multiplicity();
        if has != N {
            return Err(format!("accessor {index} has {has} numbers for each entry, where {N} are wanted"));
        }
        let kind = accessor.data_type();
        let short = || format!("accessor {index} has {count} entries, but not the bytes for them");
        let mut values = Vec::new();
        match accessor.view() {
            Some(view) => {
                let (bytes, stride) = self.view(&view, accessor.offset())?;
                let width = N * kind.size();
                let stride = stride.unwrap_or(width);
                let last = count.checked_sub(1).and_then(|n| n.checked_mul(stride)?.checked_add(width));
                if last.is_some_and(|n| n > bytes.len()) || (count > 0 && (last.is_none() || stride == 0)) {
                    return Err(short());
                }
                reserve(&mut values, count)?;
                values.extend(
                    (0..count).map(|i| entry(&bytes[i * stride..][..width], kind, accessor.normalized())),
                );
            }
            None if count > ZEROS => return Err(short()),
            None => values.resize(count, [0.0; N]),
        }
        if let Some(sparse) = accessor.sparse() {
            self.replace(&mut values, &sparse, kind, accessor.normalized())
                .map_err(|wrong| format!("accessor {index}, which is sparse: {wrong}"))?;
        }
        Ok(values)
    }

    /// Replaces some entries by others.
    fn replace<const N: usize>(
        &self,
        values: &mut [[f64; N]],
        sparse: &gltf::accessor::sparse::Sparse<'_>,
        kind: DataType,
        normalized: bool,
    ) -> Result<(), Wrong> {
        let (indices, count) = (sparse.indices(), sparse.count());
        let index_kind = match indices.index_type() {
            gltf::accessor::sparse::IndexType::U8 => DataType::U8,
            gltf::accessor::sparse::IndexType::U16 => DataType::U16,
            gltf::accessor::sparse::IndexType::U32 => DataType::U32,
        };
        let (places, _) = self.view(&indices.view(), indices.offset())?;
        let (bytes, _) = self.view(&sparse.values().view(), sparse.values().offset())?;
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
fn beside(uri: &str, path: &Path) -> Result<PathBuf, Wrong> {
    let name = percent_decode_str(uri).decode_utf8().map_err(|_| format!("`{uri}` is no file's name"))?;
    let name = Path::new(&*name);
    let plain = |part| matches!(part, Component::Normal(_) | Component::CurDir);
    if uri.contains(':') || !name.components().all(plain) {
        return Err(format!("it refers to `{uri}`; only files beside it or in folders there are read"));
    }
    Ok(path.parent().unwrap_or(Path::new("")).join(name))
}

/// The longest .gltf file of which the companions are looked for.
const MAX_JSON: u64 = 1 << 30;

/// The files that a .gltf file names for its data, as far as it can be read.
pub fn companions(path: &Path) -> Vec<PathBuf> {
    let text = files::regular(path).and_then(|file| files::read_all(file, MAX_JSON));
    let Ok(text) = text else { return Vec::new() };
    let Ok(root) = gltf::json::deserialize::from_slice::<gltf::json::Root>(&text) else { return Vec::new() };
    let uris = root.buffers.iter().filter_map(|b| b.uri.as_deref()).filter(|uri| !uri.starts_with("data:"));
    uris.filter_map(|uri| beside(uri, path).ok()).collect()
}

/// The bytes that a URI stands for, `length` at most if it is a file's: those in it, or those of a regular file beside the
/// one at `path`. Nothing is fetched from elsewhere, by links either.
fn fetch(uri: &str, path: &Path, length: usize) -> Result<Vec<u8>, Wrong> {
    if let Some(data) = uri.strip_prefix("data:") {
        let text = data.split_once(";base64,").map(|(_, text)| text);
        let text = text.ok_or("a buffer is in the file, but not as base64")?;
        return BASE64_STANDARD.decode(text).map_err(|e| format!("a buffer in the file is no base64: {e}"));
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
