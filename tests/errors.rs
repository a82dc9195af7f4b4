//! What a user reads after a mistake: every program below `tests/errors/` is wrong in the way its file name says,
//! and stands beside the messages that it gets. The folders are the stages that find the fault.
//!
//! After a change on purpose, rewrite the messages with `INSTA_UPDATE=always cargo test --test errors`, and read them.

use pse::diagnostic::{Diagnostic, Sources, Style};
use pse::syntax;

/// Snapshots the messages of every program in a folder; `check` gives the errors of one.
fn messages(folder: &str, check: fn(&mut Sources, &str, &str) -> Vec<Diagnostic>) {
    insta::glob!("errors", &format!("{folder}/*.pse"), |path| {
        let name = path.file_name().expect("a file").to_string_lossy();
        let text = std::fs::read_to_string(path).expect("the file can be read");
        let mut sources = Sources::default();
        let errors = check(&mut sources, &name, &text);
        assert!(!errors.is_empty(), "{name} has no error");
        let rendered: Vec<String> = errors.iter().map(|e| e.render(&sources, Style::PLAIN)).collect();
        let mut settings = insta::Settings::clone_current();
        settings.set_snapshot_path(path.parent().expect("a folder"));
        settings.set_prepend_module_to_snapshot(false);
        settings.set_omit_expression(true);
        settings.remove_snapshot_suffix();
        settings.remove_input_file();
        settings.bind(|| insta::assert_snapshot!(name.trim_end_matches(".pse"), rendered.join("\n")));
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
