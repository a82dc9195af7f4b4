//! The `pse` command; what it does is in [`pse::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    match pse::cli::parse() {
        Ok(cli) => pse::cli::run(cli),
        Err(status) => status,
    }
}
