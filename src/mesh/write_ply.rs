//! PLY, binary.

use super::Mesh;
use super::split::{Split, split};
use std::io::{self, Write};

/// Writes a mesh as little-endian PLY: points as doubles if a float loses a digit of one, all else as floats. A vertex without a normal, where others have one, gets a normal of 0 0 0.
///
/// PLY has no names for parts: several surfaces become a number at each face, and comments with their names.
pub(super) fn write(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    let Split { vertices, of_corner } = split(mesh);
    let normals = vertices.iter().any(|v| v.normal.is_some());
    let uvs = vertices.iter().any(|v| v.uv.is_some());
    let several = mesh.surfaces.len() > 1;
    let many = mesh.faces.iter().any(|f| f.corners > 255);

    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    for surface in 0..mesh.surfaces.len() {
        writeln!(out, "comment surface {}", mesh.line_of(surface))?;
    }
    writeln!(out, "element vertex {}", vertices.len())?;
    let precise = !mesh.fits_singles();
    for name in ["x", "y", "z"] {
        writeln!(out, "property {} {name}", if precise { "double" } else { "float" })?;
    }
    for name in ["nx", "ny", "nz"].iter().filter(|_| normals).chain(["s", "t"].iter().filter(|_| uvs)) {
        writeln!(out, "property float {name}")?;
    }
    writeln!(out, "element face {}", mesh.faces.len())?;
    writeln!(out, "property list {} uint vertex_indices", if many { "uint" } else { "uchar" })?;
    if several {
        writeln!(out, "property uint surface")?;
    }
    writeln!(out, "end_header")?;

    let mut put = |numbers: &[f64], precise: bool| {
        numbers.iter().try_for_each(|&x| match precise {
            true => out.write_all(&x.to_le_bytes()),
            false => out.write_all(&(x as f32).to_le_bytes()),
        })
    };
    for vertex in &vertices {
        put(&mesh.points[vertex.point as usize], precise)?;
        if normals {
            put(&vertex.normal.map_or([0.0; 3], |i| mesh.normals[i as usize]), false)?;
        }
        if uvs {
            put(&vertex.uv.map_or([0.0; 2], |i| mesh.uvs[i as usize]), false)?;
        }
    }
    for face in &mesh.faces {
        match many {
            true => out.write_all(&face.corners.to_le_bytes())?,
            false => out.write_all(&[face.corners as u8])?,
        }
        for vertex in &of_corner[face.first as usize..][..face.corners as usize] {
            out.write_all(&vertex.to_le_bytes())?;
        }
        if several {
            out.write_all(&face.surface.to_le_bytes())?;
        }
    }
    Ok(())
}
