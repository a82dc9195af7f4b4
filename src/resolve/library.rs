//! The standard library, written in the language itself: `src/library/*.pse`, compiled in.
//!
//! A function's documentation is the comment right above it, in the form of [`Comment`].

use crate::diagnostic::{SourceId, Sources};
use crate::syntax::{self, ast};
use std::collections::HashMap;
use std::sync::LazyLock;

/// A function of the library.
pub struct Entry {
    /// Its name.
    pub name: String,
    /// As a call is written.
    pub signature: String,
    /// Its parameters, with their defaults as they are written.
    pub params: Vec<(String, Option<String>)>,
    /// What it does, in one line.
    pub brief: String,
    /// More of it, in Markdown.
    pub doc: String,
    /// Expressions, each with an expression of the same value.
    pub examples: Vec<(String, String)>,
    /// The file, which is its group: `library/waves.pse`.
    pub file: &'static str,
    /// Its tree, with spans that belong to no program's sources.
    pub(super) function: ast::Function,
}

/// The files, in the order of the documentation.
static FILES: &[(&str, &str)] = &[
    ("library/colors.pse", include_str!("../library/colors.pse")),
    ("library/waves.pse", include_str!("../library/waves.pse")),
    ("library/light.pse", include_str!("../library/light.pse")),
    ("library/noises.pse", include_str!("../library/noises.pse")),
    ("library/shading.pse", include_str!("../library/shading.pse")),
    ("library/patterns.pse", include_str!("../library/patterns.pse")),
    ("library/stones.pse", include_str!("../library/stones.pse")),
    ("library/woods.pse", include_str!("../library/woods.pse")),
    ("library/skies.pse", include_str!("../library/skies.pse")),
    ("library/planets.pse", include_str!("../library/planets.pse")),
    ("library/fires.pse", include_str!("../library/fires.pse")),
    ("library/films.pse", include_str!("../library/films.pse")),
];

static ENTRIES: LazyLock<Vec<Entry>> = LazyLock::new(|| {
    FILES
        .iter()
        .flat_map(|(file, text)| {
            let parsed = syntax::parse(SourceId::default(), text);
            parsed.module.body.into_iter().filter_map(|stmt| match stmt.kind {
                ast::StmtKind::Function(function) => Some(entry(file, text, function)),
                _ => None,
            })
        })
        .collect()
});

static BY_NAME: LazyLock<HashMap<&'static str, &'static Entry>> =
    LazyLock::new(|| entries().map(|e| (e.name.as_str(), e)).collect());

/// Every function of the library.
pub fn entries() -> impl Iterator<Item = &'static Entry> {
    ENTRIES.iter()
}

/// The function of that name.
pub(super) fn find(name: &str) -> Option<&'static Entry> {
    BY_NAME.get(name).copied()
}

/// The library's file among a program's texts.
pub(super) fn source(sources: &mut Sources, entry: &Entry) -> SourceId {
    let text = FILES.iter().find(|(file, _)| *file == entry.file).map_or("", |(_, text)| text);
    sources.find(entry.file).unwrap_or_else(|| sources.add(entry.file, text))
}

/// The function's tree with spans in the given text.
pub(super) fn function(entry: &Entry, source: SourceId) -> ast::Function {
    let mut function = entry.function.clone();
    syntax::set_source(&mut function, source);
    function
}

fn entry(file: &'static str, text: &str, function: ast::Function) -> Entry {
    let comment = Comment::above(text, function.name.span.start as usize);
    Entry {
        name: function.name.text.clone(),
        signature: syntax::signature(&function, text),
        params: syntax::parameters(&function, text),
        brief: comment.brief,
        doc: comment.doc,
        examples: comment.examples,
        file,
        function,
    }
}

/// What a comment above a definition tells: lines of what it does, after an empty `#` more of it, and examples as
/// `#: expression -> value`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comment {
    /// What it does, in one line.
    pub brief: String,
    /// More of it, in Markdown.
    pub doc: String,
    /// Expressions, each with an expression of the same value.
    pub examples: Vec<(String, String)>,
}

impl Comment {
    /// The comment right above the line of byte `start`.
    pub fn above(text: &str, start: usize) -> Comment {
        let before = text.get(..start).unwrap_or("");
        let line = before.rfind('\n').map_or(0, |i| i + 1);
        let mut comment: Vec<&str> =
            text[..line].lines().rev().take_while(|l| l.starts_with('#')).map(|l| &l[1..]).collect();
        comment.reverse();
        let (examples, prose): (Vec<&str>, Vec<&str>) = comment.into_iter().partition(|l| l.starts_with(':'));
        let prose: Vec<&str> = prose.into_iter().map(|l| l.strip_prefix(' ').unwrap_or(l)).collect();
        let split = prose.iter().position(|l| l.is_empty()).unwrap_or(prose.len());
        let examples = examples.into_iter().filter_map(|l| l[1..].split_once("->"));
        Comment {
            brief: prose[..split].join(" "),
            doc: prose[split..].join("\n").trim().to_string(),
            examples: examples.map(|(a, b)| (a.trim().to_string(), b.trim().to_string())).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_parses_and_every_function_is_documented() {
        for (file, text) in FILES {
            let parsed = syntax::parse(SourceId::default(), text);
            assert!(parsed.errors.is_empty(), "{file}: {:?}", parsed.errors);
        }
        for entry in entries() {
            assert!(!entry.brief.is_empty(), "{} has no documentation", entry.name);
            assert!(!entry.examples.is_empty(), "{} has no example", entry.name);
        }
    }
}
