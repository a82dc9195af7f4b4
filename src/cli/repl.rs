//! `pse repl`: the language line by line, on an image.

mod commands;
mod line;
mod picture;
mod session;
mod terminal;

use super::failure::{Failure, print, warn};
use super::frames::{Chosen, Frame, FrameArg};
use super::input::{ImageArgs, Inputs};
use super::interrupt::{self, CANCEL};
use super::run::{LimitArgs, scene, set, space};
use clap::Args;
use line::{Editor, Read};
use pse::image::Image;
use pse::internal::syntax::is_incomplete;
use session::Session;
use std::io::{self, BufRead, IsTerminal};
use std::path::PathBuf;
use std::sync::atomic::Ordering;

/// What the session works on.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  pse repl\n  pse repl -i gbuffer.exr\n  pse repl --scene vase marble.pse\n  \
                        echo 'mean(point)' | pse repl\n\n\
                        An expression prints its value at the current pixel and its minimum, mean and maximum over \
                        the image; other lines are added to the program. :help lists the commands. Without a \
                        terminal, pse repl reads lines from standard input and prints no prompts or colours."
)]
pub(super) struct ReplArgs {
    /// A program to load first
    program: Option<PathBuf>,
    #[command(flatten)]
    images: ImageArgs,
    /// Set a param to an expression: veins=6
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// The frame number (default: the one in the input's name or header)
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    frame: Option<FrameArg>,
    /// Also look for imported files and textures in this folder
    #[arg(long, value_name = "DIR")]
    path: Vec<PathBuf>,
    #[command(flatten)]
    limits: LimitArgs,
}

/// Runs a session until its end.
pub(super) fn repl(args: &ReplArgs) -> Result<(), Failure> {
    let chosen = Chosen::new(None, args.frame, &args.images.frame_sources(), std::iter::empty())?;
    let frame = chosen.frames[0];
    let (image, inputs) = load(args, frame)?;
    let view = args.images.view_of_image().cloned();
    let mut session = Session::new(image, inputs, view, args.path.clone());
    session.frame = frame;
    session.pixelsize = args.images.pixelsize;
    session.limits = args.limits.limits();
    session.set = args.set.iter().map(|text| set(text, frame.value)).collect::<Result<_, _>>()?;
    session.spaces =
        args.images.space.iter().map(|text| space(text, frame.value)).collect::<Result<_, _>>()?;
    if let Some(program) = &args.program {
        print(&session.load(program)?)?;
    }
    match io::stdin().is_terminal() && io::stdout().is_terminal() {
        true => at_terminal(session),
        false => piped(session),
    }
}

/// All that the inputs hold.
fn load(args: &ReplArgs, frame: Frame) -> Result<(Image<'static>, Inputs), Failure> {
    let inputs = Inputs::open(&args.images.input, &args.images.map, false, frame.number)?;
    let seen = scene(&args.images)?;
    let scene = seen.map(|seen| args.images.view.renderer(&seen, frame.number, false)).transpose()?;
    let names = inputs.variables().into();
    let mut reader = inputs.reader(scene.as_ref(), &names, false)?;
    let height = reader.about().height;
    let image = reader.read(0..height)?;
    drop(reader);
    Ok((image, inputs))
}

/// With prompts, history and completion.
fn at_terminal(mut session: Session) -> Result<(), Failure> {
    interrupt::cancel_answer();
    let mut editor = Editor::new()?;
    let about = session.about();
    let version = env!("CARGO_PKG_VERSION");
    print(&format!("pse {version}: {about}. :help lists the commands, :quit ends.\n"))?;
    loop {
        match editor.read(&session) {
            Read::Text(text) => {
                CANCEL.store(false, Ordering::Relaxed);
                if !answer(&mut session, &text) {
                    return Ok(());
                }
            }
            Read::Again => {}
            Read::End => return Ok(()),
        }
    }
}

/// Without any of it. The first error decides how the command ends.
fn piped(mut session: Session) -> Result<(), Failure> {
    let mut text = String::new();
    let mut good = true;
    let mut lines = io::stdin().lock().lines();
    loop {
        let line = lines.next().transpose().map_err(|e| Failure::plain(format!("cannot read: {e}")))?;
        let end = line.is_none();
        // A line that is no part of the block before it begins something new.
        let indented = line.as_ref().is_some_and(|l| l.starts_with([' ', '\t']) || l.trim().is_empty());
        let goes_on = |word: &str| line.as_ref().is_some_and(|l| l.split_whitespace().next() == Some(word));
        let command = text.trim_start().starts_with(':');
        let more = !command
            && is_incomplete(text.trim_end_matches('\n'))
            && (indented || goes_on("else") || open(&text));
        if !text.trim().is_empty() && (end || !more) {
            good &= session.answer_errors(&text);
            text.clear();
            if session.ended {
                break;
            }
        }
        match line {
            Some(line) => text += &(line + "\n"),
            None => break,
        }
    }
    if good { Ok(()) } else { Err(Failure::Said) }
}

/// Does a bracket wait for its end?
fn open(text: &str) -> bool {
    is_incomplete(&format!("{}\n\n\n", text.trim_end()))
}

/// Does what a text says; `false` at the session's end.
fn answer(session: &mut Session, text: &str) -> bool {
    session.answer_errors(text);
    !session.ended
}

impl Session {
    /// Does what a text says and tells what comes of it; `false` if that is an error.
    fn answer_errors(&mut self, text: &str) -> bool {
        match self.enter(text) {
            Ok(said) => {
                // Nobody may read it any more.
                let _ = print(&said);
                true
            }
            Err(Failure::Said) => false,
            Err(Failure::Interrupted) => {
                note("cancelled");
                false
            }
            Err(failure) => {
                failure.report();
                false
            }
        }
    }
}

/// Says something about the work.
fn note(text: &str) {
    warn(text);
}
