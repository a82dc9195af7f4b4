//! Prints one statement: on one line if it fits, else broken inside its brackets.

use super::ast::*;
use super::flat::{Inside, flat};
use super::layout::Comment;
use crate::diagnostic::Span;

/// How wide a line may become before it is broken.
const WIDTH: usize = 100;

/// Prints a statement that starts at some column.
pub struct Printer<'a> {
    text: &'a str,
    /// All comments inside the statement.
    all: &'a [Comment],
    /// Those that can stay where they are: before, after or between the elements of a `[ ]` or a call.
    comments: Vec<Comment>,
    /// Which of these are printed.
    placed: Vec<bool>,
    out: String,
    /// The column that the next character comes to.
    at: usize,
}

/// The column, from 0, of a byte of the text.
pub fn column(text: &str, at: usize) -> usize {
    let line = text[..at].rfind(['\n', '\r']).map_or(0, |i| i + 1);
    text[line..at].trim_start_matches('\u{feff}').chars().count()
}

impl<'a> Printer<'a> {
    /// A printer for the statement that holds `comments`.
    pub fn new(text: &'a str, comments: &'a [Comment], indent: usize) -> Printer<'a> {
        Printer {
            text,
            all: comments,
            comments: Vec::new(),
            placed: Vec::new(),
            out: String::new(),
            at: indent,
        }
    }

    /// The statement, without its first indent, and the comments that found no place in it.
    pub fn finish(self) -> (String, Vec<Comment>) {
        let mut stay = self.comments.iter().peekable();
        let hoisted = self.all.iter().filter(|c| stay.next_if_eq(c).is_none()).copied().collect();
        (self.out, hoisted)
    }

    /// Adds text that has no line break.
    pub fn put(&mut self, text: &str) {
        self.out.push_str(text);
        self.at += text.chars().count();
    }

    /// Adds an expression outside all brackets.
    pub fn expr(&mut self, e: &Expr) {
        self.find_places(e);
        self.placed.resize(self.comments.len(), false);
        self.print(e, Inside::Line, 0);
    }

    /// Collects the comments inside `e` that can stay, in order.
    fn find_places(&mut self, e: &Expr) {
        match &*e.kind {
            ExprKind::Vector(elements) => self.find_between(elements, e.span),
            ExprKind::Call(_, arguments) => self.find_between(arguments, e.span),
            ExprKind::Group(a) | ExprKind::Member(a, _) | ExprKind::Unary(_, a) => self.find_places(a),
            ExprKind::Index(a, b) | ExprKind::Binary(_, a, b) | ExprKind::Range(a, b) => {
                self.find_places(a);
                self.find_places(b);
            }
            ExprKind::Conditional(a, b, c) => [a, b, c].into_iter().for_each(|e| self.find_places(e)),
            _ => {}
        }
    }

    fn find_between<T: HasSpan>(&mut self, items: &[T], span: Span) {
        let mut from = span.start;
        for item in items {
            self.find_in(from, item.span().start);
            self.find_places(item.value());
            from = item.span().end;
        }
        self.find_in(from, span.end);
    }

    fn find_in(&mut self, from: u32, to: u32) {
        let first = self.all.partition_point(|c| c.start < from as usize);
        self.comments.extend(self.all[first..].iter().take_while(|c| c.end <= to as usize));
    }

    /// Adds a function's header.
    pub fn function(&mut self, function: &Function) {
        self.put("function ");
        self.put(&function.name.text);
        self.put("(");
        let column = self.at;
        for (i, (name, default)) in function.params.iter().enumerate() {
            let mut item = name.text.clone();
            if let Some(default) = default {
                item += " = ";
                item += &flat(self.text, default, Inside::Round);
            }
            let width = item.chars().count() + 1;
            if i > 0 {
                self.put(",");
                if self.at + 1 + width > WIDTH { self.new_line(column) } else { self.put(" ") }
            }
            self.put(&item);
        }
        self.put(")");
    }

    /// Adds a statement that has no block.
    pub fn simple(&mut self, stmt: &Stmt) {
        match &stmt.kind {
            StmtKind::Assign { target, op, value } => {
                self.put(&target.name.text);
                for access in &target.path {
                    match access {
                        Access::Index(i) => {
                            let index = flat(self.text, i, Inside::Square);
                            self.put(&format!("[{index}]"));
                        }
                        Access::Member(name) => self.put(&format!(".{}", name.text)),
                    }
                }
                self.put(&format!(" {}= ", op.map_or("", BinaryOp::symbol)));
                self.expr(value);
            }
            StmtKind::Expr(e) => self.expr(e),
            StmtKind::Break => self.put("break"),
            StmtKind::Continue => self.put("continue"),
            StmtKind::Return(e) => {
                self.put("return ");
                self.expr(e);
            }
            StmtKind::Param { name, value, range } => {
                self.put(&format!("param {} = ", name.text));
                self.expr(value);
                if let Some(range) = range {
                    self.put(" in ");
                    self.expr(range);
                }
            }
            StmtKind::Import(_, span) => {
                let written = self.written(*span);
                self.put(&format!("import {written}"));
            }
            // Statements with blocks are taken apart by the caller.
            _ => {}
        }
    }

    fn written(&self, span: Span) -> &'a str {
        self.text.get(span.start as usize..span.end as usize).unwrap_or("")
    }

    fn new_line(&mut self, column: usize) {
        self.out.truncate(self.out.trim_end_matches(' ').len());
        self.out.push('\n');
        self.out.extend(std::iter::repeat_n(' ', column));
        self.at = column;
    }

    fn has_comment(&self, span: Span) -> bool {
        let first = self.comments.partition_point(|c| c.start < span.start as usize);
        self.comments.get(first).is_some_and(|c| c.end <= span.end as usize)
    }

    /// Prints `e`, after which `after` more columns are needed.
    fn print(&mut self, e: &Expr, inside: Inside, after: usize) {
        if !self.has_comment(e.span) {
            let flat = flat(self.text, e, inside);
            if self.at + flat.chars().count() + after <= WIDTH || !breakable(e, inside) {
                return self.put(&flat);
            }
        }
        match &*e.kind {
            ExprKind::Vector(elements) => {
                self.put("[");
                self.list(elements, e.span, "", Inside::Square, after, |p, e, after| {
                    p.print(e, Inside::Square, after)
                });
                self.put("]");
            }
            ExprKind::Call(name, arguments) => {
                self.put(&name.text);
                self.put("(");
                self.list(arguments, e.span, ",", Inside::Round, after, |p, a, after| {
                    if let Some(name) = &a.name {
                        p.put(&format!("{} = ", name.text));
                    }
                    p.print(&a.value, Inside::Round, after);
                });
                self.put(")");
            }
            ExprKind::Group(inner) => {
                self.put("(");
                self.print(inner, Inside::Round, after + 1);
                self.put(")");
            }
            ExprKind::Index(v, i) => {
                self.print(v, inside, 1);
                self.put("[");
                self.print(i, Inside::Square, after + 1);
                self.put("]");
            }
            ExprKind::Member(v, name) => {
                self.print(v, inside, after + name.text.len() + 1);
                self.put(&format!(".{}", name.text));
            }
            ExprKind::Unary(op, e) => {
                self.put(op.symbol());
                self.print(e, inside, after);
            }
            ExprKind::Binary(op, ..) => self.chain(*op, e, inside, after),
            ExprKind::Conditional(c, a, b) => {
                let column = self.at;
                self.print(c, inside, 2);
                for (mark, part) in [("? ", a), (": ", b)] {
                    if inside == Inside::Line {
                        self.put(" ")
                    } else {
                        self.new_line(column + 2)
                    }
                    self.put(mark);
                    self.print(part, inside, after);
                }
            }
            ExprKind::Range(a, b) => {
                self.print(a, inside, 3);
                self.put(" .. ");
                self.print(b, inside, after);
            }
            _ => {
                let flat = flat(self.text, e, inside);
                self.put(&flat);
            }
        }
    }

    /// A chain of operators of one precedence: inside `( )` it breaks before each of them.
    fn chain(&mut self, op: BinaryOp, e: &Expr, inside: Inside, after: usize) {
        let column = self.at;
        let mut parts = Vec::new();
        let mut at = e;
        while let ExprKind::Binary(o, a, b) = &*at.kind
            && precedence(*o) == precedence(op)
            && (parts.is_empty() || *o != BinaryOp::Pow)
        {
            parts.push((*o, b));
            at = a;
        }
        self.print(at, inside, 2);
        for (o, part) in parts.into_iter().rev() {
            match inside {
                Inside::Square => self.put(o.symbol()),
                Inside::Line => self.put(&format!(" {} ", o.symbol())),
                Inside::Round => {
                    self.new_line(column);
                    self.put(&format!("{} ", o.symbol()));
                }
            }
            self.print(part, inside, after);
        }
    }

    /// The elements of a broken bracket: one a line where they are rows or have comments, else as many as fit.
    fn list<T: HasSpan>(
        &mut self,
        items: &[T],
        span: Span,
        separator: &str,
        inside: Inside,
        after: usize,
        print: impl Fn(&mut Self, &T, usize),
    ) {
        let column = self.at;
        let comments = self.has_comment(span);
        let rows = comments || items.iter().any(HasSpan::is_row);
        let mut open_comment = false;
        for (i, item) in items.iter().enumerate() {
            let own = self
                .take_comments(if i == 0 { span.start } else { items[i - 1].span().end }, item.span().start);
            for comment in own {
                if i > 0 || open_comment {
                    self.new_line(column);
                } else {
                    self.put("  ");
                }
                self.comment(comment);
                open_comment = true;
            }
            let more = after + if i + 1 == items.len() { 1 } else { separator.len() };
            if open_comment || (i > 0 && rows) {
                self.new_line(column);
            } else if i > 0 {
                let width = self.flat_item(item, inside);
                if self.at + 1 + width + more > WIDTH { self.new_line(column) } else { self.put(" ") }
            }
            open_comment = false;
            print(self, item, more);
            if i + 1 < items.len() {
                self.put(separator);
            }
            // A comment on the line where the element ends stays there.
            let until = items.get(i + 1).map_or(span.end, |n| n.span().start);
            if let Some(comment) = self.trailing(item.span().end, until) {
                self.put("  ");
                self.comment(comment);
                open_comment = true;
            }
        }
        let from = items.last().map_or(span.start, |l| l.span().end);
        for comment in self.take_comments(from, span.end) {
            if !items.is_empty() || open_comment {
                self.new_line(column);
            } else {
                self.put("  ");
            }
            self.comment(comment);
            open_comment = true;
        }
        if open_comment {
            self.new_line(column);
        }
    }

    fn flat_item<T: HasSpan>(&self, item: &T, inside: Inside) -> usize {
        let name = item.label().map_or(0, |n| n.chars().count() + 3);
        name + flat(self.text, item.value(), inside).chars().count()
    }

    fn comment(&mut self, comment: Comment) {
        let text = self.text[comment.start..comment.end].trim_end();
        self.put(text);
    }

    /// The comments between two places, which are from now on printed.
    fn take_comments(&mut self, from: u32, to: u32) -> Vec<Comment> {
        let mut taken = Vec::new();
        for (comment, placed) in self.comments.iter().zip(&mut self.placed) {
            if comment.start >= from as usize && comment.end <= to as usize && !*placed {
                *placed = true;
                taken.push(*comment);
            }
        }
        taken
    }

    fn trailing(&mut self, from: u32, to: u32) -> Option<Comment> {
        let i = self.comments.partition_point(|c| c.start < from as usize);
        let comment = *self.comments.get(i)?;
        let same_line = !self.text[from as usize..comment.start].contains(['\n', '\r']);
        if comment.end > to as usize || !same_line || self.placed[i] {
            return None;
        }
        self.placed[i] = true;
        Some(comment)
    }
}

/// Whether a line break fits somewhere in `e`.
fn breakable(e: &Expr, inside: Inside) -> bool {
    match &*e.kind {
        ExprKind::Vector(v) => !v.is_empty(),
        ExprKind::Call(_, a) => !a.is_empty(),
        ExprKind::Group(_) | ExprKind::Index(..) => true,
        ExprKind::Member(e, _) | ExprKind::Unary(_, e) => breakable(e, inside),
        ExprKind::Binary(_, a, b) | ExprKind::Range(a, b) => {
            inside == Inside::Round || breakable(a, inside) || breakable(b, inside)
        }
        ExprKind::Conditional(c, a, b) => {
            inside != Inside::Line || [c, a, b].into_iter().any(|e| breakable(e, inside))
        }
        _ => false,
    }
}

/// Operators of one level of the grammar share a number.
fn precedence(op: BinaryOp) -> u8 {
    use BinaryOp::*;
    match op {
        Or => 0,
        And => 1,
        Eq | Ne => 2,
        Lt | Le | Gt | Ge => 3,
        Add | Sub => 4,
        Mul | Div | Rem => 5,
        Pow => 6,
    }
}

/// What a bracket lists: elements or arguments.
trait HasSpan {
    fn value(&self) -> &Expr;
    fn label(&self) -> Option<&str>;
    fn span(&self) -> Span;
    fn is_row(&self) -> bool;
}

impl HasSpan for Expr {
    fn value(&self) -> &Expr {
        self
    }
    fn label(&self) -> Option<&str> {
        None
    }
    fn span(&self) -> Span {
        self.span
    }
    fn is_row(&self) -> bool {
        matches!(&*self.kind, ExprKind::Vector(_))
    }
}

impl HasSpan for Argument {
    fn value(&self) -> &Expr {
        &self.value
    }
    fn label(&self) -> Option<&str> {
        self.name.as_ref().map(|n| n.text.as_str())
    }
    fn span(&self) -> Span {
        self.name.as_ref().map_or(self.value.span, |n| n.span.to(self.value.span))
    }
    fn is_row(&self) -> bool {
        false
    }
}
