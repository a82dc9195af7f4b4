//! The folder of a bundle: put together beside its place, and then replaced so that it is whole at every moment.
//!
//! A template names the folder of its program. While files of the program are replaced, the bundle's template is an interim
//! one that names the staged copy of the new program. So whenever the command is killed, the template that is there has all
//! files of its program: those of before or those of after. The manifest lists what both have, for the next time.

use super::super::failure::{Failure, why};
use super::files::{FOLDER, Files};
use super::manifest::{self, Manifest};
use pse::image::{Unfinished, commit};
use std::fs::{self, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// The folder in the bundle that the new files are put into first.
const STAGED: &str = ".pse-staged";

/// Staged files beside those of the bundle: the interim template, a file on the way to its place, and a new list.
const INTERIM: &str = "interim.json";
const NEXT: &str = "next";
const LIST: &str = "list.json";

/// The folder of the pictures, whose content is nobody's here.
const OUTPUT: &str = "output";

/// The template, and the values of its parameters for Deadline Cloud.
const TEMPLATE: &str = "template.json";
const VALUES: &str = "parameter_values.json";

/// The program's folder as an interim template names it.
pub(super) fn staged_folder() -> String {
    format!("{STAGED}/{FOLDER}")
}

/// What is written beside the program's files.
pub(super) struct Texts {
    pub template: String,
    /// The same, of a program that lies in [`staged_folder`].
    pub interim: String,
    pub values: Option<String>,
}

/// Writes a bundle, or replaces one that `pse` wrote. What jobs have put into the folder of the output stays, and so does
/// everything that is on no list. `force`: files of the bundle that were changed by hand are replaced too.
pub(super) fn write(bundle: &Path, files: &Files, texts: &Texts, force: bool) -> Result<(), Failure> {
    check_folder(bundle)?;
    let fresh = !bundle.exists();
    // Of folders that were not there, the outermost is taken away again with those in it.
    let outermost =
        bundle.ancestors().take_while(|path| !path.as_os_str().is_empty() && !path.exists()).last();
    let outermost = outermost.map_or(bundle.to_path_buf(), Path::to_path_buf);
    let make = || fs::create_dir_all(bundle);
    // A folder that was not there is taken away again if there is no bundle for it.
    let made = if fresh { Some(Unfinished::create(make, |()| outermost.clone())) } else { None };
    let made = made.transpose().map_err(|e| fail("make the folder", bundle, &e))?;
    let written = fill(bundle, files, texts, force, made);
    if written.is_err() && fresh {
        // Only what is empty can be removed so.
        let mut own = bundle.ancestors().take_while(|path| path.starts_with(&outermost));
        let _ = own.try_for_each(fs::remove_dir);
    }
    written
}

fn fail(what: &str, path: &Path, error: &io::Error) -> Failure {
    Failure::plain(format!("cannot {what} `{}`: {}", path.display(), why(error)))
}

fn fill(
    bundle: &Path,
    files: &Files,
    texts: &Texts,
    force: bool,
    made: Option<((), Unfinished)>,
) -> Result<(), Failure> {
    files.check_outside(bundle)?;
    let _lock = lock(bundle)?;
    let known = Manifest::read(bundle)?;
    let old = known.clone().unwrap_or_default();
    check_names(bundle, known.as_ref())?;
    let staged = Staged::new(bundle, &old, known.is_some(), &files.list())?;
    files.copy(&staged.path)?;
    let mut new = staged.list()?;
    for (name, text) in [(TEMPLATE, Some(&texts.template)), (VALUES, texts.values.as_ref())] {
        if let Some(text) = text {
            new.add_file(&staged.write(name, text)?, Path::new(name))
                .map_err(|e| fail("read", &staged.path, &e))?;
        }
    }
    let mut interim = Manifest::default();
    let path = staged.write(INTERIM, &texts.interim)?;
    interim.add_file(&path, Path::new(TEMPLATE)).map_err(|e| fail("read", &path, &e))?;
    for place in old.files.keys().chain(new.files.keys()) {
        old.check(bundle, place, force)?;
    }
    new.folders.iter().try_for_each(|folder| check_folder(&bundle.join(folder)))?;
    check_folder(&bundle.join(OUTPUT))?;
    // From here on there is nothing left that takes time, or much of the disk.
    commit(|| {
        drop(made);
        let change = Change { bundle, staged, old: &old, new: &new };
        change.apply(&old.and(&new).and(&interim))
    })
}

/// Refuses a folder in which something else has the names of a bundle.
fn check_names(bundle: &Path, known: Option<&Manifest>) -> Result<(), Failure> {
    for name in [FOLDER, TEMPLATE, VALUES, STAGED] {
        let path = bundle.join(name);
        let listed = |list: &Manifest| {
            let place = Path::new(name);
            name == STAGED || list.files.contains_key(place) || list.folders.contains(place)
        };
        if fs::symlink_metadata(&path).is_ok() && !known.is_some_and(listed) {
            let message = format!("`{}` exists, and is not part of a bundle of pse", path.display());
            let failure = Failure::plain(message).hint("Give a folder of its own: -o fire.job.");
            return Err(match bundle.join(TEMPLATE).exists() && known.is_none() {
                true => failure.hint(format!(
                    "A bundle without {} was written by an older pse or by another program. Move it away first.",
                    manifest::NAME
                )),
                false => failure,
            });
        }
    }
    Ok(())
}

/// Refuses a file where a folder of the bundle has to be.
fn check_folder(path: &Path) -> Result<(), Failure> {
    match path.exists() && !path.is_dir() {
        true => Err(Failure::plain(format!("`{}` is not a folder", path.display()))
            .hint("Give a folder of its own: -o fire.job.")),
        false => Ok(()),
    }
}

/// Keeps other commands from the bundle, where the system can.
fn lock(bundle: &Path) -> Result<Option<fs::File>, Failure> {
    let Ok(folder) = fs::File::open(bundle) else { return Ok(None) };
    match folder.try_lock() {
        Err(TryLockError::WouldBlock) => {
            Err(Failure::plain(format!("another command is writing the bundle `{}`", bundle.display())))
        }
        Ok(()) | Err(TryLockError::Error(_)) => Ok(Some(folder)),
    }
}

/// The new files beside their places. They are removed when this is dropped, unless a template needs them.
struct Staged {
    path: PathBuf,
    /// The list that the bundle had; a bundle without one loses that of the staged files too.
    manifest: PathBuf,
    listed: bool,
    unfinished: Option<[Option<Unfinished>; 2]>,
}

impl Staged {
    /// Makes the folder, with the list of the program's files, `new`, that will be put into it.
    fn new(bundle: &Path, old: &Manifest, listed: bool, new: &Manifest) -> Result<Staged, Failure> {
        let (path, manifest) = (bundle.join(STAGED), bundle.join(manifest::NAME));
        // Of a command that was killed; the bundle has a list, so this folder is ours. But a template may need it.
        if listed && fs::symlink_metadata(&path).is_ok() {
            finish_interrupted(bundle, old)?;
        }
        let mut staged = Staged { path, manifest, listed, unfinished: Some([None, None]) };
        let write = |e| fail("write into", bundle, &e);
        if !listed {
            // The list comes first: what is left of a killed command is known by it.
            let list = || fs::write(&staged.manifest, old.json());
            let ((), unfinished) = Unfinished::create(list, |()| staged.manifest.clone()).map_err(write)?;
            staged.unfinished = Some([Some(unfinished), None]);
        }
        let made = Unfinished::create(|| fs::create_dir(&staged.path), |()| staged.path.clone());
        let ((), unfinished) = made.map_err(write)?;
        if let Some([_, folder]) = &mut staged.unfinished {
            *folder = Some(unfinished);
        }
        // What is removed in the end, by whatever command, is what is listed, and nothing that somebody else has put there.
        staged.write(manifest::NAME, &new.json())?;
        Ok(staged)
    }

    /// Writes a text beside the program's folder.
    fn write(&self, name: &str, text: &str) -> Result<PathBuf, Failure> {
        let path = self.path.join(name);
        // What was installed under another name is the same file.
        let _ = fs::remove_file(&path);
        fs::write(&path, text).map_err(|e| fail("write", &path, &e))?;
        Ok(path)
    }

    /// The program's files at their places.
    fn list(&self) -> Result<Manifest, Failure> {
        let mut list = Manifest::default();
        let folder = self.path.join(FOLDER);
        if folder.exists() {
            list.add(&folder, Path::new(FOLDER)).map_err(|e| fail("read", &folder, &e))?;
        }
        Ok(list)
    }

    /// From now on a template may need the files: they stay until the end of the change.
    fn keep(&mut self) {
        self.unfinished = None;
    }
}

impl Drop for Staged {
    fn drop(&mut self) {
        if self.unfinished.is_some() {
            let _ = remove_staged(&self.path);
            if !self.listed {
                let _ = fs::remove_file(&self.manifest);
            }
        }
    }
}

/// The longest template that is read, in bytes.
const MAX_TEMPLATE: u64 = 64 << 20;

/// Makes a bundle independent of the staged files that a killed command has left, and removes these.
fn finish_interrupted(bundle: &Path, old: &Manifest) -> Result<(), Failure> {
    let staged = bundle.join(STAGED);
    let template = bundle.join(TEMPLATE);
    let bytes = pse::internal::files::regular(&template)
        .and_then(|file| pse::internal::files::read_all(file, MAX_TEMPLATE));
    let text = String::from_utf8_lossy(&bytes.unwrap_or_default()).into_owned();
    if text.contains(&staged_folder()) {
        let list = listed_in(&staged);
        let files = list.files.keys().filter(|place| place.starts_with(FOLDER));
        for place in files.filter(|place| staged.join(place).is_file()) {
            old.check(bundle, place, false)?;
            install(&staged, &staged.join(place), &bundle.join(place))?;
        }
        for (name, to) in [(VALUES, bundle.join(VALUES)), (TEMPLATE, template)] {
            let from = staged.join(name);
            if from.exists() {
                install(&staged, &from, &to)?;
            }
        }
    }
    match remove_staged(&staged)? {
        None => Ok(()),
        Some(foreign) => {
            Err(Failure::plain(format!("`{}` is not a file that pse put there", foreign.display()))
                .hint("Move it away: the folder is only for files that pse is moving into the bundle."))
        }
    }
}

/// The list in the folder of staged files; one that was killed before it was whole lists nothing.
fn listed_in(staged: &Path) -> Manifest {
    Manifest::read(staged).ok().flatten().unwrap_or_default()
}

/// Removes the staged files and their folder. What is on no list stays, and the first of it is returned.
fn remove_staged(staged: &Path) -> Result<Option<PathBuf>, Failure> {
    let list = listed_in(staged);
    let own = [TEMPLATE, VALUES, INTERIM, NEXT, LIST].map(PathBuf::from);
    for place in list.files.keys().chain(&own) {
        let folder = place.parent().unwrap_or(Path::new(""));
        if manifest::is_own_folder(staged, folder)
            && staged.join(place).symlink_metadata().is_ok_and(|f| !f.is_dir())
        {
            let path = staged.join(place);
            fs::remove_file(&path).map_err(|e| fail("remove", &path, &e))?;
        }
    }
    // The innermost first.
    for folder in list.folders.iter().rev().filter(|folder| manifest::is_own_folder(staged, folder)) {
        let _ = fs::remove_dir(staged.join(folder));
    }
    let foreign = foreign_file(staged, &list).map_err(|e| fail("read", staged, &e))?;
    if foreign.is_none() {
        let path = staged.join(manifest::NAME);
        match fs::remove_file(&path) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(fail("remove", &path, &e)),
            _ => fs::remove_dir(staged).map_err(|e| fail("remove", staged, &e))?,
        }
    }
    Ok(foreign)
}

/// Something in the folder that is left beside its list and the folders on it.
fn foreign_file(staged: &Path, list: &Manifest) -> io::Result<Option<PathBuf>> {
    let mut folders = vec![PathBuf::new()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(staged.join(&folder))? {
            let entry = entry?;
            let place = folder.join(entry.file_name());
            match entry.file_type()?.is_dir() && list.folders.contains(&place) {
                true => folders.push(place),
                false if place == Path::new(manifest::NAME) => {}
                false => return Ok(Some(entry.path())),
            }
        }
    }
    Ok(None)
}

/// Puts a staged file to its place, at once; it stays staged too.
fn install(staged: &Path, from: &Path, to: &Path) -> Result<(), Failure> {
    let next = staged.join(NEXT);
    // It may be another name of a staged file, left by a command that was killed.
    let _ = fs::remove_file(&next);
    let copied = fs::hard_link(from, &next).or_else(|_| fs::copy(from, &next).map(drop));
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder).map_err(|e| fail("make the folder", folder, &e))?;
    }
    copied.and_then(|()| fs::rename(&next, to)).map_err(|e| fail("write", to, &e))
}

/// From one state of a bundle to the next.
struct Change<'a> {
    bundle: &'a Path,
    staged: Staged,
    old: &'a Manifest,
    new: &'a Manifest,
}

impl Change<'_> {
    fn apply(mut self, all: &Manifest) -> Result<(), Failure> {
        let list = self.bundle.join(manifest::NAME);
        self.write_list(all, &list)?;
        let (template, values) = (Path::new(TEMPLATE), Path::new(VALUES));
        if self.bundle.join(TEMPLATE).exists() && self.differs() {
            if self.changed(values) {
                self.remove(values)?;
            }
            self.staged.keep();
            self.install(INTERIM, template)?;
        }
        self.staged.keep();
        let program = |place: &&PathBuf| place.starts_with(FOLDER);
        for place in self.new.files.keys().filter(|place| **place == values || program(place)) {
            self.install(place, place)?;
        }
        for folder in self.new.folders.iter().map(PathBuf::as_path).chain([Path::new(OUTPUT)]) {
            let folder = self.bundle.join(folder);
            fs::create_dir_all(&folder).map_err(|e| fail("make the folder", &folder, &e))?;
        }
        self.install(TEMPLATE, template)?;
        for place in self.old.files.keys().filter(|place| !self.new.files.contains_key(*place)) {
            self.remove(place)?;
        }
        // The innermost first. One with something else in it stays.
        for folder in self.old.folders.difference(&self.new.folders).collect::<Vec<_>>().into_iter().rev() {
            if manifest::is_own_folder(self.bundle, folder) {
                let _ = fs::remove_dir(self.bundle.join(folder));
            }
        }
        self.write_list(self.new, &list)?;
        // What somebody else has put there in the meantime stays.
        remove_staged(&self.staged.path).map(drop)
    }

    /// Whether anything is not as it was.
    fn differs(&self) -> bool {
        self.old.files.len() != self.new.files.len() || self.new.files.keys().any(|place| self.changed(place))
    }

    fn changed(&self, place: &Path) -> bool {
        self.old.files.get(place) != self.new.files.get(place)
    }

    fn write_list(&self, list: &Manifest, to: &Path) -> Result<(), Failure> {
        // The staged files have a list at every moment, too.
        let path = self.staged.write(LIST, &list.json())?;
        install(&self.staged.path, &path, &self.staged.path.join(manifest::NAME))?;
        install(&self.staged.path, &path, to)
    }

    fn install(&self, from: impl AsRef<Path>, place: &Path) -> Result<(), Failure> {
        install(&self.staged.path, &self.staged.path.join(from), &self.bundle.join(place))
    }

    fn remove(&self, place: &Path) -> Result<(), Failure> {
        let path = self.bundle.join(place);
        match fs::remove_file(&path) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => Err(fail("remove", &path, &e)),
            _ => Ok(()),
        }
    }
}
