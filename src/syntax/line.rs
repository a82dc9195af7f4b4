//! One logical line: brackets, and the blanks inside them.
//!
//! A line goes on while a bracket is open. Where the innermost bracket is `[`, a blank between two operands
//! becomes a `Separator`; everywhere else blanks vanish. A bracket that is never closed would swallow the rest
//! of the text, so a line that can only be a new statement ends it.

use super::habit::{self, Meant, Place};
use super::hex;
use super::layout::{Comment, Reader, Spanned};
use super::token::{Lexeme, Token};
use crate::diagnostic::Diagnostic;

/// How deep brackets may be nested.
pub const MAX_BRACKETS: usize = 200;

/// How deep the tree of an expression may become. Walks over the tree are recursive; at this depth they fit
/// the stack of any thread. Operators count too: `a + b + c` is a tree that leans to the left.
pub const MAX_DEPTH: u32 = 500;

/// One logical line.
pub struct Line {
    /// Its tokens, without blanks and comments.
    pub tokens: Vec<Spanned>,
    /// It has a fault, already reported, that leaves its meaning open.
    pub unreadable: bool,
    /// Where it ends: the bytes of the line break.
    pub end: (usize, usize),
}

/// An open bracket (or the line itself), with bounds on the depth of the tree inside it.
struct Frame {
    open: Option<Lexeme>,
    /// It is a call's or an index's: in the tree a link of the chain that it stands in, not a node by itself.
    postfix: bool,
    /// How many operators the element has so far.
    operators: u32,
    /// The deepest bracket of the element so far.
    inner: u32,
    /// The deepest earlier element.
    deepest: u32,
}

impl Frame {
    fn new(open: Option<Lexeme>, postfix: bool) -> Frame {
        Frame { open, postfix, operators: 0, inner: 0, deepest: 0 }
    }

    fn is(&self, token: Token) -> bool {
        self.open.is_some_and(|o| o.token == token)
    }

    /// A bound on the depth of the tree of all that this bracket holds.
    fn depth(&self) -> u32 {
        self.deepest.max(self.operators + self.inner)
    }

    fn next_element(&mut self) {
        *self = Frame { deepest: self.depth(), ..Frame::new(self.open, self.postfix) };
    }
}

struct State<'a> {
    line: Line,
    indent: &'a str,
    frames: Vec<Frame>,
    /// A blank came since the last token.
    blank: bool,
    /// An error on depth is reported.
    too_deep: bool,
    /// How many `?` wait for their `:`.
    questions: usize,
}

impl State<'_> {
    fn last(&self) -> Option<Spanned> {
        self.line.tokens.last().copied()
    }

    fn top(&mut self) -> &mut Frame {
        if self.frames.is_empty() {
            self.frames.push(Frame::new(None, false));
        }
        let last = self.frames.len() - 1;
        &mut self.frames[last]
    }
}

impl<'a> Reader<'a> {
    /// Reads one logical line whose indent is already read.
    pub(super) fn line(&mut self, indent: &'a str) -> Line {
        let end = self.raw.get(self.next).map_or(self.text.len(), |t| t.start);
        let mut state = State {
            line: Line { tokens: Vec::new(), unreadable: false, end: (end, end) },
            indent,
            frames: vec![Frame::new(None, false)],
            blank: false,
            too_deep: false,
            questions: 0,
        };
        while let Some(&lexeme) = self.raw.get(self.next) {
            self.next += 1;
            match lexeme.token {
                Token::Blank => state.blank = true,
                Token::Comment => {
                    self.comments.push(Comment { start: lexeme.start, end: lexeme.end });
                    state.blank = true;
                }
                Token::Newline => {
                    if self.line_break(&mut state) {
                        let end = state.last().map_or(lexeme.start, |t| t.2);
                        state.line.end = (end, lexeme.end);
                        return state.line;
                    }
                    state.blank = true;
                }
                _ => self.word(&mut state, lexeme),
            }
        }
        if state.frames.len() > 1 {
            self.open_at_end = true;
            self.unclosed(&mut state, None);
        }
        let end = state.last().map_or(self.text.len(), |t| t.2);
        state.line.end = (end, self.text.len().max(end));
        state.line
    }

    /// Whether the logical line ends at a line break.
    fn line_break(&mut self, state: &mut State) -> bool {
        if state.frames.len() > 1 {
            if !self.statement_follows(state) {
                return false;
            }
            let end = state.last().map_or(0, |t| t.2);
            self.unclosed(state, Some(end));
            return true;
        }
        !self.goes_on(state)
    }

    /// With no bracket open, whether the next line was meant to continue this one; that is an error.
    fn goes_on(&mut self, state: &mut State) -> bool {
        let Some((start, token, end)) = state.last() else { return false };
        if state.line.unreadable {
            return false;
        }
        let infix = token.is_infix() || token == Token::Sub || token.is_assignment() || token == Token::Comma;
        let header = state.line.tokens[0].1.opens_block();
        let deeper = |indent: &str| indent.len() > state.indent.len() && indent.starts_with(state.indent);
        let following = self.next_line();
        let word = &self.text[start..end];
        let bracket = "An expression can continue on the next line only inside `( )` or `[ ]`.";
        if infix && state.line.tokens.len() > 1 {
            if let Some(error) = self.web_color(end) {
                state.line.unreadable = true;
                self.errors.push(error);
                return false;
            }
            let what = if token.is_assignment() { "the value is missing after" } else { "nothing follows" };
            state.line.unreadable = true;
            self.errors.push(
                Diagnostic::error(
                    "syntax",
                    format!("{what} `{word}` at the end of the line"),
                    self.span(start, end),
                )
                .hint(bracket),
            );
            return following.is_some_and(|(indent, _)| deeper(indent))
                && (!header || matches!(token, Token::And | Token::Or));
        }
        if let Some((indent, next)) = following
            && next.token.is_infix()
            && token.ends_operand()
            && (deeper(indent) || next.token != Token::Range)
        {
            let word = &self.text[next.start..next.end];
            self.errors.push(
                Diagnostic::error(
                    "syntax",
                    format!("a line cannot start with `{word}`"),
                    self.span(next.start, next.end),
                )
                .hint(bracket),
            );
            state.line.unreadable = true;
            return true;
        }
        false
    }

    /// The indent and first token of the next line that has one.
    fn next_line(&self) -> Option<(&'a str, Lexeme)> {
        let mut indent = "";
        for lexeme in &self.raw[self.next..] {
            match lexeme.token {
                Token::Newline => indent = "",
                Token::Blank => indent = &self.text[lexeme.start..lexeme.end],
                Token::Comment => {}
                _ => return Some((indent, *lexeme)),
            }
        }
        None
    }

    /// With a bracket open, whether the next line can only be a new statement.
    fn statement_follows(&self, state: &mut State) -> bool {
        let mut rest = self.raw[self.next..].iter().peekable();
        let indent = rest.next_if(|l| l.token == Token::Blank).map_or(0, |l| l.end - l.start);
        let Some(first) = rest.next() else { return false };
        if first.token.starts_statement() {
            return true;
        }
        if first.token != Token::Name {
            return false;
        }
        // Find `=` or `+=` after a name and its `[i]` and `.x`.
        let (mut depth, mut path) = (0usize, false);
        for lexeme in rest {
            match lexeme.token {
                Token::Blank => {}
                Token::OpenSquare => (depth, path) = (depth + 1, true),
                Token::CloseSquare if depth > 0 => depth -= 1,
                Token::Newline | Token::Comment => return false,
                _ if depth > 0 => {}
                Token::Dot | Token::Name if lexeme.token == Token::Dot || path => path = true,
                Token::Assign => {
                    let in_call = state.top().is(Token::OpenParen);
                    let listed = matches!(state.last(), Some((_, Token::Comma | Token::OpenParen, _)));
                    // `f(a,` with `kind = "x")` below is an argument by name.
                    return path || !in_call || (!listed && indent <= state.indent.len());
                }
                token => return token.is_assignment(),
            }
        }
        false
    }

    /// The error of a colour such as `#ff0000` behind `end`, the last token of a line: it is a comment.
    fn web_color(&self, end: usize) -> Option<Diagnostic> {
        let behind = self.text.get(end..)?;
        let start = end + behind.len() - behind.trim_start_matches([' ', '\t']).len();
        let (length, instead) = hex::color(&self.text[start..])?;
        let error = Diagnostic::error("syntax", "`#` starts a comment", self.span(start, start + length));
        Some(error.hint(format!("Write the colour as `{instead}`.")))
    }

    /// Reports the open brackets, innermost first, and gives the line up.
    fn unclosed(&mut self, state: &mut State, by: Option<usize>) {
        let open: Vec<Lexeme> = state.frames.drain(1..).rev().filter_map(|f| f.open).collect();
        let Some(inner) = open.first() else { return };
        if let Some(error) =
            state.last().and_then(|(.., end)| self.web_color(end)).filter(|_| !state.line.unreadable)
        {
            self.errors.push(error);
        } else if !state.line.unreadable {
            let word = &self.text[inner.start..inner.end];
            let mut error = Diagnostic::error(
                "syntax",
                format!("`{word}` is never closed"),
                self.span(inner.start, inner.end),
            )
            .label(self.span(inner.start, inner.end), "opened here");
            for outer in open.iter().skip(1).take(2) {
                error = error.label(self.span(outer.start, outer.end), "this one too");
            }
            if let Some(by) = by {
                let close = closer(inner.token);
                error = error.label(self.span(by, by), format!("`{close}` expected by here"));
            }
            self.errors.push(error.hint(format!("Add a `{}`.", closer(inner.token))));
        }
        state.line.unreadable = true;
    }

    /// Takes one word of the line.
    fn word(&mut self, state: &mut State, lexeme: Lexeme) {
        let Lexeme { token, start, end } = lexeme;
        let next = self.raw[self.next..].iter().find(|l| l.token != Token::Blank);
        let place = Place {
            first: state.line.tokens.is_empty(),
            after_operand: state.last().is_some_and(|t| t.1.ends_operand()),
            after_dot: state.last().is_some_and(|t| t.1 == Token::Dot),
            next: next.map(|l| l.token),
            next_text: next.map_or("", |l| &self.text[l.start..l.end]),
            outside: state.frames.len() == 1,
            in_for: state.line.tokens.first().is_some_and(|t| t.1 == Token::For),
            header: state.line.tokens.first().is_some_and(|t| t.1.opens_block()) && state.questions == 0,
        };
        if let Some(found) = habit::find(token, &self.text[start..end], &place) {
            // A line that is given up gets no more messages that only guess.
            if !(state.line.unreadable && found.meant == Meant::Unknown) {
                self.report_habit(lexeme, &found);
            }
            match found.meant {
                Meant::Unknown => state.line.unreadable = true,
                Meant::Tokens(tokens) => {
                    if tokens.is_empty() {
                        state.blank = true;
                    }
                    for &token in tokens {
                        self.take(state, Lexeme { token, start, end });
                    }
                }
            }
            if token == Token::SlashSlash && place.outside {
                self.skip_line(state);
            }
            return;
        }
        match token {
            Token::UnclosedText => {
                self.errors.push(
                    Diagnostic::error("syntax", "this string is never closed", self.span(start, start + 1))
                        .label(self.span(start, start + 1), "opened here")
                        .hint("Close it with `\"` on the same line."),
                );
                state.line.unreadable = true;
                // The closers of this line are inside the string.
                let line = self.text[..start].rfind(['\n', '\r']).map_or(0, |i| i + 1);
                state.frames.retain(|f| f.open.is_none_or(|o| o.start < line));
            }
            Token::Number => {
                self.check_number(lexeme);
                self.take(state, lexeme);
            }
            Token::Text => {
                self.check_escapes(lexeme);
                self.take(state, lexeme);
            }
            Token::Dot => self.dot(state, lexeme),
            _ => self.take(state, lexeme),
        }
    }

    /// Skips what is left of the line, as a comment would be; drops the operator that was put for it.
    fn skip_line(&mut self, state: &mut State) {
        state.line.tokens.pop();
        while self.raw.get(self.next).is_some_and(|t| t.token != Token::Newline) {
            self.next += 1;
        }
    }

    /// A `.` belongs to the words on both its sides.
    fn dot(&mut self, state: &mut State, lexeme: Lexeme) {
        let span = self.span(lexeme.start, lexeme.end);
        let next = self.raw.get(self.next);
        let touches = next.is_some_and(|t| !t.token.is_space() && t.token.starts_operand());
        match state.last() {
            Some((start, Token::Number, end)) if end == lexeme.start => {
                let text = &self.text[start..end];
                self.errors.push(
                    Diagnostic::error(
                        "syntax",
                        "a number cannot end with a dot",
                        self.span(start, lexeme.end),
                    )
                    .hint(format!("Write `{text}` or `{text}.0`.")),
                );
            }
            Some((_, token, end)) if token.ends_operand() && (end != lexeme.start || !touches) => {
                self.errors.push(
                    Diagnostic::error(
                        "syntax",
                        "`.` must be directly between two names, without spaces",
                        span,
                    )
                    .hint("Write `v.x`; a range is `[1 .. 5]`."),
                );
                state.line.unreadable = true;
            }
            _ => self.take(state, lexeme),
        }
    }

    /// Adds a token to the line, with a separator before it where blanks ask for one.
    fn take(&mut self, state: &mut State, lexeme: Lexeme) {
        let Lexeme { token, start, end } = lexeme;
        self.separate(state, lexeme);
        let after_operand = state.last().is_some_and(|t| t.1.ends_operand());
        match token {
            Token::OpenParen | Token::OpenSquare => {
                state.top().operators += u32::from(after_operand);
                state.frames.push(Frame::new(Some(lexeme), after_operand));
                if state.frames.len() > MAX_BRACKETS + 1 {
                    let message = format!("brackets are nested more than {MAX_BRACKETS} deep");
                    self.too_deep(state, lexeme, message);
                }
            }
            Token::CloseParen | Token::CloseSquare => self.close(state, lexeme),
            Token::Comma | Token::EndOfLine => state.top().next_element(),
            Token::Number | Token::Name | Token::Text | Token::Assign => {}
            _ => state.top().operators += 1,
        }
        match token {
            Token::Question => state.questions += 1,
            Token::Colon if after_operand && state.questions > 0 => state.questions -= 1,
            _ => {}
        }
        if state.top().depth() > MAX_DEPTH {
            let message = format!("this expression has more than {MAX_DEPTH} operators or is nested as deep");
            self.too_deep(state, lexeme, message);
        }
        if state.too_deep {
            // The line is given up: keep its first token and the last, and no more.
            state.line.tokens.truncate(1);
        }
        state.line.tokens.push((start, token, end));
        state.blank = false;
    }

    fn too_deep(&mut self, state: &mut State, lexeme: Lexeme, message: String) {
        if !state.too_deep {
            self.errors.push(
                Diagnostic::error("syntax", message, self.span(lexeme.start, lexeme.end))
                    .hint("Assign parts of it to variables first."),
            );
        }
        state.too_deep = true;
        state.line.unreadable = true;
    }

    /// Inside `[ ]`, decides whether the blank before `lexeme` starts a new element.
    fn separate(&mut self, state: &mut State, lexeme: Lexeme) {
        let Some((_, last, end)) = state.last() else { return };
        if !state.blank || !state.top().is(Token::OpenSquare) || !last.ends_operand() {
            return;
        }
        let touches_next = self.raw.get(self.next).is_some_and(|t| !t.token.is_space());
        match lexeme.token {
            Token::Sub | Token::Not if touches_next => {}
            Token::Add if touches_next => {
                let span = self.span(lexeme.start, lexeme.end);
                self.errors.push(
                    Diagnostic::error("syntax", "`+` has a space before it and none after it", span)
                        .hint("For a sum write `a + b` or `a+b`; for two elements write `a b`, without `+`."),
                );
                return;
            }
            token if token.starts_operand() => {}
            _ => return,
        }
        state.top().next_element();
        state.line.tokens.push((end, Token::Separator, lexeme.start));
    }

    fn close(&mut self, state: &mut State, lexeme: Lexeme) {
        let word = &self.text[lexeme.start..lexeme.end];
        let span = self.span(lexeme.start, lexeme.end);
        let Some(open) = state.top().open else {
            if !state.line.unreadable {
                self.errors.push(
                    Diagnostic::error("syntax", format!("`{word}` has no opening bracket"), span)
                        .hint("Delete it, or add the bracket that it closes."),
                );
            }
            state.line.unreadable = true;
            return;
        };
        if closer(open.token) != word {
            if !state.line.unreadable {
                let opener = &self.text[open.start..open.end];
                let wanted = closer(open.token);
                self.errors.push(
                    Diagnostic::error("syntax", format!("`{opener}` is closed by `{word}`"), span)
                        .label(span, format!("`{wanted}` expected"))
                        .label(self.span(open.start, open.end), "opened here")
                        .hint(format!("Close `{opener}` with `{wanted}`.")),
                );
            }
            state.line.unreadable = true;
            let matching = state.frames.iter().rposition(|f| f.open.is_some_and(|o| closer(o.token) == word));
            if let Some(matching) = matching {
                state.frames.truncate(matching + 1);
            }
        }
        let depth = state.top().depth() + u32::from(!state.top().postfix);
        state.frames.pop();
        let outer = state.top();
        outer.inner = outer.inner.max(depth);
    }
}

/// The bracket that closes what `open` opens.
fn closer(open: Token) -> &'static str {
    match open {
        Token::OpenSquare => "]",
        _ => ")",
    }
}
