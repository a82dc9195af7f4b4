//! glTF 2.0, as one binary file or as JSON.

use super::gltf_data::{Buffers, beside};
use super::gltf_json::{Document, extension, index, indices, list, numbers, text};
use super::read::{Source, Wrong, reserve};
use super::{Corner, Face, Mesh};
use crate::image::{Content, record};
use glam::{DMat4, DQuat, DVec3};
use serde_json::Value;
use std::collections::{HashMap, HashSet};
use std::path::Path;

/// Modes of primitives: what their indices make.
const TRIANGLES: usize = 4;
const STRIP: usize = 5;
const FAN: usize = 6;

/// Reads the meshes of the scene that is to be shown first, each where its nodes put it. A scene may be empty.
pub(super) fn read(source: &mut Source<'_>) -> Result<Mesh, Wrong> {
    let (text, own) = match source.bytes.starts_with(b"glTF") {
        true => pieces(source.bytes)?,
        false => (source.bytes, None),
    };
    let document = Document::parse(text)?;
    protect_images(&document, source.path);
    let primitives = document.all("meshes").iter().flat_map(|mesh| list(mesh, "primitives"));
    let by_material = primitives.into_iter().any(|p| matches!(index(p, "material"), Ok(Some(_))));
    let mut reader = Reader {
        document: &document,
        buffers: Buffers::new(&document, own, source.path),
        mesh: Mesh::default(),
        by_material,
        surfaces: HashMap::new(),
        left_out: LeftOut::default(),
    };

    // Each node has one parent at most, so a node that comes again is a fault, and none is looked at for ever.
    let all = document.all("nodes");
    let mut seen = vec![false; all.len()];
    let mut done = 0;
    let roots = roots(&document)?;
    let mut nodes: Vec<(usize, DMat4)> =
        roots.into_iter().rev().map(|node| (node, DMat4::IDENTITY)).collect();
    while let Some((number, parent)) = nodes.pop() {
        let node = document.one("nodes", number)?;
        if std::mem::replace(&mut seen[number], true) {
            return Err(format!("node {number} is in the tree of nodes twice"));
        }
        let what = |wrong: Wrong| format!("node {number}: {wrong}");
        let to_world = parent * matrix(node).map_err(what)?;
        reader.node(number, node, to_world).map_err(what)?;
        nodes.extend(
            indices(node, "children").map_err(what)?.into_iter().rev().map(|child| (child, to_world)),
        );
        done += 1;
        (source.progress)(done, seen.len());
    }
    source.notes.extend(reader.left_out.notes());
    if reader.mesh.points.is_empty() {
        source.notes.push("Its scene contains no mesh.".into());
    }
    Ok(reader.mesh)
}

/// Records the images of its materials. They are not read, but they are a part of the mesh that no output may replace.
fn protect_images(document: &Document, path: &Path) {
    let uris = document.all("images").iter().filter_map(|image| super::gltf_json::text(image, "uri"));
    let files = uris.filter(|uri| !uri.starts_with("data:")).filter_map(|uri| beside(uri, path).ok());
    files.for_each(|file| record(&file, Content::Data));
}

/// The nodes that the scene begins with; without a scene, all that are no child of another.
fn roots(document: &Document) -> Result<Vec<usize>, Wrong> {
    if let Some(scene) = document.scene()? {
        return indices(scene, "nodes").map_err(|wrong| format!("the scene: {wrong}"));
    }
    let mut children = HashSet::new();
    for node in document.all("nodes") {
        children.extend(indices(node, "children")?);
    }
    Ok((0..document.all("nodes").len()).filter(|node| !children.contains(node)).collect())
}

/// The JSON and the data of a binary file. (The crate's own function takes a length below that of the header for granted,
/// and copies both.)
fn pieces(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Wrong> {
    let word = |at: usize| bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    match word(4) {
        Some(2) => {}
        Some(version) => return Err(format!("it uses glTF version {version}; pse reads version 2")),
        None => return Err("it ends too early".into()),
    }
    let (mut at, mut text, mut data) = (12, None, None);
    while let (Some(length), Some(kind)) = (word(at), word(at + 4)) {
        let chunk =
            bytes.get(at + 8..).and_then(|rest| rest.get(..length as usize)).ok_or("it ends too early")?;
        match &kind.to_le_bytes() {
            b"JSON" if text.is_none() => text = Some(chunk),
            b"BIN\0" if data.is_none() => data = Some(chunk),
            // Others are for extensions.
            _ => {}
        }
        // Pieces are filled up to a multiple of four bytes, but some programs leave out the filling.
        let end = at + 8 + length as usize;
        let next_is_here = word(end + 4).map(u32::to_le_bytes) == Some(*b"BIN\0");
        at = if next_is_here { end } else { end.next_multiple_of(4) };
    }
    Ok((text.ok_or("its JSON is missing")?, data))
}

/// A node's own transformation.
fn matrix(node: &Value) -> Result<DMat4, Wrong> {
    if let Some(matrix) = numbers::<16>(node, "matrix")? {
        return Ok(DMat4::from_cols_array(&matrix));
    }
    let translation = numbers::<3>(node, "translation")?.unwrap_or_default();
    let rotation = DQuat::from_array(numbers::<4>(node, "rotation")?.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    let scale = numbers::<3>(node, "scale")?.unwrap_or([1.0; 3]);
    let rotation = if rotation.length() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
    Ok(DMat4::from_scale_rotation_translation(scale.into(), rotation, translation.into()))
}

struct Reader<'a> {
    document: &'a Document,
    buffers: Buffers<'a>,
    mesh: Mesh,
    /// Are surfaces told apart by material, or by node?
    by_material: bool,
    /// The numbers of surfaces, by the index of the material or node.
    surfaces: HashMap<Option<usize>, u32>,
    left_out: LeftOut,
}

/// What is not read, or not followed.
#[derive(Default)]
struct LeftOut {
    skins: bool,
    morphs: bool,
    instances: bool,
    colours: bool,
    /// Sets of points or lines.
    lines: usize,
}

impl LeftOut {
    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let mut note = |is: bool, text: &str| {
            if is {
                notes.push(text.to_string());
            }
        };
        note(self.skins, "Skins were ignored: the mesh is in its rest pose.");
        note(self.morphs, "Morph targets were ignored.");
        note(
            self.instances,
            "Copies of a mesh (EXT_mesh_gpu_instancing) were ignored: each mesh appears once.",
        );
        note(self.colours, "Vertex colours were ignored.");
        note(self.lines > 0, &format!("{} sets of points or lines were skipped.", self.lines));
        notes
    }
}

/// Where the points, normals and uvs of a set begin in the mesh.
type Starts = (u32, Option<u32>, Option<u32>);

impl Reader<'_> {
    fn node(&mut self, number: usize, node: &Value, to_world: DMat4) -> Result<(), Wrong> {
        let Some(mesh) = index(node, "mesh")? else { return Ok(()) };
        let mesh = self.document.one("meshes", mesh)?;
        self.left_out.skins |= node.get("skin").is_some();
        self.left_out.instances |= extension(node, "EXT_mesh_gpu_instancing").is_some();
        // Primitives that share their vertices keep sharing them.
        let mut known: HashMap<[Option<usize>; 3], (Starts, usize)> = HashMap::new();
        for primitive in list(mesh, "primitives") {
            self.left_out.morphs |= !list(primitive, "targets").is_empty();
            let mode = index(primitive, "mode")?.unwrap_or(TRIANGLES);
            match mode {
                TRIANGLES | STRIP | FAN => {}
                0..TRIANGLES => {
                    self.left_out.lines += 1;
                    continue;
                }
                _ => return Err(format!("`mode` is {mode}, which is not a kind of primitive")),
            }
            let attributes = primitive.get("attributes").unwrap_or(&Value::Null);
            let [positions, normals, uvs, colours] = ["POSITION", "NORMAL", "TEXCOORD_0", "COLOR_0"];
            self.left_out.colours |= attributes.get(colours).is_some();
            let key = [index(attributes, positions)?, index(attributes, normals)?, index(attributes, uvs)?];
            let [Some(positions), normals, uvs] = key else { continue };
            self.check_compression(primitive, positions)?;
            let (starts, count) = match known.get(&key) {
                Some(starts) => *starts,
                None => {
                    let starts = self.vertices(positions, normals, uvs, to_world)?;
                    *known.entry(key).or_insert((starts, self.buffers.count(positions)?))
                }
            };
            let surface = self.surface(number, node, mesh, primitive)?;
            self.faces(primitive, mode, starts, count, surface, to_world.determinant() < 0.0)?;
        }
        Ok(())
    }

    /// Compressed primitives may have their plain numbers too. Without these their accessors would be all zeros.
    fn check_compression(&self, primitive: &Value, positions: usize) -> Result<(), Wrong> {
        let accessor = self.document.one("accessors", positions)?;
        let plain = accessor.get("bufferView").is_some() || accessor.get("sparse").is_some();
        match extension(primitive, "KHR_draco_mesh_compression") {
            Some(_) if !plain => {
                Err("its mesh is compressed (KHR_draco_mesh_compression), which pse does not read".into())
            }
            _ => Ok(()),
        }
    }

    /// The number of a primitive's surface.
    fn surface(
        &mut self,
        number: usize,
        node: &Value,
        mesh: &Value,
        primitive: &Value,
    ) -> Result<u32, Wrong> {
        let material = index(primitive, "material")?;
        let key = if self.by_material { material } else { Some(number) };
        let document = self.document;
        let names = &mut self.mesh.surfaces;
        Ok(*self.surfaces.entry(key).or_insert_with(|| {
            let (name, what) = match self.by_material {
                true => {
                    let material = material.and_then(|i| document.all("materials").get(i));
                    (material.and_then(|material| text(material, "name")), "material")
                }
                false => (text(node, "name").or(text(mesh, "name")), "node"),
            };
            names.push(match (name, key) {
                (Some(name), _) => name.to_string(),
                (None, Some(index)) => format!("{what}{index}"),
                (None, None) => "no material".into(),
            });
            names.len() as u32 - 1
        }))
    }

    /// Adds vertices, moved to where they are in the world.
    fn vertices(
        &mut self,
        positions: usize,
        normals: Option<usize>,
        uvs: Option<usize>,
        to_world: DMat4,
    ) -> Result<Starts, Wrong> {
        let mesh = &mut self.mesh;
        let start =
            |n: usize| u32::try_from(n).map_err(|_| "there are more than 4 billion vertices".to_string());
        let starts = (start(mesh.points.len())?, start(mesh.normals.len())?, start(mesh.uvs.len())?);
        let points = self.buffers.numbers::<3>(positions)?;
        reserve(&mut mesh.points, points.len())?;
        let moved = points.iter().map(|&p| match to_world == DMat4::IDENTITY {
            true => p,
            false => to_world.transform_point3(p.into()).to_array(),
        });
        mesh.points.extend(moved);
        let mut lists = [false; 2];
        if let Some(normals) = normals {
            let normals = self.buffers.numbers::<3>(normals)?;
            lists[0] = normals.len() == points.len();
            // Normals stay across the faces when these are sheared: they go with the cofactors.
            let [x, y, z] = [to_world.x_axis, to_world.y_axis, to_world.z_axis].map(|axis| axis.truncate());
            let sign = to_world.determinant().signum();
            let cofactors = [y.cross(z), z.cross(x), x.cross(y)].map(|c| c * sign);
            reserve(&mut mesh.normals, normals.len())?;
            mesh.normals.extend(normals.iter().map(|&n| match to_world == DMat4::IDENTITY {
                true => n,
                false => {
                    let normal: DVec3 = cofactors[0] * n[0] + cofactors[1] * n[1] + cofactors[2] * n[2];
                    normal.normalize_or_zero().to_array()
                }
            }));
        }
        if let Some(uvs) = uvs {
            let uvs = self.buffers.numbers::<2>(uvs)?;
            lists[1] = uvs.len() == points.len();
            reserve(&mut mesh.uvs, uvs.len())?;
            // The format has v down.
            mesh.uvs.extend(uvs.iter().map(|[u, v]| [*u, 1.0 - v]));
        }
        if normals.is_some() && !lists[0] || uvs.is_some() && !lists[1] {
            return Err("its vertices have different numbers of positions, normals or uvs".into());
        }
        Ok((starts.0, lists[0].then_some(starts.1), lists[1].then_some(starts.2)))
    }

    fn faces(
        &mut self,
        primitive: &Value,
        mode: usize,
        (points, normals, uvs): Starts,
        count: usize,
        surface: u32,
        mirrored: bool,
    ) -> Result<(), Wrong> {
        let indices: Vec<u32> = match index(primitive, "indices")? {
            Some(accessor) => self.buffers.indices(accessor)?,
            None => (0..count as u32).collect(),
        };
        if let Some(index) = indices.iter().find(|&&i| i as usize >= count) {
            return Err(format!("a face refers to vertex {index}, but there are only {count}"));
        }
        let triangles = match mode {
            TRIANGLES => indices.len() / 3,
            _ => indices.len().saturating_sub(2),
        };
        let mesh = &mut self.mesh;
        reserve(&mut mesh.faces, triangles)?;
        reserve(&mut mesh.corners, triangles * 3)?;
        for i in 0..triangles {
            let mut triangle = match mode {
                STRIP if i % 2 == 1 => [indices[i + 1], indices[i], indices[i + 2]],
                STRIP => [indices[i], indices[i + 1], indices[i + 2]],
                FAN => [indices[0], indices[i + 1], indices[i + 2]],
                _ => [indices[3 * i], indices[3 * i + 1], indices[3 * i + 2]],
            };
            if mirrored {
                triangle.swap(1, 2);
            }
            let first =
                u32::try_from(mesh.corners.len()).map_err(|_| "there are more than 4 billion corners")?;
            mesh.faces.push(Face { first, corners: 3, surface });
            mesh.corners.extend(triangle.map(|v| Corner {
                point: points + v,
                normal: normals.map(|start| start + v),
                uv: uvs.map(|start| start + v),
            }));
        }
        Ok(())
    }
}
