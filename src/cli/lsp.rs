//! `pse lsp`: a language server on standard input and output, for editors.

mod completion;
mod connection;
mod diagnostics;
mod documents;
mod formatting;
mod hover;
mod navigation;
mod position;
mod rename;
mod symbols;
mod uri;

use super::failure::{Failure, why};
use clap::Args;
use lsp_server::Connection;
use std::path::PathBuf;

/// How the server works.
#[derive(Debug, Args)]
#[command(after_help = "An editor starts it; editors/README.md tells how.")]
pub(super) struct LspArgs {
    /// Look for imported files and for textures in this folder too
    #[arg(long, value_name = "DIR")]
    path: Vec<PathBuf>,
    /// Some editors say this to every server; it is the only way there is
    #[arg(long, hide = true)]
    stdio: bool,
}

/// Serves until the editor ends it.
pub(super) fn lsp(args: &LspArgs) -> Result<(), Failure> {
    // Documents have whole paths, and are compared with what is found here.
    let path = args.path.iter().map(|folder| std::path::absolute(folder).unwrap_or_else(|_| folder.clone()));
    let (connection, threads) = Connection::stdio();
    let ended = connection::serve(&connection, path.collect());
    // The thread that writes ends when nobody can send any more.
    drop(connection);
    let joined = threads.join();
    match ended {
        true => Ok(()),
        false => Err(match joined {
            Err(error) => Failure::plain(format!("the editor's message cannot be read: {}", why(&error))),
            Ok(()) => Failure::plain("the editor left without saying shutdown and exit"),
        }),
    }
}
