//! The formats of meshes, and writing a mesh in one of them.

use super::{Mesh, write_glb, write_obj, write_ply};
use crate::image::{ErrorKind, ImageError, NewFile};
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// A format of mesh files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Wavefront OBJ: text, faces of any number of corners.
    Obj,
    /// PLY, as text or binary; binary when written.
    Ply,
    /// glTF 2.0 with its data in the same file; triangles only.
    Glb,
    /// glTF 2.0 as JSON, with its data beside it or within; it is only read.
    Gltf,
}

impl Format {
    /// The format for a file's extension.
    pub fn of(path: &Path) -> Option<Format> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "obj" => Some(Format::Obj),
            "ply" => Some(Format::Ply),
            "glb" => Some(Format::Glb),
            "gltf" => Some(Format::Gltf),
            _ => None,
        }
    }

    /// The format for writing a file with this name.
    ///
    /// # Errors
    /// If there is none.
    pub fn to_write(path: &Path) -> Result<Format, ImageError> {
        let unknown = |what: String, hint: &str| {
            let message = format!("cannot write `{}`: {what}", path.display());
            Err(ImageError::new(ErrorKind::UnknownFormat, message).hint(hint))
        };
        match Format::of(path) {
            Some(Format::Gltf) => unknown("glTF is written only as a single file".into(), "Name it .glb."),
            Some(format) => Ok(format),
            None => {
                let hint = "Write .obj, .ply or .glb.";
                match path.extension() {
                    Some(extension) => unknown(format!("unknown mesh format .{}", extension.display()), hint),
                    None => unknown("the name has no extension for the format".into(), hint),
                }
            }
        }
    }
}

impl Mesh {
    /// Writes it as a file, which appears whole or not at all, in the format that its name ends in. Nothing is turned or
    /// scaled.
    ///
    /// OBJ keeps all there is, with all digits. PLY has points as floats where these hold them, else as doubles. GLB has floats,
    /// relative to a translation if the mesh is far from the origin. PLY and GLB have one normal and one uv at each vertex, so a point whose corners differ
    /// becomes several; and GLB has nothing but triangles.
    ///
    /// # Errors
    /// If the format is unknown, the mesh is none (a point that is not finite), or the operating system refuses.
    pub fn write(&self, path: &Path) -> Result<(), ImageError> {
        let format = Format::to_write(path)?;
        let mut file = NewFile::create(path)?;
        let unwritable = |what: String| {
            ImageError::new(ErrorKind::Unwritable, format!("cannot write `{}`: {what}", path.display()))
        };
        if let Some(i) = self.points.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
            let [x, y, z] = self.points[i];
            return Err(unwritable(format!(
                "vertex {} is at [{x} {y} {z}], which is not a valid position",
                i + 1
            )));
        }
        let name = file.name().to_string();
        let fail = |e: io::Error| ImageError::io("write", &name, &e);
        let mut out = BufWriter::with_capacity(1 << 16, &mut file);
        match format {
            Format::Obj => write_obj::write(self, &mut out).map_err(fail)?,
            Format::Ply => write_ply::write(self, &mut out).map_err(fail)?,
            Format::Glb | Format::Gltf => {
                let glb = write_glb::encode(self).map_err(|what| unwritable(what.to_string()))?;
                out.write_all(&glb).map_err(fail)?;
            }
        }
        out.flush().map_err(fail)?;
        drop(out);
        file.finish()
    }

    /// The name of a surface as one line of a file; never empty.
    pub(super) fn line_of(&self, surface: usize) -> String {
        let name = self.surfaces.get(surface).map_or("", |name| name.trim());
        match name.is_empty() {
            true => format!("surface{}", surface + 1),
            false => name.chars().map(|c| if c.is_control() { '_' } else { c }).collect(),
        }
    }
}
