//! glTF 2.0 in one binary file.

use super::Corner;
use super::Mesh;
use super::cut::{Crossing, Cutter, MAX_EARS};
use super::split::{Split, split};
use serde_json::{Value, json};
use std::borrow::Cow;

/// Numbers of the format: kinds of components, and what a piece of the data is for.
const U32: u32 = 5125;
const F32: u32 = 5126;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// The mesh as bytes of a file, or why it cannot be one. Several surfaces become materials; faces become triangles.
pub(super) fn encode(mesh: &Mesh) -> Result<Vec<u8>, Cow<'static, str>> {
    let Split { vertices, of_corner } = split(mesh);
    let mut triangles: Vec<Vec<u32>> = vec![Vec::new(); mesh.surfaces.len().max(1)];
    let mut cutter = Cutter::new();
    for face in &mesh.faces {
        let list = triangles.get_mut(face.surface as usize).ok_or("a face has no surface")?;
        let add = |t: [u32; 3]| list.extend(t.map(|i| of_corner[(face.first + i) as usize]));
        cutter.cut(mesh, face, add).map_err(|Crossing { corners }| {
            format!(
                "a face of {corners} corners crosses itself; such a face can have at most {MAX_EARS} corners"
            )
        })?;
    }
    if triangles.iter().all(Vec::is_empty) {
        return Err("it would have no faces, and a .glb file must have some".into());
    }

    let mut data = Data { bytes: Vec::new(), views: Vec::new(), accessors: Vec::new() };
    let translation = translation(mesh);
    let local = |v: &Corner| {
        let point = mesh.points[v.point as usize];
        [0, 1, 2].map(|i| (point[i] - translation[i]) as f32)
    };
    let bounds = mesh.bounds().unwrap_or_default();
    let [low, high] = bounds.map(|end| [0, 1, 2].map(|i| (end[i] - translation[i]) as f32));
    let points = vertices.iter().flat_map(local);
    let mut attributes = serde_json::Map::new();
    let place = data.add(points.map(f32::to_bits), VERTICES, F32, "VEC3");
    data.accessors[place]["min"] = json!(low);
    data.accessors[place]["max"] = json!(high);
    attributes.insert("POSITION".into(), place.into());
    if mesh.corners.iter().all(|c| c.normal.is_some()) {
        // A vertex of no face has none, but there must be one.
        let normal = |i: Option<u32>| i.map_or([0.0, 0.0, 1.0], |i| mesh.normals[i as usize]);
        let normals = vertices.iter().flat_map(|v| normal(v.normal));
        let place = data.add(normals.map(|c| (c as f32).to_bits()), VERTICES, F32, "VEC3");
        attributes.insert("NORMAL".into(), place.into());
    }
    if mesh.corners.iter().any(|c| c.uv.is_some()) {
        // The format has v down.
        let uv = |i: Option<u32>| i.map_or([0.0, 1.0], |i| mesh.uvs[i as usize]);
        let uvs = vertices.iter().map(|v| uv(v.uv)).flat_map(|[u, v]| [u, 1.0 - v]);
        let place = data.add(uvs.map(|c| (c as f32).to_bits()), VERTICES, F32, "VEC2");
        attributes.insert("TEXCOORD_0".into(), place.into());
    }
    let several = mesh.surfaces.len() > 1;
    let mut primitives = Vec::new();
    for (surface, list) in triangles.into_iter().enumerate().filter(|(_, list)| !list.is_empty()) {
        let indices = data.add(list.into_iter(), INDICES, U32, "SCALAR");
        let mut primitive = json!({ "attributes": attributes, "indices": indices });
        if several {
            primitive["material"] = surface.into();
        }
        primitives.push(primitive);
    }

    let name = if several { "mesh".to_string() } else { mesh.line_of(0) };
    let mut root = json!({
        "asset": { "version": "2.0", "generator": concat!("pse ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": name }],
        "meshes": [{ "name": name, "primitives": primitives }],
        "accessors": data.accessors,
        "bufferViews": data.views,
        "buffers": [{ "byteLength": data.bytes.len() }],
    });
    if translation != [0.0; 3] {
        root["nodes"][0]["translation"] = json!(translation);
    }
    if several {
        let material = |i| json!({ "name": mesh.line_of(i), "doubleSided": true });
        root["materials"] = (0..mesh.surfaces.len()).map(material).collect::<Value>();
    }
    let mut text = root.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + text.len() + 8 + data.bytes.len();
    let size = |n: usize| {
        u32::try_from(n).map(u32::to_le_bytes).map_err(|_| "a .glb file holds at most 4 gigabytes")
    };
    let mut file = Vec::with_capacity(total);
    file.extend(*b"glTF");
    file.extend(2u32.to_le_bytes());
    file.extend(size(total)?);
    for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &data.bytes)] {
        file.extend(size(chunk.len())?);
        file.extend(kind);
        file.extend(chunk);
    }
    Ok(file)
}

/// Where the node is that has the points: not at the origin if points are so far from it that floats lose their shape. Each
/// coordinate is a float, so that every reader takes the same.
fn translation(mesh: &Mesh) -> [f64; 3] {
    if mesh.fits_singles() {
        return [0.0; 3];
    }
    let side = mesh.longest_side();
    mesh.middle().map(|c| if c.abs() > side { f64::from(c as f32) } else { 0.0 })
}

/// The binary part of the file, and what describes it.
struct Data {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Data {
    /// Adds a list of numbers of four bytes: the number of its accessor.
    fn add(&mut self, words: impl Iterator<Item = u32>, target: u32, component: u32, kind: &str) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend(words.flat_map(u32::to_le_bytes));
        let length = self.bytes.len() - offset;
        let width = match kind {
            "VEC3" => 12,
            "VEC2" => 8,
            _ => 4,
        };
        self.views.push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": length, "target": target }));
        self.accessors.push(json!({
            "bufferView": self.views.len() - 1, "componentType": component, "count": length / width, "type": kind,
        }));
        self.accessors.len() - 1
    }
}
