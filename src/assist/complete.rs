//! What may come at a place.

use super::context::{Context, Place, context};
use super::describe::about_parameter;
use super::function::{Function, Takes, all_standard, card};
use super::{Reading, Role, Symbol, occurrences};
use crate::diagnostic::SourceId;
use crate::host::Host;
use crate::reference;
use crate::resolve::print;
use std::collections::BTreeSet;
use std::ops::Range;

/// What an [`Item`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A function.
    Function,
    /// A variable of the program or of the function around.
    Variable,
    /// A param.
    Param,
    /// A constant.
    Constant,
    /// What the system provides, or an image.
    Input,
    /// A word of the language.
    Keyword,
    /// The name of an argument, to be followed by ` = `.
    Argument,
    /// A word inside of a string.
    Choice,
}

/// Something that may be written.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// The word.
    pub name: String,
    /// What it is.
    pub kind: Kind,
    /// A function's signature, or a few words.
    pub detail: String,
    /// What it means, in Markdown; may be empty.
    pub documentation: String,
}

/// All that may come at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Completion {
    /// The part of a word that is there already.
    pub word: Range<usize>,
    /// In the order of usefulness.
    pub items: Vec<Item>,
}

fn item(name: &str, kind: Kind, detail: &str, documentation: String) -> Item {
    Item { name: name.to_string(), kind, detail: detail.to_string(), documentation }
}

impl Reading {
    /// What may come at a byte. `host` knows the images that a string may name.
    pub fn complete(&self, offset: usize, host: &dyn Host) -> Completion {
        let around = context(self.text(), offset);
        let mut items = Vec::new();
        match &around.place {
            Place::Nothing | Place::Path => {}
            Place::Else => items.extend(keywords(&["if"])),
            Place::Text => self.texts(&around, host, &mut items),
            Place::Member(base) => self.members(base, offset, &mut items),
            Place::Statement => {
                self.variables(offset, &mut items);
                let starts: Vec<&str> =
                    reference::KEYWORDS.iter().map(|k| k.0).filter(|k| *k != "in").collect();
                items.extend(keywords(&starts));
                self.functions(&mut items);
            }
            Place::Value { header } => {
                if around.argument {
                    self.arguments(&around, &mut items);
                }
                if *header {
                    items.extend(keywords(&["in"]));
                }
                self.variables(offset, &mut items);
                self.functions(&mut items);
            }
        }
        // What comes first hides what comes later: a variable of the function the one outside.
        let mut seen = BTreeSet::new();
        items.retain(|item| {
            seen.insert((item.name.clone(), matches!(item.kind, Kind::Function | Kind::Argument)))
        });
        Completion { word: around.word, items }
    }

    /// The names of arguments that are not given yet.
    fn arguments(&self, around: &Context, items: &mut Vec<Item>) {
        let Some(call) = &around.call else { return };
        let Some(function) = self.function(&call.name) else { return };
        for (i, param) in function.params.iter().enumerate() {
            let open = i >= call.position && !call.given.contains(&param.name);
            if open && !(function.rest && i + 1 == function.params.len()) {
                let detail = match &param.default {
                    Some(default) => format!("{} = {default}", param.name),
                    None => param.name.clone(),
                };
                items.push(item(&param.name, Kind::Argument, &detail, about_parameter(&function, param)));
            }
        }
    }

    /// What may stand in a string.
    fn texts(&self, around: &Context, host: &dyn Host, items: &mut Vec<Item>) {
        let Some(call) = &around.call else { return };
        let Some(function) = self.function(&call.name) else { return };
        let takes = function.parameter(call.position, call.named.as_deref()).map(|p| (p, p.takes));
        if crate::resolve::names_space(&call.name) {
            for (name, brief) in reference::SPACES {
                items.push(item(name, Kind::Choice, brief, String::new()));
            }
        }
        match takes {
            Some((param, Takes::Choice(of))) => {
                let choices = of
                    .iter()
                    .map(|word| item(word, Kind::Choice, &param.name, about_parameter(&function, param)));
                items.extend(choices);
            }
            Some((_, Takes::Text)) => {
                let program = &self.sources.get(SourceId::default()).name;
                let written = &self.text()[around.word.clone()];
                let images = host.images(program, written);
                items.extend(images.iter().map(|name| item(name, Kind::Choice, "image", String::new())));
            }
            _ => {}
        }
    }

    /// What may stand behind a dot.
    fn members(&self, base: &str, offset: usize, items: &mut Vec<Item>) {
        let around = self.function_around(offset);
        let local = around.is_some_and(|f| occurrences::locals(f).contains(base));
        let outer = Symbol::Outer(base.to_string());
        let standard =
            reference::names().iter().any(|(_, lines)| lines.iter().any(|(name, _)| *name == base));
        if !(local || standard || base.is_empty() || self.definition(&outer).is_some()) {
            // A named image.
            items.extend(inputs());
        }
        let of_image = self.inputs.iter().filter_map(|name| name.strip_prefix(base)?.strip_prefix('.'));
        items.extend(of_image.map(|name| item(name, Kind::Input, "input", String::new())));
        for (i, pair) in ["xr", "yg", "zb", "wa"].iter().enumerate() {
            for letter in pair.split("").filter(|l| !l.is_empty()) {
                items.push(item(letter, Kind::Variable, &format!("element {}", i + 1), String::new()));
            }
        }
    }

    /// Variables, nearest first.
    fn variables(&self, offset: usize, items: &mut Vec<Item>) {
        let word = context(self.text(), offset).word;
        if let Some(function) = self.function_around(offset) {
            let mut own: Vec<&str> = occurrences::locals(function).into_iter().collect();
            own.sort_unstable();
            for name in own {
                let symbol = Symbol::Local { function: function.name.text.clone(), name: name.to_string() };
                items.push(item(
                    name,
                    Kind::Variable,
                    "local variable",
                    self.about(&symbol).unwrap_or_default(),
                ));
            }
        }
        for stmt in self.outer() {
            if let crate::syntax::ast::StmtKind::Param { name, .. } = &stmt.kind {
                let line = self.sources.text(stmt.span);
                let about = self.about(&Symbol::Outer(name.text.clone())).unwrap_or_default();
                items.push(item(&name.text, Kind::Param, line, about));
            }
        }
        let written = self.occurrences.iter().filter(|o| o.role == Role::Write && o.range != word);
        let names: BTreeSet<&str> = written
            .filter_map(|o| match &o.symbol {
                Symbol::Outer(name) => Some(name.as_str()),
                _ => None,
            })
            .collect();
        for name in names {
            let about = self.about(&Symbol::Outer(name.to_string())).unwrap_or_default();
            items.push(item(name, Kind::Variable, "variable", about));
        }
        items.extend(self.inputs.iter().map(|name| item(name, Kind::Input, "input", String::new())));
        items.extend(inputs());
    }

    fn functions(&self, items: &mut Vec<Item>) {
        let named = |f: &Function| item(&f.entry.name, Kind::Function, &f.entry.signature, card(&f.entry));
        items.extend(self.own_functions().map(|f| named(&f)));
        items.extend(all_standard().map(named));
    }
}

fn keywords(wanted: &[&str]) -> Vec<Item> {
    let fitting = reference::KEYWORDS.iter().filter(|k| wanted.contains(&k.0));
    fitting
        .map(|(name, brief)| item(name, Kind::Keyword, "word of the language", brief.to_string()))
        .collect()
}

/// What every program can read.
fn inputs() -> Vec<Item> {
    let groups = reference::names();
    // A statement that is written as a call is with the functions.
    let read = groups.iter().filter(|(_, lines)| lines.iter().all(|(name, _)| *name != print::NAME));
    let all = read.flat_map(|(title, lines)| {
        let kind = if *title == "Constants" { Kind::Constant } else { Kind::Input };
        lines.iter().map(move |(name, brief)| item(name, kind, title, brief.clone()))
    });
    all.collect()
}
