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
                  It prints the address of a page that only this machine can open. The picture is redrawn when the \
                  program, its imports, textures or images change on the disk. The page has an editor of its own. \
                  Ctrl-C ends it. See docs/view.md.")]
pub(super) struct PreviewArgs {
    /// The program file; if it does not exist, the first save creates it
    program: PathBuf,
    #[command(flatten)]
    pub images: ImageArgs,
    /// Read pictures (PNG, JPEG, …) without sRGB conversion
    #[arg(long, help_heading = "Input")]
    pub raw: bool,
    /// The first frame to show (default: the one in the input's name or header)
    #[arg(long, value_name = "N", allow_negative_numbers = true, help_heading = "Input")]
    frame: Option<FrameArg>,
    /// Set the initial value of a param: veins=6
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// Also look for imported files and textures in this folder
    #[arg(long, value_name = "DIR")]
    path: Vec<PathBuf>,
    /// The port of the page; 0 picks a free port
    #[arg(long, value_name = "PORT", default_value_t = 0)]
    port: u16,
    /// Open the page in the browser, with an address that works once
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
            warn(&format!("{} does not exist yet; the first save creates it", args.program.display()));
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
        return Err(Failure::usage("pse view cannot watch a program on standard input")
            .hint("Give a file: pse view marble.pse"));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    match OnDisk::read(path) {
        OnDisk::Missing if folder.is_none_or(Path::is_dir) => Ok(None),
        OnDisk::NoFile { why } => Err(Failure::plain(format!("cannot read `{}`: {why}", path.display()))
            .hint("pse view saves the program to its file.")),
        _ => super::source::read(path).map(|(_, text)| Some(text)),
    }
}
