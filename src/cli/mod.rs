//! The `pse` command: its arguments, and one file for each thing that it does.
//!
//! A command gives `Ok`, or a `Failure` that knows its message and its exit status. What people
//! asked for goes to standard output, what is said about the work to standard error.

mod ast;
mod camera;
mod check;
mod completions;
mod deform;
pub mod doc;
mod failure;
mod flow;
mod fmt;
mod frames;
mod info;
mod input;
mod interrupt;
mod job;
mod join;
mod known;
mod lsp;
mod model;
mod noise;
mod output;
mod prints;
mod progress;
mod region;
mod repl;
mod run;
mod scene;
mod solid;
mod source;
mod state;
mod stats;
mod tiles;
mod trace;
mod view;

use clap::{CommandFactory, Parser, Subcommand};
use pse::image::protect_inputs;
use pse::internal::visible::is_hidden;
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  pse run -e 'white * Noise(8 * point)'        paint the built-in donut, into out.png
  pse run marble.pse -i gbuffer.exr -o a.png   run a program on a renderer's G-buffer
  pse run marble.pse --set veins=6 -o a.exr    set one of its params
  pse view marble.pse --open                   see the picture while you write the program
  pse repl --scene vase                        try things out at a prompt
  pse trace marble.pse --pixel 320,200         what happens at a pixel, step by step
  pse job fire.pse --frames 1-100 -o fire.job  a job bundle for a render farm
  pse scene --list                             the built-in G-buffers
  pse run marble.pse --mesh teapot.obj         paint a mesh; pse scene writes its G-buffer
  pse deform teapot.obj wobble.pse -o b.obj    move the vertices of a mesh
  pse info gbuffer.exr                         what a file contains, and its variables
  pse noise -o noise.png                       the kinds of noise, with their spectra
  pse doc Noise                                what a function does

Exit status: 0 on success, 1 for an error in a program or a file, 2 for an error in the arguments, 130 if
interrupted.";

/// The pixel stream editor: runs a small program at every pixel of an image
#[derive(Debug, Parser)]
#[command(name = "pse", version, after_help = EXAMPLES, disable_help_subcommand = false)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a program at every pixel of an image
    Run(Box<run::RunArgs>),
    /// Show a program's picture in the browser and redraw it at every change
    View(Box<view::PreviewArgs>),
    /// Try programs line by line at a prompt
    Repl(repl::ReplArgs),
    /// Trace everything that happens at one pixel: assignments, branches, calls, and where NaN comes from
    Trace(Box<trace::TraceArgs>),
    /// Package a run of many frames or tiles as a job bundle for a render farm
    Job(Box<job::JobArgs>),
    /// Join the tiles of a picture into one file
    Join(join::JoinArgs),
    /// Write the G-buffer of a built-in scene, a mesh or a solid, or list the scenes
    Scene(scene::SceneArgs),
    /// Follow points along a program's velocity field and draw their paths
    Flow(Box<flow::FlowArgs>),
    /// Move the vertices of a mesh with a program
    Deform(deform::DeformArgs),
    /// List the kinds of noise, describe them, or draw them with their spectra
    Noise(noise::NoiseArgs),
    /// Show what an image or mesh file contains and which variables programs read from it
    Info(info::InfoArgs),
    /// Check programs for mistakes without running them
    Check(check::CheckArgs),
    /// Format programs in the canonical style
    Fmt(fmt::FmtArgs),
    /// Explain a function or another name of the language
    Doc(doc::DocArgs),
    /// Print a program's syntax tree
    Ast(ast::AstArgs),
    /// Serve an editor: the language server, on standard input and output
    Lsp(lsp::LspArgs),
    /// Print the completion script for a shell
    Completions(completions::CompletionsArgs),
    /// Print the manual page, or write one page per command
    Man(completions::ManArgs),
}

/// Parses the arguments of this process.
///
/// # Errors
/// The status to end with: help was asked for, or an argument is wrong, and that is said already.
pub fn parse() -> Result<Cli, ExitCode> {
    Cli::try_parse().map_err(|error| {
        let hidden = |arg: std::ffi::OsString| arg.to_string_lossy().contains(is_hidden);
        // The message quotes the arguments, among which may be names of files.
        if std::env::args_os().any(hidden) {
            failure::warn(error.to_string().trim_end());
        } else {
            // Nobody may read it any more.
            let _ = error.print();
        }
        if let Some(tip) = about_recenter(std::env::args_os()) {
            failure::warn(&tip);
        }
        ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
    })
}

/// What to write where the value of `--recenter`, which need not have one, stands apart from it.
fn about_recenter(args: impl Iterator<Item = std::ffi::OsString>) -> Option<String> {
    let words: Vec<String> = args.map(|arg| arg.to_string_lossy().into_owned()).collect();
    let pair =
        words.windows(2).find(|pair| pair[0] == "--recenter" && pse::scene::parse_point(&pair[1]).is_ok())?;
    Some(format!(
        "\n  tip: write --recenter={}; without a value, --recenter uses the middle of the mesh",
        pair[1]
    ))
}

/// Does what the arguments say, and tells how it ended.
pub fn run(cli: Cli) -> ExitCode {
    interrupt::survive_file_limits();
    interrupt::listen();
    // Whatever a command writes, it replaces nothing that it reads.
    protect_inputs();
    let outcome = match cli.command {
        Some(Command::Run(args)) => run::run(&args),
        Some(Command::View(args)) => view::view(&args),
        Some(Command::Repl(args)) => repl::repl(&args),
        Some(Command::Trace(args)) => trace::trace(&args),
        Some(Command::Job(args)) => job::job(&args),
        Some(Command::Join(args)) => join::join(&args),
        Some(Command::Scene(args)) => scene::scene(&args),
        Some(Command::Flow(args)) => flow::flow(&args),
        Some(Command::Deform(args)) => deform::deform(&args),
        Some(Command::Noise(args)) => noise::noise(&args),
        Some(Command::Info(args)) => info::info(&args),
        Some(Command::Check(args)) => check::check(&args),
        Some(Command::Fmt(args)) => fmt::fmt(&args),
        Some(Command::Doc(args)) => doc::doc(&args),
        Some(Command::Ast(args)) => ast::ast(&args),
        Some(Command::Lsp(args)) => lsp::lsp(&args),
        Some(Command::Completions(args)) => completions::completions(&args),
        Some(Command::Man(args)) => completions::man(&args),
        None => failure::print(&Cli::command().render_help().to_string()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_arguments_are_well_formed() {
        Cli::command().debug_assert();
    }
}
