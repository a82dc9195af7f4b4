//! Wavefront OBJ.
//!
//! The crates for this format give points as renderers want them: split, joined or sorted by object. Here the file's own order
//! must stay, for it is written again; and the format is a few kinds of lines.

use super::read::{Source, Wrong};
use super::text::{line_length, no_number, number as parse_number};
use super::{Corner, Face, Mesh};
use crate::image::{Content, record};
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;

/// What `usemtl`, `o` and `g` said last, as indices into the names of each.
type Names = [Option<usize>; 3];

/// Reads a mesh.
pub(super) fn read(source: &mut Source<'_>) -> Result<Mesh, Wrong> {
    let mut reader = Reader::default();
    let bytes = source.bytes;
    let mut at = 0;
    let mut number = 0;
    while at < bytes.len() {
        let line = logical_line(bytes, &mut at, &mut number);
        let line = String::from_utf8_lossy(&line);
        let last = at == bytes.len() && !bytes.ends_with(b"\n") && !bytes.ends_with(b"\r");
        let shape = reader.shape;
        reader.line(&line).map_err(|wrong| match last {
            true => format!("line {number}, where the file ends: {wrong}"),
            false => format!("line {number}: {wrong}"),
        })?;
        if last && reader.seems_cut(&line, shape) {
            source.notes.push(format!(
                "The file ends within line {number}, which differs from the lines before it: the file may be cut off."
            ));
        }
        if number.is_multiple_of(1 << 16) {
            (source.progress)(at, bytes.len());
        }
    }
    for (what, count) in [
        ("lines and points", reader.lines),
        ("curves and free-form surfaces", reader.curves),
        ("statements that call other files", reader.calls),
    ] {
        if count > 0 {
            source.notes.push(format!("{count} {what} were skipped: only faces are read."));
        }
    }
    if reader.colours {
        source.notes.push("Vertex colours were ignored.".into());
    }
    if reader.small > 0 {
        source.notes.push(format!("{} faces with fewer than three corners were skipped.", reader.small));
    }
    protect(source.path, &reader.libraries);
    if reader.mesh.points.is_empty() {
        return Err("it has no vertices (no line starts with v)".into());
    }
    Ok(reader.finish())
}

/// Records the libraries of materials. They are not read, but they are a part of the mesh that no output may replace. A
/// statement may name several files, whose names may have blanks.
fn protect(mesh: &Path, libraries: &[String]) {
    let folder = mesh.parent().unwrap_or(Path::new(""));
    let names = libraries
        .iter()
        .flat_map(|names| std::iter::once(names.as_str()).chain(names.split_ascii_whitespace()));
    names.for_each(|name| record(&folder.join(name.replace('\\', "/")), Content::Data));
}

/// The next line, joined with those after it while it ends in a backslash; and the number of its last. A comment goes to the end
/// of its own line: in `# from C:\models\` the backslash joins nothing.
fn logical_line<'a>(bytes: &'a [u8], at: &mut usize, number: &mut usize) -> Cow<'a, [u8]> {
    let mut joined: Option<Vec<u8>> = None;
    loop {
        let rest = &bytes[*at..];
        let length = line_length(rest);
        *at += length;
        *number += 1;
        let line = rest[..length].trim_ascii_end();
        let comment = line.windows(2).any(|pair| pair[1] == b'#' && pair[0].is_ascii_whitespace())
            || line.starts_with(b"#") && joined.is_none();
        let more = line.strip_suffix(b"\\").filter(|_| *at < bytes.len() && !comment);
        match (&mut joined, more) {
            (None, None) => return Cow::Borrowed(line),
            (None, Some(part)) => joined = Some([part, b" "].concat()),
            (Some(text), part) => {
                text.extend_from_slice(part.unwrap_or(line));
                if part.is_none() {
                    return Cow::Owned(joined.unwrap_or_default());
                }
                text.push(b' ');
            }
        }
    }
}

#[derive(Default)]
struct Reader {
    mesh: Mesh,
    names: [Vec<String>; 3],
    /// The places of these names.
    places: [HashMap<String, usize>; 3],
    now: Names,
    /// From which face on which names hold.
    runs: Vec<(usize, Names)>,
    lines: usize,
    curves: usize,
    calls: usize,
    small: usize,
    colours: bool,
    /// What the statements for libraries of materials name.
    libraries: Vec<String>,
    /// Of the last face: how many corners it has, and whether its last one has a uv and a normal.
    shape: Option<Shape>,
}

type Shape = (usize, bool, bool);

impl Reader {
    fn line(&mut self, line: &str) -> Result<(), Wrong> {
        let line = line.trim_start();
        let (word, rest) = line.split_once(|c: char| c.is_ascii_whitespace()).unwrap_or((line, ""));
        match word {
            "v" => {
                // Three more are a colour; a fourth alone is a weight, which polygons have no use for.
                let values = rest.split_ascii_whitespace().take_while(|part| !part.starts_with('#'));
                self.colours = self.colours || values.count() >= 6;
                self.mesh.points.push(numbers(word, rest, 3)?);
            }
            "vn" => self.mesh.normals.push(numbers(word, rest, 3)?),
            "vt" => self.mesh.uvs.push(numbers(word, rest, 1)?),
            "f" | "fo" => self.face(rest)?,
            "usemtl" => self.name(0, rest),
            "o" => self.name(1, rest),
            "g" => self.name(2, rest),
            "l" | "p" => self.lines += 1,
            "curv" | "curv2" | "surf" | "bsp" | "bzp" | "cdc" | "cdp" | "res" => self.curves += 1,
            "call" => self.calls += 1,
            "mtllib" => self.libraries.push(rest.trim().to_string()),
            // Comments, smoothing groups, points and attributes of curves.
            _ => {}
        }
        Ok(())
    }

    fn name(&mut self, kind: usize, rest: &str) {
        let name = rest.trim();
        let (names, places) = (&mut self.names[kind], &mut self.places[kind]);
        self.now[kind] = Some(match places.get(name) {
            Some(&place) => place,
            None => {
                names.push(name.into());
                places.insert(name.into(), names.len() - 1);
                names.len() - 1
            }
        });
    }

    fn face(&mut self, rest: &str) -> Result<(), Wrong> {
        let first = self.mesh.corners.len();
        // Behind a # follows a comment.
        for text in rest.split('#').next().unwrap_or("").split_ascii_whitespace() {
            let mut parts = text.split('/');
            let mut index = |count: usize, what: &str| match parts.next() {
                None | Some("") => Ok(None),
                // Indices begin at 1: some programs write a 0 for a uv or a normal that is not there.
                Some("0") if what != "vertex" => Ok(None),
                Some(part) => {
                    index(part, count).map(Some).map_err(|why| format!("the face's {what} `{part}` {why}"))
                }
            };
            let point = index(self.mesh.points.len(), "vertex")?;
            let uv = index(self.mesh.uvs.len(), "uv")?;
            let normal = index(self.mesh.normals.len(), "normal")?;
            let point = point.ok_or_else(|| format!("the face's corner `{text}` names no vertex"))?;
            self.mesh.corners.push(Corner { point, normal, uv });
        }
        let corners = self.mesh.corners.len() - first;
        self.shape = self.mesh.corners.last().map(|c| (corners, c.uv.is_some(), c.normal.is_some()));
        if corners < 3 {
            self.small += 1;
            self.mesh.corners.truncate(first);
            return Ok(());
        }
        if self.runs.last().is_none_or(|(_, names)| *names != self.now) {
            self.runs.push((self.mesh.faces.len(), self.now));
        }
        let first = u32::try_from(first).map_err(|_| "there are more than 4 billion corners")?;
        self.mesh.faces.push(Face { first, corners: corners as u32, surface: 0 });
        Ok(())
    }

    /// Whether the last line, which has no end, is such that something of it is likely to be missing. (Many whole files have no
    /// line break at their end.) `shape` is that of the face before it.
    fn seems_cut(&self, line: &str, shape: Option<Shape>) -> bool {
        match line.trim_start().split_ascii_whitespace().next() {
            Some("f" | "fo") => shape.is_some() && shape != self.shape,
            // A vertex may be followed by nothing only in a file without faces.
            Some("v" | "vt" | "vn") => !self.mesh.faces.is_empty(),
            _ => false,
        }
    }

    /// Numbers the surfaces: by material if any is named, else by object, else by group, in the order of their faces.
    fn finish(self) -> Mesh {
        let Reader { mut mesh, names, runs, .. } = self;
        let kind = (0..3).find(|&kind| runs.iter().any(|(_, names)| names[kind].is_some()));
        let mut numbers: HashMap<Option<usize>, u32> = Default::default();
        for (i, (start, now)) in runs.iter().enumerate() {
            let name = kind.and_then(|kind| now[kind]);
            let surface = *numbers.entry(name).or_insert_with(|| {
                mesh.surfaces.push(match (kind, name) {
                    (Some(kind), Some(name)) => names[kind][name].clone(),
                    (Some(0), None) => "no material".into(),
                    _ => "mesh".into(),
                });
                mesh.surfaces.len() as u32 - 1
            });
            let end = runs.get(i + 1).map_or(mesh.faces.len(), |(next, _)| *next);
            mesh.faces[*start..end].iter_mut().for_each(|face| face.surface = surface);
        }
        mesh
    }
}

/// The first numbers of a line, of which there must be so many; others are 0.
fn numbers<const N: usize>(word: &str, rest: &str, least: usize) -> Result<[f64; N], Wrong> {
    let mut numbers = [0.0; N];
    let mut parts = rest.split_ascii_whitespace();
    for (i, number) in numbers.iter_mut().enumerate() {
        let Some(part) = parts.next().filter(|part| !part.starts_with('#')) else {
            return if i < least {
                Err(format!("{word} is followed by {i} numbers, not by {N}"))
            } else {
                Ok(numbers)
            };
        };
        // A comment may follow without a blank; but 1.#INF is a number.
        let value = parse_number(part).or_else(|| parse_number(part.split_once('#')?.0));
        *number = value.ok_or_else(|| no_number(part))?;
    }
    Ok(numbers)
}

/// An index, counted from 1 or, if negative, back from the last one so far. Whether it is too large is known at the end.
fn index(text: &str, count: usize) -> Result<u32, &'static str> {
    let number: i64 = text.parse().map_err(|_| "is not a number")?;
    let index = match number {
        0 => return Err("is not an index: they start at 1"),
        1.. => number - 1,
        _ => count as i64 + number,
    };
    u32::try_from(index).map_err(|_| "does not exist")
}
