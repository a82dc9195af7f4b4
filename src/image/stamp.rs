//! A word in a file's header that says from which run it comes, so that another run can tell that the file is the one
//! it would write.

use super::RasterScan;
use super::error::ImageError;
use super::file::{File, ReadOptions, Source, read};
use super::reading::unrecorded;
use super::scan_exr::Scan;
use super::source::Input;
use super::write::Format;
use exr::meta::attribute::AttributeValue;
use std::io::Read;
use std::path::Path;

/// The EXR attribute, and the keyword of the text in a PNG file.
pub(super) const NAME: &str = "pseRun";

/// What written files name as the software that made them.
pub(super) const SOFTWARE: &str = "pse";

/// The EXR attribute for it.
pub(super) const SOFTWARE_ATTRIBUTE: &str = "software";

/// The keyword of the text in a PNG file for it.
pub(super) const SOFTWARE_KEYWORD: &str = "Software";

/// PNG: the eight bytes at the start, then the header's chunk with its length, name and checksum.
const PNG_START: usize = 8 + 4 + 4 + 13 + 4;

impl Format {
    /// Whether files of this format can hold [`WriteOptions::stamp`](super::WriteOptions::stamp).
    pub fn holds_stamp(self) -> bool {
        matches!(self, Format::Exr | Format::Png)
    }
}

/// Whether the file has this stamp and can be decoded completely.
pub fn is_whole(path: &Path, stamp: &str) -> bool {
    let checked = || -> Result<bool, ImageError> {
        let file = read(Input::Path(path.to_path_buf()), &ReadOptions::default())?;
        Ok(file.stamp()?.as_deref() == Some(stamp) && file.decode_all().is_ok())
    };
    unrecorded(path, checked).unwrap_or(false)
}

impl File {
    fn stamp(&self) -> Result<Option<String>, ImageError> {
        match &self.source {
            Source::Exr(exr) => {
                let named = exr.headers().flat_map(|header| header.all_named_attributes());
                let mut own = named.filter(|(name, _)| name.iter().copied().eq(NAME.bytes()));
                Ok(own.find_map(|(_, value)| match value {
                    AttributeValue::Text(text) => Some(text.to_string()),
                    _ => None,
                }))
            }
            Source::Raster(_) => {
                let texts = texts_of_png(&self.start()?);
                Ok(texts.into_iter().find(|(name, _)| name == NAME).map(|(_, text)| text))
            }
        }
    }

    /// The first bytes, with the texts that stand behind the header of a PNG file.
    fn start(&self) -> Result<Vec<u8>, ImageError> {
        let (reader, _) = self.input.open()?;
        let mut start = Vec::new();
        let read = reader.take(PNG_START as u64 + 512).read_to_end(&mut start);
        read.map_err(|e| ImageError::io("read", &self.name(), &e))?;
        Ok(start)
    }

    /// Decodes all pixels and keeps none.
    fn decode_all(&self) -> Result<(), ImageError> {
        match &self.source {
            Source::Exr(exr) => {
                let wanted: Vec<bool> = self.channels.iter().map(|c| c.unread.is_none()).collect();
                Scan::new(exr, &self.input, &self.channels, &wanted)?.decode(0..self.size()[1], |_| {})
            }
            Source::Raster(raster) => {
                let mut scan = RasterScan::new(raster, &self.input)?;
                let height = self.size()[1];
                (0..height).step_by(64).try_for_each(|top| scan.rows(top..height.min(top + 64)).map(drop))
            }
        }
    }
}

/// Whether `pse` wrote a file, according to the software entry in the header of an EXR or PNG file.
pub fn written_by_pse(path: &Path) -> bool {
    let about = || -> Result<bool, ImageError> {
        let file = read(Input::Path(path.to_path_buf()), &ReadOptions::default())?;
        Ok(match &file.source {
            Source::Exr(_) => {
                let named = |(name, value): (&str, String)| name == SOFTWARE_ATTRIBUTE && value == SOFTWARE;
                file.metadata().attributes.iter().any(named)
            }
            Source::Raster(_) => {
                let texts = texts_of_png(&file.start()?);
                texts.iter().any(|(name, text)| name == SOFTWARE_KEYWORD && text == SOFTWARE)
            }
        })
    };
    path.is_file() && unrecorded(path, about).unwrap_or(false)
}

/// The texts of a PNG file of which these are the first bytes: keyword and text of each. Those of ours are the first chunks
/// behind the header; what comes later is of other programs.
fn texts_of_png(start: &[u8]) -> Vec<(String, String)> {
    let mut texts = Vec::new();
    let mut rest = start.strip_prefix(b"\x89PNG\r\n\x1a\n").and_then(|rest| rest.get(PNG_START - 8..));
    while let Some((length, chunk)) = rest.and_then(|rest| rest.split_first_chunk::<4>()) {
        let length = u32::from_be_bytes(*length) as usize;
        let text = chunk.get(..length.saturating_add(4)).and_then(|chunk| chunk.strip_prefix(b"tEXt"));
        let Some((name, text)) = text.and_then(|text| {
            let end = text.iter().position(|&b| b == 0)?;
            Some((
                String::from_utf8(text[..end].to_vec()).ok()?,
                String::from_utf8(text[end + 1..].to_vec()).ok()?,
            ))
        }) else {
            break;
        };
        texts.push((name, text));
        // The kind before, the checksum behind.
        rest = chunk.get(length + 8..);
    }
    texts
}

#[cfg(test)]
mod tests {
    use super::super::{Image, Variable, WriteOptions, write};
    use super::*;
    use crate::shape::Shape;

    #[test]
    fn only_whole_files_with_the_same_stamp_count() {
        let dir = tempfile::tempdir().unwrap();
        let plane: Vec<f32> = (0..96 * 64).map(|i| (i * 7919 % 1000) as f32 / 1000.0).collect();
        let image = Image::new(96, 64, [Variable::new("color", Shape::Scalar, [plane]).unwrap()]).unwrap();
        for name in ["a.exr", "a.png"] {
            let path = dir.path().join(name);
            let plain = WriteOptions::default();
            write(&path, &image, &plain).unwrap();
            let bytes = std::fs::read(&path).unwrap();
            assert!(!is_whole(&path, "one"), "{name} has no stamp");
            write(&path, &image, &WriteOptions { stamp: Some("one".into()), ..plain.clone() }).unwrap();
            assert!(is_whole(&path, "one") && !is_whole(&path, "two"), "{name}");
            // Another image made of it is not of that run.
            let file = read(Input::Path(path.clone()), &ReadOptions::default()).unwrap();
            let again = dir.path().join(format!("again_{name}"));
            write(&again, &file.load_all().unwrap(), &plain).unwrap();
            assert!(!is_whole(&again, "one"), "{name}");
            let stamped = std::fs::read(&path).unwrap();
            assert!(stamped.len() > bytes.len());
            std::fs::write(&path, &stamped[..stamped.len() * 3 / 4]).unwrap();
            assert!(!is_whole(&path, "one"), "{name} is cut");
            let mut damaged = stamped.clone();
            let middle = damaged.len() / 2;
            damaged[middle..middle + 64].fill(0xff);
            std::fs::write(&path, &damaged).unwrap();
            assert!(!is_whole(&path, "one"), "{name} is damaged");
        }
        assert!(!is_whole(&dir.path().join("none.exr"), "one"));
    }

    #[test]
    fn files_of_this_program_are_known() {
        let dir = tempfile::tempdir().unwrap();
        let plane = vec![0.5; 6];
        let mut image = Image::new(3, 2, [Variable::new("color", Shape::Scalar, [plane]).unwrap()]).unwrap();
        image.metadata.attributes.list = vec![("software".to_string(), AttributeValue::Text("Other".into()))];
        for (name, stamp) in
            [("a.exr", None), ("b.png", None), ("c.exr", Some("one")), ("d.png", Some("one"))]
        {
            let path = dir.path().join(name);
            write(&path, &image, &WriteOptions { stamp: stamp.map(String::from), ..WriteOptions::default() })
                .unwrap();
            assert!(written_by_pse(&path), "{name}");
            let mut bytes = std::fs::read(&path).unwrap();
            let at = bytes.windows(8).position(|w| w.eq_ignore_ascii_case(b"software")).unwrap();
            bytes[at + 1] = b'X';
            std::fs::write(&path, bytes).unwrap();
            assert!(!written_by_pse(&path), "{name} of another program");
        }
        for name in ["none.png", "text.png", "."] {
            std::fs::write(dir.path().join("text.png"), "pse").unwrap();
            assert!(!written_by_pse(&dir.path().join(name)), "{name}");
        }
    }
}
