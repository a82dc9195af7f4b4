//! What can be wrong with a single word: a habit from another language, a number, an escape in a string.

use super::habit;
use super::layout::Reader;
use super::token::{Lexeme, Token};
use crate::diagnostic::{Diagnostic, Label};

impl Reader<'_> {
    /// One error for each kind of habit, which names all its places.
    pub(super) fn report_habit(&mut self, lexeme: Lexeme, found: &habit::Habit) {
        let end = if lexeme.token == Token::SlashStar { lexeme.start + 2 } else { lexeme.end };
        let span = self.span(lexeme.start, end);
        if let Some((_, error)) = self.habits.iter().find(|(m, _)| *m == found.message) {
            let error = &mut self.errors[*error];
            if error.labels.len() < 5 {
                error.labels.push(Label { span, text: "and here".into() });
            }
            return;
        }
        if self.habits.len() < 100 {
            self.habits.push((found.message.clone(), self.errors.len()));
        }
        self.errors.push(
            Diagnostic::error("syntax", found.message.clone(), span)
                .label(span, found.label)
                .hint(found.hint.clone()),
        );
    }

    /// A number must fit the type of all values.
    pub(super) fn check_number(&mut self, lexeme: Lexeme) {
        let text = &self.text[lexeme.start..lexeme.end];
        if text.parse::<f32>().is_ok_and(f32::is_infinite) {
            self.errors.push(
                Diagnostic::error(
                    "syntax",
                    format!("`{text}` is too large"),
                    self.span(lexeme.start, lexeme.end),
                )
                .hint("The largest number is about 3.4e38; for infinity write 1/0."),
            );
        }
    }

    /// A backslash in a string must mean something.
    pub(super) fn check_escapes(&mut self, lexeme: Lexeme) {
        let text = &self.text[lexeme.start..lexeme.end];
        let mut chars = text.char_indices();
        while let Some((at, c)) = chars.next() {
            let Some((_, escaped)) = (if c == '\\' { chars.next() } else { None }) else { continue };
            if !matches!(escaped, '"' | '\\' | 'n' | 't') {
                let start = lexeme.start + at;
                self.errors.push(
                    Diagnostic::error(
                        "syntax",
                        format!("`\\{escaped}` is not an escape sequence"),
                        self.span(start, start + 1 + escaped.len_utf8()),
                    )
                    .hint("For a backslash write `\\\\`; in a path you can also write `/`."),
                );
            }
        }
    }
}
