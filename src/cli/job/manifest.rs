//! The list of a bundle's files, kept in the bundle: what is not on it is not ours to replace.

use super::super::failure::{Failure, why};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

/// Its name in the bundle.
pub(super) const NAME: &str = "pse-bundle.json";

/// The longest list that is read, in bytes.
const MAX_LENGTH: u64 = 64 << 20;

/// The version of the list's form.
const VERSION: u64 = 1;

/// The files and folders that `pse` put into a bundle, by their places in it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Manifest {
    /// Each file with the digests of what it may hold: one, or while the bundle is replaced that of before and after.
    pub files: BTreeMap<PathBuf, BTreeSet<String>>,
    /// Folders, each after the one that it lies in.
    pub folders: BTreeSet<PathBuf>,
}

impl Manifest {
    /// The list of a bundle; `None` where there is none.
    pub fn read(bundle: &Path) -> Result<Option<Manifest>, Failure> {
        let path = bundle.join(NAME);
        // The bundle may come from anybody, so the list may be anything.
        let bytes = pse::internal::files::regular(&path)
            .and_then(|file| pse::internal::files::read_all(file, MAX_LENGTH));
        let text = match bytes {
            Ok(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(Failure::plain(format!("cannot read `{}`: {}", path.display(), why(&e)))),
        };
        if text.is_empty() {
            // A command was killed before it wrote the list, and so before it wrote anything else.
            return Ok(Some(Manifest::default()));
        }
        let list = serde_json::from_str(&text).ok().and_then(|value| Manifest::of_json(&value));
        match list {
            Some(list) => Ok(Some(list)),
            None => Err(Failure::plain(format!("`{}` does not list the files of a bundle", path.display()))
                .hint("Give another folder for the bundle.")),
        }
    }

    fn of_json(value: &Value) -> Option<Manifest> {
        let mut list = Manifest::default();
        if value["version"].as_u64()? != VERSION {
            return None;
        }
        for (name, digests) in value["files"].as_object()? {
            let digests = digests.as_array()?.iter().map(|d| d.as_str().map(String::from));
            list.files.insert(place(name)?, digests.collect::<Option<_>>()?);
        }
        for name in value["folders"].as_array()? {
            list.folders.insert(place(name.as_str()?)?);
        }
        Some(list)
    }

    /// Its text.
    pub fn json(&self) -> String {
        // Names have `/` between the folders, whatever the system.
        let name = |path: &Path| {
            path.components().map(|c| c.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
        };
        let files: serde_json::Map<String, Value> =
            self.files.iter().map(|(path, digests)| (name(path), json!(digests))).collect();
        let folders: Vec<String> = self.folders.iter().map(|path| name(path)).collect();
        let about = "The files of this bundle that `pse job` may replace, with their BLAKE3 digests.";
        let list = json!({ "about": about, "version": VERSION, "files": files, "folders": folders });
        format!("{list:#}\n")
    }

    /// With what another one lists too.
    pub fn and(&self, other: &Manifest) -> Manifest {
        let mut both = self.clone();
        for (path, digests) in &other.files {
            both.files.entry(path.clone()).or_default().extend(digests.iter().cloned());
        }
        both.folders.extend(other.folders.iter().cloned());
        both
    }

    /// Lists all that is in a folder, as if it were the folder `at` of the bundle.
    pub fn add(&mut self, folder: &Path, at: &Path) -> io::Result<()> {
        self.folders.insert(at.to_path_buf());
        for entry in fs::read_dir(folder)? {
            let entry = entry?;
            let (path, place) = (entry.path(), at.join(entry.file_name()));
            match entry.file_type()?.is_dir() {
                true => self.add(&path, &place)?,
                false => self.add_file(&path, &place)?,
            }
        }
        Ok(())
    }

    /// Lists a file that is not there yet, and the folders that it will lie in.
    pub fn add_place(&mut self, place: &Path) {
        self.files.entry(place.to_path_buf()).or_default();
        let folders = place.ancestors().skip(1).filter(|folder| !folder.as_os_str().is_empty());
        self.folders.extend(folders.map(Path::to_path_buf));
    }

    /// Lists a file at its place.
    pub fn add_file(&mut self, path: &Path, place: &Path) -> io::Result<()> {
        self.files.entry(place.to_path_buf()).or_default().insert(digest(path)?);
        Ok(())
    }

    /// Refuses to replace or remove what stands at a place of the bundle if it is not as it was written. `force`: listed
    /// files that were changed are replaced.
    pub fn check(&self, bundle: &Path, at: &Path, force: bool) -> Result<(), Failure> {
        let foreign = |path: &Path| {
            Failure::plain(format!("`{}` exists, and is not part of a bundle of pse", path.display()))
                .hint("Give a folder of its own: -o fire.job.")
        };
        let mut path = bundle.to_path_buf();
        for folder in at.parent().into_iter().flat_map(Path::components) {
            path.push(folder);
            match fs::symlink_metadata(&path) {
                Ok(about) if !about.is_dir() => return Err(foreign(&path)),
                Ok(_) | Err(_) => {}
            }
        }
        let path = bundle.join(at);
        let Ok(about) = fs::symlink_metadata(&path) else { return Ok(()) };
        let Some(digests) = self.files.get(at).filter(|_| about.is_file()) else {
            return Err(foreign(&path));
        };
        if force || digest(&path).is_ok_and(|digest| digests.contains(&digest)) {
            return Ok(());
        }
        Err(Failure::plain(format!("`{}` was changed after pse wrote it", path.display()))
            .hint("Move it away, or add --force to replace it."))
    }
}

/// Whether a folder of the bundle is one, and no link leads to it: only such a folder is removed.
pub(super) fn is_own_folder(bundle: &Path, at: &Path) -> bool {
    let mut path = bundle.to_path_buf();
    at.components().all(|part| {
        path.push(part);
        fs::symlink_metadata(&path).is_ok_and(|about| about.is_dir())
    })
}

/// A place in a bundle: never outside of it.
fn place(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(name);
    let inside = path.components().all(|part| matches!(part, Component::Normal(_)));
    // No file has such a name, and the system's error about it would not say which.
    (inside && !name.is_empty() && !name.contains('\0')).then_some(path)
}

/// The digest of a file's content.
fn digest(path: &Path) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(fs::File::open(path)?)?;
    Ok(hasher.finalize().to_hex().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_read_again() {
        let mut list = Manifest::default();
        list.files.insert("program/a.pse".into(), ["1".to_string(), "2".to_string()].into());
        list.folders.extend([PathBuf::from("program"), PathBuf::from("program/path-1")]);
        let value = serde_json::from_str(&list.json()).unwrap();
        assert_eq!(Manifest::of_json(&value), Some(list));
    }

    #[test]
    fn lists_name_nothing_outside() {
        for name in ["../a", "/etc/passwd", "program/../../a", "", ".", "\0", "program/a\0.pse"] {
            let files = serde_json::Map::from_iter([(name.to_string(), json!([]))]);
            let list = json!({ "version": 1, "files": files, "folders": [] });
            assert_eq!(Manifest::of_json(&list), None, "{name}");
            let list = json!({ "version": 1, "files": {}, "folders": [name] });
            assert_eq!(Manifest::of_json(&list), None, "{name}");
        }
    }
}
