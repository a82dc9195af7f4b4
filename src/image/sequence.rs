//! Frames of a sequence: their numbers, and the places of these in the names of files.

use std::path::Path;

/// A frame: the value that programs read as `frame`, and the number in the names of files.
///
/// Numbers are exact. The value is the nearest `f32`: above 16777216 (2^24) not every whole number is one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frame {
    /// The value that a program reads.
    pub value: f32,
    /// The number in file names; `None` between two frames.
    pub number: Option<i64>,
}

impl From<i64> for Frame {
    fn from(number: i64) -> Frame {
        Frame { value: number as f32, number: Some(number) }
    }
}

impl From<f64> for Frame {
    fn from(value: f64) -> Frame {
        let whole = value.fract() == 0.0 && value.abs() <= MAX_FRAME as f64;
        Frame { value: value as f32, number: whole.then_some(value as i64) }
    }
}

impl From<f32> for Frame {
    fn from(value: f32) -> Frame {
        f64::from(value).into()
    }
}

/// The largest frame number; all numbers up to it are exact in 64-bit floats too.
pub const MAX_FRAME: i64 = 1_000_000_000_000_000;

/// The most digits that a frame's number is padded to.
const MAX_WIDTH: usize = 255;

/// The first pattern in a text: where it is, and how many digits the number is padded to. Patterns are `####`, `@@@@`
/// (two or more; `#` may also be one), `%d` and `%04d`.
fn pattern(text: &str) -> Option<(std::ops::Range<usize>, usize)> {
    let bytes = text.as_bytes();
    let mut i = 0;
    while i < bytes.len() {
        let c = bytes[i];
        if c == b'#' || c == b'@' {
            let run = bytes[i..].iter().take_while(|b| **b == c).count();
            if c == b'#' || run > 1 {
                return Some((i..i + run, run));
            }
            i += run;
            continue;
        }
        if c == b'%' {
            let digits = bytes[i + 1..].iter().take_while(|b| b.is_ascii_digit()).count();
            if bytes.get(i + 1 + digits) == Some(&b'd') {
                let width = text[i + 1..i + 1 + digits].parse().unwrap_or(1);
                return Some((i..i + digits + 2, usize::min(width, 20)));
            }
        }
        i += 1;
    }
    None
}

/// The folders of a path, with the last separator, and the name of the file.
fn split(path: &str) -> (&str, &str) {
    let separator = |c: char| std::path::is_separator(c);
    path.split_at(path.rfind(separator).map_or(0, |i| i + 1))
}

/// Whether a path has a place for the frame's number. Only the name of the file counts: what looks like a pattern in the
/// name of a folder is literal.
pub fn has_pattern(path: &str) -> bool {
    pattern(split(path).1).is_some()
}

/// The path with the frame's number in each place for it. A path without one in the name of the file stays as it is. With
/// one, folders may have it too, except those that exist under the name as it is written.
pub fn fill(path: &str, frame: i64) -> String {
    let (folders, name) = split(path);
    if pattern(name).is_none() {
        return path.to_string();
    }
    let mut text = String::new();
    for part in folders.split_inclusive(std::path::is_separator) {
        let literal = pattern(part).is_none() || Path::new(&format!("{text}{part}")).is_dir();
        text += &if literal { part.to_string() } else { filled(part, frame) };
    }
    text + &filled(name, frame)
}

fn filled(text: &str, frame: i64) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some((range, width)) = pattern(rest) {
        out.push_str(&rest[..range.start]);
        // No file system has longer names, and the formatter panics at widths above 65535.
        let width = width.min(MAX_WIDTH);
        out.push_str(&format!("{frame:0width$}"));
        rest = &rest[range.end..];
    }
    out + rest
}

/// The frame's number that a file's name ends with: `clean.0003.exr`, `clean_3.exr`, `render0003.exr`, `0003.exr`.
///
/// Digits count after `.`, `_` or `-` (after `.` and `_` also with a minus sign), alone, and after letters if there are
/// four and the first is 0. Versions (`v002`) and sizes (`640x480`) do not. Words may follow a number of three digits or more
/// with a point before or behind it: `f.0001.left.exr`, `f.0010_beauty.exr`.
pub fn number_in_name(path: &Path) -> Option<i64> {
    let stem = path.file_stem()?.to_str()?;
    number_at_end(stem).or_else(|| {
        let words = stem.trim_end_matches(|c: char| c.is_alphabetic() || "._-".contains(c));
        let digits = words.len() - words.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        let (before, behind) = (&words[..words.len() - digits], &stem[words.len()..]);
        let parted = before.ends_with('.') || behind.starts_with('.') && before.ends_with(['_', '-']);
        let parted = parted && behind.starts_with(['.', '_', '-']);
        if parted && digits >= 3 { number_at_end(words) } else { None }
    })
}

/// The number at the end of a name without its extension.
fn number_at_end(stem: &str) -> Option<i64> {
    let digits = stem.bytes().rev().take_while(u8::is_ascii_digit).count();
    let (head, digits) = stem.split_at(stem.len() - digits);
    let number: i64 = digits.parse().ok().filter(|n| *n <= MAX_FRAME)?;
    let before = head.chars().next_back();
    let minus = head.strip_suffix('-').is_some_and(|head| head.is_empty() || head.ends_with(['.', '_']));
    match before {
        None => Some(number),
        Some('-') if minus => Some(-number),
        Some('.' | '_' | '-') => Some(number),
        Some(letter) if letter.is_alphabetic() => {
            let word = head.trim_end_matches(char::is_alphabetic).len();
            let version = head[word..].eq_ignore_ascii_case("v");
            (digits.len() >= 4 && digits.starts_with('0') && !version).then_some(number)
        }
        Some(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_are_filled() {
        assert_eq!(fill("a.####.exr", 7), "a.0007.exr");
        assert_eq!(fill("a_%04d.exr", 12345), "a_12345.exr");
        assert_eq!(fill("a_%d@@.exr", 3), "a_303.exr");
        assert_eq!(fill("me@home 100%.exr", 3), "me@home 100%.exr");
        assert!(has_pattern("#.png") && !has_pattern("a@b%.png"));
        assert_eq!(fill("a.####.exr", -3), "a.-003.exr");
        assert_eq!(fill("a.%d.exr", 20_240_613), "a.20240613.exr");
    }

    #[cfg(feature = "exr")]
    #[test]
    fn folders_are_literal() {
        for path in ["job#12/g.exr", "100%done/g.exr", "a@@/b.png", "x.####/g.exr", "/a/%04d/b"] {
            assert!(!has_pattern(path), "{path}");
            assert_eq!(fill(path, 7), path);
        }
        assert!(has_pattern("job#12/g.####.exr"));
        // Folders beside a pattern in the file's name have it too, unless they exist.
        assert_eq!(fill("none.####/g.##.exr", 7), "none.0007/g.07.exr");
        let dir = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(dir.path().join("job#12/100%done")).unwrap();
        let path = |name: &str| dir.path().join(name).display().to_string();
        assert_eq!(fill(&path("job#12/100%done/%d/g.#.exr"), 7), path("job#12/100%done/7/g.7.exr"));
    }

    #[test]
    fn names_have_numbers() {
        let number = |name: &str| number_in_name(Path::new(name));
        for (name, frame) in [
            ("clean.0003.exr", 3),
            ("a/b.12/clean_3.exr", 3),
            ("shot-0012.exr", 12),
            ("render0003.png", 3),
            ("0003.png", 3),
            ("a.-003.exr", -3),
            ("a_-3.exr", -3),
            ("-3.exr", -3),
            ("a.20240613.exr", 20_240_613),
            ("f.0001.left.exr", 1),
            ("f.0010_beauty.exr", 10),
            ("shot_0012.left.denoised.exr", 12),
        ] {
            assert_eq!(number(name), Some(frame), "{name}");
        }
        for name in
            ["a.exr", "donut_480x270.exr", "shot_v002.exr", "shot_V0002.exr", "camera1.exr", "size1080.exr"]
        {
            assert_eq!(number(name), None, "{name}");
        }
        for name in [
            "a.99999999999999999999.exr",
            "4k.0003/a.exr",
            "sq_0100_comp.exr",
            "v1.2.final.exr",
            "a.0003.l2.exr",
            "",
        ] {
            assert_eq!(number(name), None, "{name}");
        }
    }

    #[test]
    fn frames_are_exact() {
        assert_eq!(Frame::from(20_240_613_i64), Frame { value: 20_240_612.0, number: Some(20_240_613) });
        assert_eq!(Frame::from(2.5_f32), Frame { value: 2.5, number: None });
        assert_eq!(Frame::from(-3.0_f32).number, Some(-3));
        assert_eq!(Frame::from(f64::NAN).number, None);
    }
}
