//! Walks over a finished tree: to move its spans, and to print a function's signature.

use super::ast::{Access, Argument, Expr, ExprKind, Function, Name, Stmt, StmtKind};
use super::parse::parse;
use crate::diagnostic::{SourceId, Span};

/// One expression from a text that holds nothing else; `None` if that is not so.
pub fn parse_expression(source: SourceId, text: &str) -> Option<Expr> {
    let parsed = parse(source, text);
    let mut body = parsed.module.body;
    match (body.pop()?.kind, body.is_empty() && parsed.errors.is_empty()) {
        (StmtKind::Expr(e), true) => Some(e),
        _ => None,
    }
}

/// The function's parameters, with their defaults as they are written. `text` is what its spans point into.
pub fn parameters(function: &Function, text: &str) -> Vec<(String, Option<String>)> {
    let written = |e: &Expr| text.get(e.span.start as usize..e.span.end as usize).unwrap_or("…").to_string();
    function.params.iter().map(|(name, default)| (name.text.clone(), default.as_ref().map(written))).collect()
}

/// As a call of the function is written: `wave(v, amplitude = 1)`. `text` is what its spans point into.
pub fn signature(function: &Function, text: &str) -> String {
    let params = parameters(function, text).into_iter().map(|(name, default)| match default {
        Some(value) => format!("{name} = {value}"),
        None => name,
    });
    format!("{}({})", function.name.text, params.collect::<Vec<_>>().join(", "))
}

/// Gives every node of an expression the same span, as if all of it stood there.
pub fn set_span(e: &mut Expr, span: Span) {
    spans_of_expr(e, &mut |s| *s = span);
}

/// Makes a function's spans point into another source with the same text.
pub fn set_source(function: &mut Function, source: SourceId) {
    let mut f = |s: &mut Span| s.source = source;
    f(&mut function.name.span);
    for (name, default) in &mut function.params {
        f(&mut name.span);
        default.iter_mut().for_each(|e| spans_of_expr(e, &mut f));
    }
    spans_of_block(&mut function.body, &mut f);
}

fn spans_of_block(block: &mut [Stmt], f: &mut impl FnMut(&mut Span)) {
    for stmt in block {
        f(&mut stmt.span);
        match &mut stmt.kind {
            StmtKind::Assign { target, value, .. } => {
                f(&mut target.span);
                f(&mut target.name.span);
                for step in &mut target.path {
                    match step {
                        Access::Index(e) => spans_of_expr(e, f),
                        Access::Member(Name { span, .. }) => f(span),
                    }
                }
                spans_of_expr(value, f);
            }
            StmtKind::Expr(e) | StmtKind::Return(e) => spans_of_expr(e, f),
            StmtKind::If { arms, otherwise } => {
                for (condition, block) in arms {
                    spans_of_expr(condition, f);
                    spans_of_block(block, f);
                }
                otherwise.iter_mut().for_each(|block| spans_of_block(block, f));
            }
            StmtKind::While(e, block) => {
                spans_of_expr(e, f);
                spans_of_block(block, f);
            }
            StmtKind::For(name, e, block) => {
                f(&mut name.span);
                spans_of_expr(e, f);
                spans_of_block(block, f);
            }
            StmtKind::Param { name, value, range } => {
                f(&mut name.span);
                spans_of_expr(value, f);
                range.iter_mut().for_each(|e| spans_of_expr(e, f));
            }
            // The parser lets functions stand at the outer level only; the resolver refuses others unseen.
            StmtKind::Function(_) | StmtKind::Break | StmtKind::Continue => {}
            StmtKind::Import(_, span) => f(span),
        }
    }
}

fn spans_of_expr(e: &mut Expr, f: &mut impl FnMut(&mut Span)) {
    f(&mut e.span);
    match &mut *e.kind {
        ExprKind::Number(_) | ExprKind::Text(_) | ExprKind::Name(_) | ExprKind::Error => {}
        ExprKind::Member(a, name) => {
            f(&mut name.span);
            spans_of_expr(a, f);
        }
        ExprKind::Unary(_, a) | ExprKind::Group(a) => spans_of_expr(a, f),
        ExprKind::Index(a, b) | ExprKind::Binary(_, a, b) | ExprKind::Range(a, b) => {
            spans_of_expr(a, f);
            spans_of_expr(b, f);
        }
        ExprKind::Conditional(a, b, c) => [a, b, c].into_iter().for_each(|e| spans_of_expr(e, f)),
        ExprKind::Vector(elements) => elements.iter_mut().for_each(|e| spans_of_expr(e, f)),
        ExprKind::Call(name, args) => {
            f(&mut name.span);
            for Argument { name, value } in args {
                name.iter_mut().for_each(|n| f(&mut n.span));
                spans_of_expr(value, f);
            }
        }
    }
}
