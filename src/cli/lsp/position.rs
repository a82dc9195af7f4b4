//! Places in a text: lines and columns as editors count them, bytes as the rest of `pse` does.

use gen_lsp_types::{Position, PositionEncodingKind, Range};
use pse::internal::assist::boundary;

/// How columns are counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Encoding {
    /// In bytes.
    Utf8,
    /// In halves of UTF-16, as the protocol has it if nothing else is agreed upon.
    #[default]
    Utf16,
}

impl Encoding {
    /// Bytes if the editor can, else what every editor can.
    pub fn best(offered: Option<&[PositionEncodingKind]>) -> Encoding {
        match offered.is_some_and(|list| list.contains(&PositionEncodingKind::UTF8)) {
            true => Encoding::Utf8,
            false => Encoding::Utf16,
        }
    }

    /// As the protocol calls it.
    pub fn kind(self) -> PositionEncodingKind {
        match self {
            Encoding::Utf8 => PositionEncodingKind::UTF8,
            Encoding::Utf16 => PositionEncodingKind::UTF16,
        }
    }

    /// How many columns a text has.
    pub fn columns(self, text: &str) -> u32 {
        match self {
            Encoding::Utf8 => text.len() as u32,
            Encoding::Utf16 => text.chars().map(|c| c.len_utf16() as u32).sum(),
        }
    }
}

/// A text, cut into lines.
pub(super) struct Lines<'a> {
    text: &'a str,
    /// Where each begins.
    starts: Vec<usize>,
    encoding: Encoding,
}

impl<'a> Lines<'a> {
    pub fn new(text: &'a str, encoding: Encoding) -> Lines<'a> {
        let bytes = text.as_bytes();
        let ends = bytes.iter().enumerate().filter(|(i, b)| match b {
            b'\n' => true,
            b'\r' => bytes.get(i + 1) != Some(&b'\n'),
            _ => false,
        });
        let starts = std::iter::once(0).chain(ends.map(|(i, _)| i + 1)).collect();
        Lines { text, starts, encoding }
    }

    /// The byte at a position; beyond the end of a line or of the text, that end.
    pub fn offset(&self, position: Position) -> usize {
        let line = position.line as usize;
        let Some(&start) = self.starts.get(line) else { return self.text.len() };
        let end = self.starts.get(line + 1).copied().unwrap_or(self.text.len());
        let text = self.text[start..end].trim_end_matches(['\n', '\r']);
        let mut column = 0;
        for (i, c) in text.char_indices() {
            column += self.encoding.columns(c.encode_utf8(&mut [0; 4]));
            if column > position.character {
                return start + i;
            }
        }
        start + text.len()
    }

    /// The position of a byte.
    pub fn position(&self, offset: usize) -> Position {
        let offset = boundary(self.text, offset);
        let line = self.starts.partition_point(|&start| start <= offset) - 1;
        let character = self.encoding.columns(&self.text[self.starts[line]..offset]);
        Position { line: line as u32, character }
    }

    /// The range of some bytes.
    pub fn range(&self, bytes: std::ops::Range<usize>) -> Range {
        Range { start: self.position(bytes.start), end: self.position(bytes.end) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_both_kinds() {
        let text = "a\u{1f600}b\r\nö\rc\n";
        for (encoding, column) in [(Encoding::Utf8, 5), (Encoding::Utf16, 3)] {
            let lines = Lines::new(text, encoding);
            assert_eq!(lines.position(5), Position { line: 0, character: column });
            assert_eq!(lines.offset(Position { line: 0, character: column }), 5);
            // In the middle of a character: its start. Beyond the end: the end.
            assert_eq!(lines.offset(Position { line: 0, character: 2 }), 1);
            assert_eq!(lines.offset(Position { line: 0, character: 99 }), 6);
            assert_eq!(lines.offset(Position { line: 99, character: 0 }), text.len());
            for (i, _) in text.char_indices().filter(|(i, _)| *i != 7) {
                assert_eq!(lines.offset(lines.position(i)), i);
            }
            assert_eq!(lines.position(text.len()), Position { line: 3, character: 0 });
        }
    }
}
