//! The frame that a file belongs to, as its name or the header of an EXR file says.

use super::Metadata;
use super::file::{File, ReadOptions, read};
use super::read_exr::MAGIC;
use super::reading::unrecorded;
use super::sequence::{MAX_FRAME, number_in_name};
use super::source::Input;
use exr::meta::attribute::{AttributeValue, TimeCode};
use std::io::Read;
use std::path::Path;

/// Attributes that hold the frame's number: Blender's and Houdini's, Nuke's, and OpenEXR's own.
const NUMBERS: [&str; 4] = ["Frame", "frame", "nuke/input/frame", "imageCounter"];

/// The number of the frame that a file belongs to: that in its name, else that in its header. `None` if neither has one, and
/// if the file cannot be read, which reading it will report.
pub fn frame_number(path: &Path) -> Option<i64> {
    let header = || {
        let file = read(Input::Path(path.to_path_buf()), &ReadOptions::default()).ok()?;
        file.frame_number()
    };
    number_in_name(path).or_else(|| if is_exr(path) { unrecorded(path, header) } else { None })
}

/// Whether a file begins as EXR files do. A pipe is not asked: it can be read only once.
fn is_exr(path: &Path) -> bool {
    let mut magic = [0; 4];
    let mut begins = || std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut magic));
    path.is_file() && begins().is_ok() && magic == MAGIC
}

impl File {
    /// The frame's number in the header: an attribute for it, or the time code with the frames of a second.
    pub fn frame_number(&self) -> Option<i64> {
        self.metadata().frame_number()
    }
}

impl Metadata {
    fn frame_number(&self) -> Option<i64> {
        let value = |name: &str| self.attributes.list.iter().find(|(n, _)| n == name).map(|(_, value)| value);
        let number = |value: &AttributeValue| match value {
            AttributeValue::I32(number) => Some(i64::from(*number)),
            AttributeValue::F32(number) if number.fract() == 0.0 => Some(*number as i64),
            AttributeValue::F64(number) if number.fract() == 0.0 => Some(*number as i64),
            AttributeValue::Text(text) => text.to_string().trim().parse().ok(),
            _ => None,
        };
        let given = NUMBERS.iter().find_map(|name| value(name).and_then(number));
        let timed = || match (value("timeCode")?, value("framesPerSecond")?) {
            (AttributeValue::TimeCode(time), AttributeValue::Rational((frames, seconds))) => {
                frame_at(time, f64::from(*frames) / f64::from(*seconds))
            }
            _ => None,
        };
        given.or_else(timed).filter(|number| number.abs() <= MAX_FRAME)
    }
}

/// The frames from 00:00:00:00 to a time code, as SMPTE ST 12 counts them.
fn frame_at(time: &TimeCode, rate: f64) -> Option<i64> {
    if !(1.0..=1000.0).contains(&rate) {
        return None;
    }
    // 29.97 frames are counted as 30.
    let rate = rate.round() as i64;
    let [hours, minutes, seconds, frame] =
        [time.hours, time.minutes, time.seconds, time.frame].map(i64::from);
    let minutes = 60 * hours + minutes;
    let counted = (60 * minutes + seconds) * rate + frame;
    // Of 30 numbers two are left out at the start of each minute, but for every tenth.
    let dropped = if time.drop_frame { 2 * (rate / 30) * (minutes - minutes / 10) } else { 0 };
    Some(counted - dropped)
}

#[cfg(test)]
mod tests {
    use super::super::{Image, Variable, WriteOptions, write};
    use super::*;
    use crate::shape::Shape;

    fn time(hours: u8, minutes: u8, seconds: u8, frame: u8, drop_frame: bool) -> TimeCode {
        TimeCode {
            hours,
            minutes,
            seconds,
            frame,
            drop_frame,
            color_frame: false,
            field_phase: false,
            binary_group_flags: [false; 3],
            binary_groups: [0; 8],
        }
    }

    #[test]
    fn time_codes_are_counted() {
        assert_eq!(frame_at(&time(1, 0, 0, 0, false), 24.0), Some(86_400));
        assert_eq!(frame_at(&time(0, 0, 2, 3, false), 25.0), Some(53));
        let ntsc = 30000.0 / 1001.0;
        assert_eq!(frame_at(&time(0, 0, 59, 29, true), ntsc), Some(1799));
        assert_eq!(frame_at(&time(0, 1, 0, 2, true), ntsc), Some(1800));
        assert_eq!(frame_at(&time(0, 10, 0, 0, true), ntsc), Some(17_982));
        assert_eq!(frame_at(&time(1, 0, 0, 0, true), ntsc), Some(107_892));
        assert_eq!(frame_at(&time(1, 0, 0, 0, false), f64::NAN), None);
    }

    #[test]
    fn headers_and_names_have_numbers() {
        let dir = tempfile::tempdir().unwrap();
        let write_with = |name: &str, attributes: Vec<(&str, AttributeValue)>| {
            let plane = vec![0.5; 6];
            let variable = Variable::new("color", Shape::Scalar, [plane]).unwrap();
            let mut image = Image::new(3, 2, [variable]).unwrap();
            image.metadata.attributes.list =
                attributes.into_iter().map(|(name, value)| (name.to_string(), value)).collect();
            let path = dir.path().join(name);
            write(&path, &image, &WriteOptions::default()).unwrap();
            frame_number(&path)
        };
        let text = |text: &str| AttributeValue::Text(text.into());
        let rate = ("framesPerSecond", AttributeValue::Rational((24, 1)));
        let code = ("timeCode", AttributeValue::TimeCode(time(0, 0, 1, 6, false)));
        assert_eq!(write_with("a.exr", vec![]), None);
        assert_eq!(write_with("a.exr", vec![("Frame", text("003"))]), Some(3));
        assert_eq!(write_with("a.exr", vec![("imageCounter", AttributeValue::I32(-5))]), Some(-5));
        assert_eq!(write_with("a.exr", vec![("nuke/input/frame", AttributeValue::I32(1001))]), Some(1001));
        assert_eq!(write_with("a.exr", vec![code.clone()]), None, "of which rate?");
        assert_eq!(write_with("a.exr", vec![code.clone(), rate.clone()]), Some(30));
        assert_eq!(write_with("a.exr", vec![code, rate, ("Frame", text("7"))]), Some(7));
        assert_eq!(write_with("a.exr", vec![("Frame", text("none"))]), None);
        assert_eq!(write_with("a.0012.exr", vec![("Frame", text("3"))]), Some(12), "the name comes first");
        assert_eq!(frame_number(&dir.path().join("none.exr")), None);
    }
}
