//! `pse fmt`: programs in their canonical form.

use super::failure::{Failure, print, print_exact};
use super::source::read;
use clap::Args;
use pse::image::write_program;
use pse::internal::diagnostic::Sources;
use pse::internal::program::Error;
use pse::internal::syntax;
use std::path::{Path, PathBuf};

/// What to format.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  pse fmt *.pse             rewrites the files\n  \
                        pse fmt --check *.pse     names those that would change\n  \
                        pse fmt < a.pse > b.pse")]
pub(super) struct FmtArgs {
    /// The programs to format; none, or -, formats standard input to standard output
    #[arg(value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Change nothing; list the files that would change, and exit with 1 if there are any
    #[arg(long)]
    check: bool,
}

/// Formats, or looks whether there is something to format. A file that cannot be formatted keeps none of the
/// others from it.
pub(super) fn fmt(args: &FmtArgs) -> Result<(), Failure> {
    let stdin = [PathBuf::from("-")];
    let files = if args.files.is_empty() { &stdin[..] } else { &args.files };
    let mut good = true;
    for path in files {
        match one(path, args.check) {
            Ok(canonical) => good &= canonical,
            Err(Failure::BrokenPipe) => return Err(Failure::BrokenPipe),
            Err(failure) => {
                failure.report();
                good = false;
            }
        }
    }
    if good { Ok(()) } else { Err(Failure::Said) }
}

/// Formats one program; false if it should be in canonical form and is not.
fn one(path: &Path, check: bool) -> Result<bool, Failure> {
    let (name, text) = read(path)?;
    let formatted = match syntax::format(&text) {
        Ok(formatted) => formatted,
        Err(diagnostics) => {
            let mut sources = Sources::default();
            sources.add(name, text);
            return Err(Error::new(diagnostics, sources).into());
        }
    };
    if check {
        if formatted != text {
            print(&format!("{name}\n"))?;
        }
        return Ok(formatted == text);
    }
    if path.as_os_str() == "-" {
        print_exact(&formatted)?;
    } else if formatted != text {
        write_program(path, &formatted)?;
    }
    Ok(true)
}
