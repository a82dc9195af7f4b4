//! `pse completions`: what a shell needs to complete the arguments.

use super::failure::{Failure, print};
use clap::{Args, CommandFactory};
use clap_complete::Shell;

/// Which shell.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  pse completions bash > ~/.local/share/bash-completion/completions/pse\n  \
                        pse completions zsh > ~/.zfunc/_pse\n  \
                        pse completions fish > ~/.config/fish/completions/pse.fish"
)]
pub(super) struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

/// Prints the script.
pub(super) fn completions(args: &CompletionsArgs) -> Result<(), Failure> {
    // To memory first: clap_complete panics where a pipe closes early.
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut super::Cli::command(), "pse", &mut script);
    print(&String::from_utf8_lossy(&script))
}
