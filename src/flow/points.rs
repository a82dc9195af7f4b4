//! Trajectories for other programs: points and edges in a PLY file.

use super::trajectories::Trajectories;
use std::io::{self, Write};

/// Writes points and the edges between them as a binary PLY file: for each vertex `x y z`, the unit vector along its line as
/// `nx ny nz`, `age` from 0 to 1 and the number `line`, and its colour if there are `colors`, as bytes of sRGB.
///
/// # Errors
/// Those of the writer.
pub fn to_ply(
    trajectories: &Trajectories,
    colors: Option<&[[f32; 4]]>,
    out: &mut impl Write,
) -> io::Result<()> {
    let (points, steps) = (&trajectories.points, trajectories.steps);
    writeln!(out, "ply\nformat binary_little_endian 1.0\nelement vertex {}", points.len())?;
    for name in ["x", "y", "z", "nx", "ny", "nz", "age"] {
        writeln!(out, "property float {name}")?;
    }
    writeln!(out, "property int line")?;
    if colors.is_some() {
        for name in ["red", "green", "blue", "alpha"] {
            writeln!(out, "property uchar {name}")?;
        }
    }
    writeln!(out, "element edge {}", trajectories.lines() * steps)?;
    writeln!(out, "property int vertex1\nproperty int vertex2\nend_header")?;
    for (i, point) in points.iter().enumerate() {
        for number in point.iter().chain(&trajectories.along(i)).chain([&trajectories.age(i)]) {
            out.write_all(&number.to_le_bytes())?;
        }
        out.write_all(&((i / (steps + 1)) as i32).to_le_bytes())?;
        if let Some(colors) = colors {
            let [r, g, b, a] = colors[i];
            let code = |x: f32| crate::image::color::encode8(x);
            out.write_all(&[code(r), code(g), code(b), (a.clamp(0.0, 1.0) * 255.0).round() as u8])?;
        }
    }
    for i in (0..points.len()).filter(|i| i % (steps + 1) != steps) {
        out.write_all(&(i as i32).to_le_bytes())?;
        out.write_all(&(i as i32 + 1).to_le_bytes())?;
    }
    Ok(())
}
