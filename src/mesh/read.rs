//! Reading a mesh, whatever its format.

use super::{Format, Mesh, read_gltf, read_obj, read_ply};
use crate::files;
use crate::image::{Content, ErrorKind, ImageError, recorded};
use std::path::Path;

/// The most bytes of a mesh's file, which is read as a whole.
const MAX_BYTES: u64 = 16 << 30;

/// The most bytes of a mesh that comes from a pipe, whose end cannot be seen.
const MAX_PIPED: u64 = 1 << 30;

/// A mesh that was read.
#[derive(Clone, Debug)]
pub struct File {
    /// The mesh, as it is in the file: not turned, nor scaled.
    pub mesh: Mesh,
    /// The format it was in.
    pub format: Format,
    /// What of the file was left out, each a sentence.
    pub notes: Vec<String>,
}

/// What a reader has to work with.
pub(super) struct Source<'a> {
    /// Where the file is: others may lie beside it.
    pub path: &'a Path,
    /// All of it.
    pub bytes: &'a [u8],
    /// Is told how many of the bytes are done.
    pub progress: &'a dyn Fn(usize, usize),
    /// Sentences for the user.
    pub notes: Vec<String>,
}

/// What is wrong, without the file's name.
pub(super) type Wrong = String;

/// Reads a mesh. The format is told by the file's first bytes, or else by its name. `progress` is told now and then how
/// many bytes of how many are done.
///
/// Indices are known to be good then, points to be finite; a normal of length 0 is none.
///
/// # Errors
/// If the file cannot be read, is damaged, or holds what is not supported.
pub fn read(path: &Path, progress: &dyn Fn(usize, usize)) -> Result<File, ImageError> {
    let shown = path.display().to_string();
    let bytes = recorded(path, Content::Data, files::given(path)).and_then(|file| {
        let limit = if file.metadata()?.is_file() { MAX_BYTES } else { MAX_PIPED };
        files::read_all(file, limit)
    });
    let bytes = bytes.map_err(|e| ImageError::io("read", &shown, &e))?;
    let format = format_of(path, &bytes)?;
    let mut source = Source { path, bytes: &bytes, progress, notes: Vec::new() };
    let mesh = match format {
        Format::Obj => read_obj::read(&mut source),
        Format::Ply => read_ply::read(&mut source),
        Format::Glb | Format::Gltf => read_gltf::read(&mut source),
    };
    let mesh = mesh
        .and_then(checked)
        .map_err(|wrong| ImageError::new(ErrorKind::Damaged, format!("cannot read `{shown}`: {wrong}")))?;
    Ok(File { mesh, format, notes: source.notes })
}

/// The format of a file.
fn format_of(path: &Path, bytes: &[u8]) -> Result<Format, ImageError> {
    if bytes.starts_with(b"glTF") {
        return Ok(Format::Glb);
    }
    if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
        return Ok(Format::Ply);
    }
    let shown = path.display();
    match Format::of(path) {
        Some(Format::Glb) if !bytes.trim_ascii_start().starts_with(b"{") => {
            Err(ImageError::damaged(&shown.to_string(), "it does not begin as a .glb file does"))
        }
        Some(Format::Ply) => {
            Err(ImageError::damaged(&shown.to_string(), "it does not begin as a .ply file does"))
        }
        Some(Format::Obj) => Ok(Format::Obj),
        Some(_) => Ok(Format::Gltf),
        None => {
            Err(ImageError::new(ErrorKind::UnknownFormat, format!("`{shown}` is no mesh that is known here"))
                .hint("Meshes are read from .obj, .ply, .glb and .gltf files."))
        }
    }
}

/// The mesh, if it can be worked with: what points and corners refer to is there and finite.
fn checked(mut mesh: Mesh) -> Result<Mesh, Wrong> {
    let counts = [mesh.points.len(), mesh.corners.len(), mesh.normals.len(), mesh.uvs.len()];
    if counts.iter().any(|&n| n >= u32::MAX as usize) {
        return Err("it is too large: 4 billion corners are the limit".into());
    }
    if let Some(i) = mesh.points.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
        let [x, y, z] = mesh.points[i];
        return Err(format!("vertex {} is at [{x} {y} {z}], which is no place", i + 1));
    }
    for (number, face) in mesh.faces.iter().enumerate() {
        for corner in &mesh.corners[face.first as usize..][..face.corners as usize] {
            let lists = [
                ("vertex", Some(corner.point), mesh.points.len()),
                ("normal", corner.normal, mesh.normals.len()),
                ("uv", corner.uv, mesh.uvs.len()),
            ];
            for (what, index, count) in lists {
                if let Some(index) = index.filter(|&i| i as usize >= count) {
                    let number = number + 1;
                    return Err(format!(
                        "face {number} refers to {what} {}, but there are only {count}",
                        u64::from(index) + 1
                    ));
                }
            }
        }
    }
    let good = |n: &[f32; 3]| n.iter().all(|c| c.is_finite()) && n.iter().any(|&c| c != 0.0);
    let bad: Vec<bool> = mesh.normals.iter().map(|n| !good(n)).collect();
    let odd: Vec<bool> = mesh.uvs.iter().map(|uv| uv.iter().any(|c| !c.is_finite())).collect();
    if bad.contains(&true) || odd.contains(&true) {
        for corner in &mut mesh.corners {
            corner.normal = corner.normal.filter(|&i| !bad[i as usize]);
            corner.uv = corner.uv.filter(|&i| !odd[i as usize]);
        }
        mesh.normals.iter_mut().zip(bad).filter(|(_, bad)| *bad).for_each(|(n, _)| *n = [0.0; 3]);
        mesh.uvs.iter_mut().zip(odd).filter(|(_, odd)| *odd).for_each(|(uv, _)| *uv = [0.0; 2]);
    }
    Ok(mesh)
}

/// Makes room, as far as there is any.
pub(super) fn reserve<T>(list: &mut Vec<T>, more: usize) -> Result<(), Wrong> {
    list.try_reserve(more).map_err(|_| "the memory does not suffice for it".into())
}
