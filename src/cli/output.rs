//! The files that come out: whether they can be written, and what of a run goes into them.

use super::failure::{Failure, why};
use pse::image::{Force, Format, Image, TargetKey, check_target, set_force, target_keys, written_by_pse};
use pse::internal::program::Program;
use pse::internal::shape::Shape;
use pse::internal::vocabulary;
use std::borrow::Cow;
use std::collections::HashMap;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

/// Finds out before the work whether a file can be written at all.
pub(super) fn check(path: &Path) -> Result<Format, Failure> {
    let format = Format::of(path)?;
    if path.as_os_str() == "-" {
        if std::io::stdout().is_terminal() {
            return Err(Failure::plain("cannot write an EXR file to the terminal")
                .hint("Redirect it to a file or a program: … -o - | pse run other.pse -i - -o out.png."));
        }
        return Ok(format);
    }
    check_target(path)?;
    Ok(format)
}

/// Checks the file of a name that the user did not choose: one that another program wrote is not replaced.
pub(super) fn check_default(path: &Path, force: bool) -> Result<(), Failure> {
    // A link to no file yet replaces nothing.
    if force || std::fs::metadata(path).is_err() || written_by_pse(path) {
        return Ok(());
    }
    let shown = path.display();
    Err(Failure::plain(format!("`{shown}` exists, and pse did not write it"))
        .hint("Give a name with -o. To replace the file, add --force."))
}

/// The outputs of a command, of which no two may be one file.
#[derive(Default)]
pub(super) struct Distinct {
    /// By each of the keys of their files.
    known: HashMap<TargetKey, PathBuf>,
}

impl Distinct {
    /// Adds an output; an error if it is one of those before it, under whatever name.
    pub fn add(&mut self, path: &Path) -> Result<(), Failure> {
        let keys = target_keys(path);
        let same = keys.iter().find_map(|key| self.known.get(key));
        match same {
            Some(other) if other == path => {
                Err(Failure::usage(format!("two outputs are called {}", shown(path))))
            }
            Some(other) => {
                let (one, two) = (other.display(), path.display());
                Err(Failure::usage(format!("the outputs `{one}` and `{two}` are the same file")))
            }
            None => {
                self.known.extend(keys.into_iter().map(|key| (key, path.to_path_buf())));
                Ok(())
            }
        }
    }
}

/// What `--force` means for the files that a command writes.
pub(super) fn force(given: bool) {
    set_force(if given { Force::Given } else { Force::Offered });
}

/// The failure to write a file, with a hint about `--mkdir` if its folder is missing.
pub(super) fn or_mkdir(failure: Failure, path: &Path) -> Failure {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    match folder.is_some_and(|folder| !folder.exists()) {
        true => failure.hint("Or create it with --mkdir."),
        false => failure,
    }
}

/// Makes the folder that a file is to lie in.
pub(super) fn make_folder(path: &Path) -> Result<(), Failure> {
    let Some(folder) = path.parent().filter(|p| !p.as_os_str().is_empty()) else { return Ok(()) };
    std::fs::create_dir_all(folder)
        .map_err(|e| Failure::plain(format!("cannot create the folder `{}`: {}", folder.display(), why(&e))))
}

/// What messages call it.
pub(super) fn shown(path: &Path) -> String {
    match path.as_os_str() == "-" {
        true => "standard output".into(),
        false => path.display().to_string(),
    }
}

/// The one variable, other than `color`, that pictures are to show; `None` if `color` is shown.
///
/// A picture needs a colour. Where the program gives none, the user has to say what to show instead.
pub(super) fn shown_variable(
    program: &Program,
    vars: Option<&[String]>,
    picture: &str,
) -> Result<Option<String>, Failure> {
    let by_normal = program.resolved().by_normal.is_some();
    let no_color = |what: &str| Failure::plain(format!("cannot write `{picture}`: {what}"));
    let assigned: Vec<&str> = program.assigned().collect();
    match vars {
        Some(vars) if vars.iter().any(|v| v == "color") => Ok(None),
        Some([one]) => Ok(Some(one.clone())),
        Some(vars) => {
            Err(no_color(&format!("a picture shows color or one variable, not {}", vars.join(" and ")))
                .hint("Write an .exr file, which holds all of them."))
        }
        None if by_normal || assigned.contains(&"color") || assigned.is_empty() => Ok(None),
        None => Err(assigned
            .iter()
            .filter(|name| vocabulary::output(name) == Some("color"))
            .fold(no_color("the program assigns no color"), |failure, name| {
                failure.hint(format!("`{name}` is called `color` here."))
            })
            .hint(format!("It assigns {}.", assigned.join(", ")))
            .hint(format!(
                "Show one of them with --vars {0}, add a line color = {0}, or write an .exr file, \
                 which holds any variable.",
                assigned.last().unwrap_or(&"…")
            ))),
    }
}

/// The image as a picture shows it: the variable `name` as its colour.
pub(super) fn picture<'a>(image: &'a Image<'a>, name: &str) -> Result<Image<'a>, Failure> {
    let Some(variable) = image.variable(name) else { return Ok(image.clone()) };
    if !matches!(variable.shape, Shape::Scalar | Shape::Vector(3 | 4)) {
        let message = format!("{name} is {}, which a picture cannot show", variable.shape);
        return Err(Failure::plain(message)
            .hint("A picture shows a scalar (as grey) or a vector of 3 or 4 (as a colour)."));
    }
    let mut color = variable.clone();
    color.name = "color".into();
    color.planes = variable.planes.iter().map(|p| Cow::Borrowed(&**p)).collect();
    Ok(Image {
        width: image.width,
        height: image.height,
        variables: vec![color],
        metadata: image.metadata.clone(),
    })
}
