//! Wavefront OBJ.

use super::Mesh;
use std::io::{self, Write};

/// Writes a mesh as it is: points, uv and normals in their order, and faces that refer to them.
pub(super) fn write(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    // Several surfaces are materials: objects cannot take turns.
    let several = mesh.surfaces.len() > 1;
    if !several && !mesh.surfaces.is_empty() {
        writeln!(out, "o {}", mesh.line_of(0))?;
    }
    for [x, y, z] in &mesh.points {
        writeln!(out, "v {x} {y} {z}")?;
    }
    for [u, v] in &mesh.uvs {
        writeln!(out, "vt {u} {v}")?;
    }
    for [x, y, z] in &mesh.normals {
        writeln!(out, "vn {x} {y} {z}")?;
    }
    let mut surface = None;
    for face in &mesh.faces {
        if several && surface != Some(face.surface) {
            surface = Some(face.surface);
            writeln!(out, "usemtl {}", mesh.line_of(face.surface as usize))?;
        }
        out.write_all(b"f")?;
        for corner in mesh.corners_of(face) {
            // They count from 1.
            let point = u64::from(corner.point) + 1;
            match (corner.uv.map(|i| u64::from(i) + 1), corner.normal.map(|i| u64::from(i) + 1)) {
                (None, None) => write!(out, " {point}")?,
                (Some(uv), None) => write!(out, " {point}/{uv}")?,
                (None, Some(normal)) => write!(out, " {point}//{normal}")?,
                (Some(uv), Some(normal)) => write!(out, " {point}/{uv}/{normal}")?,
            }
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}
