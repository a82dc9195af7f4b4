//! The one canonical form of a program: what `pse fmt` prints.
//!
//! It is printed from the tree, with comments and blank lines taken from the text between the nodes.
//! Four blanks an indent, blanks around operators outside `[ ]` and none inside, at most one blank line,
//! one around every function. Numbers, strings and round brackets stay as they were written.
//! A comment inside an expression that has no line of its own there moves to the line above.
//!
//! The printed text is parsed again, and given out only if it has the same tree: a fault here can never change
//! a program.

use super::ast::*;
use super::dump::tree;
use super::layout::Comment;
use super::parse::{Whole, read};
use super::print::{Printer, column};
use super::token::Token;
use crate::diagnostic::{Diagnostic, SourceId, Span};

/// Prints a program in its canonical form, or gives its syntax errors. The errors' spans name the default source.
pub fn format(text: &str) -> Result<String, Vec<Diagnostic>> {
    let whole = read(SourceId::default(), text);
    if !whole.errors.is_empty() {
        return Err(whole.errors);
    }
    let printed = lines(text, &whole);
    let again = read(SourceId::default(), &printed);
    if again.errors.is_empty() && tree(&again.module) == tree(&whole.module) {
        return Ok(printed);
    }
    // A fault of the formatter, not of the program.
    Err(vec![
        Diagnostic::error(
            "syntax",
            "this program cannot be formatted without changing it",
            Span::new(SourceId::default(), 0, 0),
        )
        .hint("The file was not changed. Please report this, with the program."),
    ])
}

fn lines(text: &str, whole: &Whole) -> String {
    let elses = whole.tokens.iter().filter(|t| t.1 == Token::Else).map(|t| t.0).collect();
    let mut format = Format {
        text,
        comments: &whole.comments,
        next: 0,
        elses,
        next_else: 0,
        out: String::new(),
        indent: 0,
        done: 0,
        fresh: true,
        after_function: false,
    };
    format.block(&whole.module.body);
    format.comments_before(text.len(), 0);
    format.out
}

struct Format<'a> {
    text: &'a str,
    comments: &'a [Comment],
    /// The first comment that is not printed yet.
    next: usize,
    /// Where every `else` stands, in order, and the first that is not printed yet.
    elses: Vec<usize>,
    next_else: usize,
    out: String,
    /// Columns of indent.
    indent: usize,
    /// How far the text is printed.
    done: usize,
    /// No blank line is wanted here: a block has just begun.
    fresh: bool,
    /// A function has just ended, and wants a blank line.
    after_function: bool,
}

impl<'a> Format<'a> {
    fn block(&mut self, body: &[Stmt]) {
        for stmt in body {
            self.stmt(stmt);
        }
    }

    /// A blank line if the text has one before `start`, or if `wanted`.
    fn blank_line(&mut self, start: usize, wanted: bool) {
        let between = self.text.get(self.done..start).unwrap_or("");
        let breaks = between.replace("\r\n", "\n").matches(['\n', '\r']).count();
        if !self.fresh && (wanted || self.after_function || breaks > 1) {
            self.out.push('\n');
        }
        self.fresh = false;
        self.after_function = false;
    }

    fn line(&mut self, text: &str) {
        self.out.extend(std::iter::repeat_n(' ', self.indent));
        self.out.push_str(text);
        self.out.push('\n');
    }

    /// Prints the comments that stand on lines of their own before `end` and at `least` columns or further right.
    fn comments_before(&mut self, end: usize, least: usize) {
        self.comments_of(end, least, false);
    }

    fn comments_of(&mut self, end: usize, least: usize, mut function: bool) {
        let mut first = true;
        while let Some(&comment) = self.comments.get(self.next).filter(|c| c.start < end) {
            if column(self.text, comment.start) < least {
                break;
            }
            // The blank line before a function goes before the comment that belongs to it.
            let blank_after = function && first && !self.joined(self.next, end);
            self.blank_line(comment.start, function && first && !blank_after);
            if blank_after {
                // A later comment, or the function itself, takes the blank line.
                function = true;
            }
            self.line(self.text[comment.start..comment.end].trim_end());
            self.done = comment.end;
            self.next += 1;
            first = blank_after;
        }
    }

    /// Whether no blank line stands between the comment with this number and what starts at `end`.
    fn joined(&self, comment: usize, end: usize) -> bool {
        let mut at = self.comments[comment].end;
        for comment in self.comments[comment + 1..].iter().take_while(|c| c.start < end) {
            if breaks(&self.text[at..comment.start]) > 1 {
                return false;
            }
            at = comment.end;
        }
        breaks(&self.text[at..end]) <= 1
    }

    /// A comment that follows on the same line.
    fn trailing(&mut self) {
        let Some(&comment) = self.comments.get(self.next) else { return };
        let between = self.text.get(self.done..comment.start);
        if between.is_some_and(|b| !b.contains(['\n', '\r'])) {
            self.out.pop();
            self.out.push_str("  ");
            self.out.push_str(self.text[comment.start..comment.end].trim_end());
            self.out.push('\n');
            self.done = comment.end;
            self.next += 1;
        }
    }

    /// Prints one line of the program, which stands at `start..end` in the text.
    fn statement_line(&mut self, start: usize, end: usize, function: bool, print: impl FnOnce(&mut Printer)) {
        let pending = self.comments.get(self.next).is_some_and(|c| c.start < start);
        let separated = pending && self.comments_separated(start);
        self.comments_of(start, 0, function);
        let (first, last) = self.comments_within(start, end);
        let mut printer = Printer::new(self.text, &self.comments[first..last], self.indent);
        print(&mut printer);
        let (text, hoisted) = printer.finish();
        let mut wanted = function && (!pending || separated);
        for comment in hoisted {
            self.blank_line(start, wanted);
            wanted = false;
            self.line(self.text[comment.start..comment.end].trim_end());
            self.done = start;
        }
        self.blank_line(start, wanted);
        self.line(&text);
        self.next = last;
        self.done = end;
        self.trailing();
    }

    /// Whether a blank line stands between the last comment before `start` and `start`.
    fn comments_separated(&self, start: usize) -> bool {
        let last = self.comments[self.next..].iter().take_while(|c| c.start < start).last();
        last.is_some_and(|c| breaks(&self.text[c.end..start]) > 1)
    }

    fn comments_within(&self, start: usize, end: usize) -> (usize, usize) {
        let first = self.comments.partition_point(|c| c.start < start);
        let last = self.comments.partition_point(|c| c.start < end);
        (first.max(self.next), last.max(self.next))
    }

    /// A block below its header, with the comments at its end.
    fn nested(&mut self, body: &[Stmt]) {
        // The block's indent in the text tells which comments after its last line belong to it.
        let level = body.first().map_or(0, |s| column(self.text, s.span.start as usize));
        let outer = self.indent;
        self.indent += 4;
        self.fresh = true;
        self.block(body);
        let end = self.next_word();
        self.comments_before(end, level.max(1));
        self.indent = outer;
        self.fresh = false;
    }

    /// Where the program goes on after what is printed and the comments that follow.
    fn next_word(&self) -> usize {
        let mut at = self.done;
        for comment in &self.comments[self.next..] {
            if !self.text[at..comment.start].trim().is_empty() {
                break;
            }
            at = comment.end;
        }
        at + self.text[at..].find(|c: char| !c.is_whitespace()).unwrap_or(self.text.len() - at)
    }

    fn stmt(&mut self, stmt: &Stmt) {
        let (start, end) = (stmt.span.start as usize, stmt.span.end as usize);
        match &stmt.kind {
            StmtKind::If { arms, otherwise } => {
                for (i, (condition, block)) in arms.iter().enumerate() {
                    let (start, word) = if i == 0 { (start, "if ") } else { (self.take_else(), "else if ") };
                    let end = condition.span.end as usize;
                    self.statement_line(start, end, false, |p| {
                        p.put(word);
                        p.expr(condition);
                    });
                    self.nested(block);
                }
                if let Some(block) = otherwise {
                    let start = self.take_else();
                    self.statement_line(start, start + "else".len(), false, |p| p.put("else"));
                    self.nested(block);
                }
            }
            StmtKind::While(condition, block) => {
                self.statement_line(start, end, false, |p| {
                    p.put("while ");
                    p.expr(condition);
                });
                self.nested(block);
            }
            StmtKind::For(name, vector, block) => {
                self.statement_line(start, end, false, |p| {
                    p.put("for ");
                    p.put(&name.text);
                    p.put(" in ");
                    p.expr(vector);
                });
                self.nested(block);
            }
            StmtKind::Function(function) => {
                self.statement_line(start, end, true, |p| p.function(function));
                self.nested(&function.body);
                self.after_function = true;
            }
            _ => self.statement_line(start, end, false, |p| p.simple(stmt)),
        }
    }

    fn take_else(&mut self) -> usize {
        let at = self.elses.get(self.next_else).copied().unwrap_or(self.done);
        self.next_else += 1;
        at
    }
}

fn breaks(between: &str) -> usize {
    between.replace("\r\n", "\n").matches(['\n', '\r']).count()
}
