//! What an editor can tell of a program while it is being written: what a name means, what may come next, where else a
//! name stands. The language server, the session at the terminal and any other editor ask here; nothing here knows
//! how they are asked.
//!
//! A [`Reading`] is a text as it is at one moment, whole or half written. Places are bytes of that text.

mod complete;
mod context;
mod describe;
mod function;
mod occurrences;
mod outline;
mod rename;

pub use complete::{Completion, Item, Kind};
pub use context::boundary;
pub use context::{Call, Context, Place};
pub use describe::Described;
pub use function::{Function, Origin, Parameter, Takes, card};
pub use occurrences::{Occurrence, Role, Symbol};
pub use outline::{Entry as OutlineEntry, Outlined};

use crate::diagnostic::{SourceId, Sources, Span};
use crate::host::Host;
use crate::resolve::{Files, Import, gather};
use crate::syntax::ast::{self, StmtKind};
use std::collections::HashMap;
use std::ops::Range;

/// A program's text, read as far as it can be.
pub struct Reading {
    sources: Sources,
    files: Files,
    /// What its names stand for, in the order of the text.
    pub occurrences: Vec<Occurrence>,
    /// Where each symbol first gets a value in the text.
    first: HashMap<Symbol, Span>,
    /// The variables that the program writes if nobody says which, each with its first assignment.
    written: Vec<(String, Span)>,
    /// Is there anything in the text or its imports that could not be read?
    pub faulty: bool,
    /// Names that are known beside the program's own: an image's variables.
    pub inputs: Vec<String>,
}

impl Reading {
    /// Reads a text that is called `name`, and what it imports.
    pub fn new(name: &str, text: &str, host: &dyn Host) -> Reading {
        let (mut sources, mut errors) = (Sources::default(), Vec::new());
        let files = gather(name, text, &mut sources, host, &mut errors);
        let occurrences = occurrences::of(&files, text);
        let written = outline::written(&files, &sources);
        let mut first = HashMap::new();
        for o in occurrences.iter().filter(|o| matches!(o.role, Role::Write | Role::Define)) {
            first.entry(o.symbol.clone()).or_insert(o.span());
        }
        Reading {
            sources,
            files,
            occurrences,
            first,
            written,
            faulty: !errors.is_empty(),
            inputs: Vec::new(),
        }
    }

    /// The program's text.
    pub fn text(&self) -> &str {
        &self.sources.get(SourceId::default()).text
    }

    /// The texts that spans point into: the program's own is the first, its imports follow.
    pub fn sources(&self) -> &Sources {
        &self.sources
    }

    /// The program's own imports.
    pub fn imports(&self) -> &[Import] {
        &self.files.imports
    }

    /// The names of all files that it imports, whether itself or through others.
    pub fn imported_files(&self) -> impl Iterator<Item = &str> {
        self.sources.iter().skip(1).map(|source| source.name.as_str())
    }

    /// The statements of the outer level, those of imports first.
    fn outer(&self) -> impl Iterator<Item = &ast::Stmt> {
        self.files.imported.iter().chain(&self.files.body)
    }

    /// The function of that name that the program or an import of it defines.
    fn own_function(&self, name: &str) -> Option<&ast::Function> {
        self.outer().find_map(|stmt| match &stmt.kind {
            StmtKind::Function(f) if f.name.text == name => Some(f),
            _ => None,
        })
    }

    /// The param of that name: its statement and its parts.
    fn param(&self, name: &str) -> Option<(&ast::Stmt, &ast::Name)> {
        self.outer().find_map(|stmt| match &stmt.kind {
            StmtKind::Param { name: own, .. } if own.text == name => Some((stmt, own)),
            _ => None,
        })
    }

    /// The function in whose block a byte stands, or would if something were written there.
    fn function_around(&self, offset: usize) -> Option<&ast::Function> {
        let text = self.text();
        let line = text[..boundary(text, offset)].rfind(['\n', '\r']).map_or(0, |i| i + 1);
        let last = self.files.body.iter().rfind(|stmt| stmt.span.start as usize <= offset)?;
        match &last.kind {
            StmtKind::Function(f) if last.span.end as usize >= offset => Some(f),
            // What stands at the left margin is of no block.
            StmtKind::Function(f) if text[line..].starts_with([' ', '\t']) => Some(f),
            _ => None,
        }
    }

    /// Where a symbol is defined: a function's name, a param, a variable's first assignment. `None` for what no text of
    /// the program defines.
    pub fn definition(&self, symbol: &Symbol) -> Option<Span> {
        match symbol {
            Symbol::Function(name) => self.own_function(name).map(|f| f.name.span),
            Symbol::Outer(name) => match self.param(name) {
                Some((_, name)) => Some(name.span),
                None => self.first.get(symbol).copied(),
            },
            Symbol::Local { function, name } => {
                let parameter =
                    self.own_function(function).and_then(|f| f.params.iter().find(|p| p.0.text == *name));
                parameter.map(|(name, _)| name.span).or_else(|| self.first.get(symbol).copied())
            }
        }
    }

    /// The occurrence at a byte, or right before it.
    pub fn occurrence(&self, offset: usize) -> Option<&Occurrence> {
        self.occurrences.iter().find(|o| o.range.start <= offset && offset <= o.range.end)
    }

    /// What the word at a byte stands for and where it is, also on a line that could not be read.
    pub fn symbol(&self, offset: usize) -> Option<(Symbol, Range<usize>)> {
        if let Some(found) = self.occurrence(offset) {
            return Some((found.symbol.clone(), found.range.clone()));
        }
        let (name, range) = context::name_at(self.text(), offset)?;
        let called = self.text()[range.end..].trim_start_matches([' ', '\t']).starts_with('(');
        let around = self.function_around(offset);
        let local = around.filter(|f| occurrences::locals(f).contains(name.as_str()));
        let symbol = match local {
            _ if called => Symbol::Function(name),
            Some(f) => Symbol::Local { function: f.name.text.clone(), name },
            None => Symbol::Outer(name),
        };
        Some((symbol, range))
    }
}
