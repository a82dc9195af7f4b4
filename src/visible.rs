//! Text from files, made harmless for a terminal.
//!
//! Names and values of files, paths and programs may hold anything: sequences that move the cursor, change the title of
//! the window or answer for the user, and marks that turn the direction of writing. They are shown as `\u{1b}`.
//!
//! Messages are made visible where they are rendered ([`crate::Diagnostic::render`]), and everything else that a command
//! prints where it is printed (`cli::failure`).

use std::borrow::Cow;
use std::fmt::Write;

/// Whether a character does something else than to be seen: control characters other than the end of a line and the tab,
/// marks of direction, and characters without a width. (Joiners, which some scripts need, stay.)
pub fn is_hidden(c: char) -> bool {
    match c {
        '\n' | '\t' => false,
        '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}' | '\u{200e}' | '\u{200f}' => true,
        '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}' => true,
        '\u{e0000}'..='\u{e007f}' => true,
        c => c.is_control(),
    }
}

/// The text with `\u{1b}` for each hidden character, and otherwise as it is.
pub fn visible(text: &str) -> Cow<'_, str> {
    escaped(text, is_hidden, |out, c| write!(out, "\\u{{{:x}}}", c as u32))
}

/// The like for sentences, in which a tab can only come from a name.
pub fn visible_sentence(text: &str) -> Cow<'_, str> {
    let hidden = |c| is_hidden(c) || c == '\t';
    escaped(text, hidden, |out, c| match c {
        '\t' => out.write_str("\\t"),
        c => write!(out, "\\u{{{:x}}}", c as u32),
    })
}

/// The like for a name, which stands on one line: ends of lines and tabs are shown, too.
pub fn visible_name(text: &str) -> Cow<'_, str> {
    let hidden = |c| is_hidden(c) || matches!(c, '\n' | '\t');
    escaped(text, hidden, |out, c| match c {
        '\n' => out.write_str("\\n"),
        '\t' => out.write_str("\\t"),
        c => write!(out, "\\u{{{:x}}}", c as u32),
    })
}

/// JSON that means the same: what is hidden can only stand in strings, where JSON has an escape for it.
pub fn visible_json(json: &str) -> Cow<'_, str> {
    escaped(json, is_hidden, |out, c| write!(out, "\\u{:04x}", c as u32))
}

fn escaped(
    text: &str,
    hidden: impl Fn(char) -> bool,
    write: impl Fn(&mut String, char) -> std::fmt::Result,
) -> Cow<'_, str> {
    // Most texts are plain, and a look at their bytes tells it.
    let lines = !hidden('\n');
    let plain = |b: u8| (0x20..0x7f).contains(&b) || lines && b == b'\n';
    if text.bytes().all(plain) || !text.contains(&hidden) {
        return text.into();
    }
    let mut out = String::with_capacity(text.len() + 16);
    let mut letters = text.chars().peekable();
    while let Some(c) = letters.next() {
        // A line may end as Windows has it.
        if hidden(c) && !(c == '\r' && letters.peek() == Some(&'\n')) {
            // A text takes whatever is written.
            let _ = write(&mut out, c);
        } else {
            out.push(c);
        }
    }
    out.into()
}

/// A text that is made visible, and where its bytes have gone.
pub struct Excerpt<'t> {
    /// The text to show.
    pub text: Cow<'t, str>,
    /// Where hidden characters were, and how many bytes longer the text has become by each and those before it.
    moved: Vec<(usize, usize)>,
}

impl<'t> Excerpt<'t> {
    /// Makes a text visible.
    pub fn new(text: &'t str) -> Excerpt<'t> {
        let shown = visible(text);
        let mut moved = Vec::new();
        if let Cow::Owned(_) = &shown {
            let mut longer = 0;
            for (at, c) in text.char_indices() {
                let windows = c == '\r' && text[at + 1..].starts_with('\n');
                if is_hidden(c) && !windows {
                    longer += visible(&text[at..at + c.len_utf8()]).len() - c.len_utf8();
                    moved.push((at, longer));
                }
            }
        }
        Excerpt { text: shown, moved }
    }

    /// Where a byte of the original text is in what is shown.
    pub fn place(&self, byte: usize) -> usize {
        let before = self.moved.partition_point(|(at, _)| *at < byte);
        byte + before.checked_sub(1).map_or(0, |i| self.moved[i].1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_obeys_is_shown() {
        assert_eq!(visible("a\x1b]0;owned\x07b"), "a\\u{1b}]0;owned\\u{7}b");
        assert_eq!(
            visible("c1 \u{9b}31m, del \u{7f}, bidi \u{202e}x\u{2066}"),
            "c1 \\u{9b}31m, del \\u{7f}, bidi \\u{202e}x\\u{2066}"
        );
        assert_eq!(visible("over\rwritten, line\r\n\tend\n"), "over\\u{d}written, line\r\n\tend\n");
        assert!(matches!(visible("plain, ünïcödé 視図 \n"), Cow::Borrowed(_)));
        assert_eq!(visible_name("a\nb\tc\x1b"), "a\\nb\\tc\\u{1b}");
    }

    #[cfg(feature = "mesh")]
    #[test]
    fn json_stays_json() {
        let text = serde_json::json!({"name": "a\u{9b}b\u{202e}c\x1b"}).to_string();
        let shown = visible_json(&text);
        assert!(!shown.contains(is_hidden), "{shown}");
        assert_eq!(
            serde_json::from_str::<serde_json::Value>(&shown).unwrap(),
            serde_json::from_str::<serde_json::Value>(&text).unwrap()
        );
    }

    #[test]
    fn places_move_with_the_text() {
        let text = "a\x1bb\u{202e}c";
        let excerpt = Excerpt::new(text);
        for letter in ["a", "b", "c"] {
            let at = excerpt.place(text.find(letter).unwrap());
            assert!(excerpt.text[at..].starts_with(letter), "{letter}");
        }
    }
}
