//! Text to tree. Only this file and [`super::actions`] know which parser generator is used.

use super::actions::Fault;
use super::ast::Module;
use super::error;
use super::layout::{Comment, Spanned, layout};
use crate::diagnostic::{Diagnostic, SourceId, Span};

/// The parser, generated from `grammar/pse.lalrpop`; a test tells when it is stale and writes it anew.
#[allow(missing_docs, unused, clippy::all, clippy::pedantic)]
#[rustfmt::skip]
#[path = "../../grammar/pse.rs"]
mod grammar;

/// How many errors one run reports.
pub const MAX_ERRORS: usize = 50;

/// How long a program may be, in bytes.
pub const MAX_TEXT: usize = 16 << 20;

/// A text, parsed.
#[derive(Clone, Debug)]
pub struct Parsed {
    /// The tree; where there are errors, of what could be read.
    pub module: Module,
    /// What is wrong, in the order of the text, at most [`MAX_ERRORS`].
    pub errors: Vec<Diagnostic>,
}

/// Parses a whole text. It never fails: what cannot be read is in `errors`, all of it, and left out of the tree.
pub fn parse(source: SourceId, text: &str) -> Parsed {
    let whole = read(source, text);
    Parsed { module: whole.module, errors: whole.errors }
}

/// Whether `text` stops where more must follow: inside a bracket, before the block of its last line, or inside a
/// block that no empty line has ended. An interactive session then asks for another line.
pub fn is_incomplete(text: &str) -> bool {
    let laid = layout(SourceId::default(), text);
    let empty_lines =
        text.lines().rev().take_while(|l| l.trim().is_empty()).count() + usize::from(text.ends_with('\n'));
    laid.incomplete && (empty_lines < 2 || laid.open_bracket) || laid.in_block && empty_lines == 0
}

/// Checks that `name` can be a variable or a function of a program.
///
/// # Errors
/// Why it cannot.
pub fn check_name(name: &str) -> Result<(), String> {
    let parsed = parse(SourceId::default(), &format!("{name} = 1\n"));
    let good = match &parsed.module.body[..] {
        [stmt] => {
            matches!(&stmt.kind, super::ast::StmtKind::Assign { target, .. } if target.name.text == name)
        }
        _ => false,
    };
    match good && parsed.errors.is_empty() {
        true => Ok(()),
        false => Err(format!(
            "`{name}` cannot be a name. A name consists of letters, digits and _, does not start with a digit, and is not a word of the language."
        )),
    }
}

/// A tree with all that the formatter needs beside it.
pub(super) struct Whole {
    pub module: Module,
    pub errors: Vec<Diagnostic>,
    pub tokens: Vec<Spanned>,
    pub comments: Vec<Comment>,
}

/// Parses, and keeps tokens and comments.
pub(super) fn read(source: SourceId, text: &str) -> Whole {
    if text.len() > MAX_TEXT {
        let error = Diagnostic::error(
            "syntax",
            format!("the text is longer than {} MiB", MAX_TEXT >> 20),
            Span::new(source, 0, 0),
        )
        .hint("Put large tables into an image, and read it as a texture.");
        return Whole {
            module: Module::default(),
            errors: vec![error],
            tokens: Vec::new(),
            comments: Vec::new(),
        };
    }
    let mut laid = layout(source, text);
    let mut faults: Vec<Fault> = Vec::new();
    let stream = laid.tokens.iter().map(|&t| Ok(t));
    let module = match grammar::ModuleParser::new().parse(text, source, &mut faults, stream) {
        Ok(module) => module,
        Err(error) => {
            faults.push(Fault::parse(error));
            Module::default()
        }
    };
    let mut errors = std::mem::take(&mut laid.errors);
    faults.sort_by_key(Fault::start);
    for (start, end, error) in laid.blockless {
        let faulty = |f: &Fault| (start..=end).contains(&f.start());
        let first = faults.partition_point(|f| f.start() < start);
        if !faults.get(first).is_some_and(faulty) {
            errors.push(error);
        }
    }
    errors.extend(faults.into_iter().take(MAX_ERRORS).map(|f| error::explain(f, source, text, &laid.tokens)));
    errors.sort_by_key(|e| e.span().map_or(0, |s| s.start));
    errors.truncate(MAX_ERRORS);
    Whole { module, errors, tokens: laid.tokens, comments: laid.comments }
}
