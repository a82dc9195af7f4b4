//! The folder of a bundle: made beside its place, and put there when it is whole.

use super::super::failure::{Failure, why};
use super::files::{FOLDER, Files};
use std::fs;
use std::io;
use std::path::Path;

/// Writes the program's files and the texts, of which those that are not there are taken away. What jobs have put into the folder of
/// the output stays.
pub(super) fn write(bundle: &Path, files: &Files, texts: &[(&str, Option<String>)]) -> Result<(), Failure> {
    let fail = |what: &str, path: &Path, e: &io::Error| {
        Failure::plain(format!("cannot {what} `{}`: {}", path.display(), why(e)))
    };
    let program = bundle.join(FOLDER);
    if program.exists() && !bundle.join("template.json").exists() {
        let message = format!("`{}` is there, and of no bundle", program.display());
        return Err(Failure::plain(message).hint("Give a folder for the bundle alone: -o fire.job."));
    }
    let output = bundle.join("output");
    fs::create_dir_all(&output).map_err(|e| fail("make the folder", &output, &e))?;
    let fresh = tempfile::Builder::new().prefix(".pse-").tempdir_in(bundle);
    let fresh = fresh.map_err(|e| fail("write into", bundle, &e))?;
    files.copy(fresh.path())?;
    for (name, text) in texts {
        let path = fresh.path().join(name);
        let Some(text) = text else { continue };
        fs::write(&path, text).map_err(|e| fail("write", &bundle.join(name), &e))?;
    }
    // From here on there is nothing left that takes time, or much of the disk.
    let gone = |result: io::Result<()>| match result {
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(()),
        other => other,
    };
    gone(fs::remove_dir_all(&program)).map_err(|e| fail("replace", &program, &e))?;
    let made = fresh.path().join(FOLDER);
    if made.exists() {
        fs::rename(&made, &program).map_err(|e| fail("write", &program, &e))?;
    }
    for (name, text) in texts {
        let path = bundle.join(name);
        match text {
            Some(_) => fs::rename(fresh.path().join(name), &path),
            None => gone(fs::remove_file(&path)),
        }
        .map_err(|e| fail("write", &path, &e))?;
    }
    Ok(())
}
