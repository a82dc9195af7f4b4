//! A word in a file's header that says from which run it comes, so that another run can tell that the file is the one
//! it would write.

use super::error::ImageError;
use super::file::{File, ReadOptions, Source, read};
use super::scan_exr::Scan;
use super::scan_raster::RasterScan;
use super::source::Input;
use super::write::Format;
use exr::meta::attribute::AttributeValue;
use std::io::Read;
use std::path::Path;

/// The EXR attribute, and the keyword of the text in a PNG file.
pub(super) const NAME: &str = "pseRun";

/// PNG: the eight bytes at the start, then the header's chunk with its length, name and checksum.
const PNG_START: usize = 8 + 4 + 4 + 13 + 4;

impl Format {
    /// Can a file of this format hold [`WriteOptions::stamp`](super::WriteOptions::stamp)?
    pub fn holds_stamp(self) -> bool {
        matches!(self, Format::Exr | Format::Png)
    }
}

/// Does the file bear this stamp, and can all of it be decoded?
pub fn is_whole(path: &Path, stamp: &str) -> bool {
    let checked = || -> Result<bool, ImageError> {
        let file = read(Input::Path(path.to_path_buf()), &ReadOptions::default())?;
        Ok(file.stamp()?.as_deref() == Some(stamp) && file.decode_all().is_ok())
    };
    checked().unwrap_or(false)
}

impl File {
    fn stamp(&self) -> Result<Option<String>, ImageError> {
        match &self.source {
            Source::Exr(exr) => {
                let named = exr.headers().iter().flat_map(|header| header.all_named_attributes());
                let mut own = named.filter(|(name, _)| name.iter().copied().eq(NAME.bytes()));
                Ok(own.find_map(|(_, value)| match value {
                    AttributeValue::Text(text) => Some(text.to_string()),
                    _ => None,
                }))
            }
            Source::Raster(_) => {
                let (reader, _) = self.input.open()?;
                let mut start = Vec::new();
                let read = reader.take(PNG_START as u64 + 256).read_to_end(&mut start);
                read.map_err(|e| ImageError::io("read", &self.name(), &e))?;
                Ok(from_png(&start))
            }
        }
    }

    /// Decodes all pixels and keeps none.
    fn decode_all(&self) -> Result<(), ImageError> {
        match &self.source {
            Source::Exr(exr) => {
                let wanted = vec![true; self.channels.len()];
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

/// The stamp of a PNG file of which these are the first bytes. It is the first chunk behind the header, or it is not
/// one of ours.
fn from_png(start: &[u8]) -> Option<String> {
    let rest = start.strip_prefix(b"\x89PNG\r\n\x1a\n")?.get(PNG_START - 8..)?;
    let (length, rest) = rest.split_first_chunk::<4>()?;
    let text = rest.get(..4 + u32::from_be_bytes(*length) as usize)?.strip_prefix(b"tEXt")?;
    let stamp = text.strip_prefix(NAME.as_bytes())?.strip_prefix(&[0])?;
    String::from_utf8(stamp.to_vec()).ok()
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
}
