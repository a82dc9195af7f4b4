//! Lines and indentation: from the lexer's tokens to the stream that the grammar reads.
//!
//! The grammar sees no blanks, comments or empty lines, only `Indent`, `Dedent` and one `EndOfLine` for each
//! logical line; [`super::line`] reads these lines, with the brackets and blanks inside them. The stream is always
//! well formed, whatever the text: blocks are balanced, and every line that opens a block has one.
//! A line with a fault that leaves its meaning open comes out as `Unreadable`, so that it is reported once.

use super::line::Line;
use super::token::{Lexeme, Token, lex};
use crate::diagnostic::{Diagnostic, SourceId, Span};

/// A token as the grammar takes it.
pub type Spanned = (usize, Token, usize);

/// How deep blocks may be nested.
pub const MAX_BLOCKS: usize = 100;

/// A comment, from its `#` to before the end of its line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Comment {
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

/// A text, laid out.
pub struct Layout {
    /// The tokens for the grammar.
    pub tokens: Vec<Spanned>,
    /// The comments, in order.
    pub comments: Vec<Comment>,
    /// What is wrong so far.
    pub errors: Vec<Diagnostic>,
    /// Lines that need a block and have none: where each starts and ends, and the error. If the line itself is
    /// at fault, that is what counts.
    pub blockless: Vec<(usize, usize, Diagnostic)>,
    /// The text stops inside a bracket, or before the block of its last line.
    pub incomplete: bool,
    /// A bracket is open at the end.
    pub open_bracket: bool,
    /// Its last line belongs to a block.
    pub in_block: bool,
}

/// Lays out `text`.
pub fn layout(source: SourceId, text: &str) -> Layout {
    let mut reader = Reader {
        source,
        text,
        raw: lex(text),
        next: 0,
        comments: Vec::new(),
        errors: Vec::new(),
        blockless: Vec::new(),
        habits: Vec::new(),
        open_at_end: false,
    };
    let mut blocks = Blocks {
        levels: vec![Level { indent: "", aliases: Vec::new(), start: 0 }],
        header: None,
        out: Vec::new(),
    };
    while let Some((start, indent)) = reader.indentation() {
        let line = reader.line(indent);
        if line.tokens.is_empty() && !line.unreadable {
            continue;
        }
        blocks.indent(&mut reader, start, indent, &line);
        if blocks.levels.len() > MAX_BLOCKS + 1 {
            let at = start + indent.len();
            reader.errors.push(
                Diagnostic::error(
                    "syntax",
                    format!("blocks are nested more than {MAX_BLOCKS} deep"),
                    Span::new(source, at, line.tokens.first().map_or(at, |t| t.2)),
                )
                .hint("Move the inner blocks into a function."),
            );
            break;
        }
        blocks.emit(line);
    }
    let header = blocks.header.is_some_and(|h| h.1);
    let in_block = blocks.levels.len() > 1;
    blocks.finish(&mut reader);
    Layout {
        tokens: blocks.out,
        comments: reader.comments,
        errors: reader.errors,
        blockless: reader.blockless,
        incomplete: header || reader.open_at_end,
        open_bracket: reader.open_at_end,
        in_block,
    }
}

/// The text, how far it is read, and what came of it.
pub struct Reader<'a> {
    pub(super) source: SourceId,
    pub(super) text: &'a str,
    pub(super) raw: Vec<Lexeme>,
    pub(super) next: usize,
    pub(super) comments: Vec<Comment>,
    pub(super) errors: Vec<Diagnostic>,
    blockless: Vec<(usize, usize, Diagnostic)>,
    /// Messages on habits, with the error that each made: one error names all places.
    pub(super) habits: Vec<(String, usize)>,
    /// A bracket was open at the end of the text.
    pub(super) open_at_end: bool,
}

impl<'a> Reader<'a> {
    /// Skips blank lines and lines of comment; gives the start and the indent of the next line.
    fn indentation(&mut self) -> Option<(usize, &'a str)> {
        loop {
            let first = *self.raw.get(self.next)?;
            let mut indent = "";
            if first.token == Token::Blank {
                indent = &self.text[first.start..first.end];
                self.next += 1;
            }
            let token = self.raw.get(self.next)?;
            match token.token {
                Token::Newline => self.next += 1,
                Token::Comment => {
                    self.comments.push(Comment { start: token.start, end: token.end });
                    self.next += 1;
                    if self.raw.get(self.next).is_some_and(|t| t.token == Token::Newline) {
                        self.next += 1;
                    }
                }
                _ => return Some((first.start, indent)),
            }
        }
    }

    pub(super) fn span(&self, start: usize, end: usize) -> Span {
        Span::new(self.source, start, end)
    }
}

/// One open block, or the outer level.
struct Level<'a> {
    /// The indent of its lines, as text.
    indent: &'a str,
    /// Faulty indents that are read as if they were this one.
    aliases: Vec<&'a str>,
    /// Where its first line starts.
    start: usize,
}

impl Level<'_> {
    fn has(&self, indent: &str) -> bool {
        self.indent == indent || self.aliases.contains(&indent)
    }
}

/// The blocks that are open, and the stream so far.
struct Blocks<'a> {
    levels: Vec<Level<'a>>,
    /// The last line opened a block: its first word, and whether the lack of a block is to be reported.
    header: Option<(Spanned, bool)>,
    out: Vec<Spanned>,
}

impl<'a> Blocks<'a> {
    fn top(&self) -> &Level<'a> {
        // The outer level is never closed.
        &self.levels[self.levels.len() - 1]
    }

    /// Opens and closes the blocks that a line with this indent asks for.
    fn indent(&mut self, reader: &mut Reader<'a>, start: usize, indent: &'a str, line: &Line) {
        let at = start + indent.len();
        let deeper = !self.top().has(indent) && indent.starts_with(self.top().indent);
        let known = self.levels.iter().rposition(|l| l.has(indent));
        if deeper && known.is_none() {
            return self.open(start, indent);
        }
        if let Some(level) = known {
            self.expect_no_block(reader, Some(line));
            return self.close_to(level, at);
        }
        // A fault: take the level that looks nearest, and remember the text as another name for it.
        let shown = |level: &Level| width(level.indent).abs_diff(width(indent));
        // An `else` belongs to a line around the block that it ends.
        let is_else = line.tokens.first().is_some_and(|t| t.1 == Token::Else);
        let open = if is_else { self.levels.len().max(2) - 1 } else { self.levels.len() };
        let nearest = (0..open).rev().min_by_key(|&i| shown(&self.levels[i])).unwrap_or(0);
        if self.top().indent.starts_with(indent) {
            let mut error = Diagnostic::error(
                "syntax",
                "the indent of this line matches no block",
                reader.span(start, at),
            )
            .label(reader.span(start, at), format!("{} here", blanks(indent)));
            let top = self.top();
            if !top.indent.is_empty() {
                let span = reader.span(top.start, top.start + top.indent.len());
                error = error.label(span, format!("{} in the block above", blanks(top.indent)));
            }
            let inner = self.levels.iter().find(|l| l.indent.len() > indent.len()).unwrap_or(top);
            let outer = self.levels.iter().rfind(|l| l.indent.len() < indent.len()).unwrap_or(top);
            let hint = format!(
                "Give all lines of a block the same indent: here {} for the block, or {} for the lines around it.",
                blanks(inner.indent),
                blanks(outer.indent),
            );
            reader.errors.push(error.hint(hint));
        } else {
            let top = self.top();
            reader.errors.push(
                Diagnostic::error(
                    "syntax",
                    "the indent mixes tabs and spaces, and cannot be compared with the line above",
                    reader.span(start, at),
                )
                .label(reader.span(start, at), format!("{} here", blanks(indent)))
                .label(reader.span(top.start, top.start + top.indent.len()), blanks(top.indent))
                .hint("Indent with spaces only, four for each block."),
            );
            if self.header.is_some() || width(indent) > width(self.top().indent) {
                return self.open(start, indent);
            }
        }
        self.expect_no_block(reader, None);
        self.close_to(nearest, at);
        self.levels[nearest].aliases.push(indent);
    }

    fn open(&mut self, start: usize, indent: &'a str) {
        self.header = None;
        let at = start + indent.len();
        self.levels.push(Level { indent, aliases: Vec::new(), start });
        self.out.push((start, Token::Indent, at));
    }

    fn close_to(&mut self, level: usize, at: usize) {
        while self.levels.len() > level + 1 {
            self.levels.pop();
            self.out.push((at, Token::Dedent, at));
        }
    }

    /// Reports a line that needs a block and has none, and makes an empty one.
    fn expect_no_block(&mut self, reader: &mut Reader<'a>, next: Option<&Line>) {
        let Some(((start, token, end), report)) = self.header.take() else { return };
        if report {
            let word = &reader.text[start..end];
            let mut error =
                Diagnostic::error("syntax", format!("`{word}` has no block"), reader.span(start, end));
            let first = next.and_then(|n| n.tokens.first());
            if let Some(&(start, first, end)) = first
                && first != token
                && first != Token::Else
            {
                error = error.label(reader.span(start, end), "this line is not indented");
            }
            let error = error.hint("Indent the lines of its block by four spaces.");
            reader.blockless.push((start, self.out.last().map_or(end, |t| t.2), error));
        }
        let at = self.out.last().map_or(end, |t| t.2);
        self.out.push((at, Token::Indent, at));
        self.out.push((at, Token::Dedent, at));
    }

    /// Adds a line to the stream.
    fn emit(&mut self, line: Line) {
        let first = line.tokens.first().copied();
        // An unreadable line's block may be missing, but it is not looked for.
        self.header = first.filter(|t| t.1.opens_block() && !line.unreadable).map(|t| (t, true));
        if line.unreadable {
            let start = first.map_or(line.end.0, |t| t.0);
            self.out.push((start, Token::Unreadable, line.end.0));
        } else {
            self.out.extend(line.tokens);
        }
        self.out.push((line.end.0, Token::EndOfLine, line.end.1));
    }

    fn finish(&mut self, reader: &mut Reader<'a>) {
        self.expect_no_block(reader, None);
        let end = reader.text.len();
        self.close_to(0, end);
    }
}

/// How wide an indent looks.
fn width(indent: &str) -> usize {
    indent.chars().map(|c| if c == '\t' { 4 } else { 1 }).sum()
}

/// An indent in words: `2 tabs`, `a tab and 3 blanks`.
fn blanks(indent: &str) -> String {
    let counted = |n: usize, what: &str| match n {
        1 => format!("one {what}"),
        n => format!("{n} {what}s"),
    };
    let tabs = indent.matches('\t').count();
    match (tabs, indent.len() - tabs) {
        (0, 0) => "no indent".to_string(),
        (0, n) => counted(n, "space"),
        (n, 0) => counted(n, "tab"),
        (t, n) => format!("{} and {}", counted(t, "tab"), counted(n, "space")),
    }
}
