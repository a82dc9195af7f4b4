//! OBJ, PLY and glTF as programs write them, and as the specifications allow them.

use super::{of, read};
use pse::mesh::Mesh;

const TRIANGLE: [[f64; 3]; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// What was left out of a text of that ending.
fn notes(ending: &str, text: impl AsRef<[u8]>) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("a.{ending}"));
    std::fs::write(&path, text).unwrap();
    read(&path).unwrap().notes
}

fn uvs(mesh: &Mesh) -> Vec<Option<[f64; 2]>> {
    mesh.corners.iter().map(|c| c.uv.map(|i| mesh.uvs[i as usize])).collect()
}

#[test]
fn obj_in_every_encoding_and_with_every_line_end() {
    let text = "o k\u{e4}se\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let expected = of("obj", text).unwrap();
    assert_eq!(expected.points, TRIANGLE);
    assert_eq!(expected.surfaces, ["k\u{e4}se"]);
    let wide = |mark: &str, bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
        format!("{mark}{text}").encode_utf16().flat_map(bytes).collect()
    };
    let forms: [Vec<u8>; 9] = [
        format!("\u{FEFF}{text}").into_bytes(),
        wide("\u{FEFF}", u16::to_le_bytes),
        wide("\u{FEFF}", u16::to_be_bytes),
        wide("", u16::to_le_bytes),
        wide("", u16::to_be_bytes),
        text.replace('\n', "\r\n").into_bytes(),
        text.replace('\n', "\r").into_bytes(),
        text.replace(' ', "\t").replace("v\t", " v \t ").into_bytes(),
        text.trim_end().as_bytes().to_vec(),
    ];
    for form in forms {
        assert_eq!(of("obj", &form).unwrap(), expected, "{:?}", String::from_utf8_lossy(&form));
    }
}

#[test]
fn obj_statements_that_are_left_out_leave_the_rest() {
    let text = "# from C:\\models\\\nv 0 0 0 1.0 # first \\\nv 1 0 0 # second\nv 0 1 \\\n 0#third\nvp 0.5\ncstype bezier\n\
                deg 3\ncurv 0 1 1 2 3\nparm u 0 1\nend\nvt 0.5\nvt 0.25 0.75 0\nvn 0 0 1\nl 1 2\np 1\ncall other.obj\n\
                f 1/1/0 2/0/1 \\\n  3/2/1\nf -3 -2 -1\nf 1// 2/ 3\n";
    let mesh = of("obj", text).unwrap();
    assert_eq!(mesh.points, TRIANGLE);
    assert_eq!(mesh.faces.len(), 3);
    assert_eq!(uvs(&mesh)[..3], [Some([0.5, 0.0]), None, Some([0.25, 0.75])]);
    assert_eq!(mesh.corners[..3].iter().map(|c| c.normal).collect::<Vec<_>>(), [None, Some(0), Some(0)]);
    assert_eq!(
        notes("obj", text),
        [
            "2 lines and points were skipped: only faces are read.",
            "1 curves and free-form surfaces were skipped: only faces are read.",
            "1 statements that call other files were skipped: only faces are read.",
        ]
    );
    let colours = "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 0 1 0\nf 1 2 3\n";
    assert_eq!(notes("obj", colours), ["Vertex colours were ignored."]);
}

#[test]
fn numbers_that_are_none_are_read_as_nan_is() {
    let text = |odd: &str| {
        format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt {odd} 0\nvt 1 1\nvn {odd} {odd} {odd}\nf 1/1/1 2/2/1 3/2/1\n")
    };
    let expected = of("obj", text("nan")).unwrap();
    assert_eq!(uvs(&expected), [None, Some([1.0; 2]), Some([1.0; 2])]);
    assert!(expected.corners.iter().all(|c| c.normal.is_none()));
    for odd in
        ["-nan(ind)", "nan(snan)", "1.#QNAN", "-1.#IND", "-1.#IND00", "1.#INF", "-1.#INF", "1.#J", "NaN"]
    {
        assert_eq!(of("obj", text(odd)).unwrap(), expected, "{odd}");
        let ply = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             property float nx\nproperty float ny\nproperty float nz\nelement face 1\n\
             property list uchar int vertex_indices\nend_header\n0 0 0 {odd} 0 0\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n"
        );
        let mesh = of("ply", ply).unwrap();
        assert_eq!(
            mesh.corners.iter().map(|c| c.normal).collect::<Vec<_>>(),
            [None, Some(1), Some(2)],
            "{odd}"
        );
    }
    // A place must be one.
    assert_eq!(
        of("obj", "v 0 0 0\nv -1.#IND 0 0\n").unwrap_err(),
        "cannot read `a`: vertex 2 is at [NaN 0 0], which is not a valid position"
    );
    assert_eq!(
        of("obj", "v 1e39 0 0\n").unwrap_err(),
        "cannot read `a`: vertex 1 is at [1e39 0 0], which is not a valid position"
            .replace("1e39", &1e39f64.to_string())
    );
}

#[test]
fn normals_and_uv_that_are_not_there_are_left_out() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/7\n";
    let mesh = of("obj", text).unwrap();
    assert_eq!(uvs(&mesh), [None; 3]);
    assert_eq!(mesh.corners.iter().map(|c| c.normal).collect::<Vec<_>>(), [Some(0), Some(0), None]);
    let said = "Faces refer 4 times to normals or uv that do not exist; these references were ignored.";
    assert_eq!(notes("obj", text), [said]);
}

#[test]
fn an_obj_that_is_cut_within_a_line_is_reported() {
    let whole = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nf 1/1 2/1 3/1\nf 2/1 4/1 3/1";
    assert!(notes("obj", whole).is_empty());
    let said =
        ["The file ends within line 7, which differs from the lines before it: the file may be cut off."];
    assert_eq!(notes("obj", whole.trim_end_matches("/1")), said);
    assert_eq!(
        notes("obj", whole.trim_end_matches(" 3/1")),
        [said[0], "1 faces with fewer than three corners were skipped."]
    );
    assert_eq!(
        of("obj", format!("{whole}/\nv 1 2")).unwrap_err(),
        "cannot read `a`: line 8, where the file ends: v is followed by 2 numbers, not by 3"
    );
    assert_eq!(notes("obj", format!("{whole}\nv 1 2 3.1")).len(), 1);
}

fn ply(format: &str, properties: &str, body: &str) -> String {
    format!("ply\nformat {format} 1.0\n{properties}end_header\n{body}")
}

const VERTICES: &str = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";

#[test]
fn ply_text_as_programs_write_it() {
    let faces = "element face 2\nproperty list uchar int vertex_indices\n";
    let head = format!("{VERTICES}{faces}");
    let points = "0 0 0\n1 0 0\n0 1 0\n";
    let expected = of("ply", ply("ascii", &head, &format!("{points}3 0 1 2\n3 2 1 0\n"))).unwrap();
    assert_eq!(expected.points, TRIANGLE);
    // More numbers in a line than were announced.
    let longer = ply("ascii", &head, "0 0 0 9 9\n1 0 0\n0 1 0\n3 0 1 2 6 0.5 0.6 0.7\n3 2 1 0 6 1 1\n");
    assert_eq!(of("ply", &longer).unwrap(), expected);
    assert_eq!(
        notes("ply", &longer),
        ["3 lines have more numbers than the header declares; these were ignored. The first is vertex 1."]
    );
    // Blank lines and tabs; all in one line; an entry in several lines; old line ends; a byte order mark.
    for body in [
        "\n0\t0 0\n\n 1 0 0\n0 1 0\n\n3 0 1 2\n3 2 1 0\n\n",
        "0 0 0 1 0 0 0 1 0 3 0 1 2 3 2 1 0",
        "0 0 0\n1\n0 0\n0 1 0\n3 0\n1 2\n3 2 1 0\n",
    ] {
        assert_eq!(of("ply", ply("ascii", &head, body)).unwrap(), expected, "{body:?}");
    }
    let text = ply("ascii", &head, &format!("{points}3 0 1 2\n3 2 1 0\n"));
    for form in [text.replace('\n', "\r\n"), text.replace('\n', "\r"), format!("\u{FEFF}{text}")] {
        assert_eq!(of("ply", &form).unwrap(), expected);
    }
    // As many lines as entries: one that is too short does not take from the next.
    assert_eq!(
        of("ply", ply("ascii", &head, "0 0 0\n1 0\n0 1 0\n3 0 1 2\n3 2 1 0\n")).unwrap_err(),
        "cannot read `a`: vertex 2 of 3: its line has fewer numbers than the header declares"
    );
    // Both styles of names, lists of any type, faces first, other elements between.
    let other = "comment by hand\nobj_info an old tag\nelement face 2\nproperty int8 flag\n\
                 property list int32 float64 vertex_index\nelement camera 1\nproperty list uint16 uint8 name\n\
                 element vertex 3\nproperty float64 x\nproperty float32 y\nproperty int16 z\n";
    assert_eq!(
        of("ply", ply("ascii", other, "-1 3 0 1 2\n7 3 2 1 0\n2 65 66\n0 0 0\n1 0 0\n0 1 0\n")).unwrap(),
        expected
    );
}

#[test]
fn ply_binary_with_wide_indices_and_any_line_end() {
    let head = format!("{VERTICES}element face 1\nproperty list uint8 int64 vertex_indices\n");
    let bytes = |header: String| {
        let mut bytes = header.into_bytes();
        // Begins with the byte that ends lines, so that the end of the header must be known exactly.
        for x in [f32::from_bits(0x0A0A_0A0A), 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
            bytes.extend(x.to_le_bytes());
        }
        bytes.push(3);
        [0i64, 1, 2].iter().for_each(|i| bytes.extend(i.to_le_bytes()));
        bytes
    };
    let header = ply("binary_little_endian", &head, "");
    let expected = of("ply", bytes(header.clone())).unwrap();
    assert_eq!((expected.faces.len(), expected.points[1]), (1, [1.0, 0.0, 0.0]));
    for end in ["\r\n", "\r"] {
        assert_eq!(of("ply", bytes(header.replace('\n', end))).unwrap(), expected, "{end:?}");
    }
}

/// A triangle as glTF, with parts of the JSON put in: at the root, in the scene, the node, the primitive, the accessor.
fn gltf(root: &str, scene: &str, node: &str, primitive: &str, accessor: &str) -> String {
    let uri = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,{root}"scenes":[{{{scene}"nodes":[0]}}],"nodes":[{{{node}"mesh":0}}],
        "meshes":[{{"primitives":[{{{primitive}"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{{accessor}"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"byteLength":36,"uri":"{uri}"}}]}}"#
    )
}

#[test]
fn gltf_as_the_specification_allows_it() {
    let plain = gltf("", "", "", "", "");
    let expected = of("gltf", &plain).unwrap();
    assert_eq!(expected.points, TRIANGLE);
    for extras in ["42", "[1, \"a\"]", "\"text\"", "null", "{\"a\": {\"b\": []}}", "true"] {
        let part = format!("\"extras\":{extras},");
        assert_eq!(of("gltf", gltf(&part, &part, &part, &part, &part)).unwrap(), expected, "{extras}");
    }
    let extensions = "\"extensions\":{\"VENDOR_any\":{\"a\":[1]}},";
    assert_eq!(
        of("gltf", gltf(extensions, extensions, extensions, extensions, extensions)).unwrap(),
        expected
    );
    for root in [
        // Textures without a source, also such that an extension would have it; images that are nowhere.
        r#""textures":[{},{"sampler":0},{"extensions":{"EXT_texture_webp":{"source":0}}}],"images":[{"uri":"none.png"}],"#,
        r#""materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":7}}},{"alphaMode":"OTHER"}],"#,
        r#""extensionsUsed":["KHR_draco_mesh_compression","VENDOR_any"],"#,
        r#""extensionsRequired":["KHR_texture_basisu","KHR_materials_volume"],"#,
        r#""cameras":[{"type":"perspective"}],"animations":[{"channels":[]}],"skins":[{"joints":[]}],"other":[1,2],"#,
        r#""generator":null,"samplers":[{"magFilter":1}],"#,
    ] {
        assert_eq!(of("gltf", gltf(root, "", "", "", "")).unwrap(), expected, "{root}");
    }
    // Integers are numbers without a fraction, however they are written.
    let floats = plain
        .replace(":0,", ":0.0,")
        .replace(":36", ":3.6e1")
        .replace(":3,", ":3.0,")
        .replace("5126", "5126.0");
    assert_eq!(of("gltf", floats.replace("[0]", "[0.0]")).unwrap(), expected);
    assert!(
        of("gltf", plain.replace(":3,", ":3.5,"))
            .unwrap_err()
            .contains("`count` is 3.5, which is not a whole number")
    );
    // A buffer that nothing needs need not be there, and padding may be missing.
    let more = plain.replace("AAAA\"}]}", "AAAA\"},{\"byteLength\":9,\"uri\":\"none.bin\"}]}");
    assert_ne!(more, plain);
    assert_eq!(of("gltf", more).unwrap(), expected);
    assert_eq!(of("gltf", format!("\u{FEFF}{plain}")).unwrap(), expected);
}

#[test]
fn gltf_with_nothing_to_show_is_empty() {
    let plain = gltf("", "", "", "", "");
    for text in [
        plain.replace("\"nodes\":[0]", "\"name\":\"empty\""),
        r#"{"asset":{"version":"2.0"}}"#.to_string(),
        r#"{"asset":{"version":"2.1","minVersion":"2.0"},"scenes":[{}]}"#.to_string(),
    ] {
        assert_eq!(of("gltf", &text).unwrap(), Mesh::default(), "{text}");
        assert_eq!(notes("gltf", &text), ["Its scene contains no mesh."]);
    }
    // Without a view all numbers are zeros.
    let zeros = of("gltf", plain.replace("\"bufferView\":0,", "")).unwrap();
    assert_eq!(zeros.points, [[0.0; 3]; 3]);
    let without = plain.replace("\"scene\":0,", "").replace("\"scenes\":[{\"nodes\":[0]}],", "");
    assert_eq!(of("gltf", without).unwrap().points, TRIANGLE);
}

#[test]
fn gltf_errors_name_the_object() {
    let plain = gltf("", "", "", "", "");
    for (from, to, expected) in [
        ("\"POSITION\":0", "\"POSITION\":4", "node 0: it refers to accessors[4], but there are only 1"),
        ("\"mesh\":0", "\"mesh\":1", "node 0: it refers to meshes[1], but there are only 1"),
        ("\"nodes\":[0]", "\"nodes\":[0,0]", "node 0 is in the tree of nodes twice"),
        ("\"nodes\":[0]", "\"nodes\":[-1]", "the scene: `nodes` has -1, which is not a whole number"),
        ("5126", "5124", "node 0: accessor 0: `componentType` is 5124, which is not a type of numbers"),
        ("VEC3", "VEC2", "node 0: accessor 0 is of type VEC2, where VEC3 is needed"),
        (
            "\"byteLength\":36}],\"buffers\"",
            "\"byteLength\":99}],\"buffers\"",
            "node 0: buffer view 0 is outside its buffer",
        ),
        ("\"mesh\":0", "\"mesh\":0,\"scale\":[1,2]", "node 0: `scale` is [1,2], not a list of 3 numbers"),
        ("2.0", "1.0", "it uses glTF version 1.0; pse reads version 2"),
        (
            "\"attributes\"",
            "\"mode\":9,\"attributes\"",
            "node 0: `mode` is 9, which is not a kind of primitive",
        ),
    ] {
        assert!(plain.contains(from), "{from}");
        assert_eq!(
            of("gltf", plain.replacen(from, to, 1)).unwrap_err(),
            format!("cannot read `a`: {expected}")
        );
    }
    // Compressed data whose plain form is not there, though the file does not say that it requires the extension.
    let draco = gltf("", "", "", "\"extensions\":{\"KHR_draco_mesh_compression\":{\"bufferView\":0}},", "");
    assert_eq!(of("gltf", &draco).unwrap().points, TRIANGLE);
    let error =
        of("gltf", draco.replace("{\"bufferView\":0,\"componentType\"", "{\"componentType\"")).unwrap_err();
    assert!(error.contains("its mesh is compressed (KHR_draco_mesh_compression)"), "{error}");
}

#[test]
fn pieces_of_glb_may_lack_their_filling() {
    let text = gltf("", "", "", "", "");
    let start = text.find("\"uri\"").unwrap();
    let json = format!("{}\"name\":\"1\"}}]}}", &text[..start]);
    for filling in 0..4 {
        let json = format!("{json}{}", " ".repeat(filling));
        let data: Vec<u8> = TRIANGLE.iter().flatten().flat_map(|&c| (c as f32).to_le_bytes()).collect();
        let mut file = b"glTF\x02\0\0\0".to_vec();
        file.extend((28 + json.len() as u32 + data.len() as u32).to_le_bytes());
        for (kind, piece) in [(b"JSON", json.as_bytes()), (b"BIN\0", &data)] {
            file.extend((piece.len() as u32).to_le_bytes());
            file.extend(kind);
            file.extend(piece);
        }
        assert_eq!(of("glb", &file).unwrap().points, TRIANGLE, "{filling}");
    }
    let old = text.replace("{\"version\":\"2.0\"}", "{\"version\":1}");
    assert_eq!(of("gltf", old).unwrap_err(), "cannot read `a`: it uses glTF version 1; pse reads version 2");
}

#[test]
fn very_many_groups_and_corners() {
    // The same face again and again, each time in a group of its own.
    let mut text = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    (0..60_000).for_each(|i| text += &format!("g part{i}\nusemtl m{i}\nf 1 2 3\n"));
    let mesh = of("obj", &text).unwrap();
    assert_eq!((mesh.surfaces.len(), mesh.faces[59_999].surface), (60_000, 59_999));
    let seen = super::picture(mesh, &super::view(8, 8, [0.25, 0.25, 5.0], [0.25, 0.25, 0.0], 5.0));
    assert_eq!(super::at(&seen, "surface", 4, 4), [1.0]);
    // A comb of 100,000 corners, whose teeth stand beside long edges.
    let across: Vec<i32> = (0..50_000).collect();
    let tooth = |x: &i32, below: i32| format!("v {x} {} 0\n", 10 * (x % 2) - below);
    let mut text: String = across.iter().map(|x| tooth(x, 0)).collect();
    text += &across.iter().rev().map(|x| tooth(x, 1)).collect::<String>();
    text += &(1..=100_000).fold("f".to_string(), |face, i| face + &format!(" {i}"));
    let model = pse::scene::Model::new(of("obj", &text).unwrap());
    assert!(model.is_ok_and(|model| model.triangles() == 99_998));
    // One that crosses itself has no inside, and is not cut in quadratic time.
    let text: String =
        (0..5000_i64).map(|i| format!("v {} {} 0\n", i * i % 4999, i * i * i % 4997)).collect();
    let corners = (1..=5000).fold("f".to_string(), |face, i| face + &format!(" {i}"));
    let error = pse::scene::Model::new(of("obj", text + &corners).unwrap()).err().unwrap();
    assert_eq!(
        error.to_string(),
        "the outline of face 1, of 5000 corners, crosses itself; split the face; a face that crosses itself \
         can have at most 1000 corners"
    );
}

#[test]
fn numbers_with_commas_and_headers_without_a_coordinate() {
    let error = |ending: &str, text: &str| of(ending, text).unwrap_err();
    let wrong = error("obj", "v 0,5 1,25 2\n");
    assert!(
        wrong.ends_with(
            "line 1: `0,5` has a decimal comma instead of a point: 0.5. Save the file with decimal points"
        ),
        "{wrong}"
    );
    let text = ply("ascii", &VERTICES.replace("property float y\n", ""), "0 0\n1 0\n0 1\n");
    assert!(error("ply", &text).contains("its vertices have no `y`"), "{text}");
    let text = ply("ascii", VERTICES, "0 0 0\n1,5 0 0\n0 1 0\n");
    assert!(error("ply", &text).contains("`1,5` has a decimal comma"), "{text}");
}

#[test]
fn triangles_that_are_lines_show_nothing() {
    let model = |text: &str| pse::scene::Model::new(of("obj", text).unwrap());
    let line = "v 0 0 0\nv 0.1 0.3 0\nv 0.2 0.6 0\nv 0 1 0\nf 1 2 3\n";
    assert!(model(line).is_err_and(|e| e.to_string().contains("no faces with an area")));
    assert!(model(&format!("{line}f 1 2 4\n")).is_ok());
}
