//! Where imported programs come from: the disk for the command, memory for tests and embedders.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Finds the files that `import` names.
pub trait Host: Send + Sync {
    /// The text of the file that `path` names in a program called `importing`, and the name under which
    /// messages show it. `Err` says where it was looked for, as a sentence.
    fn import(&self, importing: &str, path: &str) -> Result<(String, String), String>;

    /// Where imports are looked for, as a sentence, for who misses one.
    fn hint(&self) -> Option<String> {
        None
    }
}

/// No files: every import is an error.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl Host for NoFiles {
    fn import(&self, _: &str, _: &str) -> Result<(String, String), String> {
        Err("this program can import no files".into())
    }
}

/// Files in memory, by name.
#[derive(Clone, Debug, Default)]
pub struct Memory(pub HashMap<String, String>);

impl Host for Memory {
    fn import(&self, _: &str, path: &str) -> Result<(String, String), String> {
        match self.0.get(path) {
            Some(text) => Ok((path.to_string(), text.clone())),
            None => Err("there is no file of that name".into()),
        }
    }

    fn hint(&self) -> Option<String> {
        let mut names: Vec<&str> = self.0.keys().map(String::as_str).collect();
        names.sort_unstable();
        (!names.is_empty()).then(|| format!("The files are {}.", names.join(", ")))
    }
}

/// Files on disk: beside the importing file, then in the given folders.
#[derive(Clone, Debug, Default)]
pub struct Disk {
    /// Folders to search after the importing file's own.
    pub path: Vec<PathBuf>,
}

impl Host for Disk {
    fn import(&self, importing: &str, path: &str) -> Result<(String, String), String> {
        let beside = Path::new(importing).parent().unwrap_or(Path::new(""));
        let mut tried = Vec::new();
        for folder in std::iter::once(beside).chain(self.path.iter().map(PathBuf::as_path)) {
            let file = folder.join(path);
            match std::fs::read_to_string(&file) {
                Ok(text) => return Ok((file.display().to_string(), text)),
                Err(e) if e.kind() == std::io::ErrorKind::NotFound => tried.push(file.display().to_string()),
                Err(e) => return Err(format!("{}: {e}", file.display())),
            }
        }
        Err(format!("there is no {}", tried.join(" and no ")))
    }

    fn hint(&self) -> Option<String> {
        let more =
            "An import is looked for beside the file that imports it, then in the folders of `--path`.";
        Some(more.into())
    }
}
