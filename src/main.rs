//! The `pse` command; what it does is in [`pse::cli`].

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    pse::cli::run(pse::cli::Cli::parse())
}
