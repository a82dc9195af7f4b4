//! What the entries of the kinds say, put into words: for the terminal, and for `docs/noise.md`.

use super::kind::Kind;
use super::kinds::KINDS;
use super::options::{OPTIONS, Opt};
use std::fmt::Write;

/// A line for each kind: name, dimensions, deviation, smoothness, cost, and what it is.
pub fn list() -> String {
    let head = ["name", "dimensions", "deviation", "smoothness", "cost", "what it is"].map(String::from);
    let line = |kind: &&Kind| {
        let contract = &kind.contract;
        [
            kind.name.to_string(),
            span(*kind.dimensions.start(), *kind.dimensions.end()),
            contract.deviation.to_string(),
            contract.smoothness.to_string(),
            contract.cost.to_string(),
            kind.brief.to_string(),
        ]
    };
    let lines: Vec<[String; 6]> = std::iter::once(head).chain(KINDS.iter().map(line)).collect();
    let width = |column: usize| lines.iter().map(|l| l[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..5).map(width).collect();
    let mut text = String::new();
    for line in &lines {
        for (cell, width) in line.iter().zip(&widths) {
            let _ = write!(text, "{cell:width$}  ");
        }
        let _ = writeln!(text, "{}", line[5]);
    }
    text
}

/// All that is known of a kind, for the terminal.
pub fn describe(kind: &Kind) -> String {
    let mut text = format!("{}: {}\n\n", kind.name, kind.brief);
    for (what, value) in rows(kind) {
        let _ = writeln!(text, "  {what:17}  {value}");
    }
    if kind.options.is_empty() {
        return text + &remarks(kind);
    }
    text.push_str("\n  options\n");
    for option in kind.options {
        let _ = writeln!(text, "    {:15}  {}", option.name(), meaning(*option));
    }
    text + &remarks(kind)
}

fn remarks(kind: &Kind) -> String {
    match kind.contract.remarks {
        "" => String::new(),
        remarks => format!("\n{remarks}\n"),
    }
}

/// All kinds in Markdown: a section each.
pub fn markdown() -> String {
    let mut text = String::new();
    for (i, kind) in KINDS.iter().enumerate() {
        let gap = if i > 0 { "\n" } else { "" };
        let _ = write!(
            text,
            "{gap}<a id=\"{0}\"></a>\n### {0}\n\n{1}.\n\n| | |\n|---|---|\n",
            kind.name,
            sentence(kind.brief)
        );
        for (what, value) in rows(kind) {
            let _ = writeln!(text, "| {what} | {} |", value.replace('|', "\\|"));
        }
        text.push_str(&remarks(kind));
    }
    text
}

/// All options in Markdown: a table of what they mean and which kinds take them.
pub fn options() -> String {
    let mut text = String::from("| option | meaning | kinds |\n|---|---|---|\n");
    for info in &OPTIONS {
        let takers = KINDS.iter().filter(|kind| kind.options.contains(&info.option));
        let takers: Vec<String> = takers.map(|kind| format!("[{0}](#{0})", kind.name)).collect();
        let _ = writeln!(text, "| `{}` | {} | {} |", info.name, meaning(info.option), takers.join(", "));
    }
    text
}

/// The contract, line by line.
fn rows(kind: &Kind) -> Vec<(&'static str, String)> {
    let c = &kind.contract;
    let names: Vec<&str> = kind.options.iter().map(|o| o.name()).collect();
    let names = if names.is_empty() { "none but a seed".to_string() } else { names.join(", ") };
    vec![
        ("dimensions", span(*kind.dimensions.start(), *kind.dimensions.end())),
        ("takes", names),
        ("bounds", bounds(kind)),
        ("mean", c.mean.to_string()),
        ("deviation", c.deviation.to_string()),
        ("at lattice points", c.lattice.to_string()),
        ("smoothness", c.smoothness.to_string()),
        ("cost", format!("{} × gradient", c.cost)),
        ("source", c.source.to_string()),
    ]
}

/// What an option means, with the words that it can be.
fn meaning(option: Opt) -> String {
    let info = &OPTIONS[option as usize];
    match info.choices {
        [] => info.doc.to_string(),
        [first, others @ ..] => format!("{}: {first} (default), {}", info.doc, others.join(", ")),
    }
}

/// From one whole number to another.
fn span(least: usize, most: usize) -> String {
    if least == most { most.to_string() } else { format!("{least} to {most}") }
}

/// The bounds in each number of dimensions; those alike once.
fn bounds(kind: &Kind) -> String {
    let pair = |[least, most]: [f32; 2]| match (least.is_infinite() || most.is_infinite(), least == -most) {
        (true, _) => "none".to_string(),
        (_, true) => format!("±{most}"),
        _ => format!("{least} … {most}"),
    };
    let all = kind.contract.bounds;
    if all.windows(2).all(|w| w[0] == w[1]) {
        return all.first().map_or(String::new(), |b| pair(*b));
    }
    let each = kind.dimensions.clone().zip(all).map(|(d, b)| format!("{} in {d}-D", pair(*b)));
    each.collect::<Vec<_>>().join(", ")
}

/// With a capital.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_told_whole() {
        let (list, markdown) = (list(), markdown());
        for kind in KINDS {
            assert!(list.lines().any(|l| l.starts_with(&format!("{} ", kind.name))), "{list}");
            assert!(markdown.contains(&format!("### {}\n", kind.name)));
            let text = describe(kind);
            assert!(text.starts_with(kind.name) && text.contains(kind.contract.source), "{text}");
            assert!(text.contains(kind.contract.remarks) && markdown.contains(kind.contract.remarks));
            for option in kind.options {
                assert!(text.contains(option.info().doc), "{text}");
            }
        }
        assert!(options().contains("| `period` |") && options().contains("[gradient](#gradient)"));
        let gradient = Kind::from_name("gradient").expect("the kind");
        assert_eq!(bounds(gradient), "±0.75 in 1-D, ±1.5 in 2-D, ±2.25 in 3-D, ±2.5981 in 4-D");
    }
}
