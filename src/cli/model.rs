//! Meshes that are looked at: read once, and kept for the next frame.

use super::failure::{Failure, warn};
use super::progress::{Meter, Style};
use clap::ValueEnum;
use pse::internal::program::Progress;
use pse::mesh::{self, Format};
use pse::scene::{Model, parse_point};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

/// Which way is up in a file of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum Up {
    /// y is up, as in glTF and most OBJ and PLY files; the mesh is rotated
    #[default]
    Y,
    /// z is up, as in the built-in scenes; the mesh is not rotated
    Z,
}

/// What is moved to the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Recenter {
    /// The middle of the mesh, rounded to a hundredth of its size or better
    Middle,
    /// A point in the space of `point`
    Point([f64; 3]),
}

impl Recenter {
    /// Parses the option's value.
    pub fn parse(text: &str) -> Result<Recenter, String> {
        match text {
            MIDDLE => Ok(Recenter::Middle),
            _ => parse_point(text).map(Recenter::Point).map_err(|e| e.hint()),
        }
    }

    /// The point of a mesh that is to be at the origin.
    pub fn origin(self, mesh: &mesh::Mesh) -> [f64; 3] {
        match self {
            Recenter::Middle => mesh.round_middle(),
            Recenter::Point(point) => point,
        }
    }
}

/// The value of `--recenter` where none is given.
pub(super) const MIDDLE: &str = "middle";

/// Reports that `point` is coarse where the mesh is.
pub(super) fn warn_coarse(path: &Path, mesh: &mesh::Mesh) {
    if let Some(step) = mesh.coarse_step() {
        warn(&format!(
            "{}: the mesh is so far from the origin that its `point`, in 32-bit floats, has steps of {}. Add --recenter to \
             move its middle to the origin.",
            path.display(),
            step as f32
        ));
    }
}

/// What a model was made from: file, direction, origin, and the file's length and time.
type Key = (PathBuf, Up, Option<Recenter>, u64, Option<SystemTime>);

/// The model that was made last.
static LAST: Mutex<Option<(Key, Arc<Model>)>> = Mutex::new(None);

/// The mesh of a file, ready to be looked at.
pub(super) fn load(
    path: &Path,
    up: Up,
    recenter: Option<Recenter>,
    quiet: bool,
) -> Result<Arc<Model>, Failure> {
    let about = std::fs::metadata(path).ok();
    let time = about.as_ref().and_then(|about| about.modified().ok());
    let key: Key = (path.to_path_buf(), up, recenter, about.map_or(0, |about| about.len()), time);
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, model)) = last.as_ref().filter(|(of, _)| *of == key) {
        return Ok(Arc::clone(model));
    }
    // The old one need not be there while the new one is made.
    *last = None;
    let mut mesh = read(path, quiet)?;
    if up == Up::Y {
        mesh.y_up_to_z_up();
    }
    match recenter {
        Some(recenter) => {
            let [x, y, z] = recenter.origin(&mesh);
            mesh.translate([-x, -y, -z]);
            if !quiet && recenter == Recenter::Middle {
                let path = path.display();
                warn(&format!("{path}: moved {x},{y},{z} to the origin (--recenter={x},{y},{z})"));
            }
        }
        None if !quiet => warn_coarse(path, &mesh),
        None => {}
    }
    let model = Arc::new(Model::new(mesh)?);
    *last = Some((key, Arc::clone(&model)));
    Ok(model)
}

/// The mesh of a file, or the built-in head, as it is there. How far reading has come is shown, and what was left out.
pub(super) fn read(path: &Path, quiet: bool) -> Result<mesh::Mesh, Failure> {
    if path.as_os_str() == "head" && !path.exists() {
        return Ok(mesh::head());
    }
    let meter = Meter::new(&path.display().to_string(), Style::Bar, quiet, 1);
    let file = mesh::read(path, &|done, total| meter.update(Progress { done, total }))?;
    meter.frame();
    if !quiet {
        for note in &file.notes {
            warn(&format!("{}: {note}", path.display()));
        }
    }
    Ok(file.mesh)
}

/// The files that a mesh is made of: its own, and those that a .gltf file names.
pub(super) fn files(path: &Path) -> Vec<PathBuf> {
    let built_in = path.as_os_str() == "head" && !path.exists();
    let mut files = if built_in { Vec::new() } else { vec![path.to_path_buf()] };
    if Format::of(path) == Some(Format::Gltf) {
        files.extend(mesh::companions(path));
    }
    files
}
