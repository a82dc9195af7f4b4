//! What a program consists of: functions, params, and what it writes.

use super::Reading;
use crate::diagnostic::{SourceId, Sources, Span};
use crate::resolve::{Files, assigned, print};
use crate::syntax::{
    self,
    ast::{Expr, ExprKind, Stmt, StmtKind},
};
use std::collections::HashSet;
use std::ops::Range;

/// What an entry of the outline is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outlined {
    /// A function.
    Function,
    /// A param.
    Param,
    /// A variable that is written.
    Output,
}

/// A line of the outline.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The name.
    pub name: String,
    /// The signature, or the whole param line.
    pub detail: String,
    /// What it is.
    pub kind: Outlined,
    /// All that belongs to it.
    pub whole: Range<usize>,
    /// Its name's bytes.
    pub place: Range<usize>,
}

impl Reading {
    /// Functions, params and outputs of the program's own text, in its order.
    pub fn outline(&self) -> Vec<Entry> {
        let text = self.text();
        let mut list = Vec::new();
        for stmt in &self.files.body {
            let (name, kind, detail) = match &stmt.kind {
                StmtKind::Function(f) => (&f.name, Outlined::Function, syntax::signature(f, text)),
                StmtKind::Param { name, .. } => {
                    (name, Outlined::Param, self.sources.text(stmt.span).to_string())
                }
                _ => continue,
            };
            let whole = stmt.span.start as usize..end(stmt) as usize;
            list.push(Entry { name: name.text.clone(), detail, kind, whole, place: range(name.span) });
        }
        for &(ref name, span) in &self.written {
            if span.source == SourceId::default() {
                let detail = "written".to_string();
                let (whole, place) = (range(span), range(span));
                list.push(Entry { name: name.to_string(), detail, kind: Outlined::Output, whole, place });
            }
        }
        list.sort_by_key(|entry| entry.place.start);
        list
    }
}

/// The variables that a program writes if nobody says which, each with its first assignment; as `docs/language.md` has
/// it under "What is written".
pub(super) fn written(files: &Files, sources: &Sources) -> Vec<(String, Span)> {
    let mut all: Vec<(&str, Span)> = Vec::new();
    let mut seen: HashSet<&str> = HashSet::new();
    for stmt in &files.body {
        // The block of `if begin_frame` is the frame's.
        if matches!(&stmt.kind, StmtKind::If { arms, .. } if sources.text(arms[0].0.span) == "begin_frame") {
            continue;
        }
        assigned(std::slice::from_ref(stmt), &mut |name| {
            if seen.insert(&name.text) {
                all.push((&name.text, name.span));
            }
        });
    }
    let prints = |e: &Expr| matches!(&*e.kind, ExprKind::Call(name, _) if name.text == print::NAME);
    let alone = files.body.iter().any(|stmt| matches!(&stmt.kind, StmtKind::Expr(e) if !prints(e)));
    let picture = seen.contains("color") || alone || seen.contains("normal");
    all.retain(|(name, _)| !picture || matches!(*name, "color" | "alpha"));
    all.into_iter().map(|(name, span)| (name.to_string(), span)).collect()
}

/// Where a statement with all its blocks ends.
fn end(stmt: &Stmt) -> u32 {
    let last = |block: &[Stmt]| block.last().map_or(0, end);
    let inside = match &stmt.kind {
        StmtKind::Function(f) => last(&f.body),
        StmtKind::If { arms, otherwise } => arms
            .iter()
            .map(|(_, block)| last(block))
            .chain(otherwise.iter().map(|b| last(b)))
            .max()
            .unwrap_or(0),
        StmtKind::While(_, block) | StmtKind::For(_, _, block) => last(block),
        _ => 0,
    };
    inside.max(stmt.span.end)
}

fn range(span: Span) -> Range<usize> {
    span.start as usize..span.end as usize
}
