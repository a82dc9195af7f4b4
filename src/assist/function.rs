//! A function as a caller sees it, whoever defines it.

use super::{Reading, context::context};
use crate::builtin::reference::Entry;
use crate::builtin::{self, ParamKind};
use crate::diagnostic::Span;
use crate::reference;
use crate::resolve::{Comment, library_entries, print};
use crate::syntax;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::LazyLock;

pub use crate::builtin::reference::card;

/// Who defines a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The table of built-in functions, or the library.
    Standard,
    /// The program itself or a file that it imports.
    Program(Span),
}

/// What a parameter takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Takes {
    /// A value.
    Value,
    /// A string, one of these.
    Choice(&'static [&'static str]),
    /// A string that names an image or the like.
    Text,
}

/// A parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its default as it is written; `None` if it must be given.
    pub default: Option<String>,
    /// What may be given.
    pub takes: Takes,
    /// Where the signature shows it, in bytes.
    pub place: Range<usize>,
}

/// A function.
#[derive(Clone, Debug)]
pub struct Function {
    /// Its name, signature and documentation.
    pub entry: Entry,
    /// Its parameters in order.
    pub params: Vec<Parameter>,
    /// Does the last one take any number of values?
    pub rest: bool,
    /// Who defines it.
    pub origin: Origin,
}

static STANDARD: LazyLock<HashMap<String, Function>> = LazyLock::new(|| {
    let entries = reference::entries().into_iter();
    let functions = entries.filter_map(|entry| Some((entry.name.clone(), standard(entry)?)));
    functions.chain([(print::NAME.to_string(), printing())]).collect()
});

/// The statement that is written as a call.
fn printing() -> Function {
    let entry = Entry {
        group: String::new(),
        name: print::NAME.to_string(),
        signature: print::SIGNATURE.to_string(),
        brief: print::BRIEF.to_string(),
        doc: print::DOC.to_string(),
        examples: Vec::new(),
    };
    let mut params = parameters(&entry, &[("e".to_string(), None)]);
    params[0].place.end = entry.signature.len() - 1;
    Function { entry, params, rest: true, origin: Origin::Standard }
}

fn standard(entry: Entry) -> Option<Function> {
    let origin = Origin::Standard;
    if let Some(library) = library_entries().find(|e| e.name == entry.name) {
        return Some(Function { params: parameters(&entry, &library.params), rest: false, entry, origin });
    }
    let builtin = builtin::find(&entry.name)?;
    let written: Vec<_> = builtin
        .params
        .iter()
        .map(|p| match p.kind {
            ParamKind::Choice(of) => (p.name.to_string(), Some(format!("\"{}\"", of[0]))),
            _ => (p.name.to_string(), p.default.map(str::to_string)),
        })
        .collect();
    let mut params = parameters(&entry, &written);
    for (param, own) in params.iter_mut().zip(builtin.params) {
        param.takes = match own.kind {
            ParamKind::Choice(of) => Takes::Choice(of),
            ParamKind::Text => Takes::Text,
            ParamKind::Value | ParamKind::Rest(_) => Takes::Value,
        };
    }
    let rest = builtin.params.iter().any(|p| matches!(p.kind, ParamKind::Rest(_)));
    if let Some(last) = params.last_mut().filter(|_| rest) {
        // With its `…`.
        last.place.end = entry.signature.len() - 1;
    }
    Some(Function { entry, params, rest, origin })
}

/// Parameters with their places in the signature. Those that it does not show stand in its `…`.
fn parameters(entry: &Entry, written: &[(String, Option<String>)]) -> Vec<Parameter> {
    let label = &entry.signature;
    let end = label.len().saturating_sub(1);
    let mut at = entry.name.len() + 1;
    let place = |(name, default): &(String, Option<String>)| {
        let shown = match default {
            Some(default) => format!("{name} = {default}"),
            None => name.clone(),
        };
        match label.get(at..).is_some_and(|rest| rest.starts_with(&shown)) {
            true => {
                let place = at..at + shown.len();
                at = place.end + 2;
                place
            }
            false => end.saturating_sub('…'.len_utf8())..end,
        }
    };
    let places: Vec<Range<usize>> = written.iter().map(place).collect();
    let whole = written.iter().zip(places);
    whole
        .map(|((name, default), place)| Parameter {
            name: name.clone(),
            default: default.clone(),
            takes: Takes::Value,
            place,
        })
        .collect()
}

/// All functions of the table and the library, in the order of the documentation, and `print`.
pub(super) fn all_standard() -> impl Iterator<Item = &'static Function> {
    static ORDER: LazyLock<Vec<String>> =
        LazyLock::new(|| reference::entries().into_iter().map(|e| e.name).collect());
    ORDER.iter().map(String::as_str).chain([print::NAME]).filter_map(|name| STANDARD.get(name))
}

impl Reading {
    /// What a call of this name calls.
    pub fn function(&self, name: &str) -> Option<Function> {
        match self.own_function(name) {
            Some(_) => self.own_functions().find(|f| f.entry.name == name),
            None => STANDARD.get(name).cloned(),
        }
    }

    /// The function whose call is open around a byte, and which of its parameters is being written; `None` if it has
    /// no such one.
    pub fn call(&self, offset: usize) -> Option<(Function, Option<usize>)> {
        let call = context(self.text(), offset).call?;
        let function = self.function(&call.name)?;
        let param = function.parameter(call.position, call.named.as_deref()).map(|p| p.name.clone());
        let active = param.and_then(|name| function.params.iter().position(|p| p.name == name));
        Some((function, active))
    }

    /// Is there a function of that name?
    pub fn is_function(&self, name: &str) -> bool {
        self.own_function(name).is_some() || STANDARD.contains_key(name)
    }

    /// The functions of the program and its imports.
    pub(super) fn own_functions(&self) -> impl Iterator<Item = Function> + '_ {
        self.outer().filter_map(|stmt| {
            let syntax::ast::StmtKind::Function(f) = &stmt.kind else { return None };
            let source = self.sources.get(f.name.span.source);
            let comment = Comment::above(&source.text, f.name.span.start as usize);
            let entry = Entry {
                group: source.name.clone(),
                name: f.name.text.clone(),
                signature: syntax::signature(f, &source.text),
                brief: comment.brief,
                doc: comment.doc,
                examples: comment.examples,
            };
            let params = parameters(&entry, &syntax::parameters(f, &source.text));
            Some(Function { entry, params, rest: false, origin: Origin::Program(f.name.span) })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::host::NoFiles;

    #[test]
    fn every_parameter_has_its_place_in_the_signature() {
        for function in all_standard() {
            let label = &function.entry.signature;
            for param in &function.params {
                let shown = &label[param.place.clone()];
                let hidden = shown == "…" && label.ends_with("…)");
                assert!(shown.starts_with(&param.name) || hidden, "{} in {label}: {shown}", param.name);
            }
        }
        assert_eq!(all_standard().count(), reference::entries().len() + 1);
    }

    #[test]
    fn the_programs_own_function_comes_first() {
        let text = "# Less of it.\n#\n# Much less.\nfunction Noise(p, by = [1, 2])\n    return p * by\n";
        let reading = Reading::new("a.pse", text, &NoFiles);
        let function = reading.function("Noise").unwrap();
        assert_eq!(
            (function.entry.brief.as_str(), function.entry.doc.as_str()),
            ("Less of it.", "Much less.")
        );
        assert_eq!(&function.entry.signature[function.params[1].place.clone()], "by = [1, 2]");
    }
}
