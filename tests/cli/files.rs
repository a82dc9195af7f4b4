//! Images that come in and go out: names, pipes, and what must not be overwritten.

use super::{Folder, gbuffer, load};
use std::fs;

#[test]
fn pipes_carry_images() {
    let f = Folder::new();
    f.write("a.pse", "half = point / 2\ncolor = white\n");
    let first = f.good("run a.pse -o - --vars half,surface --size 20x10 -q");
    assert_eq!(&first.out[..4], &[0x76, 0x2f, 0x31, 0x01]);
    let second = f.pse_with(&["run", "-e", "half * 2", "-i", "-", "-o", "b.exr"], &first.out);
    assert_eq!(second.code, 0, "{}", second.err);
    f.good("scene donut --size 20x10 -o g.exr");
    assert_eq!(f.planes("b.exr", "color"), f.planes("g.exr", "point"));
    let info = f.pse_with(&["info", "-"], &first.out);
    assert!(info.text.contains("standard input: OpenEXR, 20 x 10"), "{}", info.text);
    f.bad(2, "run - -i -", &["cannot both be standard input"]);
    f.bad(2, "run -e white -i - -i a=-", &["cannot both be standard input"]);
}

#[test]
fn pictures_are_turned_as_they_say() {
    let f = Folder::new();
    let kinds = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/kinds");
    let info = f.good(&format!("info {kinds}/turned_6.jpg")).text;
    assert!(
        info.contains("JPEG, 24 x 20") && info.contains("Orientation 6 of the file is applied"),
        "{info}"
    );
    let info = f.good(&format!("info {kinds}/turned_6.jpg --raw")).text;
    assert!(info.contains("JPEG, 20 x 24") && info.contains("not applied, because of --raw"), "{info}");
    f.good(&format!("run -q -e color=color -i {kinds}/turned_6.png -o a.exr"));
    f.good(&format!("run -q -e color=color -i {kinds}/turned_6.tif -o b.exr"));
    assert_eq!(f.planes("a.exr", "color"), f.planes("b.exr", "color"));
    let bytes = fs::read(format!("{kinds}/turned_3.jpg")).unwrap();
    // Behind its header, which is most of so small a file.
    fs::write(f.path("cut.jpg"), &bytes[..bytes.len() - 40]).unwrap();
    for command in ["info cut.jpg", "run -q -e color=color -i cut.jpg -o c.exr"] {
        f.bad(1, command, &["`cut.jpg` is damaged or incomplete: it ends too early"]);
    }
}

#[cfg(unix)]
#[test]
fn a_closed_pipe_is_no_failure() {
    use std::process::{Command, Stdio};
    let f = Folder::new();
    for arguments in ["run -e white -o - --size 600x400", "doc --markdown", "completions bash"] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_pse"))
            .args(arguments.split(' '))
            .current_dir(f.path(""))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("pse starts");
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("pse ends");
        let err = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && !err.contains("cannot"), "{arguments}: {err}");
    }
}

#[test]
fn several_images_by_name() {
    let f = Folder::new();
    f.good("scene donut --size 16x12 -o g.exr");
    f.good("run -e [0.25,0.5,1] -i g.exr -o plate.exr");
    f.good("run -e bg.color*(surface>0) -i g.exr -i bg=plate.exr -o a.exr");
    let (color, surface) = (f.planes("a.exr", "color"), f.planes("g.exr", "surface"));
    let expected: Vec<f32> = surface[0].iter().map(|s| 0.25 * s).collect();
    assert_eq!(color[0], expected);
    // A scene may be the first image; two files without a name complete each other.
    f.good("run -e bg.color*point.x --scene donut --size 16x12 -i bg=plate.exr -o b.exr");
    f.good("run -e color*point.x -i plate.exr -i g.exr -o c.exr");
    assert_eq!(f.planes("b.exr", "color"), f.planes("c.exr", "color"));
    // The first has the metadata, and the sizes agree.
    f.good("run -e white -o small.exr --size 9x9");
    f.bad(
        1,
        "run -e bg.color*point.x -i g.exr -i bg=small.exr -o d.exr",
        &["different sizes", "g.exr is 16x12", "small.exr is 9x9"],
    );
    f.bad(1, "run -e bg.colr*point.x -i g.exr -i bg=plate.exr", &["bg.colr", "Did you mean `color`?"]);
    f.bad(2, "run -e white -i bg=g.exr -i bg=plate.exr", &["two inputs are called bg"]);
    f.bad(1, "run -e white*point -i bg=g.exr", &["no variable `point`", "All inputs have names"]);
}

#[test]
fn channels_are_mapped() {
    let f = Folder::new();
    let path = gbuffer("donut_320x180_plain_datawindow_crop.exr");
    f.good(&format!("run -e where -i {path} --map where=point -o a.exr"));
    f.good(&format!("run -e point -i {path} -o b.exr"));
    assert_eq!(f.planes("a.exr", "color"), f.planes("b.exr", "color"));
    f.good(&format!("run -e g.where -i g={path} --map g.where=point -o c.exr"));
    assert_eq!(f.planes("a.exr", "color"), f.planes("c.exr", "color"));
    f.bad(1, &format!("run -e where -i {path} --map where=pont -o a.exr"), &["pont", "Did you mean"]);
    f.bad(2, &format!("run -e where -i {path} --map where -o a.exr"), &["invalid --map"]);
    f.bad(1, &format!("run -e white -i {path} --map h.where=point"), &["no view `h`", "-i h=FILE"]);
    f.bad(2, &format!("run -e white -i g={path} --map h.where=point"), &["no input h"]);
    f.bad(1, &format!("run -e white*albedo -i {path}"), &["no variable `albedo`", "`point`"]);
    assert!(f.good(&format!("info {path} --map where=point")).text.contains("where.x"));
}

#[test]
fn inputs_are_not_overwritten() {
    let f = Folder::new();
    f.good("scene card --size 8x8 -o g.exr");
    let before = f.read("g.exr");
    f.bad(1, "run -e white -i g.exr -o g.exr", &["the output `g.exr` is the input", "--force"]);
    f.bad(1, "run -e white -i g.exr -o ./g.exr", &["is the input"]);
    assert_eq!(f.read("g.exr"), before);
    f.good("run -e white -i g.exr -o g.exr --force");
    assert_ne!(f.read("g.exr"), before);
    // Other files that are there are replaced, and nothing else is left behind.
    f.good("run -e white -o a.png --size 8x8");
    f.good("run -e black -o a.png --size 8x8");
    assert_eq!(fs::read_dir(f.path("")).expect("a folder").count(), 2);
}

#[test]
fn outputs_that_cannot_be_written() {
    let f = Folder::new();
    fs::create_dir(f.path("dir.exr")).expect("a folder");
    f.bad(1, "run -e white -o a.foo", &["unknown format `.foo`", ".exr .png"]);
    f.bad(1, "run -e white -o a", &["no extension"]);
    f.bad(1, "run -e white -o dir.exr", &["it is a directory"]);
    f.bad(1, "run -e white -o no/a.exr", &["there is no directory `no`", "mkdir"]);
    f.bad(1, "run -e white -o a.jpg --bits 16 --size 4x4", &["16"]);
    f.bad(2, "run -e white --bits 12", &["8, 16 or 32"]);
}

#[test]
fn inputs_that_cannot_be_read() {
    let f = Folder::new();
    f.write("text.exr", "no image");
    f.bad(1, "run -e white -i none.exr", &["cannot read `none.exr`: there is no such file"]);
    f.bad(1, "run -e white -i .", &["it is a directory"]);
    f.bad(1, "run -e white -i text.exr", &["`text.exr` is not an image"]);
    f.bad(1, "info none.exr", &["there is no such file"]);
    f.bad(1, "info .", &["it is a directory"]);
}

#[test]
fn precision_and_raw_numbers() {
    let f = Folder::new();
    f.good("run -e white/3 -o h.exr --half --size 8x8");
    let third = f.planes("h.exr", "color")[0][0];
    assert!(third != 1.0 / 3.0 && (third - 1.0 / 3.0).abs() < 1e-3);
    f.good("run -e white/2 -o raw.png --raw --bits 16 --size 8x8");
    f.good("run -e color -i raw.png -o back.exr --raw");
    assert!((f.planes("back.exr", "color")[0][0] - 0.5).abs() < 1e-4);
    f.good("run -e color -i raw.png -o decoded.exr");
    assert!(f.planes("decoded.exr", "color")[0][0] < 0.3);
}

#[test]
fn scenes_are_written() {
    let f = Folder::new();
    let ended = f.good("scene vase --size 12x16 --eye 0,-30,10 --look-at 0,0,5 --fov 30 --scale 2");
    assert!(ended.err.contains("wrote vase.exr (12x16)"), "{}", ended.err);
    let image = load(&f.path("vase.exr"));
    assert!(image.variable("dPdv").is_some());
    let piped = f.good("scene vase -o - --size 12x16 -q --eye 0,-30,10 --look-at 0,0,5 --fov 30 --scale 2");
    assert_eq!(piped.out, f.read("vase.exr"));
    let list = f.good("scene --list").text;
    assert!(list.lines().any(|l| l.starts_with("donut ")), "{list}");
    assert_eq!(f.good("scene").text, list);
    f.bad(1, "scene vse", &["did you mean `vase`?"]);
    f.bad(2, "scene vase --list", &["cannot be used with"]);
    f.bad(1, "scene vase -o a.png --size 4x4", &["no `color`", ".exr"]);
}

#[test]
fn info_of_a_mesh() {
    let f = Folder::new();
    f.write("a.obj", "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 3\nusemtl wood\nf 1 2 3 4\nusemtl glass\nf 1 2 3\n");
    assert_eq!(
        f.good("info a.obj").text,
        "a.obj: a mesh\n  points     4\n  faces      2 of up to 4 corners\n  normals    none\n  uv         none\n  \
         from       [0 0 0]\n  to         [1 2 3]\n  surface    1 is wood, 1 faces\n  surface    2 is glass, 1 faces\n"
    );
    f.bad(1, "info b.obj", &["b.obj", "no such file"]);
}
