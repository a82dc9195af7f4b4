//! The program that a command works on: a file, standard input, or lines of the command line.

use super::failure::{Failure, why};
use clap::Args;
use pse::image::{Content, record_standard_input, recorded};
use pse::internal::host::{Disk, read_text};
use pse::internal::program::{Compiler, Program};
use pse::internal::resolve::unknown::Doubt;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Which program.
#[derive(Debug, Args)]
pub(super) struct ProgramArgs {
    /// The program file; - reads standard input
    #[arg(required_unless_present = "lines", conflicts_with = "lines")]
    pub program: Option<PathBuf>,
    /// A line of program text instead of a file; repeat for more lines
    #[arg(short = 'e', long = "expression", value_name = "LINE", allow_hyphen_values = true)]
    pub lines: Vec<String>,
    /// Also look for imported files and textures in this folder
    #[arg(long, value_name = "DIR")]
    pub path: Vec<PathBuf>,
}

impl ProgramArgs {
    /// The program's name in messages, and its text.
    pub fn read(&self) -> Result<(String, String), Failure> {
        check_path(&self.path)?;
        match &self.program {
            Some(path) => read(path),
            None => Ok(("<command line>".into(), self.lines.join("\n") + "\n")),
        }
    }

    /// Does it come from standard input?
    pub fn is_stdin(&self) -> bool {
        self.program.as_ref().is_some_and(|p| p.as_os_str() == "-")
    }

    /// The program's name without folder and extension, for the names of pictures.
    pub fn stem(&self) -> String {
        let path = self.program.as_ref().filter(|_| !self.is_stdin());
        path.and_then(|p| p.file_stem()).map_or("out".into(), |s| s.to_string_lossy().into_owned())
    }
}

/// The most folders of `--path`: each import and each texture is looked for in all of them.
const MAX_FOLDERS: usize = 256;

/// Refuses more folders than are searched.
pub(super) fn check_path(path: &[PathBuf]) -> Result<(), Failure> {
    match path.len() <= MAX_FOLDERS {
        true => Ok(()),
        false => {
            Err(Failure::usage(format!("--path is given {} times; the limit is {MAX_FOLDERS}", path.len()))
                .hint("Give a common parent folder, and name files as \"folder/file\"."))
        }
    }
}

/// Compiles a text that may import files.
pub(super) fn compile(name: &str, text: &str, path: &[PathBuf]) -> Result<Program, Failure> {
    let host = Disk { path: path.to_vec() };
    Ok(Compiler::new().host(&host).compile(name, text)?)
}

/// The same, for images that `doubt` knows.
pub(super) fn compile_for(
    name: &str,
    text: &str,
    path: &[PathBuf],
    doubt: &Doubt<'_>,
) -> Result<Program, Failure> {
    let host = Disk { path: path.to_vec() };
    Ok(Compiler::new().host(&host).doubt(doubt).compile(name, text)?)
}

/// Why the file is no program, if it is a mesh or an image.
fn of_another_kind(path: &Path) -> Option<Failure> {
    let mut start = [0; 16];
    let read = std::fs::File::open(path).ok().filter(|_| path.is_file())?.read(&mut start).ok()?;
    let start = &start[..read];
    let is_mesh =
        pse::mesh::Format::of(path).is_some() || start.starts_with(b"glTF") || start.starts_with(b"ply");
    let magic: [&[u8]; 9] = [
        &[0x76, 0x2f, 0x31, 0x01],
        b"\x89PNG",
        &[0xff, 0xd8, 0xff],
        b"II*\0",
        b"MM\0*",
        b"#?RADIANCE",
        b"#?RGBE",
        b"RIFF",
        b"GIF8",
    ];
    let is_image = magic.iter().any(|magic| start.starts_with(magic));
    let word = pse::internal::quote::path(path);
    let (what, how) = match (is_mesh, is_image) {
        (true, _) => {
            ("a mesh", format!("Give the mesh with --mesh, and a program: pse run a.pse --mesh {word}."))
        }
        (false, true) => {
            ("an image", format!("Give the image with -i, and a program: pse run a.pse -i {word}."))
        }
        (false, false) => return None,
    };
    Some(Failure::plain(format!("`{}` is {what}, not a program", path.display())).hint(how))
}

/// The name in messages and the text of a program's file, or of standard input for `-`.
pub(super) fn read(path: &Path) -> Result<(String, String), Failure> {
    if path.as_os_str() == "-" {
        record_standard_input(Content::Program);
        let text = read_text(std::io::stdin().lock());
        let text = text.map_err(|e| Failure::plain(format!("cannot read standard input: {}", why(&e))))?;
        return Ok(("<standard input>".into(), text));
    }
    let shown = path.display().to_string();
    if let Some(failure) = of_another_kind(path) {
        return Err(failure);
    }
    match recorded(path, Content::Program, std::fs::File::open(path)).and_then(read_text) {
        Ok(text) => Ok((shown, text)),
        Err(e) => {
            let failure = Failure::plain(format!("cannot read `{shown}`: {}", why(&e)));
            Err(match e.kind() {
                std::io::ErrorKind::InvalidData => {
                    failure.hint("A program belongs here. Give an image with -i.")
                }
                _ => failure,
            })
        }
    }
}
