//! A program as one function: what is asked at points of space, instead of what runs at pixels.

use super::effects::{Seen, needed};
use super::import::Files;
use super::tree::{Place, Resolved};
use crate::diagnostic::{Diagnostic, Sources};
use crate::syntax::{self, ast};
use std::collections::BTreeSet;

/// The code of the error that the program does not have the function.
pub const NO_FUNCTION: &str = "entrance";

/// A function of the program that is asked from outside, with what it is given.
#[derive(Clone, Debug, PartialEq)]
pub struct Entrance {
    /// The function's name; its value becomes a variable of this name.
    pub function: String,
    /// The variables that it is given, in order: as many as it takes.
    pub arguments: Vec<String>,
}

impl Entrance {
    /// `density(point)`, with the first so many arguments.
    fn written(&self, arguments: usize) -> String {
        format!("{}({})", self.function, self.arguments[..arguments].join(", "))
    }

    /// Adds the call behind the program's own statements.
    pub(super) fn call(&self, files: &mut Files, sources: &mut Sources, errors: &mut Vec<Diagnostic>) {
        let own = |stmt: &ast::Stmt| match &stmt.kind {
            ast::StmtKind::Function(f) if f.name.text == self.function => {
                Some((f.name.span, f.params.len(), f.params.iter().filter(|(_, d)| d.is_none()).count()))
            }
            _ => None,
        };
        let given = self.arguments.len();
        let Some((span, most, least)) = files.imported.iter().chain(&files.body).find_map(own) else {
            // What could not be read may have been it.
            if errors.is_empty() {
                let written = self.written(given);
                let error = Diagnostic::bare(NO_FUNCTION, format!("the program has no function `{written}`"));
                errors.push(
                    error.hint(format!("Write one: `function {written}`, and below it what it returns.")),
                );
            }
            return;
        };
        if least > given {
            let message = format!("`{}()` is called as `{}`", self.function, self.written(given));
            let error = Diagnostic::error("call", message, span).label(span, format!("it takes {least}"));
            errors.push(error.hint("Give its other parameters default values."));
            return;
        }
        let text = format!("{} = {}", self.function, self.written(given.min(most)));
        let id = sources.add("<call>", text.as_str());
        files.body.extend(syntax::parse(id, &text).module.body);
    }
}

/// Leaves of the outer statements those that the function needs: those that assign what it reads, and what these read.
pub(super) fn prune(program: &mut Resolved, entry: &Entrance, seen: &[Seen]) -> Option<Diagnostic> {
    let slot = |name: &str| program.globals.iter().position(|g| !g.library && g.name == name);
    let result = Place::Global(slot(&entry.function)? as u32);
    let needed = needed(seen, BTreeSet::from([result]), |_| false);
    let part = || seen.iter().zip(&needed).filter(|(_, needed)| **needed).map(|(seen, _)| seen);
    let reads: BTreeSet<Place> = part().flat_map(|seen| &seen.reads).copied().collect();
    let writes: BTreeSet<Place> = part().flat_map(|seen| &seen.writes).copied().collect();
    let derives = part().any(|seen| seen.derives);
    for (slot, global) in program.globals.iter_mut().enumerate() {
        let place = Place::Global(slot as u32);
        if !reads.contains(&place) && global.framed.is_none() {
            global.read = None;
        }
        if !writes.contains(&place) {
            global.assigned = None;
        }
    }
    let mut keep = needed.iter();
    program.body.retain(|_| keep.next().is_some_and(|keep| *keep));
    program.by_normal = None;
    program.derivatives = false;
    program.shadowed = Vec::new();
    derives.then(|| {
        let message = format!("`{}()` uses neighbouring pixels", entry.function);
        let hint = "It is evaluated at points without neighbours. Remove the derivatives, and give image look-ups a `width`.";
        Diagnostic::bare("derivative", message).hint(hint)
    })
}
