//! Meshes as the outside sees them: read, written, looked at, moved.

use pse::image::Image;
use pse::mesh::{self, Deform, Mesh};
use pse::scene::{Model, Options, Renderer};
use pse::{Program, RunOptions};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

mod far;
mod forms;

fn suzanne(ending: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/meshes/suzanne.{ending}"))
}

fn read(path: &Path) -> Result<mesh::File, String> {
    mesh::read(path, &|_, _| ()).map_err(|error| error.message)
}

/// The mesh that a text or bytes of that ending are.
fn of(ending: &str, bytes: impl AsRef<[u8]>) -> Result<Mesh, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("a.{ending}"));
    std::fs::write(&path, bytes).unwrap();
    let shown = path.display().to_string();
    read(&path).map(|file| file.mesh).map_err(|error| error.replace(&shown, "a"))
}

fn picture(mesh: Mesh, options: &Options) -> Image<'static> {
    let model = Arc::new(Model::new(mesh).unwrap());
    Renderer::of_model(&model, options).unwrap().rows(0..options.height).unwrap()
}

fn view(width: usize, height: usize, eye: [f64; 3], look_at: [f64; 3], fov: f64) -> Options {
    Options { width, height, eye: Some(eye), look_at: Some(look_at), fov: Some(fov), scale: 1.0 }
}

fn at(image: &Image<'_>, name: &str, column: usize, row: usize) -> Vec<f32> {
    let planes = &image.variable(name).unwrap().planes;
    planes.iter().map(|plane| plane[row * image.width + column]).collect()
}

/// A ball of quads and triangles, closed.
fn ball(steps: usize) -> String {
    let mut text = String::from("v 0 1 0\n");
    for i in 1..steps {
        let a = std::f64::consts::PI * i as f64 / steps as f64;
        for j in 0..2 * steps {
            let b = std::f64::consts::PI * j as f64 / steps as f64;
            text += &format!(
                "v {} {} {}\n",
                libm::sin(a) * libm::sin(b),
                libm::cos(a),
                libm::sin(a) * libm::cos(b)
            );
        }
    }
    text += "v 0 -1 0\n";
    let (round, last) = (2 * steps, 2 + (steps - 1) * 2 * steps);
    let ring = |i: usize, j: usize| 2 + i * round + j % round;
    for j in 0..round {
        text += &format!("f 1 {} {}\n", ring(0, j), ring(0, j + 1));
        for i in 0..steps - 2 {
            let [a, b, c, d] = [ring(i, j), ring(i + 1, j), ring(i + 1, j + 1), ring(i, j + 1)];
            text += &format!("f {a} {b} {c} {d}\n");
        }
        text += &format!("f {last} {} {}\n", ring(steps - 2, j + 1), ring(steps - 2, j));
    }
    text
}

#[test]
fn the_same_head_from_both_formats() {
    let obj = read(&suzanne("obj")).unwrap();
    assert_eq!((obj.mesh.points.len(), obj.mesh.normals.len(), obj.mesh.uvs.len()), (2012, 2012, 2109));
    assert_eq!((obj.mesh.faces.len(), obj.mesh.corners.len()), (1968, 4 * 1968));
    assert_eq!(obj.mesh.points[0], [0.439019, 0.159939, 0.756944]);
    assert_eq!(obj.mesh.surfaces, ["Suzanne"]);
    let glb = read(&suzanne("glb")).unwrap();
    assert_eq!((glb.mesh.points.len(), glb.mesh.normals.len(), glb.mesh.uvs.len()), (2109, 2109, 2109));
    assert_eq!((glb.mesh.faces.len(), glb.mesh.corners.len()), (3936, 3 * 3936));
    for (a, b) in obj.mesh.bounds().unwrap().iter().zip(glb.mesh.bounds().unwrap()) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5), "{a:?} {b:?}");
    }

    // Seen from before it they are the same picture, uv included: v is up in both.
    let options = view(64, 48, [0.0, 4.0, 0.5], [0.0; 3], 40.0);
    let [one, other] = [obj.mesh, glb.mesh].map(|mut mesh| {
        mesh.y_up_to_z_up();
        picture(mesh, &options)
    });
    let both = |i: usize| [&one, &other].map(|image| image.variable("surface").unwrap().planes[0][i]);
    let seen: Vec<usize> = (0..64 * 48).filter(|&i| both(i) == [1.0, 1.0]).collect();
    assert!(seen.len() > 500, "{} pixels", seen.len());
    assert!((0..64 * 48).filter(|&i| both(i)[0] != both(i)[1]).count() < 5);
    for name in ["point", "normal", "uv", "depth", "dPdu"] {
        let planes = [&one, &other].map(|image| &image.variable(name).unwrap().planes);
        // A quad is two triangles that may be cut along either diagonal.
        let far = |i: usize| planes[0].iter().zip(planes[1].iter()).any(|(a, b)| (a[i] - b[i]).abs() > 0.02);
        let off = seen.iter().filter(|&&i| far(i)).count();
        assert!(off * 12 < seen.len(), "{name}: {off} of {}", seen.len());
    }
}

#[test]
fn what_is_written_is_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let text = "o a b\nv 0 0 0\nv 1 0 0.1\nv 1 1 0\nv 0 1 1e-7\nv 2 2 2\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n\
                usemtl red\nf 1/1/1 2/2/1 3/3/1 4/4/1\nusemtl blue paint\nf 1/1 2/2 5/3\nusemtl red\nf -5 -4 -3\n";
    let mesh = of("obj", text).unwrap();
    assert_eq!(mesh.surfaces, ["red", "blue paint"]);
    assert_eq!(
        mesh.faces.iter().map(|f| (f.corners, f.surface)).collect::<Vec<_>>(),
        [(4, 0), (3, 1), (3, 0)]
    );
    let again = |mesh: &Mesh, name: &str| {
        let path = folder.path().join(name);
        mesh.write(&path).unwrap();
        read(&path).unwrap().mesh
    };
    assert_eq!(again(&mesh, "a.obj"), mesh);

    // Suzanne's points are split at seams of uv alone, and then once for all.
    let obj = read(&suzanne("obj")).unwrap().mesh;
    assert_eq!(again(&obj, "s.obj"), obj);
    let ply = again(&obj, "s.ply");
    assert_eq!((ply.points.len(), ply.faces.len()), (2109, 1968));
    assert_eq!(again(&ply, "t.ply"), ply);
    let glb = again(&ply, "s.glb");
    assert_eq!((glb.points.len(), glb.faces.len()), (2109, 3936));
    assert_eq!(glb.points, ply.points);
    assert_eq!(glb.normals, ply.normals);
    assert_eq!(glb.surfaces, ["Suzanne"]);
    assert!(glb.uvs.iter().zip(&ply.uvs).all(|(a, b)| a[0] == b[0] && (a[1] - b[1]).abs() < 1e-6));

    let two = again(&mesh, "two.glb");
    assert_eq!(two.surfaces, ["red", "blue paint"]);
    let two = again(&mesh, "two.ply");
    assert_eq!((two.surfaces.len(), two.faces[1].surface), (2, 1));
    assert_eq!(two.surfaces, ["red", "blue paint"]);

    let error = mesh.write(&folder.path().join("a.stl")).unwrap_err();
    assert!(error.message.contains("unknown mesh format .stl"), "{error}");
    let mut broken = mesh.clone();
    broken.points[2][1] = f64::NAN;
    let error = broken.write(&folder.path().join("b.obj")).unwrap_err();
    assert!(error.message.contains("vertex 3 is at [1 NaN 0]"), "{error}");
    assert!(!folder.path().join("b.obj").exists());
}

#[test]
fn ply_in_all_its_forms() {
    let header = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty double y\n\
             property float z\nproperty uchar red\nelement face 2\nproperty list uchar int vertex_index\nend_header\n"
        )
    };
    let text =
        of("ply", header("ascii") + "0 0 0 255\n1 0 0 255\n1 1 0 0\n0 1 0.5 7\n3 0 1 2\n3 0 2 3\n").unwrap();
    assert_eq!(text.points, [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]]);
    assert_eq!(text.faces.len(), 2);
    let binary = |big: bool| {
        let put = |bytes: &[u8]| {
            if big { bytes.iter().rev().copied().collect::<Vec<u8>>() } else { bytes.to_vec() }
        };
        let mut data = header(if big { "binary_big_endian" } else { "binary_little_endian" }).into_bytes();
        for [x, y, z] in &text.points {
            data.extend(put(&(*x as f32).to_le_bytes()));
            data.extend(put(&y.to_le_bytes()));
            data.extend(put(&(*z as f32).to_le_bytes()));
            data.push(9);
        }
        for face in [[0i32, 1, 2], [0, 2, 3]] {
            data.push(3);
            face.iter().for_each(|i| data.extend(put(&i.to_le_bytes())));
        }
        data
    };
    assert_eq!(of("ply", binary(false)).unwrap(), text);
    assert_eq!(of("ply", binary(true)).unwrap(), text);
    let short = &binary(false)[..binary(false).len() - 2];
    assert_eq!(of("ply", short).unwrap_err(), "cannot read `a`: face 2 of 2: the file ends here");
    let liar = header("binary_little_endian").replace("vertex 4", "vertex 4000000000");
    assert_eq!(
        of("ply", liar).unwrap_err(),
        "cannot read `a`: it ends before its 4000000000 vertex entries do"
    );
}

#[test]
fn nodes_of_gltf_move_turn_and_mirror() {
    let folder = tempfile::tempdir().unwrap();
    let mut data: Vec<u8> = Vec::new();
    for x in [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        data.extend(x.to_le_bytes());
    }
    // A sparse replacement: entry 2 becomes [0 2 0].
    data.extend(2u32.to_le_bytes());
    for x in [0.0f32, 2.0, 0.0] {
        data.extend(x.to_le_bytes());
    }
    std::fs::write(folder.path().join("some data.bin"), &data).unwrap();
    let gltf = |required: &str, uri: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"extensionsRequired":[{required}],"extensionsUsed":[{required}],
            "scenes":[{{"nodes":[0,2]}}],
            "nodes":[{{"children":[1],"translation":[10,0,0]}},{{"mesh":0,"scale":[-1,1,1],"name":"left"}},{{"mesh":1,"name":"right"}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}},{{"primitives":[{{"attributes":{{"POSITION":1}}}}]}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},
              {{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
               "sparse":{{"count":1,"indices":{{"bufferView":1,"componentType":5125}},"values":{{"bufferView":2}}}}}}],
            "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":4}},{{"buffer":0,"byteOffset":40,"byteLength":12}}],
            "buffers":[{{"byteLength":52,"uri":"{uri}"}}]}}"#
        )
    };
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, gltf("", "some%20data.bin")).unwrap();
    let mesh = read(&path).unwrap().mesh;
    assert_eq!(mesh.points[..3], [[10.0, 0.0, 0.0], [9.0, 0.0, 0.0], [10.0, 1.0, 0.0]]);
    // Mirrored, it would look the other way if its order were kept.
    let order: Vec<u32> = mesh.corners.iter().map(|c| c.point).collect();
    assert_eq!(order, [0, 2, 1, 3, 4, 5]);
    assert_eq!(mesh.points[3..], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
    assert_eq!(mesh.surfaces, ["left", "right"]);

    let fails = |text: String| {
        std::fs::write(&path, text).unwrap();
        read(&path).unwrap_err()
    };
    assert!(fails(gltf("", "../some.bin")).contains("only files beside it"));
    assert!(fails(gltf("", "https://a.b/c.bin")).contains("only files beside it"));
    assert!(fails(gltf("", "none.bin")).contains("none.bin"));
    let error = fails(gltf("\"KHR_draco_mesh_compression\"", "some%20data.bin"));
    assert!(error.contains("requires the extension KHR_draco_mesh_compression"), "{error}");
    let encoded = "data:application/octet-stream;base64,AAAA";
    assert!(fails(gltf("", encoded)).contains("buffer 0 has 3 bytes, but should have 52"));
    let lost = gltf("", "some%20data.bin").replace("\"POSITION\":1", "\"POSITION\":7");
    assert!(fails(lost).contains("node 2: it refers to accessors[7], but there are only 2"));
    std::fs::write(&path, gltf("\"KHR_materials_unlit\"", "some%20data.bin")).unwrap();
    assert!(read(&path).is_ok());
}

#[test]
fn polygons_that_are_not_convex_keep_their_outline() {
    // A U seen from above: nothing is between its arms.
    let u = "v 0 0 0\nv 3 0 0\nv 3 3 0\nv 2 3 0\nv 2 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\nf 1 2 3 4 5 6 7 8\n";
    // An arrowhead: a quad whose third corner goes in.
    let arrow = "v 0 0 0\nv 2 1 0\nv 0.5 1 0\nv 0 3 0\nf 1 2 3 4\nf 4 3 2 1\n";
    let options = view(30, 30, [1.5, 1.5, 40.0], [1.5, 1.5, 0.0], 2.0 * libm::atan(1.5 / 40.0).to_degrees());
    let image = picture(of("obj", u).unwrap(), &options);
    for row in 0..30 {
        for column in 0..30 {
            let inside = !((10..20).contains(&column) && row < 20);
            assert_eq!(at(&image, "surface", column, row), [f32::from(inside)], "{column} {row}");
            assert_eq!(at(&image, "normal", column, row)[2], f32::from(inside));
        }
    }
    let image = picture(of("obj", arrow).unwrap(), &options);
    // [1 1.5] is beyond the corner that goes in, [0.3 1.2] is not.
    assert_eq!(at(&image, "surface", 10, 15), [0.0]);
    assert_eq!(at(&image, "surface", 3, 18), [1.0]);
}

#[test]
fn a_closed_mesh_has_no_holes_from_anywhere() {
    for (steps, scale) in [(3, 1.0), (40, 1.0), (24, 1e-3), (24, 3e4)] {
        let mut mesh = of("obj", ball(steps)).unwrap();
        mesh.points.iter_mut().flatten().for_each(|c| *c *= scale);
        let model = Arc::new(Model::new(mesh).unwrap());
        for i in 0..40 {
            let (a, b) = (i as f64 * 2.4, libm::asin(i as f64 / 20.0 - 0.97));
            let from = [libm::cos(a) * libm::cos(b), libm::sin(a) * libm::cos(b), libm::sin(b)];
            // From far away and from near, and from the very axes, whose rays meet edges and vertices.
            let far = if i % 2 == 0 { 3.0 } else { 90.0 };
            let from = if i < 6 {
                std::array::from_fn(|k| if k == i % 3 { 1.0 - 2.0 * (i / 3) as f64 } else { 0.0 })
            } else {
                from
            };
            let eye = from.map(|c| c * far * scale);
            // The whole picture lies within the inscribed ball.
            let fov = 2.0 * libm::atan(0.45 / far).to_degrees();
            let image =
                Renderer::of_model(&model, &view(41, 41, eye, [0.0; 3], fov)).unwrap().rows(0..41).unwrap();
            let holes = image.variable("surface").unwrap().planes[0].iter().filter(|&&s| s == 0.0).count();
            assert_eq!(holes, 0, "{steps} steps, scale {scale}, seen from {eye:?}");
            // Nor does any ray go through to the far side.
            let depth = &image.variable("depth").unwrap().planes[0];
            assert!(depth.iter().all(|&d| f64::from(d) < far * scale), "from {eye:?}");
        }
    }
}

#[test]
fn missing_normals_are_smooth_and_sheets_turn_to_the_eye() {
    let mesh = of("obj", ball(32)).unwrap();
    let image = picture(mesh, &view(33, 33, [0.0, -6.0, 0.0], [0.0; 3], 11.0));
    for pixel in 0..33 * 33 {
        let [point, normal] =
            [at(&image, "point", pixel % 33, pixel / 33), at(&image, "normal", pixel % 33, pixel / 33)];
        let length = point.iter().map(|c| c * c).sum::<f32>().sqrt();
        let cosine: f32 = point.iter().zip(&normal).map(|(p, n)| p * n / length).sum();
        assert!(cosine > 0.9995, "{point:?} {normal:?}");
    }
    let sheet = of(
        "obj",
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 2 0\nvt 2 2\nvt 0 2\nf 1/1 2/2 3/3 4/4\n",
    )
    .unwrap();
    let above = picture(sheet.clone(), &view(9, 9, [0.0, 0.0, 5.0], [0.0; 3], 10.0));
    let below = picture(sheet, &view(9, 9, [0.0, 0.0, -5.0], [0.0; 3], 10.0));
    assert_eq!(at(&above, "normal", 4, 4), [0.0, 0.0, 1.0]);
    assert_eq!(at(&below, "normal", 4, 4), [0.0, 0.0, -1.0]);
    assert_eq!(at(&above, "uv", 4, 4), [1.0, 1.0]);
    assert_eq!(
        (at(&above, "dPdu", 4, 4), at(&above, "dPdv", 4, 4)),
        (vec![1.0, 0.0, 0.0], vec![0.0, 1.0, 0.0])
    );
    assert_eq!(at(&above, "depth", 4, 4), [5.0]);
}

#[test]
fn degenerate_faces_do_no_harm() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 2 0 0\nv 1e38 1e38 1e38\nvt 0 0\nvn 0 0 0\n\
                f 1 1 1\nf 1 2\nf 1 2 4\nf 1//1 2//1 3//1\nf 1/1 2/1 3/1\nf 1 2 3 2 1\n";
    let file = of("obj", text).unwrap();
    assert_eq!(file.faces.len(), 5);
    let image = picture(file, &view(20, 20, [0.7, 0.2, 3.0], [0.7, 0.2, 0.0], 20.0));
    assert!(image.variables.iter().all(|v| v.planes.iter().all(|p| p.iter().all(|x| x.is_finite()))));
    assert_eq!(at(&image, "surface", 10, 10), [1.0]);
    assert_eq!(at(&image, "normal", 10, 10), [0.0, 0.0, 1.0]);
    assert_eq!(at(&image, "dPdu", 10, 10), [0.0; 3]);
    let none = Model::new(of("obj", "v 0 0 0\nf 1 1 1\n").unwrap()).err().unwrap().to_string();
    assert!(none.contains("no faces"), "{none}");
}

#[test]
fn errors_say_where() {
    for (ending, text, expected) in [
        ("obj", "v 0 0 0\nv 1 x 0\n", "cannot read `a`: line 2: `x` is not a number"),
        ("obj", "v 0 0\n", "cannot read `a`: line 1: v is followed by 2 numbers, not by 3"),
        ("obj", "v 0 0 0\nf 1 1 9\n", "cannot read `a`: face 1 refers to vertex 9, but there are only 1"),
        (
            "obj",
            "v 0 0 0\nf 1 0 1\n",
            "cannot read `a`: line 2: the face's vertex `0` is not an index: they start at 1",
        ),
        ("obj", "v 0 0 inf\n", "cannot read `a`: vertex 1 is at [0 0 inf], which is not a valid position"),
        ("obj", "hello\n", "cannot read `a`: it has no vertices (no line starts with v)"),
        (
            "ply",
            "ply\nformat ascii 1.0\nelement vertex x\n",
            "cannot read `a`: line 3 of its header: `x` is not a count",
        ),
        ("ply", "solid", "`a` is damaged or incomplete: it does not begin as a .ply file does"),
        ("glb", "glTF\u{1}\0\0\0", "cannot read `a`: it uses glTF version 1; pse reads version 2"),
        ("stl", "solid", "`a` is not a mesh file that pse reads"),
    ] {
        assert_eq!(of(ending, text).unwrap_err(), expected);
    }
}

#[test]
fn two_thousand_flipped_bits_are_an_error_or_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let mut obj = of("obj", ball(6).replace("v 0 1 0\n", "v 0 1 0\nvn 0 0 1\nvt 0.5 0.5\no one\n")).unwrap();
    obj.points.iter_mut().flatten().for_each(|c| *c = f64::from(*c as f32));
    let bytes = |name: &str| {
        obj.write(&folder.path().join(name)).unwrap();
        std::fs::read(folder.path().join(name)).unwrap()
    };
    let ascii = {
        let mut text = format!(
            "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n",
            obj.points.len()
        );
        text += &format!(
            "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
            obj.faces.len()
        );
        obj.points.iter().for_each(|[x, y, z]| text += &format!("{x} {y} {z}\n"));
        for face in &obj.faces {
            let corners: Vec<String> = obj.corners_of(face).iter().map(|c| c.point.to_string()).collect();
            text += &format!("{} {}\n", corners.len(), corners.join(" "));
        }
        text.into_bytes()
    };
    let little = bytes("a.ply");
    let big = {
        // The header of the other byte order before the same data is damage too, but of another kind.
        let text = String::from_utf8_lossy(&little).find("end_header\n").unwrap() + 11;
        let header = String::from_utf8_lossy(&little[..text]).replace("little", "big");
        let mut whole = header.into_bytes();
        let faces = text + 12 * obj.points.len();
        little[text..faces].chunks(4).for_each(|c| whole.extend(c.iter().rev()));
        let mut at = faces;
        while at < little.len() {
            let corners = little[at] as usize;
            whole.push(little[at]);
            little[at + 1..at + 1 + 4 * corners].chunks(4).for_each(|c| whole.extend(c.iter().rev()));
            at += 1 + 4 * corners;
        }
        whole
    };
    assert_eq!(of("ply", &big).unwrap(), of("ply", &little).unwrap());
    let sources = [
        ("obj", bytes("a.obj")),
        ("ply", ascii),
        ("ply", little),
        ("ply", big),
        ("glb", bytes("a.glb")),
        ("gltf", gltf_text()),
    ];
    let start = Instant::now();
    let mut state = 1u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as usize % below
    };
    let (mut pictures, mut errors) = (0, 0);
    for (ending, whole) in &sources {
        for i in 0..2000 {
            let mut bytes = whole.clone();
            // Half of them near the beginning, where headers are.
            let most = if i % 2 == 0 { bytes.len() } else { bytes.len().min(400) };
            for _ in 0..1 + i % 3 {
                bytes[random(most)] ^= 1 << random(8);
            }
            if i % 10 == 9 {
                bytes.truncate(random(bytes.len()));
            }
            match of(ending, &bytes).map(Model::new) {
                Ok(Ok(model)) => {
                    let options = Options { width: 8, height: 8, ..Options::default() };
                    // Far points may put the eye out of range.
                    match Renderer::of_model(&Arc::new(model), &options) {
                        Ok(renderer) => {
                            renderer.rows(0..8).unwrap();
                            pictures += 1;
                        }
                        Err(_) => errors += 1,
                    }
                }
                Ok(Err(_)) | Err(_) => errors += 1,
            }
        }
    }
    assert!(pictures > 1000 && errors > 1000, "{pictures} pictures, {errors} errors");
    assert!(start.elapsed().as_secs() < 120, "{:?}", start.elapsed());
}

/// A triangle as .gltf, its data within.
fn gltf_text() -> Vec<u8> {
    let uri = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"rotation":[0,0,0,1]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"mode":4}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"byteLength":36,"uri":"{uri}"}}]}}"#
    )
    .into_bytes()
}

#[test]
fn a_program_moves_the_vertices() {
    let before = read(&suzanne("obj")).unwrap().mesh;
    let deform = Deform::new(before.clone());
    let moved = |text: &str| {
        let program = Program::compile(text).unwrap();
        let report = program.run(&deform.image(), &RunOptions::default()).unwrap();
        deform.moved(&report.image)
    };
    let after = moved("point = 2 * point + [1 0 0]").unwrap();
    assert!(
        after
            .points
            .iter()
            .zip(&before.points)
            .all(|(a, b)| { a[0] as f32 == 2.0 * b[0] as f32 + 1.0 && a[1] as f32 == 2.0 * b[1] as f32 })
    );
    assert_eq!((&after.faces, &after.uvs), (&before.faces, &before.uvs));
    // Scaled evenly, the normals made anew are about those of the file.
    let normal = |mesh: &Mesh, corner: usize| mesh.normals[mesh.corners[corner].normal.unwrap() as usize];
    let cosine = |i: usize| normal(&before, i).iter().zip(normal(&after, i)).map(|(a, b)| a * b).sum::<f64>();
    let off = (0..before.corners.len()).filter(|&i| cosine(i) < 0.97).count();
    assert!(off < before.corners.len() / 50, "{off} normals are elsewhere");
    assert_eq!(
        moved("point = point / (uv.x * 0)").unwrap_err().message.split(" to ").next().unwrap(),
        "the program moves vertex 1"
    );
    assert!(moved("point = 1").unwrap_err().message.contains("`point` is a scalar"));

    // A cube keeps its edges, and its faces stay together where their normals part.
    let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 -1\nvn 0 -1 0\nv 0 0 1\nv 1 0 1\nf 4//1 3//1 2//1 1//1\nf 1//2 2//2 6//2 5//2\n";
    let deform = Deform::new(of("obj", cube).unwrap());
    let program = Program::compile("point += normal").unwrap();
    let report = program.run(&deform.image(), &RunOptions::default()).unwrap();
    let after = deform.moved(&report.image).unwrap();
    assert_eq!(after.normals.len(), 2 * 4, "two faces of four corners, none of them smooth");
    assert!((after.points[0][1] + 0.5f64.sqrt()).abs() < 1e-6 && after.points[0][1] == after.points[0][2]);
}
