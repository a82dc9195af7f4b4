//! What outputs may replace: nothing that is read, no file of another program under a name by default, nothing in a bundle
//! that `pse` did not put there.

use super::Folder;
use std::fs;

impl Folder {
    /// Runs it, and expects that it refuses with these words and that the file stays as it is.
    fn keeps(&self, file: &str, arguments: &str, words: &[&str]) {
        let before = self.read(file);
        self.bad(1, arguments, words);
        assert!(self.read(file) == before, "pse {arguments}: {file} has changed");
        let left = fs::read_dir(self.path("")).expect("a folder").map(|e| e.expect("a file").file_name());
        let temporary: Vec<_> = left.filter(|name| name.to_string_lossy().starts_with(".pse-")).collect();
        assert!(temporary.is_empty(), "pse {arguments}: {temporary:?}");
    }
}

const SOLID: &str = "import \"lib.pse\"\nfunction density(p)\n    return radius() - length(p) + 0.1 * texture(\"t.png\", 0.5, 0.5).x\n";

/// A mesh whose data lie in a file of their own, and that file.
fn gltf(f: &Folder, buffer: &str) {
    let points: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let bytes: Vec<u8> = points.iter().flat_map(|x| x.to_le_bytes()).collect();
    fs::write(f.path(buffer), bytes).expect("a file");
    f.write(
        "m.gltf",
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}}],
            "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"uri":"{buffer}","byteLength":36}}]}}"#
        ),
    );
}

#[test]
fn what_nobody_listed_is_not_replaced() {
    let f = Folder::new();
    f.write("lib.pse", "function radius()\n    return 1\n");
    f.write("s.pse", SOLID);
    f.good("run -e white/2 --size 4x4 -o t.png");
    let iso = "--iso s.pse --size 16x12 --resolution 8";
    f.keeps(
        "t.png",
        "scene --iso s.pse --size 16x12 -o t.png",
        &["the output `t.png` is the input", "--force"],
    );
    fs::copy(f.path("t.png"), f.path("t.exr")).expect("a copy");
    f.write("s.pse", SOLID.replace("t.png", "t.exr"));
    // The texture, the program and its import of a solid; as a G-buffer, as a mesh, and as what another program runs on.
    f.keeps(
        "t.exr",
        "scene --iso s.pse --size 16x12 -o t.exr",
        &["the output `t.exr` is the input", "--force"],
    );
    f.keeps("t.exr", "run -e white --iso s.pse --size 16x12 -o t.exr", &["is the input", "--force"]);
    for name in ["s.pse", "lib.pse"] {
        let link = format!("{name}.exr");
        fs::hard_link(f.path(name), f.path(&link)).expect("a link");
        for command in ["scene --iso s.pse", "run -e white --iso s.pse"] {
            f.keeps(name, &format!("{command} --size 16x12 -o {link}"), &["is the program"]);
            f.keeps(name, &format!("{command} --size 16x12 --force -o {link}"), &["is the program"]);
        }
        let link = format!("{name}.obj");
        fs::hard_link(f.path(name), f.path(&link)).expect("a link");
        f.keeps(name, &format!("scene {iso} -o {link}"), &["is the program"]);
    }
    // An import of what is run.
    f.write("p.pse", "import \"lib.pse\"\ncolor = white * radius()\n");
    f.keeps("lib.pse", "run p.pse --size 8x8 -o lib.pse.exr", &["is the program `lib.pse`"]);
    f.keeps("p.pse", "fmt lib.pse.exr none.pse", &["none.pse"]);
    // The data of a mesh.
    gltf(&f, "data.obj");
    f.keeps("data.obj", "deform m.gltf -e point+=1 -o data.obj", &["is the input `data.obj`", "--force"]);
    fs::hard_link(f.path("data.obj"), f.path("data.exr")).expect("a link");
    f.keeps("data.obj", "scene --mesh m.gltf --size 8x8 -o data.exr", &["is the input", "--force"]);
    f.keeps("data.obj", "run -e white --mesh m.gltf --size 8x8 -o data.exr", &["is the input", "--force"]);
    f.good("deform m.gltf -e point+=1 -o data.obj --force");
    // Lines: textures and programs.
    f.write(
        "f.pse",
        "import \"lib.pse\"\nfunction velocity(p)\n    return p * texture(\"t.exr\", 0.5, 0.5)\n",
    );
    f.keeps("t.exr", "flow f.pse --ball 9 -o t.exr", &["is the input", "--force"]);
    f.keeps("lib.pse", "flow f.pse --ball 9 -o lib.pse.exr", &["is the program"]);
    // Tiles.
    for n in 1..=2 {
        f.good(&format!("run -e white --size 8x8 --tile {n}/2x1 -o tile.{{tile}}.exr"));
    }
    f.keeps("tile.2.exr", "join tile.{tile}.exr --tiles 2x1 -o tile.2.exr", &["is the input", "--force"]);
    f.good("join tile.{tile}.exr --tiles 2x1 -o whole.exr");
}

#[cfg(unix)]
#[test]
fn under_whatever_name() {
    use std::os::unix::fs::symlink;
    let f = Folder::new();
    f.good("scene card --size 8x8 -o g.exr");
    fs::create_dir(f.path("d")).expect("a folder");
    symlink("g.exr", f.path("soft.exr")).expect("a link");
    symlink("d", f.path("e")).expect("a link");
    fs::hard_link(f.path("g.exr"), f.path("hard.exr")).expect("a link");
    fs::hard_link(f.path("g.exr"), f.path("d/far.exr")).expect("a link");
    let whole = f.path("g.exr").display().to_string();
    for output in ["soft.exr", "hard.exr", "./g.exr", "d/../g.exr", "e/far.exr", "e/../g.exr", &whole] {
        f.keeps("g.exr", &format!("run -e white -i g.exr -o {output}"), &["is the input"]);
    }
    // Through a descriptor, and from standard input.
    let shell = |line: &str| {
        let mut command = assert_cmd::Command::new("sh");
        command.current_dir(f.path("")).args(["-c", line]).env("PSE", env!("CARGO_BIN_EXE_pse"));
        super::ended(&mut command)
    };
    let before = f.read("g.exr");
    for line in [
        "\"$PSE\" run -e white -i - -o g.exr < g.exr",
        "\"$PSE\" run -e white -i /proc/self/fd/3 -o g.exr 3< g.exr",
    ] {
        let ended = shell(line);
        assert!(ended.code == 1 && ended.err.contains("the output `g.exr` is the input"), "{}", ended.err);
        assert!(f.read("g.exr") == before);
    }
    // A frame's output that a later frame reads.
    for n in [1, 12] {
        fs::copy(f.path("g.exr"), f.path(&format!("s.{n}.exr"))).expect("a copy");
    }
    f.keeps("s.12.exr", "run -e white -i s.#.exr --frames 1,12 -o s.%d2.exr", &["`s.12.exr` is the input"]);
    // One file under two names.
    f.bad(
        2,
        "run -e white --size 4x4 -o z.png -o ./z.png",
        &["the outputs `z.png` and `./z.png` are the same file"],
    );
    f.bad(2, "run -e white --size 4x4 -o d/z.png -o e/z.png", &["are the same file"]);
    f.write("x.pse", "function velocity(p)\n    return p\n");
    f.bad(2, "flow x.pse --ball 3 -o z.png -o d/../z.png", &["are the same file"]);
    f.bad(2, "join g.exr -o z.exr -o ./z.exr", &["are the same file"]);
    // What a link leads to takes the output, whether it is there or not, and the link stays.
    symlink("later.png", f.path("link.png")).expect("a link");
    f.good("run -e white --size 4x4 -o link.png");
    f.good("run -e white --size 4x4 -o link.png");
    assert!(f.path("link.png").is_symlink() && f.path("later.png").is_file());
}

#[test]
fn names_by_default_replace_no_other_programs_files() {
    let f = Folder::new();
    f.write("marble.pse", "color = white * Noise(8 * point)\n");
    f.write("hair.pse", "function velocity(p)\n    return p\n");
    f.write("ball.pse", "function density(p)\n    return 1 - length(p)\n");
    fs::copy(super::gbuffer("donut_320x180_plain_tiled64.exr"), f.path("vase.exr")).expect("a copy");
    let mut picture =
        fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/pictures/marble.png")).expect("a picture");
    // The name of the software that wrote it goes.
    if let Some(at) = picture.windows(8).position(|bytes| bytes == b"Software") {
        picture[at] = b'X';
    }
    for (file, command) in [
        ("marble.png", "run marble.pse --size 8x8"),
        ("out.png", "run -e white --size 8x8"),
        ("marble.0002.png", "run marble.pse --size 8x8 --frames 1-2"),
        ("marble.1.exr", "run marble.pse --size 8x8 --tile 1/2x2"),
        ("hair.png", "flow hair.pse --ball 9"),
        ("hair.0002.png", "flow hair.pse --ball 9 --frames 1-2"),
        ("vase.exr", "scene vase --size 8x8"),
        ("ball.exr", "scene --iso ball.pse --size 8x8"),
        ("noise.png", "noise value --size 64"),
    ] {
        if !f.path(file).exists() {
            // A picture of another program, and what is no picture at all.
            fs::write(f.path(file), if file.ends_with(".png") { &picture[..] } else { b"text" })
                .expect("a file");
        }
        f.keeps(file, command, &[&format!("`{file}` exists, and pse did not write it"), "-o", "--force"]);
        f.good(&format!("{command} --force"));
        // Its own are made anew.
        f.good(command);
        // A name that was given is meant.
        f.write(file, "text");
        if !command.contains("--tile") && !command.contains("--frames") {
            f.good(&format!("{command} -o {file}"));
        }
    }
}

/// Standard output may lead into a file that is read, and a link from one frame's name to another's.
#[cfg(unix)]
#[test]
fn outputs_without_names_of_their_own() {
    use std::fs::OpenOptions;
    use std::process::Command;
    let f = Folder::new();
    f.good("run -q -e white --size 4x4 -o in.exr");
    let before = f.read("in.exr");
    let file = OpenOptions::new().append(true).open(f.path("in.exr")).expect("the input");
    let ended = Command::new(env!("CARGO_BIN_EXE_pse"))
        .current_dir(f.path(""))
        .args(["run", "-q", "-e", "color = 0.5 * color", "-i", "in.exr", "-o", "-"])
        .stdout(file)
        .output()
        .expect("the command");
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(
        ended.status.code() == Some(1) && said.contains("standard output") && said.contains("in.exr"),
        "{said}"
    );
    assert_eq!(f.read("in.exr"), before);

    std::os::unix::fs::symlink("f.1.png", f.path("f.2.png")).expect("a link");
    f.bad(
        1,
        "run -q -e white*frame/5 --size 8x8 --frames 1-3 -o f.%d.png",
        &["`f.2.png` is the same file as the output `f.1.png`"],
    );
    let first = f.read("f.1.png");
    f.good("run -q -e white*frame/5 --size 8x8 --frame 1 -o g.png");
    assert_eq!(first, f.read("g.png"));
}

/// The list of a bundle may be anything: it is not waited for, and no folder behind a link is removed.
#[cfg(unix)]
#[test]
fn lists_of_bundles_are_not_trusted() {
    let f = Folder::new();
    f.write("p.pse", "color = white\n");
    f.good("job p.pse -o j -q");
    let list = f.path("j/pse-bundle.json");
    std::fs::create_dir_all(f.path("other/empty")).expect("a folder");
    std::os::unix::fs::symlink("../other", f.path("j/x")).expect("a link");
    let text = std::fs::read_to_string(&list).expect("the list");
    let forged = text.replace("\"folders\": [", "\"folders\": [\"x/empty\", ");
    assert_ne!(forged, text);
    std::fs::write(&list, forged).expect("the list");
    f.good("job p.pse -o j -q");
    assert!(f.path("other/empty").exists());
    std::fs::remove_file(&list).expect("the list");
    assert!(std::process::Command::new("mkfifo").arg(&list).status().expect("mkfifo").success());
    f.bad(1, "job p.pse -o j -q", &["pse-bundle.json"]);
}
