//! `pse info`: what is in an image, or in a mesh.

use super::failure::{Failure, print};
use super::input::MapArg;
use super::model;
use crate::image::{Input, ReadOptions, info as image_info, read};
use crate::mesh::{Format, Mesh};
use clap::Args;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Which files.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  pse info gbuffer.exr\n  pse info gbuffer.exr --map point=ViewLayer.Position\n  pse info teapot.glb"
)]
pub(super) struct InfoArgs {
    /// Images, and meshes (.obj, .ply, .glb, .gltf); - is an image on standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Read a variable from other channels than the names suggest
    #[arg(long, value_name = "NAME=CHANNELS")]
    map: Vec<MapArg>,
    /// Take PNG, JPEG and the like as plain numbers: no sRGB decoding
    #[arg(long)]
    raw: bool,
}

/// Prints a table for each file.
pub(super) fn info(args: &InfoArgs) -> Result<(), Failure> {
    let maps = args.map.iter().map(|m| m.mapping.clone()).collect();
    let options = ReadOptions { maps, raw: args.raw };
    for (i, path) in args.files.iter().enumerate() {
        print(if i > 0 { "\n" } else { "" })?;
        if Format::of(path).is_some() {
            print(&about_mesh(path, &model::read(path, false)?))?;
            continue;
        }
        let file = read(Input::from_argument(path)?, &options)?;
        let table = image_info(&file)?.to_string();
        print(&table)?;
    }
    Ok(())
}

/// What a mesh has, as a table.
fn about_mesh(path: &Path, mesh: &Mesh) -> String {
    let mut text = format!("{}: a mesh\n", path.display());
    let mut line = |name: &str, value: String| {
        // A text takes whatever is written.
        let _ = writeln!(text, "  {name:10} {value}");
    };
    line("points", mesh.points.len().to_string());
    let most = mesh.faces.iter().map(|f| f.corners).max().unwrap_or(0);
    line("faces", format!("{} of up to {most} corners", mesh.faces.len()));
    let given = |of: fn(&crate::mesh::Corner) -> bool| match mesh.corners.iter().filter(|c| of(c)).count() {
        0 => "none",
        n if n == mesh.corners.len() => "at all corners",
        _ => "at some corners",
    };
    line("normals", given(|c| c.normal.is_some()).into());
    line("uv", given(|c| c.uv.is_some()).into());
    if let Some([low, high]) = mesh.bounds() {
        line("from", format!("[{} {} {}]", low[0], low[1], low[2]));
        line("to", format!("[{} {} {}]", high[0], high[1], high[2]));
    }
    for (i, name) in mesh.surfaces.iter().enumerate() {
        let faces = mesh.faces.iter().filter(|f| f.surface as usize == i).count();
        line("surface", format!("{} is {name}, {faces} faces", i + 1));
    }
    text
}
