//! What a name means, in words.

use super::context::{Place, context};
use super::function::{Function, Origin, Parameter, Takes, card};
use super::{Reading, Symbol};
use crate::reference;
use crate::resolve::{Comment, names};
use crate::syntax::{Token, lex};
use std::ops::Range;

/// What is to be said of a word.
#[derive(Clone, Debug, PartialEq)]
pub struct Described {
    /// The word's bytes.
    pub range: Range<usize>,
    /// Markdown.
    pub text: String,
}

impl Reading {
    /// What the word at a byte means; `None` where there is nothing to say.
    pub fn describe(&self, offset: usize) -> Option<Described> {
        let text = self.text();
        let lexemes = lex(text);
        let at = |l: &crate::syntax::Lexeme| l.start <= offset && offset <= l.end;
        let word = lexemes.iter().find(|l| at(l) && (l.token == Token::Name || l.token.is_keyword()));
        if let Some(string) =
            lexemes.iter().find(|l| l.token == Token::Text && l.start < offset && offset < l.end)
        {
            let inside = context(text, string.end - 1);
            let call = inside.call.filter(|_| inside.place == Place::Text)?;
            let function = self.function(&call.name)?;
            let param = function.parameter(call.position, call.named.as_deref())?;
            return Some(Described {
                range: string.start..string.end,
                text: about_parameter(&function, param),
            });
        }
        let word = word?;
        let range = word.start..word.end;
        if word.token.is_keyword() {
            let (keyword, brief) = reference::KEYWORDS.iter().find(|k| k.0 == &text[range.clone()])?;
            return Some(Described { range, text: format!("`{keyword}`\n\n{brief}") });
        }
        if self.occurrence(offset).is_none() && text[..word.start].ends_with('.') {
            let component = names::component(&text[range.clone()])?;
            return Some(Described { range, text: format!("Element {} of the vector.", component + 1) });
        }
        let (symbol, range) = self.symbol(offset)?;
        Some(Described { range, text: self.about(&symbol)? })
    }

    /// What a symbol is, as Markdown.
    pub fn about(&self, symbol: &Symbol) -> Option<String> {
        match symbol {
            Symbol::Function(name) => {
                let function = self.function(name)?;
                let text = card(&function.entry);
                Some(match function.origin {
                    Origin::Program(span) if span.source.0 > 0 => {
                        format!("{text}\n\nFrom `{}`.", self.sources.get(span.source).name)
                    }
                    _ => text,
                })
            }
            Symbol::Local { function, name } => {
                let whole = self.function(function)?;
                Some(match whole.params.iter().find(|p| p.name == *name) {
                    Some(param) => about_parameter(&whole, param),
                    None => format!("`{name}`\n\nA variable of the function `{function}()`."),
                })
            }
            Symbol::Outer(name) => self.about_variable(name),
        }
    }

    fn about_variable(&self, name: &str) -> Option<String> {
        if let Some((stmt, own)) = self.param(name) {
            let source = self.sources.get(own.span.source);
            let comment = Comment::above(&source.text, own.span.start as usize);
            let line = self.sources.text(stmt.span);
            let said = [comment.brief, comment.doc].join("\n\n");
            return Some(
                format!("```pse\n{line}\n```\nA param: one value for the frame, set from outside.\n\n{said}")
                    .trim_end()
                    .to_string(),
            );
        }
        let mut said = Vec::new();
        let assigned = self.definition(&Symbol::Outer(name.to_string())).is_some();
        if self.written.iter().any(|(output, _)| output == name) {
            said.push("An output: the program writes it.".to_string());
        } else if assigned {
            said.push("A variable of the program.".to_string());
        }
        let groups = reference::names();
        let standard = groups.iter().find_map(|(title, lines)| {
            lines.iter().find(|(known, _)| *known == name).map(|(_, brief)| (*title, brief))
        });
        match standard {
            Some((title, brief)) if assigned => {
                said.push(format!("Before it is assigned: {brief} ({title})."))
            }
            Some((title, brief)) => said.push(format!("{}. ({title})", sentence(brief))),
            None if assigned => {}
            None => match name.split_once('.') {
                Some((image, variable)) => {
                    said.push(format!("The variable `{variable}` of the image called `{image}`."));
                }
                None if self.function(name).is_some() => {
                    return self.about(&Symbol::Function(name.to_string()));
                }
                None => said.push("The program does not assign it: the image must have it.".to_string()),
            },
        }
        Some(format!("`{name}`\n\n{}", said.join(" ")))
    }
}

impl Function {
    /// The parameter that an argument is for: the one of that name, or the one at that position.
    pub fn parameter(&self, position: usize, named: Option<&str>) -> Option<&Parameter> {
        match named {
            Some(name) => self.params.iter().find(|p| p.name == name),
            None if self.rest => self.params.get(position).or(self.params.last()),
            None => self.params.get(position),
        }
    }
}

/// A parameter, what it takes and what it is if not given.
pub(super) fn about_parameter(function: &Function, param: &Parameter) -> String {
    let mut text = format!("`{}`\n\nA parameter of `{}`.", param.name, function.entry.signature);
    match (param.takes, &param.default) {
        (Takes::Choice(of), _) => {
            let words: Vec<String> = of.iter().map(|word| format!("`\"{word}\"`")).collect();
            text += &format!(" One of {}; the first is the default.", words.join(", "));
        }
        (_, Some(default)) if default == "[]" || default == "\"\"" => text += " Optional.",
        (_, Some(default)) => text += &format!(" Default: `{default}`."),
        (_, None) => {}
    }
    if !function.entry.brief.is_empty() {
        text += &format!("\n\n{}", function.entry.brief);
    }
    text
}

/// With a capital letter at its start.
fn sentence(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or(String::new(), |first| first.to_uppercase().chain(chars).collect())
}
