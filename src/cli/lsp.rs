//! `pse lsp`: a language server on standard input and output, for editors.

mod completion;
mod connection;
mod diagnostics;
mod documents;
mod formatting;
mod framing;
mod hover;
mod navigation;
mod position;
mod rename;
mod symbols;
mod uri;

use super::failure::Failure;
use clap::Args;
use framing::{Frame, Frames};
use lsp_server::{Connection, Message};
use std::io::{self, Write};
use std::path::PathBuf;

/// How the server works.
#[derive(Debug, Args)]
#[command(after_help = "Editors start it; see editors/README.md for their settings.")]
pub(super) struct LspArgs {
    /// Also look for imported files and textures in this folder
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
    let (connection, editor) = Connection::memory();
    let Connection { sender, receiver } = editor;
    // It waits for the editor to the end of the process.
    std::thread::spawn(move || hear(&mut Frames::new(io::stdin()), |message| sender.send(message).is_ok()));
    let writer =
        std::thread::spawn(move || receiver.iter().try_for_each(|m| m.write(&mut io::stdout().lock())));
    let ended = connection::serve(&connection, path.collect());
    // The thread that writes ends when nobody can send any more. An editor that does not listen misses nothing.
    drop(connection);
    let _ = writer.join();
    match ended {
        true => Ok(()),
        false => Err(Failure::plain("the editor closed the connection without shutdown and exit")),
    }
}

/// Passes on all messages until the last one; what is none is answered at once.
fn hear(frames: &mut Frames<impl io::Read>, mut pass: impl FnMut(Message) -> bool) {
    while let Ok(Some(frame)) = frames.next() {
        let goes_on = match frame {
            Frame::Message(message) => {
                let last = matches!(&message, Message::Notification(note) if note.method == "exit");
                pass(message) && !last
            }
            Frame::Refused(response) => {
                let text = response.to_string();
                let mut out = io::stdout().lock();
                write!(out, "Content-Length: {}\r\n\r\n{text}", text.len()).and_then(|()| out.flush()).is_ok()
            }
        };
        if !goes_on {
            return;
        }
    }
}
