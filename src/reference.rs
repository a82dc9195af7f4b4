//! Every function of the language, those of the table and those of the library, as the reference shows them.

use crate::builtin::reference::{self, Entry};
use crate::resolve::library_entries;

/// Every function, built-in or of the library, in the order of the documentation.
pub fn entries() -> Vec<Entry> {
    let mut all = reference::entries();
    all.extend(library_entries().map(|e| Entry {
        group: group(e.file),
        name: e.name.clone(),
        signature: e.signature.clone(),
        brief: e.brief.clone(),
        doc: e.doc.clone(),
        examples: e.examples.clone(),
    }));
    all
}

/// `library/waves.pse` as a heading.
fn group(file: &str) -> String {
    let stem = file.trim_start_matches("library/").trim_end_matches(".pse");
    format!("Library: {}", stem.replace('_', " "))
}
