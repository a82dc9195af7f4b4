//! glTF 2.0, as one binary file or as JSON.

use super::gltf_data::Buffers;
use super::read::{Source, Wrong, reserve};
use super::{Corner, Face, Mesh};
use glam::{DMat4, DQuat, DVec3};
use gltf::mesh::{Mode, Semantic};
use gltf::scene::Transform;
use serde_json::json;
use std::collections::{HashMap, HashSet};

/// Extensions that a file may require: without them the shape is the same, or they are known here.
const KNOWN: [&str; 6] = [
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_texture_basisu",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_",
];

/// Reads the meshes of the scene that is to be shown first, each where its nodes put it.
pub(super) fn read(source: &mut Source<'_>) -> Result<Mesh, Wrong> {
    let (text, own) = match source.bytes.starts_with(b"glTF") {
        true => pieces(source.bytes)?,
        false => (source.bytes, None),
    };
    let document = document(text)?;
    let buffers = Buffers::read(&document, own, source.path)?;
    let mut reader = Reader {
        buffers,
        mesh: Mesh::default(),
        by_material: document.meshes().flat_map(|m| m.primitives()).any(|p| p.material().index().is_some()),
        surfaces: HashMap::new(),
        lines: 0,
        strange: [false; 2],
    };

    // Each node has one parent at most, so a node that comes again is a fault, and none is looked at for ever.
    let mut seen = vec![false; document.nodes().len()];
    let mut nodes: Vec<(gltf::Node<'_>, DMat4)> = Vec::new();
    match document.default_scene().or_else(|| document.scenes().next()) {
        Some(scene) => nodes.extend(scene.nodes().map(|node| (node, DMat4::IDENTITY))),
        None => {
            let children: HashSet<usize> =
                document.nodes().flat_map(|n| n.children()).map(|n| n.index()).collect();
            let roots = document.nodes().filter(|n| !children.contains(&n.index()));
            nodes.extend(roots.map(|node| (node, DMat4::IDENTITY)));
        }
    }
    nodes.reverse();
    while let Some((node, parent)) = nodes.pop() {
        if std::mem::replace(&mut seen[node.index()], true) {
            return Err(format!("node {} is in the tree of nodes twice", node.index()));
        }
        let to_world = parent * matrix(&node.transform());
        reader.strange[0] |= node.skin().is_some();
        reader.node(&node, to_world).map_err(|wrong| format!("node {}: {wrong}", node.index()))?;
        let children: Vec<_> = node.children().map(|child| (child, to_world)).collect();
        nodes.extend(children.into_iter().rev());
        (source.progress)(seen.iter().filter(|s| **s).count(), seen.len());
    }

    let [skins, morphs] = reader.strange;
    if skins {
        source.notes.push("Skins were left out: the mesh stands as it was modelled.".into());
    }
    if morphs {
        source.notes.push("Morph targets were left out.".into());
    }
    if reader.lines > 0 {
        source.notes.push(format!("{} sets of points or lines were left out.", reader.lines));
    }
    if reader.mesh.points.is_empty() {
        return Err("there is no mesh in its scene".into());
    }
    Ok(reader.mesh)
}

/// The JSON and the data of a binary file. (The crate's own function takes a length below that of the header for granted,
/// and copies both.)
fn pieces(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Wrong> {
    let word = |at: usize| bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    match word(4) {
        Some(2) => {}
        Some(version) => return Err(format!("it is of version {version} of glTF; version 2 is known here")),
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
        at += 8 + (length as usize).next_multiple_of(4);
    }
    Ok((text.ok_or("its JSON is missing")?, data))
}

/// The JSON, whose references are known to be good.
fn document(text: &[u8]) -> Result<gltf::Document, Wrong> {
    let mut root: gltf::json::Root = gltf::json::deserialize::from_slice(text.trim_ascii_end())
        .map_err(|e| format!("its JSON is no glTF: {e}"))?;
    let known = |name: &str| KNOWN.iter().any(|k| name == *k || k.ends_with('_') && name.starts_with(k));
    if let Some(name) = root.extensions_required.iter().find(|name| !known(name)) {
        return Err(format!("it requires the extension {name}, which is not known here"));
    }
    // The crate does not know them all, and wants bounds of points that are of no use here.
    root.extensions_required.clear();
    for accessor in &mut root.accessors {
        (accessor.min, accessor.max) = (Some(json!([0, 0, 0])), Some(json!([0, 0, 0])));
    }
    // Of all references, it follows these before it looks at them.
    let attributes = root.meshes.iter().flat_map(|mesh| &mesh.primitives).flat_map(|p| p.attributes.values());
    if let Some(index) = attributes.map(|index| index.value()).find(|&i| i >= root.accessors.len()) {
        return Err(format!("a vertex attribute refers to accessor {index}, which is not there"));
    }
    gltf::Document::from_json(root).map_err(|error| match error {
        gltf::Error::Validation(faults) => match faults.first() {
            Some((path, fault)) => format!("{path}: {fault}"),
            None => "it is no glTF".into(),
        },
        other => other.to_string(),
    })
}

/// A node's own transformation.
fn matrix(transform: &Transform) -> DMat4 {
    match transform {
        Transform::Matrix { matrix } => {
            DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from)))
        }
        Transform::Decomposed { translation, rotation, scale } => {
            let rotation = DQuat::from_array(rotation.map(f64::from)).normalize();
            DMat4::from_translation(translation.map(f64::from).into())
                * DMat4::from_quat(rotation)
                * DMat4::from_scale(scale.map(f64::from).into())
        }
    }
}

struct Reader<'a> {
    buffers: Buffers<'a>,
    mesh: Mesh,
    /// Are surfaces told apart by material, or by node?
    by_material: bool,
    /// The numbers of surfaces, by the index of the material or node.
    surfaces: HashMap<Option<usize>, u32>,
    lines: usize,
    /// Skins and morph targets, which are not followed.
    strange: [bool; 2],
}

/// Where the points, normals and uvs of a set begin in the mesh.
type Starts = (u32, Option<u32>, Option<u32>);

impl Reader<'_> {
    fn node(&mut self, node: &gltf::Node<'_>, to_world: DMat4) -> Result<(), Wrong> {
        let Some(mesh) = node.mesh() else { return Ok(()) };
        // Primitives that share their vertices keep sharing them.
        let mut known: HashMap<[Option<usize>; 3], (Starts, usize)> = HashMap::new();
        for primitive in mesh.primitives() {
            self.strange[1] |= primitive.morph_targets().next().is_some();
            if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
                self.lines += 1;
                continue;
            }
            let accessors = [Semantic::Positions, Semantic::Normals, Semantic::TexCoords(0)];
            let accessors = accessors.map(|semantic| primitive.get(&semantic));
            let Some(positions) = &accessors[0] else { continue };
            let key = accessors.each_ref().map(|a| a.as_ref().map(|a| a.index()));
            let (starts, count) = match known.get(&key) {
                Some(starts) => *starts,
                None => {
                    let starts =
                        self.vertices(positions, accessors[1].as_ref(), accessors[2].as_ref(), to_world)?;
                    known.insert(key, (starts, positions.count()));
                    (starts, positions.count())
                }
            };
            let surface = self.surface(node, &mesh, &primitive);
            self.faces(&primitive, starts, count, surface, to_world.determinant() < 0.0)?;
        }
        Ok(())
    }

    /// The number of a primitive's surface.
    fn surface(
        &mut self,
        node: &gltf::Node<'_>,
        mesh: &gltf::Mesh<'_>,
        primitive: &gltf::Primitive<'_>,
    ) -> u32 {
        let material = primitive.material();
        let key = if self.by_material { material.index() } else { Some(node.index()) };
        let names = &mut self.mesh.surfaces;
        *self.surfaces.entry(key).or_insert_with(|| {
            let (name, what) = match self.by_material {
                true => (material.name(), "material"),
                false => (node.name().or(mesh.name()), "node"),
            };
            names.push(match (name, key) {
                (Some(name), _) => name.to_string(),
                (None, Some(index)) => format!("{what}{index}"),
                (None, None) => "no material".into(),
            });
            names.len() as u32 - 1
        })
    }

    /// Adds vertices, moved to where they are in the world.
    fn vertices(
        &mut self,
        positions: &gltf::Accessor<'_>,
        normals: Option<&gltf::Accessor<'_>>,
        uvs: Option<&gltf::Accessor<'_>>,
        to_world: DMat4,
    ) -> Result<Starts, Wrong> {
        let mesh = &mut self.mesh;
        let start =
            |n: usize| u32::try_from(n).map_err(|_| "there are more than 4 billion vertices".to_string());
        let starts = (start(mesh.points.len())?, start(mesh.normals.len())?, start(mesh.uvs.len())?);
        let points = self.buffers.numbers::<3>(positions)?;
        reserve(&mut mesh.points, points.len())?;
        let moved = points.iter().map(|&p| match to_world == DMat4::IDENTITY {
            true => p.map(|c| c as f32),
            false => to_world.transform_point3(p.into()).as_vec3().to_array(),
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
                true => n.map(|c| c as f32),
                false => {
                    let normal: DVec3 = cofactors[0] * n[0] + cofactors[1] * n[1] + cofactors[2] * n[2];
                    normal.normalize_or_zero().as_vec3().to_array()
                }
            }));
        }
        if let Some(uvs) = uvs {
            let uvs = self.buffers.numbers::<2>(uvs)?;
            lists[1] = uvs.len() == points.len();
            reserve(&mut mesh.uvs, uvs.len())?;
            // The format has v down.
            mesh.uvs.extend(uvs.iter().map(|[u, v]| [*u as f32, (1.0 - v) as f32]));
        }
        if normals.is_some() && !lists[0] || uvs.is_some() && !lists[1] {
            return Err("its vertices have not as many normals or uvs as positions".into());
        }
        Ok((starts.0, lists[0].then_some(starts.1), lists[1].then_some(starts.2)))
    }

    fn faces(
        &mut self,
        primitive: &gltf::Primitive<'_>,
        (points, normals, uvs): Starts,
        count: usize,
        surface: u32,
        mirrored: bool,
    ) -> Result<(), Wrong> {
        let indices: Vec<u32> = match primitive.indices() {
            Some(accessor) => self.buffers.numbers::<1>(&accessor)?.into_iter().map(|[i]| i as u32).collect(),
            None => (0..count as u32).collect(),
        };
        if let Some(index) = indices.iter().find(|&&i| i as usize >= count) {
            return Err(format!("a face refers to vertex {index}, but there are only {count}"));
        }
        let triangles = match primitive.mode() {
            Mode::Triangles => indices.len() / 3,
            _ => indices.len().saturating_sub(2),
        };
        let mesh = &mut self.mesh;
        reserve(&mut mesh.faces, triangles)?;
        reserve(&mut mesh.corners, triangles * 3)?;
        for i in 0..triangles {
            let mut triangle = match primitive.mode() {
                Mode::TriangleStrip if i % 2 == 1 => [indices[i + 1], indices[i], indices[i + 2]],
                Mode::TriangleStrip => [indices[i], indices[i + 1], indices[i + 2]],
                Mode::TriangleFan => [indices[0], indices[i + 1], indices[i + 2]],
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
