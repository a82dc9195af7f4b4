//! `pse info`: what is in an image, or in a mesh.

use super::camera;
use super::failure::{Failure, print};
use super::frames;
use super::input::MapArg;
use super::model;
use clap::Args;
use pse::gbuffer::{JumpCounter, PointSampler};
use pse::image::{File, Image, Info, Input, ReadOptions, info as image_info, number_in_name, read};
use pse::internal::eval::has_space;
use pse::internal::quote;
use pse::internal::resolve::names;
use pse::internal::shape::Shape;
use pse::internal::visible::visible_name;
use pse::mesh::{Format, Mesh, shortest};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Which files.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  pse info gbuffer.exr\n  pse info gbuffer.exr --map point=ViewLayer.Position\n  pse info teapot.glb"
)]
pub(super) struct InfoArgs {
    /// Images and meshes (.obj, .ply, .glb, .gltf); - reads an image from standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Read a variable from the channels named here
    #[arg(long, value_name = "NAME=CHANNELS")]
    map: Vec<MapArg>,
    /// Read pictures (PNG, JPEG, …) without sRGB conversion
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
        let file = read(Input::from_argument(path)?, &options)
            .map_err(|error| about_sequence(error.into(), path))?;
        let mut table = image_info(&file)?;
        table.notes.extend(about_points(&file)?);
        leave_out_unreadable(&mut table);
        print(&table.to_string())?;
    }
    Ok(())
}

/// Takes names that no program can read out of the table, and says how the channels can be read.
fn leave_out_unreadable(table: &mut Info) {
    let mut names: Vec<String> = Vec::new();
    for channel in &mut table.channels {
        channel.variables.retain(|written| {
            let name = written.trim_start_matches('(').trim_end_matches([')', '?']);
            let name = name.split('[').next().unwrap_or(name);
            // A vector's component stands behind its name.
            let (variable, member) = name.rsplit_once('.').map_or((name, None), |(v, m)| (v, Some(m)));
            let variable =
                if member.is_some_and(|m| names::component(m).is_some()) { variable } else { name };
            let readable = names::is_readable(variable);
            if !readable && !names.iter().any(|known| known == variable) {
                names.push(variable.to_string());
            }
            readable
        });
    }
    for name in names {
        let why = if names::RESERVED.contains(&name.as_str()) {
            "is a name of the system"
        } else {
            "cannot be read"
        };
        table
            .notes
            .push(format!("`{name}` {why} in programs: rename the channels with --map NAME=CHANNELS."));
    }
}

/// Says which files a name with a place for the frame's number may mean.
fn about_sequence(failure: Failure, path: &Path) -> Failure {
    let name = path.to_string_lossy();
    if !frames::is_sequence(&name) {
        return failure;
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let numbers = |file: PathBuf| {
        let number = number_in_name(&file)?;
        (frames::fill(&name, number) == path.with_file_name(file.file_name()?).to_string_lossy())
            .then_some(number)
    };
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let found: Vec<i64> = files.filter_map(numbers).collect();
    let failure = failure.hint("The name needs a frame number, and pse info describes one file.");
    match found.iter().min() {
        Some(first) => failure.hint(format!(
            "Frames {} exist; the first is {}.",
            frames::ranges(&found, "x"),
            quote::word(&frames::fill(&name, *first))
        )),
        None => failure.hint("No file matches this name with a number."),
    }
}

/// Rows that are read at once.
const ROWS: usize = 64;

/// What the points say: where the eye is, if the header does not tell, and whether they are noise.
fn about_points(file: &File) -> Result<Vec<String>, Failure> {
    if !file.find("point").is_ok_and(|point| point.shape == Shape::Vector(3)) {
        return Ok(Vec::new());
    }
    let names: Vec<&str> = ["point", "surface"].into_iter().filter(|name| file.find(name).is_ok()).collect();
    let [width, height] = file.size();
    let about = Image { width, height, metadata: file.metadata().clone(), ..Image::default() };
    let (mut sampler, mut jumps) = (PointSampler::new(&about), JumpCounter::default());
    let mut rows = file.rows(&names)?;
    for top in (0..height).step_by(ROWS) {
        // With a row above and one below, whose points are neighbours.
        let band = rows.read(top.saturating_sub(1)..height.min(top + ROWS + 1))?;
        sampler.add(&band);
        jumps.add(&band);
    }
    let found = sampler.resect();
    let camera = found.as_ref().ok();
    let jumps = jumps.finish(camera.map(|found| &found.projection));
    let mut notes = Vec::new();
    let is_written = ["camera", "screen"].iter().any(|space| has_space(space, file.metadata()));
    notes.extend(camera.filter(|_| !is_written).map(|found| sentence(&camera::description(found))));
    if jumps.noisy {
        notes.push(format!(
            "`point` jumps from pixel to pixel at {} of {} pixels within a surface ({:.1} %), as renderers write it with depth \
             of field or motion blur: from one random sample of each pixel. Render the data passes without them.",
            jumps.jumps,
            jumps.tested,
            100.0 * jumps.jumps as f64 / jumps.tested as f64
        ));
    }
    Ok(notes)
}

fn sentence(text: &str) -> String {
    let (first, rest) = text.split_at(1);
    format!("{}{rest}.", first.to_uppercase())
}

/// What a mesh has, as a table.
fn about_mesh(path: &Path, mesh: &Mesh) -> String {
    let mut text = format!("{}: a mesh\n", visible_name(&path.display().to_string()));
    let mut line = |name: &str, value: String| {
        // A text takes whatever is written.
        let _ = writeln!(text, "  {name:10} {value}");
    };
    line("points", mesh.points.len().to_string());
    let most = mesh.faces.iter().map(|f| f.corners).max().unwrap_or(0);
    line("faces", format!("{} of up to {most} corners", mesh.faces.len()));
    let given = |of: fn(&pse::mesh::Corner) -> bool| match mesh.corners.iter().filter(|c| of(c)).count() {
        0 => "none",
        n if n == mesh.corners.len() => "at all corners",
        _ => "at some corners",
    };
    line("normals", given(|c| c.normal.is_some()).into());
    line("uv", given(|c| c.uv.is_some()).into());
    if let Some([low, high]) = mesh.bounds() {
        for (name, end) in [("from", low), ("to", high)] {
            line(name, format!("[{}]", end.map(shortest).join(" ")));
        }
    }
    let mut counts = vec![0usize; mesh.surfaces.len()];
    for face in &mesh.faces {
        counts[face.surface as usize] += 1;
    }
    for (i, (name, faces)) in mesh.surfaces.iter().zip(counts).enumerate() {
        line("surface", format!("{} is {}, {faces} faces", i + 1, visible_name(name)));
    }
    text
}
