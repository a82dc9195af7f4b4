//! A message in lines of plain text: what is wrong, each place with its line of the source, and the hints.

use super::super::{Diagnostic, Severity, Sources, Style};
use super::short;
use crate::visible::{visible, visible_name};
use std::fmt::Write;

/// Characters of a source line that are shown.
const MAX_LINE: usize = 200;

pub(super) fn excerpts(d: &Diagnostic, sources: &Sources, _: Style) -> String {
    let mut text = String::new();
    let severity = match d.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    };
    // Writing to a string cannot fail.
    let _ = write!(text, "{severity}: {}", short(&d.message));
    if let Some([column, row]) = d.pixel {
        let _ = write!(text, " (at pixel [{column} {row}])");
    }
    text.push('\n');
    for label in &d.labels {
        let (line, column) = sources.line_column(label.span);
        let source = sources.get(label.span.source);
        let _ = writeln!(text, "  at {}:{line}:{column} {}", visible_name(&source.name), short(&label.text));
        let shown: String =
            source.text.lines().nth(line - 1).unwrap_or_default().chars().take(MAX_LINE).collect();
        let _ = writeln!(text, "    {}", visible(&shown));
    }
    for hint in &d.hints {
        let _ = writeln!(text, "  help: {}", short(hint));
    }
    text
}

#[cfg(test)]
mod tests {
    use crate::program::Program;

    #[test]
    fn the_place_and_the_hints_are_there() {
        let error = Program::compile("color = nosie(point)").unwrap_err();
        let text = error.to_string();
        for part in ["error: ", "1:9", "color = nosie(point)", "help: "] {
            assert!(text.contains(part), "{part} in {text}");
        }
    }
}
