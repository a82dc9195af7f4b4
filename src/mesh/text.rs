//! Text as programs write it: its encoding, and numbers that are none.

use std::borrow::Cow;

/// The bytes of a text file as UTF-8, without a byte order mark. Files in UTF-16 and UTF-32 are known by their mark, or by the
/// zeros beside the first character; all others stay as they are.
pub(super) fn utf8(bytes: &[u8]) -> Cow<'_, [u8]> {
    if let Some(rest) = bytes.strip_prefix(b"\xEF\xBB\xBF") {
        return Cow::Borrowed(rest);
    }
    let (width, big) = match bytes {
        [0xFF, 0xFE, 0, 0, ..] => (4, false),
        [0, 0, 0xFE, 0xFF, ..] => (4, true),
        [0xFF, 0xFE, ..] => (2, false),
        [0xFE, 0xFF, ..] => (2, true),
        [1..=127, 0, 0, 0, ..] => (4, false),
        [0, 0, 0, 1..=127, ..] => (4, true),
        [1..=127, 0, 1..=127, 0, ..] => (2, false),
        [0, 1..=127, 0, 1..=127, ..] => (2, true),
        _ => return Cow::Borrowed(bytes),
    };
    let units = bytes.chunks(width).map(|unit| {
        let add = |sum: u32, byte: &u8| sum << 8 | u32::from(*byte);
        if big { unit.iter().fold(0, add) } else { unit.iter().rev().fold(0, add) }
    });
    let mut text = String::with_capacity(bytes.len() / width);
    match width {
        4 => text.extend(units.map(|unit| char::from_u32(unit).unwrap_or(char::REPLACEMENT_CHARACTER))),
        _ => text.extend(
            char::decode_utf16(units.map(|unit| unit as u16))
                .map(|unit| unit.unwrap_or(char::REPLACEMENT_CHARACTER)),
        ),
    }
    Cow::Owned(text.trim_start_matches('\u{FEFF}').to_string().into_bytes())
}

/// The length of a line with its end: `\n`, `\r\n`, or `\r` alone.
pub(super) fn line_length(bytes: &[u8]) -> usize {
    match bytes.iter().position(|&b| b == b'\n' || b == b'\r') {
        Some(end) if bytes[end..].starts_with(b"\r\n") => end + 2,
        Some(end) => end + 1,
        None => bytes.len(),
    }
}

/// A number as a program may write it. What stands for no number has as many names as there are libraries: `nan`, `-nan(ind)`,
/// `nan(snan)`, `1.#QNAN`, `-1.#IND`; and infinity is `inf` or `1.#INF`.
pub(super) fn number(word: &str) -> Option<f64> {
    if let Ok(number) = word.parse() {
        return Some(number);
    }
    let (sign, rest) = match word.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, word.strip_prefix('+').unwrap_or(word)),
    };
    // Digits may follow, and a short format leaves less than the whole name: 1.#J is a rounded 1.#INF.
    if let Some(name) = rest.strip_prefix("1.#") {
        let infinite = name.get(..3).is_some_and(|name| name.eq_ignore_ascii_case("inf"));
        let known = name.bytes().all(|b| b.is_ascii_alphanumeric()) && !name.is_empty();
        return known.then_some(if infinite { f64::INFINITY * sign } else { f64::NAN });
    }
    // The name, and in brackets which of the many it is.
    let lower = rest.to_ascii_lowercase();
    let name = ["nanq", "nans", "nan", "qnan", "snan"].iter().find_map(|name| lower.strip_prefix(name))?;
    let inner = name.strip_prefix('(').and_then(|rest| rest.strip_suffix(')'));
    let known =
        name.is_empty() || inner.is_some_and(|t| t.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_'));
    known.then_some(f64::NAN)
}

/// What is wrong with a word that is no number: a comma in the place of the point, perhaps.
pub(super) fn no_number(word: &str) -> String {
    let with_point = word.replace(',', ".");
    match with_point != word && number(&with_point).is_some() {
        true => format!(
            "`{}` has a decimal comma instead of a point: {with_point}. Save the file with decimal points",
            word.escape_debug()
        ),
        false => format!("`{}` is not a number", word.escape_debug()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_none_have_many_names() {
        for word in [
            "nan",
            "NaN",
            "-nan",
            "+nan",
            "nan(ind)",
            "-nan(ind)",
            "nan(snan)",
            "-nan(snan)",
            "nan(0x7ff)",
            "nan()",
            "1.#QNAN",
            "-1.#QNAN",
            "1.#QNAN0",
            "1.#SNAN",
            "-1.#IND",
            "-1.#IND00",
            "1.#IND",
            "1.#R",
            "-1.#J",
            "NaNQ",
            "qnan",
            "sNaN",
            "-nan(IND)",
        ] {
            assert!(number(word).is_some_and(f64::is_nan), "{word}");
        }
        for (word, value) in
            [("1.#INF", f64::INFINITY), ("-1.#INF00", f64::NEG_INFINITY), ("-inf", f64::NEG_INFINITY)]
        {
            assert_eq!(number(word), Some(value), "{word}");
        }
        for (word, value) in [("+1.5", 1.5), (".5", 0.5), ("2.", 2.0), ("-1e-3", -1e-3), ("1E5", 1e5)] {
            assert_eq!(number(word), Some(value), "{word}");
        }
        for word in ["", "x", "-", "1.#", "1.#?", "nan(", "nan)", "nano!", "1,5", "0x10", "n\u{e4}n"] {
            assert_eq!(number(word).map(f64::to_bits), None, "{word}");
        }
    }

    #[test]
    fn text_of_every_encoding_becomes_utf8() {
        let text = "v 1 2 3 \u{e4}\u{1F600}\n";
        let encoded = |width: usize, big: bool, mark: bool| {
            let text = if mark { format!("\u{FEFF}{text}") } else { text.into() };
            let units: Vec<u32> = match width {
                2 => text.encode_utf16().map(u32::from).collect(),
                _ => text.chars().map(u32::from).collect(),
            };
            let bytes = units.iter().flat_map(|unit| match big {
                true => unit.to_be_bytes()[4 - width..].to_vec(),
                false => unit.to_le_bytes()[..width].to_vec(),
            });
            bytes.collect::<Vec<u8>>()
        };
        for width in [2, 4] {
            for (big, mark) in [(false, false), (false, true), (true, false), (true, true)] {
                assert_eq!(utf8(&encoded(width, big, mark)), text.as_bytes(), "{width} {big} {mark}");
            }
        }
        assert_eq!(utf8(b"\xEF\xBB\xBFv"), &b"v"[..]);
        assert_eq!(utf8(b"v \xFF"), &b"v \xFF"[..]);
    }
}
