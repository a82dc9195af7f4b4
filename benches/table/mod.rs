//! Tables in documents, out of what criterion measured.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// Are the documents to be written? `UPDATE=1 cargo bench`
pub fn updating() -> bool {
    std::env::var_os("UPDATE").is_some_and(|value| value == "1")
}

/// The median of a benchmark's last run, in nanoseconds; none if it never ran.
pub fn median(group: &str, function: &str) -> Option<f64> {
    // Criterion replaces what file names may not have.
    let safe = |name: &str| name.replace(['?', '"', '/', '\\', '*', '<', '>', ':', '|', '^'], "_");
    let path = measured().join(safe(group)).join(safe(function)).join("new/estimates.json");
    let estimates: Value = serde_json::from_slice(&fs::read(path).ok()?).ok()?;
    estimates["median"]["point_estimate"].as_f64()
}

/// Where criterion keeps its measurements: beside what cargo built, this program with it.
fn measured() -> PathBuf {
    if let Some(home) = std::env::var_os("CRITERION_HOME") {
        return home.into();
    }
    let program = std::env::current_exe().unwrap_or_default();
    let beside = program.ancestors().map(|folder| folder.join("criterion")).find(|folder| folder.is_dir());
    beside.unwrap_or_else(|| "target/criterion".into())
}

/// A table in Markdown.
pub fn markdown<H: AsRef<str>, R: AsRef<str>>(header: &[H], rows: &[Vec<R>]) -> String {
    let header: Vec<&str> = header.iter().map(AsRef::as_ref).collect();
    let mut text = format!("| {} |\n|{}\n", header.join(" | "), "---|".repeat(header.len()));
    for row in rows {
        let cells: Vec<&str> = row.iter().map(AsRef::as_ref).collect();
        text.push_str(&format!("| {} |\n", cells.join(" | ")));
    }
    text
}

/// Puts text between the lines `<!-- NAME begin -->` and `<!-- NAME end -->` of a document.
///
/// # Panics
/// If the document can't be read or written, or has no such lines.
pub fn replace(document: &str, name: &str, text: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(document);
    let old = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let (begin, end) = (format!("<!-- {name} begin -->\n"), format!("<!-- {name} end -->"));
    let parts = old.split_once(&begin).and_then(|(before, rest)| Some((before, rest.split_once(&end)?.1)));
    let (before, after) = parts.unwrap_or_else(|| panic!("{document} has no place called {name}"));
    let text = text.trim_end();
    // Blank lines, or Markdown would not see a table between comments.
    fs::write(&path, format!("{before}{begin}\n{text}\n\n{end}{after}"))
        .unwrap_or_else(|e| panic!("{}: {e}", path.display()));
}
