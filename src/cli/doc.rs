//! `pse doc`: the reference in the terminal.

use super::failure::{Failure, print};
use clap::Args;
use pse::internal::builtin::reference;
use pse::internal::reference::{entries, names as names_by_group};
use pse::internal::resolve::{names, print as printing};
use pse::internal::vocabulary;
use std::fmt::Write;

/// What to explain.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  pse doc\n  pse doc smoothstep\n  pse doc pixelsize\n  \
                        pse doc --markdown > docs/builtins.md")]
pub(super) struct DocArgs {
    /// A function, constant or other name (default: list all)
    name: Option<String>,
    /// Print the whole reference in Markdown
    #[arg(long, conflicts_with = "name")]
    markdown: bool,
}

/// The whole reference: `docs/builtins.md`.
fn markdown() -> String {
    let mut text = reference::markdown(&entries());
    // Writing to a string cannot fail.
    for (title, lines) in names_by_group() {
        let _ = write!(text, "\n## {title}\n\n| name | what it is |\n|---|---|\n");
        for (name, brief) in lines {
            let _ = writeln!(text, "| `{name}` | {brief} |");
        }
    }
    text
}

/// Prints the explanation, the list, or the whole reference.
pub(super) fn doc(args: &DocArgs) -> Result<(), Failure> {
    match &args.name {
        _ if args.markdown => print(&markdown()),
        Some(name) => explain(name),
        None => print(&list()),
    }
}

fn explain(name: &str) -> Result<(), Failure> {
    print(&text(name)?)
}

/// The explanation of a name.
pub(super) fn text(name: &str) -> Result<String, Failure> {
    // People copy the brackets along.
    let name = name.trim().trim_end_matches("()");
    let entries = entries();
    if let Some(entry) = entries.iter().find(|e| e.name == name) {
        return Ok(reference::describe(entry));
    }
    if name == printing::NAME {
        return Ok(format!(
            "{}\n\n{}\n{}",
            printing::SIGNATURE,
            reference::paragraph(printing::BRIEF),
            reference::paragraph(printing::DOC)
        ));
    }
    let groups = names_by_group();
    let others = || groups.iter().flat_map(|(title, lines)| lines.iter().map(move |l| (*title, l)));
    if let Some((title, (name, brief))) = others().find(|(_, (n, _))| *n == name) {
        return Ok(format!("{name}\n\n{brief}\n({title})\n"));
    }
    let known = entries.iter().map(|e| e.name.as_str()).chain(others().map(|(_, (n, _))| *n));
    let failure = Failure::plain(format!("there is no function or name {name}"));
    if let Some(instead) = vocabulary::function(name) {
        return Err(failure.hint(instead));
    }
    Err(match names::nearest(name, known) {
        Some(near) => failure.hint(format!("Did you mean {near}?")),
        None => failure.hint("pse doc lists them all."),
    })
}

/// All names by group, a line each.
pub(super) fn list() -> String {
    let entries = entries();
    let mut text = String::new();
    let mut last = "";
    for entry in &entries {
        if entry.group != last {
            let gap = if last.is_empty() { "" } else { "\n" };
            let _ = writeln!(text, "{gap}{}", entry.group);
            last = &entry.group;
        }
        line(&mut text, &entry.name, &entry.brief);
    }
    for (title, lines) in names_by_group() {
        let _ = writeln!(text, "\n{title}");
        lines.iter().for_each(|(name, brief)| line(&mut text, name, brief));
    }
    text
}

fn line(text: &mut String, name: &str, brief: &str) {
    let _ = writeln!(text, "  {name:16}  {brief}");
}
