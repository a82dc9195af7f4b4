//! What the grammar does when it has read a rule: it makes nodes, and reports what was written wrong but can be read.

use super::ast::{Access, Argument, BinaryOp, Expr, ExprKind, Name, Stmt, StmtKind, Target, UnaryOp};
use super::token::Token;
use crate::diagnostic::{Diagnostic, SourceId, Span};
use lalrpop_util::ParseError;
use std::convert::Infallible;

/// A fault that the grammar found.
pub enum Fault {
    /// A token that fits no rule: where, which, and what the grammar would have taken.
    Unexpected {
        /// First byte of the token.
        start: usize,
        /// One past its last byte.
        end: usize,
        /// The token; `None` at the end of the text.
        found: Option<Token>,
        /// Terminals of the grammar. The list may lack some, so it only ever narrows a message down.
        expected: Vec<String>,
    },
    /// A fault that an action found.
    Found(Diagnostic),
}

impl Fault {
    /// Takes the parser's own error apart.
    pub fn parse(error: ParseError<usize, Token, Infallible>) -> Fault {
        match error {
            ParseError::UnrecognizedToken { token: (start, token, end), expected } => {
                Fault::Unexpected { start, end, found: Some(token), expected }
            }
            ParseError::ExtraToken { token: (start, token, end) } => {
                Fault::Unexpected { start, end, found: Some(token), expected: Vec::new() }
            }
            ParseError::UnrecognizedEof { location, expected } => {
                Fault::Unexpected { start: location, end: location, found: None, expected }
            }
            ParseError::InvalidToken { location } => {
                Fault::Unexpected { start: location, end: location, found: None, expected: Vec::new() }
            }
            ParseError::User { error } => match error {},
        }
    }

    /// Where it is.
    pub fn start(&self) -> usize {
        match self {
            Fault::Unexpected { start, .. } => *start,
            Fault::Found(d) => d.span().map_or(0, |s| s.start as usize),
        }
    }
}

/// What a block is made of, before `else` finds its `if`.
pub enum Item {
    /// A whole statement.
    Stmt(Stmt),
    /// `else if` with its condition and block, and the span of its header.
    ElseIf(usize, usize, Expr, Vec<Stmt>),
    /// `else` with its block.
    Else(usize, usize, Vec<Stmt>),
    /// A block that no line opened.
    Stray(usize, Vec<Stmt>),
    /// A line that could not be read; its error is reported.
    Faulty,
}

impl Item {
    /// A statement at `l..r`.
    pub fn stmt(source: SourceId, l: usize, r: usize, kind: StmtKind) -> Item {
        Item::Stmt(Stmt { kind, span: Span::new(source, l, r) })
    }
}

/// An expression of this kind.
pub fn expr(span: Span, kind: ExprKind) -> Expr {
    Expr { kind: Box::new(kind), span }
}

/// An expression at `l..r`.
pub fn node(source: SourceId, l: usize, r: usize, kind: ExprKind) -> Expr {
    expr(Span::new(source, l, r), kind)
}

/// `a op b`.
pub fn binary(op: BinaryOp, a: Expr, b: Expr) -> Expr {
    let span = a.span.to(b.span);
    expr(span, ExprKind::Binary(op, a, b))
}

/// `op e`, the operator at `l`.
pub fn unary(source: SourceId, l: usize, op: UnaryOp, e: Expr) -> Expr {
    let span = Span::new(source, l, l).to(e.span);
    expr(span, ExprKind::Unary(op, e))
}

/// The value of a string as written, quotes and all.
pub fn unescape(written: &str) -> String {
    let inner = written.get(1..written.len().saturating_sub(1)).unwrap_or("");
    let mut text = String::with_capacity(inner.len());
    let mut chars = inner.chars();
    while let Some(c) = chars.next() {
        match c {
            '\\' => match chars.next() {
                Some('n') => text.push('\n'),
                Some('t') => text.push('\t'),
                Some(escaped) => text.push(escaped),
                None => {}
            },
            c => text.push(c),
        }
    }
    text
}

/// Makes nodes that need the text, or that may be at fault.
pub struct Builder<'a, 'f> {
    /// The text being parsed.
    pub text: &'a str,
    /// Its name in spans.
    pub source: SourceId,
    /// The faults so far.
    pub faults: &'f mut Vec<Fault>,
}

impl Builder<'_, '_> {
    fn fault(&mut self, message: impl Into<String>, span: Span, label: &str, hint: impl Into<String>) {
        let error = Diagnostic::error("syntax", message, span).label(span, label).hint(hint);
        self.faults.push(Fault::Found(error));
    }

    fn written(&self, span: Span) -> &str {
        self.text.get(span.start as usize..span.end as usize).unwrap_or("")
    }

    /// The text of a short expression, to be quoted in a message; a long one is cut to `…`.
    fn quoted<'s>(&'s self, span: Span, otherwise: &'s str) -> &'s str {
        let text = self.written(span);
        if text.len() <= 24 && !text.contains(['\n', '\r']) { text } else { otherwise }
    }

    /// The name at `l..r`.
    pub fn name(&self, l: usize, r: usize) -> Name {
        Name { text: self.text[l..r].to_string(), span: Span::new(self.source, l, r) }
    }

    /// The variable at `l..r`.
    pub fn variable(&self, l: usize, r: usize) -> Expr {
        node(self.source, l, r, ExprKind::Name(self.text[l..r].to_string()))
    }

    /// The number at `l..r`.
    pub fn number(&self, l: usize, r: usize) -> Expr {
        // A word that only stands for a number (`true`) is reported already; its value does not matter.
        node(self.source, l, r, ExprKind::Number(self.text[l..r].parse().unwrap_or(0.0)))
    }

    /// The string at `l..r`.
    pub fn string(&self, l: usize, r: usize) -> Expr {
        node(self.source, l, r, ExprKind::Text(unescape(&self.text[l..r])))
    }

    /// `a == b` and its kin, which do not chain.
    pub fn compare(&mut self, op: BinaryOp, a: Expr, b: Expr) -> Expr {
        if let ExprKind::Binary(first, _, middle) = &*a.kind
            && (matches!(first, BinaryOp::Eq | BinaryOp::Ne) == matches!(op, BinaryOp::Eq | BinaryOp::Ne))
            && matches!(
                first,
                BinaryOp::Eq | BinaryOp::Ne | BinaryOp::Lt | BinaryOp::Le | BinaryOp::Gt | BinaryOp::Ge
            )
        {
            let hint = format!(
                "Write `{} && {} {} {}`.",
                self.quoted(a.span, "a < b"),
                self.quoted(middle.span, "b"),
                op.symbol(),
                self.quoted(b.span, "c"),
            );
            self.fault("comparisons do not chain", a.span.to(b.span), "", hint);
        }
        binary(op, a, b)
    }

    /// A range that stands outside `[ ]`.
    pub fn range_outside(&mut self, a: Expr, b: Expr) -> Expr {
        let span = a.span.to(b.span);
        let hint = format!("Write `[{} .. {}]`.", self.quoted(a.span, "1"), self.quoted(b.span, "5"));
        self.fault("a range is only allowed inside `[ ]`", span, "", hint);
        let range = expr(span, ExprKind::Range(a, b));
        expr(span, ExprKind::Vector(vec![range]))
    }

    /// `e[i]`, with `[` at `l` and the end of `]` at `r`.
    pub fn index(&mut self, e: Expr, l: usize, mut elements: Vec<Expr>, r: usize) -> Expr {
        let inside = Span::new(self.source, l, r);
        let what = self.quoted(e.span, "v").to_string();
        if elements.len() != 1 {
            let written = self.quoted(inside, "[1 2]");
            let minus = elements.iter().skip(1).any(|e| matches!(&*e.kind, ExprKind::Unary(UnaryOp::Neg, _)));
            let hint = if elements.is_empty() {
                format!("The first component is `{what}[1]`.")
            } else if minus {
                "Spaces separate elements inside `[ ]`: write `a - b` or `a-b` for a difference.".to_string()
            } else {
                format!("To pick several, write `{what}[{written}]`; to pick one of a row, `{what}[1][2]`.")
            };
            let message = match elements.len() {
                0 => "the index is missing".to_string(),
                n => format!("an index is one value, and {n} were found"),
            };
            self.fault(message, inside, "", hint);
        }
        if let [range] = &elements[..]
            && matches!(&*range.kind, ExprKind::Range(..))
        {
            let hint = format!("To pick several, write `{what}[{}]`.", self.quoted(inside, "[1 .. 3]"));
            self.fault("an index is one value, and a range was found", range.span, "", hint);
        }
        let span = e.span.to(inside);
        match elements.pop() {
            Some(index) => expr(span, ExprKind::Index(e, index)),
            None => expr(span, ExprKind::Error),
        }
    }

    /// `f(args)`, with `(` at `l` and the end of `)` at `r`.
    pub fn call(&mut self, f: Expr, l: usize, args: Vec<Argument>, r: usize) -> Expr {
        let span = f.span.to(Span::new(self.source, l, r));
        if let ExprKind::Name(text) = &*f.kind {
            let name = Name { text: text.clone(), span: f.span };
            return expr(span, ExprKind::Call(name, args));
        }
        let what = self.quoted(f.span, "this").to_string();
        let hint = match &*f.kind {
            ExprKind::Number(_) | ExprKind::Group(_) | ExprKind::Index(..) => {
                format!("To multiply, write `{what} * (…)`.")
            }
            ExprKind::Member(..) => "Functions are not members of variables: write `f(v)`.".to_string(),
            _ => "Only the name of a function has `(` after it.".to_string(),
        };
        self.fault("only a function can be called", f.span, "this is not the name of a function", hint);
        expr(span, ExprKind::Error)
    }

    /// `target = value` or `target op= value`.
    pub fn assign(&mut self, target: Expr, op: Option<BinaryOp>, value: Expr) -> StmtKind {
        let span = target.span;
        let what = match innermost(&target) {
            ExprKind::Name(_) => None,
            ExprKind::Call(..) => Some("the result of a call"),
            ExprKind::Number(_) => Some("a number"),
            ExprKind::Text(_) => Some("a string"),
            ExprKind::Vector(_) => Some("a vector"),
            _ => Some("an expression"),
        };
        match (what, path(target)) {
            (None, Some((name, path))) => StmtKind::Assign { target: Target { name, path, span }, op, value },
            (what, _) => {
                let hint = match what {
                    Some("a vector") => {
                        "Assign to one variable, and take its components: `v = f(x)`, `v[1]`."
                    }
                    Some("an expression") => {
                        "The left side of `=` must be a variable, `v[i]` or `v.x`; to compare, write `==`."
                    }
                    _ => "The left side of `=` must be a variable, `v[i]` or `v.x`.",
                };
                if let Some(what) = what {
                    self.fault(format!("{what} cannot be assigned to"), span, "", hint);
                }
                StmtKind::Expr(expr(span, ExprKind::Error))
            }
        }
    }

    /// `param name = value in range`.
    pub fn param(&mut self, name: Name, value: Expr, range: Option<Expr>) -> StmtKind {
        if let Some(range) = &range
            && !matches!(&*range.kind, ExprKind::Vector(e)
                if e.len() == 2 && !e.iter().any(|e| matches!(&*e.kind, ExprKind::Range(..))))
        {
            let hint = format!("Write `param {} = … in [0 1]`.", name.text);
            self.fault("the range of a param is two values in `[ ]`", range.span, "", hint);
        }
        StmtKind::Param { name, value, range }
    }

    /// Joins every `else` to its `if`, and reports the ones that have none, and stray blocks.
    pub fn assemble(&mut self, items: Vec<Item>) -> Vec<Stmt> {
        let mut body: Vec<Stmt> = Vec::new();
        // What an `else` here would belong to.
        enum Before {
            If,
            Else(Span),
            Faulty,
            Other,
        }
        let mut before = Before::Other;
        for item in items {
            let (l, r, condition, block) = match item {
                Item::Stmt(stmt) => {
                    before =
                        if matches!(stmt.kind, StmtKind::If { .. }) { Before::If } else { Before::Other };
                    body.push(stmt);
                    continue;
                }
                Item::Faulty => {
                    before = Before::Faulty;
                    continue;
                }
                Item::Stray(l, mut block) => {
                    if !matches!(before, Before::Faulty) {
                        self.stray(l, body.last());
                    }
                    before = Before::Faulty;
                    body.append(&mut block);
                    continue;
                }
                Item::ElseIf(l, r, condition, block) => (l, r, Some(condition), block),
                Item::Else(l, r, block) => (l, r, None, block),
            };
            let span = Span::new(self.source, l, r);
            let is_last = condition.is_none();
            match (&before, body.last_mut().map(|s| &mut s.kind)) {
                (Before::If, Some(StmtKind::If { arms, otherwise })) => match condition {
                    Some(condition) => arms.push((condition, block)),
                    None => *otherwise = Some(block),
                },
                (Before::Else(first), _) => {
                    let first = *first;
                    let error = Diagnostic::error("syntax", "nothing can follow an `else`", span)
                        .label(first, "this `else` covers all other cases")
                        .hint("Put `else if` before `else`; an `if` has at most one `else`.");
                    self.faults.push(Fault::Found(error));
                }
                (Before::Faulty, _) => {}
                _ => self.fault(
                    "this `else` has no `if`",
                    span,
                    "",
                    "Give `else` the same indent as its `if`, directly after the block.",
                ),
            }
            before = match (before, is_last) {
                (Before::If, true) => Before::Else(Span::new(self.source, l, l + 4)),
                (Before::If, false) => Before::If,
                (Before::Else(first), _) => Before::Else(first),
                _ => Before::Faulty,
            };
        }
        body
    }

    fn stray(&mut self, start: usize, above: Option<&Stmt>) {
        let indent = self.text[start..].find(|c| c != ' ' && c != '\t').unwrap_or(0);
        let span = Span::new(self.source, start, start + indent);
        let mut error = Diagnostic::error("syntax", "this line is indented, but no block starts here", span);
        if let Some(above) = above
            && matches!(above.kind, StmtKind::Assign { .. } | StmtKind::Expr(_))
        {
            error = error.label(above.span, "this line does not start a block");
        }
        self.faults.push(Fault::Found(error.hint(
            "Give it the indent of the line above; a block starts after if, else, while, for or function.",
        )));
    }
}

/// What a path of `[i]` and `.x` starts from.
fn innermost(target: &Expr) -> &ExprKind {
    let mut at = &target.kind;
    while let ExprKind::Index(e, _) | ExprKind::Member(e, _) = &**at {
        at = &e.kind;
    }
    at
}

/// A variable and the places inside it, if that is what `target` is.
fn path(target: Expr) -> Option<(Name, Vec<Access>)> {
    let mut path = Vec::new();
    let mut at = target;
    loop {
        match *at.kind {
            ExprKind::Index(e, i) => {
                path.push(Access::Index(i));
                at = e;
            }
            ExprKind::Member(e, n) => {
                path.push(Access::Member(n));
                at = e;
            }
            ExprKind::Name(text) => {
                path.reverse();
                return Some((Name { text, span: at.span }, path));
            }
            _ => return None,
        }
    }
}
