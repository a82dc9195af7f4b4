//! `pse view`: a program's picture in the browser, drawn anew at every change of what it is made of.

mod connections;
mod disk;
mod http;
mod opening;
mod render;
mod server;
mod session;
mod source;
mod token;
mod told;
mod watch;

use super::failure::{Failure, print, warn};
use super::frames::{Frame, FrameArg, given_or_found};
use super::input::ImageArgs;
use super::run::{LimitArgs, set, space};
use clap::Args;
use disk::OnDisk;
use server::Server;
use session::Session;
use source::Pictures;
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What to show.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  pse view marble.pse --open\n  pse view marble.pse -i gbuffer.exr\n  \
                  pse view new.pse --scene vase --port 8017\n\n\
                  It prints an address for the browser, of this machine alone. The picture is drawn anew when the \
                  program, its imports, its textures or the images change on the disk, by whatever editor; the page has an \
                  editor of its own. Ctrl-C ends it. docs/view.md tells the rest.")]
pub(super) struct PreviewArgs {
    /// The program's file; one that does not exist yet is written at the first save
    program: PathBuf,
    #[command(flatten)]
    pub images: ImageArgs,
    /// Take PNG, JPEG and the like as plain numbers: no sRGB curve
    #[arg(long, help_heading = "Input")]
    pub raw: bool,
    /// The number of the frame to begin with; that in the name or the header of the input if not given
    #[arg(long, value_name = "N", allow_negative_numbers = true, help_heading = "Input")]
    frame: Option<FrameArg>,
    /// Set a param to an expression to begin with: veins=6
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// Look for imported files and for textures in this folder too
    #[arg(long, value_name = "DIR")]
    path: Vec<PathBuf>,
    /// The port of the page's address; 0 takes one that is free
    #[arg(long, value_name = "PORT", default_value_t = 0)]
    port: u16,
    /// Open the page in the browser, by an address that works once
    #[arg(long)]
    open: bool,
    #[command(flatten)]
    limits: LimitArgs,
}

impl PreviewArgs {
    /// The frame to begin with.
    fn first_frame(&self) -> Frame {
        let (frame, _) = given_or_found(self.frame, &self.images.frame_sources());
        // A preview always is at a frame: there is a slider for it.
        Frame { number: frame.number.or(Frame::from(frame.value).number), ..frame }
    }
}

/// Shows the page until it is interrupted, which ends it as it is: nothing is half written.
pub(super) fn view(args: &PreviewArgs) -> Result<(), Failure> {
    let pictures = Pictures::new(args)?;
    let frame = args.first_frame();
    let mut values = Vec::new();
    for text in &args.set {
        let (name, value) = set(text, frame.value)?;
        let shown = text.split_once('=').map_or("", |(_, value)| value).trim().to_string();
        values.push((name, shown, value));
    }
    let spaces = args.images.space.iter().map(|text| space(text, frame.value)).collect::<Result<_, _>>()?;
    let text = match program(&args.program)? {
        Some(text) => text,
        None => {
            warn(&format!("{} does not exist yet; it is written at the first save", args.program.display()));
            String::new()
        }
    };
    let options = session::Fixed {
        file: args.program.clone(),
        path: args.path.clone(),
        spaces,
        pixelsize: args.images.pixelsize,
        limits: args.limits.limits(),
        texture_memory: args.limits.textures(),
    };
    let session = Arc::new(Session::new(options, text, frame, values));
    let server = Server::bind(args.port, Arc::clone(&session))?;
    let watcher = watch::Watcher::new(Arc::clone(&session));
    let address = server.address();
    let opened = if args.open { Some(server.one_time_address()?) } else { None };
    // The address is what the command gives; the rest is said beside it.
    print(&format!("{address}\n"))?;
    if io::stdout().is_terminal() {
        warn("open this address in a browser; Ctrl-C ends it");
    }
    std::thread::spawn(move || server.serve());
    if let Some(address) = opened
        && let Err(error) = open::that_detached(address)
    {
        warn(&format!("cannot open a browser: {error}"));
    }
    let clock = Arc::clone(&session);
    std::thread::spawn(move || clock.end_what_is_late());
    render::for_ever(&session, pictures, watcher)
}

/// The program's text; `None` if there is no such file yet.
fn program(path: &Path) -> Result<Option<String>, Failure> {
    if path.as_os_str() == "-" {
        return Err(Failure::usage("a program from standard input does not change")
            .hint("Give a file: pse view marble.pse"));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    match OnDisk::read(path) {
        OnDisk::Missing if folder.is_none_or(Path::is_dir) => Ok(None),
        OnDisk::NoFile { why } => Err(Failure::plain(format!("cannot read `{}`: {why}", path.display()))
            .hint("A preview saves its program, so that has to be a file.")),
        _ => super::source::read(path).map(|(_, text)| Some(text)),
    }
}
