//! Files on disk, for the command and for hosts that read their programs and textures from there.

use super::{Host, HostError};
use crate::files::{Folders, outside};
use crate::image::{Content, Input, has_pattern, recorded};
use crate::syntax::MAX_TEXT;
use crate::texture::Origin;
use std::collections::HashSet;
use std::io::{self, ErrorKind, Read};
use std::path::{Component, Path, PathBuf};

/// Files on disk, searched in the program's folder and below, then in the given folders, and nowhere else.
#[derive(Clone, Debug, Default)]
pub struct Disk {
    /// Folders to search after the importing file's own.
    pub path: Vec<PathBuf>,
}

impl Disk {
    /// Finds the first existing file for an import. `open_text` returns the text of a document that an editor has
    /// open.
    pub fn find(
        &self,
        importing: &str,
        path: &str,
        open_text: &dyn Fn(&Path) -> Option<String>,
    ) -> Result<(String, String), HostError> {
        let places = self.places(importing, path);
        let folders = Folders::new(self.roots(importing));
        for file in &places {
            let text = match open_text(file) {
                Some(text) => Ok(text),
                None => recorded(file, Content::Program, folders.open(file)).and_then(read_text),
            };
            match text {
                Ok(text) => return Ok((file.display().to_string(), text)),
                Err(e) if e.kind() == ErrorKind::NotFound => {}
                Err(e) => return Err(format!("{}: {}", file.display(), reason(&e)).into()),
            }
        }
        Err(nowhere(&places).into())
    }

    /// The folders that a program's files lie in.
    fn roots(&self, program: &str) -> Vec<PathBuf> {
        let beside = Path::new(program).parent().unwrap_or(Path::new(""));
        std::iter::once(beside).chain(self.path.iter().map(PathBuf::as_path)).map(Path::to_path_buf).collect()
    }

    /// Where the file of that name may lie, in the order in which it is looked for: never outside of the folders, as far
    /// as the name says. `..` undoes the folder written before it, whether that is a link or not.
    fn places(&self, program: &str, name: &str) -> Vec<PathBuf> {
        let roots = self.roots(program);
        let allowed: HashSet<PathBuf> = roots.iter().map(|root| absolute(root)).collect();
        let mut seen = HashSet::new();
        let mut places: Vec<PathBuf> = roots.iter().map(|root| clean(&root.join(name))).collect();
        places.retain(|path| {
            let whole = absolute(path);
            whole.ancestors().any(|folder| allowed.contains(folder)) && seen.insert(path.clone())
        });
        places
    }
}

/// Says that a file is in none of its places.
fn nowhere(places: &[PathBuf]) -> String {
    if places.is_empty() {
        return "outside the folders that this program may read".into();
    }
    let tried: Vec<String> = places.iter().map(|path| path.display().to_string()).collect();
    format!("there is no {}", tried.join(" and no "))
}

/// Why a file cannot be read, in words that hold for all systems where there are some.
fn reason(error: &io::Error) -> String {
    match error.kind() {
        ErrorKind::PermissionDenied => "permission denied".into(),
        ErrorKind::IsADirectory => "it is a directory".into(),
        ErrorKind::InvalidData => "it is not UTF-8 text".into(),
        _ => match outside(error) {
            Some(folder) => format!("{error}; `--path {}` allows it", crate::quote::path(folder)),
            None => error.to_string(),
        },
    }
}

/// The text of a program. What is too long is none, and is not read to its end.
pub fn read_text(from: impl Read) -> io::Result<String> {
    let mut bytes = Vec::new();
    from.take(MAX_TEXT as u64 + 1).read_to_end(&mut bytes)?;
    if bytes.len() > MAX_TEXT {
        // What is wrong with it is said by who reads the text; the last letter may be cut.
        return Ok(" ".repeat(bytes.len()));
    }
    String::from_utf8(bytes).map_err(|e| io::Error::new(ErrorKind::InvalidData, e))
}

/// The path without `.` and, as far as folders stand before them, without `..`. Links are not followed.
pub fn clean(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if matches!(out.components().next_back(), Some(Component::Normal(_))) => {
                out.pop();
            }
            part => out.push(part),
        }
    }
    out
}

/// The same from the root of the disk.
pub fn absolute(path: &Path) -> PathBuf {
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    clean(&std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf()))
}

/// Is there such a file, or for a name with a place for the frame's number one for some frame?
fn exists(path: &Path) -> bool {
    let pattern = path.file_name().map(|n| n.to_string_lossy().into_owned()).filter(|n| has_pattern(n));
    let Some(pattern) = pattern.filter(|_| !path.exists()) else { return path.exists() };
    let marks = |c: char| "#@%".contains(c);
    let (head, _) = pattern.split_once(marks).unwrap_or_default();
    let (_, tail) = pattern.rsplit_once(['#', '@', 'd']).unwrap_or_default();
    names_in(path.parent().unwrap_or(Path::new("")))
        .iter()
        .any(|n| n.len() > head.len() + tail.len() && n.starts_with(head) && n.ends_with(tail))
}

/// The files of a folder, sorted.
fn names_in(folder: &Path) -> Vec<String> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> =
        entries.filter_map(|entry| Some(entry.file_name().to_str()?.to_string())).collect();
    names.sort_unstable();
    names
}

impl Host for Disk {
    fn import(&self, importing: &str, path: &str) -> Result<(String, String), HostError> {
        self.find(importing, path, &|_| None)
    }

    fn hint(&self) -> Option<String> {
        let more = "A program can import files only from its own folder and below, and from the folders of `--path`.";
        Some(more.into())
    }

    fn image(&self, program: &str, name: &str) -> Result<Origin, HostError> {
        let places = self.places(program, name);
        let found = places.iter().find(|path| exists(path)).ok_or_else(|| nowhere(&places))?;
        Ok(Origin::File(Input::Confined { path: found.clone(), folders: Folders::new(self.roots(program)) }))
    }

    fn images(&self, program: &str, name: &str) -> Vec<String> {
        const ENDINGS: [&str; 10] = ["exr", "png", "jpg", "jpeg", "tif", "tiff", "hdr", "bmp", "tga", "webp"];
        let folder = Path::new(name).parent().unwrap_or(Path::new(""));
        let image =
            |n: &String| n.rsplit_once('.').is_some_and(|(_, e)| ENDINGS.contains(&&*e.to_lowercase()));
        let roots = self.roots(program);
        let allowed = Folders::new(&roots);
        let folders = roots.iter().map(|root| absolute(&root.join(folder)));
        let mine = folders.filter(|folder| allowed.resolve(folder).is_ok());
        mine.flat_map(|f| names_in(&f)).filter(image).map(|n| folder.join(n).display().to_string()).collect()
    }

    fn image_hint(&self) -> Option<String> {
        let more =
            "A program can read images only from its own folder and below, and from the folders of `--path`.";
        Some(more.into())
    }
}
