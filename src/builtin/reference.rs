//! The reference of functions, made from their tables: `docs/builtins.md`, and `pse doc NAME` in the terminal.
//!
//! It takes [`Entry`]s, so that functions written in the language itself are listed with the built-in ones.

use super::GROUPS;
use std::fmt::Write;

/// A function as the reference shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The heading that it stands under.
    pub group: String,
    /// Its name in programs.
    pub name: String,
    /// As a call is written, with defaults.
    pub signature: String,
    /// What it does, in one line.
    pub brief: String,
    /// More of it, in Markdown; may be empty.
    pub doc: String,
    /// Expressions, each with one that has the same value.
    pub examples: Vec<(String, String)>,
}

/// The built-in functions, in the order of the documentation.
pub fn entries() -> Vec<Entry> {
    let of_group = |group: &'static super::Group| {
        group.functions.iter().map(|b| Entry {
            group: group.title.to_string(),
            name: b.name.to_string(),
            signature: b.signature(),
            brief: b.brief.to_string(),
            doc: b.doc.to_string(),
            examples: b.examples.iter().map(|e| (e.code.to_string(), e.gives.to_string())).collect(),
        })
    };
    GROUPS.iter().flat_map(of_group).collect()
}

/// The groups of some entries, each where it first appears, with its entries.
fn groups(entries: &[Entry]) -> Vec<(&str, Vec<&Entry>)> {
    let mut groups: Vec<(&str, Vec<&Entry>)> = Vec::new();
    for entry in entries {
        match groups.iter_mut().find(|(title, _)| *title == entry.group) {
            Some((_, members)) => members.push(entry),
            None => groups.push((&entry.group, vec![entry])),
        }
    }
    groups
}

/// The whole reference in Markdown: a table of contents, then each function by group.
pub fn markdown(entries: &[Entry]) -> String {
    let mut text = String::from(
        "# Functions\n\n\
         Made by `pse doc --markdown` from the tables of functions; not to be edited by hand.\n\n\
         Where nothing else is said, a function works on scalars and on vectors of any depth, component by component;\n\
         a scalar meets a vector by being used with each of its components. Functions of vectors, such as `norm`, are\n\
         applied to each element of a vector of vectors. Arguments are given by position or by name.\n\n",
    );
    let groups = groups(entries);
    for (title, members) in &groups {
        let links: Vec<String> = members.iter().map(|e| format!("[{0}](#{0})", e.name)).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "- **{title}**: {}", links.join(" · "));
    }
    for (title, members) in &groups {
        let _ = write!(text, "\n## {title}\n");
        for entry in members {
            let _ = write!(
                text,
                "\n<a id=\"{0}\"></a>\n### {0}\n\n```\n{1}\n```\n\n{2}\n",
                entry.name, entry.signature, entry.brief
            );
            if !entry.doc.is_empty() {
                let _ = write!(text, "\n{}\n", entry.doc);
            }
            text.push_str("\n```\n");
            text.push_str(&examples(entry));
            text.push_str("```\n");
        }
    }
    text
}

/// The examples, one a line, with their values in a column of comments.
fn examples(entry: &Entry) -> String {
    let width = entry.examples.iter().map(|(code, _)| code.chars().count()).max().unwrap_or(0);
    entry.examples.iter().map(|(code, gives)| format!("{code:width$}  # {gives}\n")).collect()
}

/// One function for the terminal: plain text, its lines no longer than 80 columns where they can be broken.
pub fn describe(entry: &Entry) -> String {
    let mut text = format!("{}\n\n", entry.signature);
    text.push_str(&wrap(&entry.brief));
    if !entry.doc.is_empty() {
        text.push('\n');
        text.push_str(&paragraph(&entry.doc));
    }
    text.push('\n');
    for line in examples(entry).lines() {
        let _ = writeln!(text, "    {line}");
    }
    text
}

/// A paragraph of Markdown for the terminal.
pub fn paragraph(markdown: &str) -> String {
    wrap(&plain(markdown))
}

/// One function for an editor, in Markdown.
pub fn card(entry: &Entry) -> String {
    let mut text = format!("```pse\n{}\n```", entry.signature);
    for part in [&entry.brief, &unlinked(&entry.doc)] {
        if !part.is_empty() {
            let _ = write!(text, "\n\n{part}");
        }
    }
    if !entry.examples.is_empty() {
        let _ = write!(text, "\n\n```pse\n{}```", examples(entry));
    }
    text
}

/// Markdown whose links within the documentation are cut down to their words.
fn unlinked(markdown: &str) -> String {
    let mut parts = markdown.split("](");
    let mut text = parts.next().unwrap_or("").to_string();
    for part in parts {
        match (text.rfind('['), part.split_once(')')) {
            (Some(open), Some((target, rest))) if target.starts_with('#') || target.contains(".md") => {
                text.remove(open);
                text += rest;
            }
            _ => text = text + "](" + part,
        }
    }
    text
}

/// Markdown without its marks: emphasis, code, and links cut down to their words.
fn plain(markdown: &str) -> String {
    let mut text = String::new();
    let mut rest = markdown;
    while let Some(at) = rest.find(['`', '*', '[']) {
        text.push_str(&rest[..at]);
        let (mark, after) = rest[at..].split_at(1);
        rest = after;
        let link = after.split_once("](#").and_then(|(words, tail)| Some((words, tail.split_once(')')?.1)));
        match (mark, link) {
            ("`", _) => {
                // Code stands as it is: a star in it multiplies.
                let (code, after) = rest.split_once('`').unwrap_or((rest, ""));
                text.push_str(code);
                rest = after;
            }
            ("[", Some((words, after))) if !words.contains(['[', ']']) => {
                text.push_str(words);
                rest = after;
            }
            ("[", _) => text.push('['),
            _ => {}
        }
    }
    text + rest
}

/// The paragraph broken into lines of 80 columns.
fn wrap(paragraph: &str) -> String {
    let mut text = String::new();
    let mut column = 0;
    for word in paragraph.split_whitespace() {
        let width = word.chars().count();
        if column > 0 && column + 1 + width > 80 {
            text.push('\n');
            column = 0;
        } else if column > 0 {
            text.push(' ');
            column += 1;
        }
        text.push_str(word);
        column += width;
    }
    text.push('\n');
    text
}

#[cfg(test)]
mod tests {
    use super::super::all;
    use super::*;

    #[test]
    fn every_function_is_in_the_contents_and_every_link_leads_somewhere() {
        let text = markdown(&entries());
        for b in all() {
            assert!(text.contains(&format!("[{0}](#{0})", b.name)), "{} is not listed", b.name);
        }
        for link in text.split("](#").skip(1) {
            let target = link.split(')').next().unwrap();
            assert!(super::super::find(target).is_some(), "a link to {target}");
        }
    }

    #[test]
    fn a_description_is_plain_text() {
        let entry = Entry {
            group: "G".into(),
            name: "twice".into(),
            signature: "twice(x)".into(),
            brief: "Two times x.".into(),
            doc: "It is `x * 2`, as *everyone* knows; see [sum](#sum), `[a b]`.".into(),
            examples: vec![("twice(2)".into(), "4".into()), ("twice([1 2])".into(), "[2 4]".into())],
        };
        let expected = "twice(x)\n\nTwo times x.\n\nIt is x * 2, as everyone knows; see sum, [a b].\n\n    \
                        twice(2)      # 4\n    twice([1 2])  # [2 4]\n";
        assert_eq!(describe(&entry), expected);
    }

    #[test]
    fn a_card_has_no_links() {
        for entry in entries() {
            let text = card(&entry);
            assert!(!text.contains("](#") && text.contains(&entry.brief), "{text}");
        }
        assert_eq!(
            unlinked("see [sum](#sum), [a b](a.md), `[1 2]`, [c](d)"),
            "see sum, a b, `[1 2]`, [c](d)"
        );
    }
}
