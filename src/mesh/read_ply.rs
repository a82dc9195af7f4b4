//! PLY, as text or binary of either byte order.
//!
//! The crates for this format make a map of named properties for each vertex and face, which takes gigabytes for a million
//! triangles, and some believe what the header says of counts.

use super::ply_header::{Element, Encoding, Header, Kind, Property};
use super::read::{Source, Wrong, reserve};
use super::text::{line_length, no_number, number};
use super::{Corner, Face, Mesh};
use std::cmp::Ordering;

/// The names of properties that are coordinates of textures, in pairs.
const UVS: [[&str; 2]; 4] = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]];

/// Reads a mesh.
pub(super) fn read(source: &mut Source<'_>) -> Result<Mesh, Wrong> {
    let header = Header::read(source.bytes)?;
    let rest = &source.bytes[header.length..];
    let mut data = Data { rest, encoding: header.encoding, rows: Rows::Free };
    if header.encoding == Encoding::Text {
        let lines = text_lines(rest);
        let entries = header.elements.iter().filter(|e| !e.properties.is_empty());
        let entries = entries.fold(0, |sum: usize, e| sum.saturating_add(e.count));
        data.rows = match lines.cmp(&entries) {
            Ordering::Less => Rows::Free,
            Ordering::Equal => Rows::Lines,
            Ordering::Greater => Rows::Begin,
        };
    }
    let mut builder = Builder::new(&header);
    let mut row = Row::default();
    // How many lines had more numbers, and the first of those.
    let mut longer: (usize, Option<String>) = (0, None);
    for element in &header.elements {
        if element.properties.is_empty() {
            continue;
        }
        // Each needs bytes, so a count that lies is found before there is room for it.
        let least = element.least_size(header.encoding);
        let wrong =
            |number: usize, wrong: Wrong| format!("{} {number} of {}: {wrong}", element.name, element.count);
        if element.count > data.rest.len() / least.max(1) + 1 {
            return Err(format!("it ends before its {} {} entries do", element.count, element.name));
        }
        let plan = Plan::new(element);
        builder.begin(&plan, element.count)?;
        for number in 0..element.count {
            row.read(&mut data, element).map_err(|w| wrong(number + 1, w))?;
            if data.finish_row() {
                longer.0 += 1;
                longer.1.get_or_insert_with(|| format!("{} {}", element.name, number + 1));
            }
            builder.take(&plan, &row).map_err(|w| wrong(number + 1, w))?;
            if number.is_multiple_of(1 << 16) {
                (source.progress)(source.bytes.len() - data.rest.len(), source.bytes.len());
            }
        }
    }
    if builder.mesh.points.is_empty() {
        let vertices = header.elements.iter().find(|e| e.name == "vertex" && e.count > 0);
        let missing =
            vertices.and_then(|e| ["x", "y", "z"].into_iter().find(|name| e.place(name, false).is_none()));
        return Err(match missing {
            Some(name) => {
                format!("its vertices have no `{name}`: the header lacks the line `property float {name}`")
            }
            None => "it has no vertices".into(),
        });
    }
    if let (count, Some(first)) = longer {
        source.notes.push(format!(
            "{count} lines have more numbers than the header declares; these were ignored. The first is {first}."
        ));
    }
    if builder.small > 0 {
        source.notes.push(format!("{} faces with fewer than three corners were skipped.", builder.small));
    }
    if header.elements.iter().any(|e| e.name == "vertex" && e.place("red", false).is_some()) {
        source.notes.push("Vertex colours were ignored.".into());
    }
    Ok(builder.finish())
}

/// How entries lie in the lines of a text file. The format has one entry in each line, but not all programs do.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Rows {
    /// There are fewer lines than entries (or the file is binary): line breaks mean nothing.
    Free,
    /// As many lines as entries: each is a line. What follows in the line was not announced.
    Lines,
    /// More lines than entries: each begins a line, and may go on in the next one.
    Begin,
}

/// How many lines there are in which there is something.
fn text_lines(bytes: &[u8]) -> usize {
    bytes.split(|&b| b == b'\n' || b == b'\r').filter(|line| !line.trim_ascii().is_empty()).count()
}

/// The values of one entry: of property `i` those from `starts[i]` up to `starts[i + 1]`.
#[derive(Default)]
struct Row {
    values: Vec<f64>,
    starts: Vec<usize>,
}

impl Row {
    fn read(&mut self, data: &mut Data<'_>, element: &Element) -> Result<(), Wrong> {
        self.values.clear();
        self.starts.clear();
        data.start_row();
        for property in &element.properties {
            self.starts.push(self.values.len());
            let count = match property.count {
                None => 1.0,
                Some(kind) => data.next(kind)?,
            };
            if !(count >= 0.0 && count.fract() == 0.0) {
                return Err(format!("a list of {count} values"));
            }
            // No room is made beforehand: the list may claim more than there is.
            for _ in 0..count as u64 {
                self.values.push(data.next(property.kind)?);
            }
        }
        self.starts.push(self.values.len());
        Ok(())
    }

    fn of(&self, property: usize) -> &[f64] {
        &self.values[self.starts[property]..self.starts[property + 1]]
    }

    fn scalar(&self, property: usize) -> f64 {
        self.of(property).first().copied().unwrap_or(0.0)
    }
}

/// The bytes that are still to be read.
struct Data<'a> {
    rest: &'a [u8],
    encoding: Encoding,
    rows: Rows,
}

impl Data<'_> {
    /// Goes to where the next entry begins.
    fn start_row(&mut self) {
        if self.encoding == Encoding::Text {
            self.rest = self.rest.trim_ascii_start();
        }
    }

    /// Goes to the end of the line, if that ends an entry: whether there were more numbers in it.
    fn finish_row(&mut self) -> bool {
        if self.rows == Rows::Free {
            return false;
        }
        let (line, rest) = self.rest.split_at(line_length(self.rest));
        self.rest = rest;
        !line.trim_ascii().is_empty()
    }

    fn next(&mut self, kind: Kind) -> Result<f64, Wrong> {
        if self.encoding == Encoding::Text {
            let text = self.rest.trim_ascii_start();
            let blank = &self.rest[..self.rest.len() - text.len()];
            if self.rows == Rows::Lines && !text.is_empty() && blank.iter().any(|b| b"\r\n".contains(b)) {
                return Err("its line has fewer numbers than the header declares".into());
            }
            let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
            let (word, rest) = text.split_at(end);
            self.rest = rest;
            if word.is_empty() {
                return Err("the file ends here".into());
            }
            let number = str::from_utf8(word).ok().and_then(number);
            return number.ok_or_else(|| match str::from_utf8(word) {
                Ok(word) => no_number(word),
                Err(_) => format!("`{}` is not a number", word.escape_ascii()),
            });
        }
        let (bytes, rest) = self.rest.split_at_checked(kind.size()).ok_or("the file ends here")?;
        self.rest = rest;
        let mut word = [0; 8];
        word[..bytes.len()].copy_from_slice(bytes);
        if self.encoding == Encoding::BigEndian {
            word[..bytes.len()].reverse();
        }
        Ok(kind.value(word))
    }
}

/// What the properties of an element are to the mesh, by their places.
enum Plan {
    Vertex { point: [usize; 3], normal: Option<[usize; 3]>, uv: Option<[usize; 2]> },
    Face { vertices: usize, uvs: Option<usize>, surface: Option<usize> },
    Strips { vertices: usize },
    Skip,
}

impl Plan {
    fn new(element: &Element) -> Plan {
        let scalar = |name: &str| element.place(name, false);
        let list = |names: &[&str]| names.iter().find_map(|name| element.place(name, true));
        let three = |names: [&str; 3]| Some([scalar(names[0])?, scalar(names[1])?, scalar(names[2])?]);
        let two = |names: [&str; 2]| Some([scalar(names[0])?, scalar(names[1])?]);
        let vertices = list(&["vertex_indices", "vertex_index"]);
        match (element.name.as_str(), three(["x", "y", "z"]), vertices) {
            ("vertex", Some(point), _) => {
                let uv = UVS.into_iter().find_map(two);
                Plan::Vertex { point, normal: three(["nx", "ny", "nz"]), uv }
            }
            ("tristrips", _, Some(vertices)) => Plan::Strips { vertices },
            (_, _, Some(vertices)) => {
                let surface = scalar("surface").or(scalar("material_index"));
                Plan::Face { vertices, uvs: list(&["texcoord"]), surface }
            }
            _ => Plan::Skip,
        }
    }
}

/// The mesh in the making.
struct Builder {
    mesh: Mesh,
    surfaces: Vec<String>,
    /// Has each vertex a normal, a uv?
    per_vertex: [bool; 2],
    /// How many faces had too few corners.
    small: usize,
}

impl Builder {
    fn new(header: &Header) -> Builder {
        // Faces may come before the vertices.
        let per_vertex = header.elements.iter().find_map(|element| match Plan::new(element) {
            Plan::Vertex { normal, uv, .. } => Some([normal.is_some(), uv.is_some()]),
            _ => None,
        });
        let surfaces = header.surfaces.clone();
        Builder { mesh: Mesh::default(), surfaces, per_vertex: per_vertex.unwrap_or_default(), small: 0 }
    }

    fn begin(&mut self, plan: &Plan, count: usize) -> Result<(), Wrong> {
        match plan {
            Plan::Vertex { normal, uv, .. } => {
                reserve(&mut self.mesh.points, count)?;
                reserve(&mut self.mesh.normals, if normal.is_some() { count } else { 0 })?;
                reserve(&mut self.mesh.uvs, if uv.is_some() { count } else { 0 })
            }
            Plan::Face { .. } => {
                reserve(&mut self.mesh.faces, count)?;
                reserve(&mut self.mesh.corners, count.saturating_mul(3))
            }
            _ => Ok(()),
        }
    }

    fn take(&mut self, plan: &Plan, row: &Row) -> Result<(), Wrong> {
        match *plan {
            Plan::Vertex { point, normal, uv } => {
                self.mesh.points.push(point.map(|i| row.scalar(i)));
                self.mesh.normals.extend(normal.map(|n| n.map(|i| row.scalar(i))));
                self.mesh.uvs.extend(uv.map(|n| n.map(|i| row.scalar(i))));
            }
            Plan::Face { vertices, uvs, surface } => {
                let surface = surface.map_or(0.0, |i| row.scalar(i).max(0.0));
                let own = uvs.map(|i| row.of(i)).filter(|uvs| uvs.len() == 2 * row.of(vertices).len());
                self.face(row.of(vertices), own, surface as u32)?;
            }
            Plan::Strips { vertices } => {
                // Strips are separated by -1; every second triangle is the other way round.
                for strip in row.of(vertices).split(|&i| i == -1.0) {
                    for (i, t) in strip.windows(3).enumerate() {
                        let triangle = if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
                        if t[0] != t[1] && t[1] != t[2] && t[0] != t[2] {
                            self.face(&triangle, None, 0)?;
                        }
                    }
                }
            }
            Plan::Skip => {}
        }
        Ok(())
    }

    /// Adds a face, unless it has too few corners to be one. `uvs` are its own, two numbers a corner.
    fn face(&mut self, vertices: &[f64], uvs: Option<&[f64]>, surface: u32) -> Result<(), Wrong> {
        if vertices.len() < 3 {
            self.small += 1;
            return Ok(());
        }
        let mesh = &mut self.mesh;
        let first = u32::try_from(mesh.corners.len()).map_err(|_| "there are more than 4 billion corners")?;
        for (i, &vertex) in vertices.iter().enumerate() {
            if !(vertex >= 0.0 && vertex.fract() == 0.0 && vertex < f64::from(u32::MAX)) {
                return Err(format!("there is no vertex {vertex}"));
            }
            let point = vertex as u32;
            let uv = match uvs {
                Some(uvs) => {
                    mesh.uvs.push([uvs[2 * i], uvs[2 * i + 1]]);
                    Some(mesh.uvs.len() as u32 - 1)
                }
                None => self.per_vertex[1].then_some(point),
            };
            mesh.corners.push(Corner { point, normal: self.per_vertex[0].then_some(point), uv });
        }
        mesh.faces.push(Face { first, corners: vertices.len() as u32, surface });
        Ok(())
    }

    /// Numbers the surfaces that have faces, and names them.
    fn finish(self) -> Mesh {
        let Builder { mut mesh, surfaces, .. } = self;
        let used: std::collections::BTreeSet<u32> = mesh.faces.iter().map(|f| f.surface).collect();
        // As in the file, if it has a name for each.
        let named = used.last().is_some_and(|&last| (last as usize) < surfaces.len());
        if named {
            mesh.surfaces = surfaces;
            return mesh;
        }
        let numbers: Vec<u32> = used.into_iter().collect();
        for face in &mut mesh.faces {
            face.surface = numbers.binary_search(&face.surface).unwrap_or(0) as u32;
        }
        mesh.surfaces = match numbers.len() {
            0 | 1 => numbers.iter().map(|_| "mesh".to_string()).collect(),
            _ => numbers.iter().map(|n| format!("surface{n}")).collect(),
        };
        mesh
    }
}

impl Element {
    /// The place of a property.
    fn place(&self, name: &str, list: bool) -> Option<usize> {
        self.properties.iter().position(|p: &Property| p.name == name && p.count.is_some() == list)
    }
}
