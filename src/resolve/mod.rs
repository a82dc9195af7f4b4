//! From the tree as written to a program that can run: every name gets a slot, every call its function and
//! its arguments in order, and what depends on the frame alone is marked.

pub mod names;
pub mod print;
pub mod tree;

mod call;
mod effects;
mod entry;
mod exposed;
mod expr;
mod import;
mod library;
mod lower;
mod rate;
mod scope;
mod several;
mod spaces;
mod texture;
pub mod unknown;

pub use entry::{Entrance, NO_FUNCTION};
pub use import::{Files, Import, gather};
pub use library::{Comment, Entry, entries as library_entries};
pub use scope::assigned;
pub use spaces::{names_space, space_of};
pub use tree::Resolved;

use crate::diagnostic::{Diagnostic, Sources};
use crate::eval::HostFunction;
use crate::host::Host;
use std::collections::HashMap;
use std::sync::Arc;

/// The functions that the embedding program gives, by name.
pub type HostFunctions = HashMap<String, Arc<HostFunction>>;

pub(crate) use texture::unreadable;

/// Is it the name of a built-in function, of one of the library, or of `print`?
pub fn is_standard_function(name: &str) -> bool {
    crate::builtin::find(name).is_some() || library::find(name).is_some() || name == print::NAME
}

/// Reads and resolves a program called `name`. On failure: every error that could be found, and the texts they
/// point into. `value` names the variable of the last outer expression; with an `entry` the program is one function.
/// `doubt` is asked about the variables that a program with errors does not assign.
pub fn resolve(
    name: &str,
    text: &str,
    host: &dyn Host,
    functions: &HostFunctions,
    value: Option<&str>,
    entry: Option<&Entrance>,
    doubt: &unknown::Doubt<'_>,
) -> Result<Resolved, (Vec<Diagnostic>, Sources)> {
    let mut sources = Sources::default();
    let mut errors = Vec::new();
    let mut files = import::gather(name, text, &mut sources, host, &mut errors);
    if let Some(entry) = entry {
        entry.call(&mut files, &mut sources, &mut errors);
    }
    let mut resolver = lower::Resolver::new(&mut sources, host, functions);
    resolver.value = value;
    resolver.entry = entry;
    resolver.program(&files);
    let mut resolved = resolver.finish();
    let found = resolver.errors;
    resolved.sources = sources;
    if errors.is_empty() && found.is_empty() {
        return Ok(resolved);
    }
    let more = several::unassigned(&resolved, doubt);
    let more = several::credible(found.into_iter().chain(more), &errors, &resolved.sources);
    errors.extend(more);
    Err((errors, resolved.sources))
}
