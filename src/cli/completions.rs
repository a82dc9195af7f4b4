//! `pse completions` and `pse man`: what shells and `man` need to know about the arguments.

use super::failure::{Failure, print_exact};
use clap::builder::PossibleValuesParser;
use clap::{Args, Command, CommandFactory};
use clap_complete::Shell;
use pse::image::write_file;
use pse::internal::reference;
use pse::scene;
use std::fs;
use std::path::{Path, PathBuf};

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

/// Where manual pages go.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  pse man | man -l -\n  pse man -o ~/.local/share/man/man1")]
pub(super) struct ManArgs {
    /// Write one page per command into this folder (default: print pse(1))
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Also replace files that are not manual pages of pse
    #[arg(long, requires = "output")]
    force: bool,
}

/// The arguments, with the names that a shell can offer: scenes and the names that `pse doc` explains. Running checks
/// these names itself, with better messages than a list of values.
fn command() -> Command {
    let scenes: Vec<String> = scene::scenes().iter().map(|s| s.name.to_string()).collect();
    let mut functions: Vec<String> = reference::entries().into_iter().map(|e| e.name).collect();
    functions.sort_unstable();
    functions.dedup();
    super::Cli::command().mut_subcommands(|mut command| {
        let names: Vec<String> = command.get_arguments().map(|a| a.get_id().to_string()).collect();
        if names.iter().any(|n| n == "scene") {
            command = command.mut_arg("scene", |a| a.value_parser(PossibleValuesParser::new(scenes.clone())));
        }
        match command.get_name() {
            "scene" => command.mut_arg("name", |a| a.value_parser(PossibleValuesParser::new(scenes.clone()))),
            "doc" => {
                command.mut_arg("name", |a| a.value_parser(PossibleValuesParser::new(functions.clone())))
            }
            _ => command,
        }
    })
}

/// Prints the script.
pub(super) fn completions(args: &CompletionsArgs) -> Result<(), Failure> {
    // To memory first: clap_complete panics where a pipe closes early.
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command(), "pse", &mut script);
    print_exact(&String::from_utf8_lossy(&script))
}

/// Prints the page of the whole command, or writes a page for each command.
pub(super) fn man(args: &ManArgs) -> Result<(), Failure> {
    let command = super::Cli::command();
    let Some(folder) = &args.output else {
        return print_exact(&String::from_utf8_lossy(&page(command, "pse")?));
    };
    fs::create_dir_all(folder)
        .map_err(|e| Failure::plain(format!("cannot create the folder {}: {e}", folder.display())))?;
    let subcommands: Vec<Command> = command.get_subcommands().cloned().collect();
    for (name, command) in std::iter::once(("pse".to_string(), command))
        .chain(subcommands.into_iter().map(|c| (format!("pse-{}", c.get_name()), c)))
    {
        let path = folder.join(format!("{name}.1"));
        if !args.force && is_foreign(&path, &name) {
            return Err(Failure::plain(format!(
                "`{}` exists, and is not a manual page of pse",
                path.display()
            ))
            .hint("Give another folder, or add --force to replace it."));
        }
        write_file(&path, &page(command, &name)?)?;
    }
    Ok(())
}

/// Whether something else has the name of a page: a link, or a file without the page's title.
fn is_foreign(path: &Path, name: &str) -> bool {
    let Ok(about) = fs::symlink_metadata(path) else { return false };
    let title = format!(".TH {name} 1");
    let bytes =
        pse::internal::files::regular(path).and_then(|file| pse::internal::files::read_all(file, 1 << 20));
    !about.is_file() || !bytes.is_ok_and(|bytes| String::from_utf8_lossy(&bytes).contains(&title))
}

fn page(command: Command, name: &str) -> Result<Vec<u8>, Failure> {
    let mut page = Vec::new();
    clap_mangen::Man::new(command.display_name(name).name(name.to_string()))
        .render(&mut page)
        .map_err(|e| Failure::plain(format!("cannot write the page {name}: {e}")))?;
    Ok(page)
}
