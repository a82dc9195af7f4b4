//! Textures: where they are found, sequences of them, and how much memory they may take.

use super::{Folder, load};

/// A picture of one colour.
fn plain(f: &Folder, name: &str, color: &str) {
    f.good(&format!("run -q -e {color} -o {name} --scene card --size 4x4"));
}

const ONE: &str = "--scene card --size 1x1 -o out.exr -q";

fn red(f: &Folder) -> f32 {
    load(&f.path("out.exr")).variable("color").unwrap().planes[0][0]
}

#[test]
fn beside_the_program_then_in_the_folders_of_path() {
    let f = Folder::new();
    for folder in ["a", "b", "b/maps"] {
        std::fs::create_dir(f.path(folder)).unwrap();
    }
    plain(&f, "a/one.exr", "[1,0,0]");
    plain(&f, "b/one.exr", "[2,0,0]");
    plain(&f, "b/two.exr", "[3,0,0]");
    plain(&f, "b/maps/three.exr", "[4,0,0]");
    plain(&f, "outside.exr", "[5,0,0]");
    let write = |name: &str| f.write("a/p.pse", format!("color = texture(\"{name}\", 0.5, 0.5)\n"));
    for (name, expected) in [
        ("one.exr", 1.0),
        ("two.exr", 3.0),
        ("maps/three.exr", 4.0),
        ("maps/../two.exr", 3.0),
        ("../b/two.exr", 3.0),
    ] {
        write(name);
        f.good(&format!("run a/p.pse --path b {ONE}"));
        assert_eq!(red(&f), expected, "{name}");
    }
    let absolute = std::fs::canonicalize(f.path("b/two.exr")).unwrap();
    write(&absolute.display().to_string());
    f.good(&format!("run a/p.pse --path {} {ONE}", absolute.parent().unwrap().display()));
    assert_eq!(red(&f), 3.0);
    f.bad(1, &format!("run a/p.pse {ONE}"), &["outside the folders that this program may read"]);
    for name in ["../outside.exr", "maps/../../outside.exr"] {
        write(name);
        f.bad(1, &format!("run a/p.pse --path b {ONE}"), &["outside the folders"]);
    }
    write("tow.exr");
    f.bad(
        1,
        &format!("run a/p.pse --path b {ONE}"),
        &["there is no a/tow.exr and no b/tow.exr", "Did you mean \"two.exr\"?"],
    );
    f.bad(1, "check a/p.pse", &["cannot find the image \"tow.exr\""]);
    // What a file of the library of one's own names lies beside that file.
    f.write("b/lib.pse", "function two(p)\n    return texture(\"two.exr\", p)\n");
    f.write("a/p.pse", "import \"lib.pse\"\ncolor = two([0.5 0.5])\n");
    f.good(&format!("run a/p.pse --path b {ONE}"));
    assert_eq!(red(&f), 3.0);
}

#[test]
fn a_frame_has_its_own_texture() {
    let f = Folder::new();
    plain(&f, "sky.0001.exr", "[1,0,0]");
    plain(&f, "sky.0002.exr", "[2,0,0]");
    plain(&f, "still.exr", "[0,7,0]");
    f.write("p.pse", "color = texture(\"sky.####.exr\", 0.5, 0.5) + texture(\"still.exr\", 0.5, 0.5)\n");
    f.good("check p.pse");
    f.good("run p.pse --frames 1-2 --scene card --size 1x1 -o out.#.exr -q");
    for frame in [1, 2] {
        let color = f.planes(&format!("out.{frame}.exr"), "color");
        assert_eq!([color[0][0], color[1][0]], [frame as f32, 7.0]);
    }
    f.bad(
        1,
        "run p.pse --frame 3 --scene card --size 1x1 -o out.exr",
        &["sky.0003.exr", "there is no such file"],
    );
    f.bad(2, "run p.pse --frame 1.5 --scene card --size 1x1 -o out.exr", &["the frame is 1.5"]);
}

#[test]
fn an_output_does_not_replace_a_texture() {
    let f = Folder::new();
    plain(&f, "p.png", "[1,0,0]");
    f.write("p.pse", "color = texture(\"p.png\", 0.5, 0.5)\n");
    f.bad(1, "run p.pse", &["the output `p.png` is the input `p.png`", "--force"]);
}

#[test]
fn memory_is_bounded() {
    let f = Folder::new();
    f.good("run -q -e white*Noise(0.1*pixel) -o large.exr --scene card --size 1000x800");
    let look = "texture(\"large.exr\", uv, filter = \"sat\") + texture(\"large.exr\", 2 * uv)";
    f.write("p.pse", format!("color = {look}\n"));
    let run = |out: &str, more: &str| {
        f.good(&format!("run p.pse --scene card --size 300x200 -o {out} --stats {more}"))
    };
    run("whole.exr", "");
    // In tiles of a temporary file, and what is looked at in memory.
    run("tiles.exr", "--texture-memory 1");
    run("none.exr", "--texture-memory 0 --threads 2");
    for tiled in ["tiles.exr", "none.exr"] {
        assert_eq!(f.read("whole.exr"), f.read(tiled), "{tiled}");
    }
}

#[test]
fn what_finds_no_room_for_its_tiles_is_told() {
    let f = Folder::new();
    f.good("run -q -e white -o large.exr --scene card --size 64x64");
    f.write("p.pse", "color = texture(\"large.exr\", uv)\n");
    let arguments = "run p.pse --scene card --size 8x8 -o o.exr --texture-memory 0".split_whitespace();
    let ended = crate::ended(f.command().args(arguments).env("TMPDIR", "/no/such/folder"));
    let told = ended.err;
    assert!(ended.code == 1 && told.contains("TMPDIR"), "{told}");
    assert!(
        told.contains("temporary file for textures") && told.contains("texture(\"large.exr\", uv)"),
        "{told}"
    );
}

#[test]
fn pictures_are_decoded_unless_they_are_data() {
    let f = Folder::new();
    f.good("run -q --raw -e [0.5,0.5,1] -o n.png --scene card --size 4x4");
    f.write("p.pse", "color = texture(\"n.png\", 0.5, 0.5)\n");
    f.good(&format!("run p.pse {ONE}"));
    assert!((red(&f) - 0.2158).abs() < 1e-3, "{}", red(&f));
    f.write("p.pse", "color = texture(\"n.png\", 0.5, 0.5, encoding = \"raw\")\n");
    f.good(&format!("run p.pse {ONE}"));
    assert!((red(&f) - 128.0 / 255.0).abs() < 1e-6, "{}", red(&f));
}

#[test]
fn a_grey_picture_is_a_scalar_and_windows_are_kept() {
    let f = Folder::new();
    f.good("run -q -e v=pixel.x -o grey.exr --scene card --size 4x4");
    f.write("p.pse", "color = white * (texture(\"grey.exr\", 0.875, 0.5) + 0)\n");
    f.good(&format!("run p.pse {ONE}"));
    assert_eq!(red(&f), 3.5);
    // Of a crop the rest of the picture is black.
    f.good("run -q -e white*pixel.x -o crop.exr --scene card --size 4x4 --region 2,0,4,4");
    f.write(
        "p.pse",
        "color = [texture(\"crop.exr\", 0.125, 0.5)[1] texture(\"crop.exr\", 0.875, 0.5)[1] 0]\n",
    );
    f.good(&format!("run p.pse {ONE}"));
    let color = f.planes("out.exr", "color");
    assert_eq!([color[0][0], color[1][0]], [0.0, 3.5]);
}
