//! What stands around a place of a text that may be half written: it looks at words alone, not at the tree.

use crate::syntax::{Lexeme, Token, lex};
use std::ops::Range;

/// What may stand at a place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// Nothing that is known: a comment, a number, a name that is new.
    Nothing,
    /// The first word of a statement.
    Statement,
    /// What comes after `else`.
    Else,
    /// A value. In the header of a loop or a param, `in` too.
    Value {
        /// May `in` come?
        header: bool,
    },
    /// What comes behind the dot of this name.
    Member(String),
    /// The inside of a string, an argument of the call around it.
    Text,
    /// The path of an import.
    Path,
}

/// A call around a place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Call {
    /// The function's name.
    pub name: String,
    /// How many arguments by position stand before this one.
    pub position: usize,
    /// Its name, if this one is given by name.
    pub named: Option<String>,
    /// The names that other arguments before it are given by.
    pub given: Vec<String>,
}

/// The surroundings of a place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Context {
    /// The part of a word or string that is written before the place.
    pub word: Range<usize>,
    /// What may stand there.
    pub place: Place,
    /// The innermost call that is open there.
    pub call: Option<Call>,
    /// Does an argument of that call begin with the word?
    pub argument: bool,
}

/// An open bracket.
struct Open {
    call: Option<Call>,
}

/// A line as far as it is read.
#[derive(Default)]
struct Line {
    open: Vec<Open>,
    /// Columns of indent.
    indent: usize,
    /// Its words but for blanks and comments.
    words: Vec<Lexeme>,
}

/// The name that a byte is in, or right behind, and where it is.
pub(super) fn name_at(text: &str, offset: usize) -> Option<(String, Range<usize>)> {
    let found =
        lex(text).into_iter().find(|l| l.token == Token::Name && l.start <= offset && offset <= l.end)?;
    Some((text[found.start..found.end].to_string(), found.start..found.end))
}

/// A byte where a character begins: this one, or the nearest before it.
pub fn boundary(text: &str, offset: usize) -> usize {
    (0..=offset.min(text.len())).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0)
}

/// What is around a place.
pub fn context(text: &str, offset: usize) -> Context {
    let offset = boundary(text, offset);
    let text = &text[..offset];
    let lexemes = lex(text);
    let last = lexemes.last().copied();
    let is_word = |l: &Lexeme| {
        matches!(l.token, Token::Name | Token::Unknown | Token::UnclosedText) || l.token.is_keyword()
    };
    let word = last.filter(|l| {
        is_word(l) && text[l.start..].starts_with(|c: char| c == '_' || c == '"' || c.is_alphabetic())
    });
    let mut line = Line::default();
    let before = &lexemes[..lexemes.len() - usize::from(word.is_some())];
    for (i, lexeme) in before.iter().enumerate() {
        line.take(text, *lexeme, &lexemes[i + 1..]);
    }
    let call = line.open.iter().rev().find_map(|open| open.call.clone());
    let named = call.as_ref().is_some_and(|c| c.named.is_some());
    let previous = line.words.last().map(|l| l.token);
    let direct = line.open.last().is_some_and(|open| open.call.is_some());
    let argument = direct && !named && matches!(previous, Some(Token::OpenParen | Token::Comma));
    let place = match (word.map(|w| w.token), last.map(|l| l.token)) {
        (Some(Token::UnclosedText), _) if previous == Some(Token::Import) => Place::Path,
        (Some(Token::UnclosedText), _) => Place::Text,
        (None, Some(Token::Comment | Token::Number | Token::BadNumber | Token::Text | Token::Name)) => {
            Place::Nothing
        }
        _ => line.place(text, named),
    };
    let word = match word {
        Some(w) if w.token == Token::UnclosedText => w.start + 1..offset,
        Some(w) => w.start..offset,
        None => offset..offset,
    };
    Context { word, place, call, argument }
}

impl Line {
    fn take(&mut self, text: &str, lexeme: Lexeme, rest: &[Lexeme]) {
        match lexeme.token {
            Token::Newline if self.open.is_empty() || self.is_over(rest) => {
                *self = Line::default();
                return;
            }
            Token::Blank if self.words.is_empty() => self.indent = lexeme.end - lexeme.start,
            Token::OpenParen => {
                let name = self.words.last().filter(|l| l.token == Token::Name);
                let defined = self.words.first().is_some_and(|l| l.token == Token::Function);
                let call = name.filter(|_| !defined).map(|l| Call {
                    name: text[l.start..l.end].to_string(),
                    position: 0,
                    named: None,
                    given: Vec::new(),
                });
                self.open.push(Open { call });
            }
            Token::OpenSquare => self.open.push(Open { call: None }),
            Token::CloseParen | Token::CloseSquare => drop(self.open.pop()),
            Token::Comma => {
                if let Some(call) = self.top() {
                    match call.named.take() {
                        Some(name) => call.given.push(name),
                        None => call.position += 1,
                    }
                }
            }
            Token::Assign => {
                let name = self.words.last().filter(|l| l.token == Token::Name).copied();
                if let (Some(call), Some(name)) = (self.top(), name) {
                    call.named = Some(text[name.start..name.end].to_string());
                }
            }
            _ => {}
        }
        if !lexeme.token.is_space() {
            self.words.push(lexeme);
        }
    }

    /// The call whose bracket is the innermost one.
    fn top(&mut self) -> Option<&mut Call> {
        self.open.last_mut()?.call.as_mut()
    }

    /// With a bracket open at the end of a line: can the next one only be a statement of its own?
    fn is_over(&self, rest: &[Lexeme]) -> bool {
        let indent = rest.first().filter(|l| l.token == Token::Blank).map_or(0, |l| l.end - l.start);
        let mut words = rest.iter().filter(|l| l.token != Token::Blank);
        let Some(first) = words.next() else { return false };
        let assigns = first.token == Token::Name && words.next().is_some_and(|l| l.token.is_assignment());
        let listed = self.words.last().is_some_and(|l| matches!(l.token, Token::Comma | Token::OpenParen));
        first.token.starts_statement() || (assigns && !listed && indent <= self.indent)
    }

    fn place(&self, text: &str, named: bool) -> Place {
        let Some(last) = self.words.last() else { return Place::Statement };
        let first = self.words[0].token;
        match last.token {
            Token::Dot => {
                let base = self.words.iter().rev().nth(1).filter(|l| l.token == Token::Name);
                Place::Member(base.map_or("", |l| &text[l.start..l.end]).to_string())
            }
            Token::Else => Place::Else,
            Token::Function | Token::Param | Token::For | Token::Import => Place::Nothing,
            // The names of parameters are new.
            _ if first == Token::Function && !(named || last.token == Token::Assign) => Place::Nothing,
            _ => Place::Value { header: matches!(first, Token::For | Token::Param) && self.open.is_empty() },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The surroundings of the `|`.
    fn at(text: &str) -> Context {
        context(&text.replace('|', ""), text.find('|').unwrap())
    }

    #[test]
    fn places() {
        for (text, place) in [
            ("a = 1\nwh|", Place::Statement),
            ("a = wh|", Place::Value { header: false }),
            ("a = 1 # wh|", Place::Nothing),
            ("a = 12|", Place::Nothing),
            ("if a\n    b = 1\nelse |", Place::Else),
            ("for i |", Place::Value { header: true }),
            ("for |", Place::Nothing),
            ("function f(a, b|", Place::Nothing),
            ("function f(a, b = no|", Place::Value { header: false }),
            ("a = bg.co|", Place::Member("bg".into())),
            ("a = Noise(p, kind = \"gr|", Place::Text),
            ("import \"st|", Place::Path),
            ("a = f(1,\nb = 2)\nc|", Place::Statement),
            ("a = f(1\nb = 2\nc|", Place::Statement),
        ] {
            assert_eq!(at(text).place, place, "{text}");
        }
    }

    #[test]
    fn calls() {
        let call = |text: &str| at(text).call.map(|c| (c.name, c.position, c.named));
        assert_eq!(call("a = f(1, g(2), |"), Some(("f".into(), 2, None)));
        assert_eq!(call("a = f(1, g(2, [3 4|"), Some(("g".into(), 1, None)));
        assert_eq!(call("a = f(1, kind = |"), Some(("f".into(), 1, Some("kind".into()))));
        assert_eq!(call("a = f(\n    1,\n    2|"), Some(("f".into(), 1, None)));
        assert_eq!(call("a = f(1)|"), None);
        assert_eq!(call("a = f(1\nb = |"), None);
        assert_eq!(call("function f(|"), None);
        assert!(at("a = f(|").argument && at("a = f(1, k|").argument);
        assert!(!at("a = f(1 + |").argument && !at("a = f([|").argument);
    }

    #[test]
    fn the_word_is_what_is_written_of_it() {
        let text = "a = Noise(p, kind = \"gra|dient\")";
        assert_eq!(&text[at(text).word], "gra");
        assert_eq!(at("größe|").word, 0.."größe".len());
    }
}
