//! Gathers a program's files: the program itself and what it imports, each once.

use crate::diagnostic::{Diagnostic, SourceId, Sources, Span};
use crate::host::Host;
use crate::syntax::{self, MAX_ERRORS, ast};

/// The files of a program, imports first in the order in which they are met.
pub struct Files {
    /// What the imported files bring: functions and params, never their other statements.
    pub imported: Vec<ast::Stmt>,
    /// The program's own statements, without the imports.
    pub body: Vec<ast::Stmt>,
    /// The program's own imports.
    pub imports: Vec<Import>,
}

/// An `import` of the program itself.
#[derive(Clone, Debug)]
pub struct Import {
    /// As it is written.
    pub path: String,
    /// Where the string is.
    pub span: Span,
    /// The text that it brought; `None` if there is none.
    pub file: Option<SourceId>,
}

/// How many imports may lead from one file to the next.
const DEPTH: usize = 32;

/// Parses the program and everything it imports. Errors are collected in `errors`; what could be read is returned.
pub fn gather(
    name: &str,
    text: &str,
    sources: &mut Sources,
    host: &dyn Host,
    errors: &mut Vec<Diagnostic>,
) -> Files {
    let id = sources.add(name, text);
    let parsed = syntax::parse(id, text);
    errors.extend(parsed.errors);
    let mut gatherer =
        Gatherer { sources, host, errors, seen: vec![name.to_string()], missing: 0, imported: Vec::new() };
    let mut body = Vec::new();
    let mut imports = Vec::new();
    for stmt in parsed.module.body {
        match &stmt.kind {
            ast::StmtKind::Import(path, span) => {
                let file = gatherer.import(name, path, *span, 1);
                imports.push(Import { path: path.clone(), span: *span, file });
            }
            _ => body.push(stmt),
        }
    }
    Files { imported: gatherer.imported, body, imports }
}

struct Gatherer<'a> {
    sources: &'a mut Sources,
    host: &'a dyn Host,
    errors: &'a mut Vec<Diagnostic>,
    seen: Vec<String>,
    /// How many imports have failed.
    missing: usize,
    imported: Vec<ast::Stmt>,
}

impl Gatherer<'_> {
    fn import(&mut self, importing: &str, path: &str, span: Span, depth: usize) -> Option<SourceId> {
        if depth > DEPTH {
            let message = format!("imports are nested more than {DEPTH} files deep");
            self.errors.push(Diagnostic::error("import", message, span));
            return None;
        }
        let (name, text) = match self.host.import(importing, path) {
            Ok(found) => found,
            Err(_) if self.missing >= MAX_ERRORS => return None,
            Err(why) => {
                self.missing += 1;
                let error = Diagnostic::error("import", format!("cannot import \"{path}\""), span)
                    .label(span, why.message());
                self.errors.push(self.host.hint().into_iter().fold(error, Diagnostic::hint));
                return None;
            }
        };
        if self.seen.contains(&name) {
            return self.sources.find(&name);
        }
        self.seen.push(name.clone());
        let id = self.sources.add(&name, text.as_str());
        let parsed = syntax::parse(id, &text);
        self.errors.extend(parsed.errors);
        for stmt in parsed.module.body {
            match &stmt.kind {
                ast::StmtKind::Import(path, span) => {
                    self.import(&name, path, *span, depth + 1);
                }
                ast::StmtKind::Function(_) | ast::StmtKind::Param { .. } => self.imported.push(stmt),
                _ => {}
            }
        }
        Some(id)
    }
}
