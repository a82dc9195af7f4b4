//! `pse ast`: how a program was understood.

use super::failure::{Failure, print};
use super::source::ProgramArgs;
use clap::Args;
use pse::internal::diagnostic::Sources;
use pse::internal::program::Error;
use pse::internal::syntax;

/// Which program.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  pse ast marble.pse\n  pse ast -e 'color = -x ^ 2'")]
pub(super) struct AstArgs {
    #[command(flatten)]
    program: ProgramArgs,
}

/// Prints the tree.
pub(super) fn ast(args: &AstArgs) -> Result<(), Failure> {
    let (name, text) = args.program.read()?;
    let mut sources = Sources::default();
    let id = sources.add(name, text.as_str());
    let parsed = syntax::parse(id, &text);
    if !parsed.errors.is_empty() {
        return Err(Error::new(parsed.errors, sources).into());
    }
    print(&syntax::tree(&parsed.module))
}
