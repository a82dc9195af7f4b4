//! Reading a mesh, whatever its format.

use super::text::utf8;
use super::{Format, Mesh, read_gltf, read_obj, read_ply};
use crate::files;
use crate::image::{Content, ErrorKind, ImageError, recorded};
use std::path::Path;

/// The most bytes of a mesh's file, which is read as a whole.
const MAX_BYTES: u64 = 16 << 30;

/// The most bytes of a mesh that comes from a pipe, whose end cannot be seen.
const MAX_PIPED: u64 = 1 << 30;

/// The result of reading a mesh.
#[derive(Clone, Debug)]
pub struct File {
    /// The mesh as in the file, neither rotated nor scaled.
    pub mesh: Mesh,
    /// The format of the file.
    pub format: Format,
    /// Notes on skipped parts of the file; each is a sentence.
    pub notes: Vec<String>,
}

/// What a reader has to work with.
pub(super) struct Source<'a> {
    /// The path of the file, beside which other files may be.
    pub path: &'a Path,
    /// All bytes of the file.
    pub bytes: &'a [u8],
    /// A callback for the number of processed bytes.
    pub progress: &'a dyn Fn(usize, usize),
    /// Sentences for the user.
    pub notes: Vec<String>,
}

/// What is wrong, without the file's name.
pub(super) type Wrong = String;

/// Reads a mesh. The format is determined from the file's first bytes, otherwise from its name. `progress` is called
/// with the number of processed bytes and the total.
///
/// Text may be in UTF-8, UTF-16 or UTF-32. Indices are known to be good then, points to be finite, also as `f32`; a normal of length 0 is none.
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
    let bytes = utf8(&bytes);
    let format = format_of(path, &bytes)?;
    let mut source = Source { path, bytes: &bytes, progress, notes: Vec::new() };
    let mesh = match format {
        Format::Obj => read_obj::read(&mut source),
        Format::Ply => read_ply::read(&mut source),
        Format::Glb | Format::Gltf => read_gltf::read(&mut source),
    };
    let mesh = mesh
        .and_then(|mesh| checked(mesh, &mut source.notes))
        .map_err(|wrong| ImageError::new(ErrorKind::Damaged, format!("cannot read `{shown}`: {wrong}")))?;
    Ok(File { mesh, format, notes: source.notes })
}

/// The format of a file.
fn format_of(path: &Path, bytes: &[u8]) -> Result<Format, ImageError> {
    if bytes.starts_with(b"glTF") {
        return Ok(Format::Glb);
    }
    if bytes.strip_prefix(b"ply").is_some_and(|rest| rest.first().is_some_and(u8::is_ascii_whitespace)) {
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
        None => Err(ImageError::new(
            ErrorKind::UnknownFormat,
            format!("`{shown}` is not a mesh file that pse reads"),
        )
        .hint("Give an .obj, .ply, .glb or .gltf file.")),
    }
}

/// The mesh, if it can be worked with: the points that corners refer to are there and finite. Normals and uv that are not are
/// left out.
fn checked(mut mesh: Mesh, notes: &mut Vec<String>) -> Result<Mesh, Wrong> {
    let counts = [mesh.points.len(), mesh.corners.len(), mesh.normals.len(), mesh.uvs.len()];
    if counts.iter().any(|&n| n >= u32::MAX as usize) {
        return Err("it is too large: the limit is 4 billion corners".into());
    }
    // Pictures and programs have 32-bit numbers.
    if let Some(i) = mesh.points.iter().position(|p| p.iter().any(|&c| !(c as f32).is_finite())) {
        let [x, y, z] = mesh.points[i];
        return Err(format!("vertex {} is at [{x} {y} {z}], which is not a valid position", i + 1));
    }
    let counts = [mesh.points.len(), mesh.normals.len(), mesh.uvs.len()];
    let mut missing = 0;
    for (number, face) in mesh.faces.iter().enumerate() {
        for corner in &mut mesh.corners[face.first as usize..][..face.corners as usize] {
            if corner.point as usize >= counts[0] {
                return Err(format!(
                    "face {} refers to vertex {}, but there are only {}",
                    number + 1,
                    u64::from(corner.point) + 1,
                    counts[0]
                ));
            }
            for (index, count) in [(&mut corner.normal, counts[1]), (&mut corner.uv, counts[2])] {
                if index.is_some_and(|i| i as usize >= count) {
                    *index = None;
                    missing += 1;
                }
            }
        }
    }
    if missing > 0 {
        notes.push(format!(
            "Faces refer {missing} times to normals or uv that do not exist; these references were ignored."
        ));
    }
    let good = |n: &[f64; 3]| n.iter().all(|c| c.is_finite()) && n.iter().any(|&c| c != 0.0);
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
    list.try_reserve(more).map_err(|_| "not enough memory for it".into())
}
