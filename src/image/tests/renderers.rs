//! Every renderer's spelling becomes the same variables.

use super::*;

/// Channels, and what each variable must be read from.
fn check(channels: &[&str], expected: &[(&str, &[&str])]) {
    let file = file_of(channels);
    for (name, from) in expected {
        assert_eq!(channels_of(&file, name), *from, "{name} in {channels:?}");
    }
}

fn none(channels: &[&str], name: &str) {
    let error = file_of(channels).find(name).unwrap_err();
    assert_eq!(error.kind, ErrorKind::Missing, "{name} in {channels:?}: {error}");
}

#[test]
fn blender() {
    for (layer, id) in [("ViewLayer", "IndexOB"), ("View Layer 2", "Object Index"), ("a.b", "Object Index")] {
        let full = |c: &str| format!("{layer}.{c}");
        let names: Vec<String> = [
            "Combined.R",
            "Combined.G",
            "Combined.B",
            "Combined.A",
            "Position.X",
            "Position.Y",
            "Position.Z",
            "Normal.X",
            "Normal.Y",
            "Normal.Z",
            "Depth.Z",
            "Mist.Z",
            "UV.U",
            "UV.V",
            "UV.A",
            "Vector.X",
            "Vector.Y",
            "Vector.Z",
            "Vector.W",
            "DiffCol.R",
            "DiffCol.G",
            "DiffCol.B",
        ]
        .iter()
        .map(|c| full(c))
        .chain([full(&format!("{id}.X"))])
        .collect();
        let list: Vec<&str> = names.iter().map(String::as_str).collect();
        let file = file_of(&list);
        let of = |name: &str| channels_of(&file, name).join(" ");
        let want = |c: &str| c.split(' ').map(full).collect::<Vec<_>>().join(" ");
        assert_eq!(of("color"), want("Combined.R Combined.G Combined.B"));
        assert_eq!(of("alpha"), want("Combined.A"));
        assert_eq!(of("point"), want("Position.X Position.Y Position.Z"));
        assert_eq!(of("normal"), want("Normal.X Normal.Y Normal.Z"));
        assert_eq!(of("depth"), want("Depth.Z"));
        assert_eq!(of("Mist"), want("Mist.Z"));
        assert_eq!(of("uv"), want("UV.U UV.V"));
        assert_eq!(of("uv_coverage"), want("UV.A"));
        assert_eq!(of("motion"), want("Vector.X Vector.Y Vector.Z Vector.W"));
        assert_eq!(of("albedo"), want("DiffCol.R DiffCol.G DiffCol.B"));
        assert_eq!(of("surface"), format!("{layer}.{id}.X"));
        assert_eq!(file.find("surface").unwrap().shape, Shape::Scalar);
        assert_eq!(file.find("uv").unwrap().shape, Shape::Vector(2));
        // Each group also goes by its own name.
        assert_eq!(of("Position"), of("point"));
    }
    check(
        &["L.Diffuse Color.R", "L.Diffuse Color.G", "L.Diffuse Color.B"],
        &[("albedo", &["L.Diffuse Color.R", "L.Diffuse Color.G", "L.Diffuse Color.B"])],
    );
}

#[test]
fn arnold() {
    check(
        &[
            "R", "G", "B", "A", "P.X", "P.Y", "P.Z", "N.X", "N.Y", "N.Z", "Z", "ID", "albedo.R", "albedo.G",
            "albedo.B",
        ],
        &[
            ("color", &["R", "G", "B"]),
            ("alpha", &["A"]),
            ("point", &["P.X", "P.Y", "P.Z"]),
            ("normal", &["N.X", "N.Y", "N.Z"]),
            ("depth", &["Z"]),
            ("surface", &["ID"]),
            ("albedo", &["albedo.R", "albedo.G", "albedo.B"]),
        ],
    );
    check(
        &["RGBA.R", "RGBA.G", "RGBA.B", "RGBA.A", "diffuse_albedo.R", "diffuse_albedo.G", "diffuse_albedo.B"],
        &[
            ("color", &["RGBA.R", "RGBA.G", "RGBA.B"]),
            ("alpha", &["RGBA.A"]),
            ("albedo", &["diffuse_albedo.R", "diffuse_albedo.G", "diffuse_albedo.B"]),
        ],
    );
}

#[test]
fn renderman() {
    check(
        &[
            "Ci.r",
            "Ci.g",
            "Ci.b",
            "__Pworld.r",
            "__Pworld.g",
            "__Pworld.b",
            "P.r",
            "P.g",
            "P.b",
            "__Nworld.r",
            "__Nworld.g",
            "__Nworld.b",
            "Nn.r",
            "Nn.g",
            "Nn.b",
            "id",
            "rawId",
            "z",
            "__st.x",
            "__st.y",
        ],
        &[
            ("color", &["Ci.r", "Ci.g", "Ci.b"]),
            ("point", &["__Pworld.r", "__Pworld.g", "__Pworld.b"]),
            ("P", &["P.r", "P.g", "P.b"]),
            ("normal", &["__Nworld.r", "__Nworld.g", "__Nworld.b"]),
            ("surface", &["id"]),
            ("depth", &["z"]),
            ("uv", &["__st.x", "__st.y"]),
        ],
    );
    check(&["__depth.r", "rawId"], &[("depth", &["__depth.r"]), ("surface", &["rawId"])]);
    check(&["Pworld.x", "Pworld.y", "Pworld.z"], &[("point", &["Pworld.x", "Pworld.y", "Pworld.z"])]);
}

#[test]
fn redshift() {
    check(
        &[
            "R",
            "G",
            "B",
            "A",
            "P.R",
            "P.G",
            "P.B",
            "normals.R",
            "normals.G",
            "normals.B",
            "ID",
            "Z",
            "DiffuseFilter.R",
            "DiffuseFilter.G",
            "DiffuseFilter.B",
        ],
        &[
            ("point", &["P.R", "P.G", "P.B"]),
            ("normal", &["normals.R", "normals.G", "normals.B"]),
            ("surface", &["ID"]),
            ("depth", &["Z"]),
            ("albedo", &["DiffuseFilter.R", "DiffuseFilter.G", "DiffuseFilter.B"]),
        ],
    );
}

#[test]
fn v_ray() {
    check(
        &[
            "VRaySamplerInfo.X",
            "VRaySamplerInfo.Y",
            "VRaySamplerInfo.Z",
            "VRayNormals.X",
            "VRayNormals.Y",
            "VRayNormals.Z",
            "VRayObjectID",
            "VRayRenderID",
            "VRayZDepth",
            "VRayDiffuseFilter.R",
            "VRayDiffuseFilter.G",
            "VRayDiffuseFilter.B",
        ],
        &[
            ("point", &["VRaySamplerInfo.X", "VRaySamplerInfo.Y", "VRaySamplerInfo.Z"]),
            ("normal", &["VRayNormals.X", "VRayNormals.Y", "VRayNormals.Z"]),
            ("surface", &["VRayObjectID"]),
            ("depth", &["VRayZDepth"]),
            ("albedo", &["VRayDiffuseFilter.R", "VRayDiffuseFilter.G", "VRayDiffuseFilter.B"]),
        ],
    );
    check(
        &[
            "VRaySamplerInfo.U",
            "VRaySamplerInfo.V",
            "VRaySamplerInfo.W",
            "bump_normals.R",
            "bump_normals.G",
            "bump_normals.B",
            "VRayRenderID",
            "VRayZDepth.R",
            "diffuse.R",
            "diffuse.G",
            "diffuse.B",
        ],
        &[
            ("uv", &["VRaySamplerInfo.U", "VRaySamplerInfo.V"]),
            ("normal", &["bump_normals.R", "bump_normals.G", "bump_normals.B"]),
            ("surface", &["VRayRenderID"]),
            ("depth", &["VRayZDepth.R"]),
            ("albedo", &["diffuse.R", "diffuse.G", "diffuse.B"]),
        ],
    );
}

#[test]
fn karma_and_mantra() {
    check(
        &[
            "C.r",
            "C.g",
            "C.b",
            "C.a",
            "ray:hitP.x",
            "ray:hitP.y",
            "ray:hitP.z",
            "ray:hitN.x",
            "ray:hitN.y",
            "ray:hitN.z",
            "ray:hitPz",
            "ray:objectid",
            "ray:hituv.x",
            "ray:hituv.y",
        ],
        &[
            ("color", &["C.r", "C.g", "C.b"]),
            ("alpha", &["C.a"]),
            ("point", &["ray:hitP.x", "ray:hitP.y", "ray:hitP.z"]),
            ("ray_hitP", &["ray:hitP.x", "ray:hitP.y", "ray:hitP.z"]),
            ("normal", &["ray:hitN.x", "ray:hitN.y", "ray:hitN.z"]),
            ("depth", &["ray:hitPz"]),
            ("surface", &["ray:objectid"]),
            ("uv", &["ray:hituv.x", "ray:hituv.y"]),
        ],
    );
    check(
        &["Op_Id", "Pz", "P.x", "P.y", "P.z", "N.x", "N.y", "N.z"],
        &[("surface", &["Op_Id"]), ("depth", &["Pz"]), ("point", &["P.x", "P.y", "P.z"])],
    );
}

#[test]
fn unreal() {
    check(
        &[
            "FinalImage.R",
            "FinalImage.G",
            "FinalImage.B",
            "FinalImage.A",
            "WorldNormal.R",
            "WorldNormal.G",
            "WorldNormal.B",
            "WorldDepth.R",
            "ActorHitProxyMask00.R",
            "ActorHitProxyMask00.G",
        ],
        &[
            ("color", &["FinalImage.R", "FinalImage.G", "FinalImage.B"]),
            ("alpha", &["FinalImage.A"]),
            ("normal", &["WorldNormal.R", "WorldNormal.G", "WorldNormal.B"]),
            ("depth", &["WorldDepth.R"]),
            ("surface", &["ActorHitProxyMask00.R"]),
        ],
    );
    check(
        &["FinalImageMovieRenderQueue_WorldDepth.R"],
        &[("depth", &["FinalImageMovieRenderQueue_WorldDepth.R"])],
    );
}

#[test]
fn any_suffix_and_any_case() {
    let suffixes = ["x y z", "X Y Z", "r g b", "R G B", "red green blue", "Red Green Blue", "RED GREEN BLUE"];
    for suffix in suffixes {
        for group in ["point", "POINT", "x.y.Position", "beauty pass.p"] {
            let names: Vec<String> = suffix.split(' ').map(|s| format!("{group}.{s}")).collect();
            let list: Vec<&str> = names.iter().map(String::as_str).collect();
            assert_eq!(channels_of(&file_of(&list), "point"), names);
        }
    }
}

#[test]
fn a_bare_z_is_depth_and_a_layers_z_is_not() {
    check(&["Z"], &[("depth", &["Z"])]);
    check(&["L.Depth.Z"], &[("depth", &["L.Depth.Z"])]);
    // Mist goes from 0 to 1, and is no distance.
    check(&["L.Mist.Z"], &[("Mist", &["L.Mist.Z"])]);
    none(&["L.Mist.Z"], "depth");
    check(&["L.Depth.Z", "L.Mist.Z"], &[("depth", &["L.Depth.Z"])]);
    check(&["m.R", "m.G", "m.B", "m.Z"], &[("depth", &["m.Z"])]);
    none(&["ViewLayer.Foo.Z"], "depth");
    check(&["ViewLayer.Foo.Z"], &[("Foo", &["ViewLayer.Foo.Z"])]);
}

#[test]
fn what_is_not_known_keeps_its_own_name() {
    check(
        &["L.Cool Pass.R", "L.Cool Pass.G", "L.Cool Pass.B", "L.2nd", "v.10", "v.1", "v.2"],
        &[
            ("Cool_Pass", &["L.Cool Pass.R", "L.Cool Pass.G", "L.Cool Pass.B"]),
            ("_2nd", &["L.2nd"]),
            ("v_10", &["v.10"]),
        ],
    );
    let names: Vec<String> = (1..=12).map(|i| format!("v.{i}")).collect();
    let list: Vec<&str> = names.iter().map(String::as_str).collect();
    let file = file_of(&list);
    assert_eq!(channels_of(&file, "v"), names, "numbers count up, they are not sorted as text");
    let file = file_of(&["m.1.1", "m.1.2", "m.2.1", "m.2.2"]);
    assert_eq!(file.find("m").unwrap().shape.to_string(), "a vector of 2 vectors of 2");
}

#[test]
fn two_view_layers_are_ambiguous_only_if_read() {
    let file = file_of(&[
        "A.Position.X",
        "A.Position.Y",
        "A.Position.Z",
        "B.Position.X",
        "B.Position.Y",
        "B.Position.Z",
        "A.Depth.Z",
    ]);
    assert_eq!(channels_of(&file, "depth"), ["A.Depth.Z"]);
    let error = file.find("point").unwrap_err();
    assert_eq!(error.kind, ErrorKind::Ambiguous);
    assert_eq!(error.hints, ["This one: --map point=A.Position", "This one: --map point=B.Position"]);
    assert!(file.load(&["depth"]).is_ok());
    // The one without a prefix wins, and any over Blender's composite.
    let file = file_of(&["R", "G", "B", "L.Combined.R", "L.Combined.G", "L.Combined.B"]);
    assert_eq!(channels_of(&file, "color"), ["R", "G", "B"]);
    let file = file_of(&[
        "Composite.Combined.R",
        "Composite.Combined.G",
        "Composite.Combined.B",
        "L.Combined.R",
        "L.Combined.G",
        "L.Combined.B",
    ]);
    assert_eq!(channels_of(&file, "color"), ["L.Combined.R", "L.Combined.G", "L.Combined.B"]);
}

fn mapped(channels: &[&str], map: &str) -> Result<File, ImageError> {
    let bytes = exr_bytes(vec![part(None, (2, 2), channels)], (2, 2));
    let options = ReadOptions { maps: vec![map.parse()?], raw: false };
    read(Input::from_bytes("test.exr", bytes), &options)
}

#[test]
fn a_map_overrides() {
    let channels = [
        "A.Position.X",
        "A.Position.Y",
        "A.Position.Z",
        "B.Position.X",
        "B.Position.Y",
        "B.Position.Z",
        "B.IndexMA.X",
    ];
    let file = mapped(&channels, "point=B.Position").unwrap();
    assert_eq!(channels_of(&file, "point"), ["B.Position.X", "B.Position.Y", "B.Position.Z"]);
    let file = mapped(&channels, "surface = indexma").unwrap();
    assert_eq!(channels_of(&file, "surface"), ["B.IndexMA.X"]);
    let file = mapped(&channels, "surface=B.IndexMA.X").unwrap();
    assert_eq!(channels_of(&file, "surface"), ["B.IndexMA.X"]);
    let file = mapped(&channels, "w=A.Position.Z,B.IndexMA.X").unwrap();
    assert_eq!(channels_of(&file, "w"), ["A.Position.Z", "B.IndexMA.X"]);
    let error = mapped(&channels, "point=B.Positon").err().unwrap();
    assert!(error.hints[0].contains("--map point=B.Position?"), "{:?}", error.hints);
    let error = mapped(&channels, "point=Position").err().unwrap();
    assert_eq!(error.kind, ErrorKind::Mapping);
    assert_eq!(error.hints.len(), 2);
    for wrong in ["point", "=x", "point=", "a b=x"] {
        assert_eq!(wrong.parse::<Mapping>().unwrap_err().kind, ErrorKind::Mapping, "{wrong}");
    }
}

#[test]
fn nothing_is_invented_and_the_hint_helps() {
    let file = file_of(&["R", "G", "B", "A", "Z", "N.X", "N.Y", "N.Z", "L.IndexMA.X"]);
    let error = file.find("surface").unwrap_err();
    assert_eq!(error.message, "`test.exr` has no variable `surface`");
    assert_eq!(
        error.hints,
        [
            "If `IndexMA` is it: --map surface=L.IndexMA",
            "It has `color`, `alpha`, `IndexMA`, `normal`, `depth`."
        ]
    );
    let error = file.find("normals").unwrap_err();
    assert_eq!(error.hints[0], "Did you mean `normal`?");
}

#[test]
fn one_number_is_one_number_in_every_family() {
    check(&["depth.R", "depth.G", "depth.B"], &[("depth", &["depth.R"])]);
    check(&["ZDepth.R", "ZDepth.G", "ZDepth.B"], &[("depth", &["ZDepth.R"])]);
    check(&["surface.R", "surface.G", "surface.B"], &[("surface", &["surface.R"])]);
    check(&["alpha.R", "alpha.G", "alpha.B"], &[("alpha", &["alpha.R"])]);
    // A program's own vector of that name comes back.
    check(&["depth.x", "depth.y"], &[("depth", &["depth.x", "depth.y"])]);
}

#[test]
fn a_lone_a_is_alpha_in_both_cases() {
    check(&["N.X", "N.Y", "N.Z", "a"], &[("alpha", &["a"]), ("a", &["a"])]);
    check(&["A", "a"], &[("alpha", &["A"]), ("a", &["a"])]);
    check(&["R", "G", "B", "a"], &[("alpha", &["a"])]);
    none(&["diffuse.a"], "alpha");
    none(&["a", "b"], "alpha");
}
