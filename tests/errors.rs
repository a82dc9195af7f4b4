//! What a user reads after a mistake: every program below `tests/errors/` is wrong in the way its file name says,
//! and stands beside the messages that it gets. The folders are the stages that find the fault.
//!
//! After a change on purpose, rewrite the messages with `INSTA_UPDATE=always cargo test --test errors`, and read them.

use pse::diagnostic::{Diagnostic, Sources, Style};
use pse::syntax;
use std::path::Path;

/// Snapshots the messages of every program in a folder; `check` gives the errors of one.
fn messages(folder: &str, check: fn(&mut Sources, &str, &str) -> Vec<Diagnostic>) {
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/errors").join(folder));
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.remove_input_file();
    settings.bind(|| {
        let mut files: Vec<_> = std::fs::read_dir(Path::new("tests/errors").join(folder))
            .expect("the folder is there")
            .map(|entry| entry.expect("an entry can be read").path())
            .filter(|path| path.extension().is_some_and(|e| e == "pse"))
            .collect();
        files.sort();
        assert!(!files.is_empty());
        let mut changed = Vec::new();
        for path in files {
            let name = path.file_name().expect("a file").to_string_lossy().into_owned();
            let text = std::fs::read_to_string(&path).expect("the file can be read");
            let mut sources = Sources::default();
            let errors = check(&mut sources, &name, &text);
            assert!(!errors.is_empty(), "{name} has no error");
            let rendered: Vec<String> = errors.iter().map(|e| e.render(&sources, Style::PLAIN)).collect();
            let stem = name.trim_end_matches(".pse");
            let same = std::panic::catch_unwind(|| insta::assert_snapshot!(stem, rendered.join("\n")));
            if same.is_err() {
                changed.push(name);
            }
        }
        assert!(changed.is_empty(), "the messages changed: {changed:?}");
    });
}

fn parse_errors(sources: &mut Sources, name: &str, text: &str) -> Vec<Diagnostic> {
    let source = sources.add(name, text);
    syntax::parse(source, text).errors
}

#[test]
fn lex() {
    messages("lex", parse_errors);
}

#[test]
fn parse() {
    messages("parse", parse_errors);
}
