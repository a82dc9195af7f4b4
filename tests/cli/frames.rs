//! Runs of many frames: which are left out, what becomes of those that fail, and what is told on the way.

use super::{Folder, gbuffer};
use std::fs;

/// The frames that a run wrote, from what it said.
fn written(err: &str) -> Vec<&str> {
    err.lines().filter_map(|l| l.strip_prefix("wrote ")).filter_map(|l| l.split(' ').next()).collect()
}

const RUN: &str = "run p.pse --size 40x30 --frames 1-3 -o p.##.exr -o p.##.png --resume";

#[test]
fn frames_that_are_whole_are_left_out() {
    let f = Folder::new();
    f.write(
        "p.pse",
        "import \"q.pse\"\nparam a = 1\ncolor = twice(a) * frame * 0.1 * pixel.x / resolution.x\n",
    );
    f.write("q.pse", "function twice(x)\n    return 2 * x * white\n");
    let first = f.good(RUN);
    assert_eq!(written(&first.err).len(), 6, "{}", first.err);
    let bytes = ["p.01.exr", "p.02.png", "p.03.exr"].map(|name| f.read(name));
    fs::remove_file(f.path("p.02.png")).expect("a file");
    fs::write(f.path("p.03.exr"), &bytes[2][..bytes[2].len() - 50]).expect("a file");
    let again = f.good(RUN);
    assert_eq!(written(&again.err), ["p.02.exr", "p.02.png", "p.03.exr", "p.03.png"], "{}", again.err);
    assert!(again.err.contains("skipped 1 of 3 frames"), "{}", again.err);
    assert!(["p.01.exr", "p.02.png", "p.03.exr"].map(|name| f.read(name)) == bytes, "the same bytes");
    // What changes no pixel changes nothing.
    for same in ["--threads 1", "--batch 16", "--no-optimize", "--keep-going"] {
        assert!(written(&f.good(&format!("{RUN} {same}")).err).is_empty(), "{same}");
    }
    for other in ["--set a=0.5", "--half", "--samples 2", "--region 0,0,20,20", "--vars color"] {
        assert_eq!(written(&f.good(&format!("{RUN} {other}")).err).len(), 6, "{other}");
    }
    f.good(RUN);
    // The same text elsewhere and later is the same program; another text is not.
    f.write("q.pse", "function twice(x)\n    return 2 * x * white\n");
    assert!(written(&f.good(RUN).err).is_empty());
    f.write("q.pse", "function twice(x)\n    return 3 * x * white\n");
    assert_eq!(written(&f.good(RUN).err).len(), 6, "an import");
}

#[test]
fn what_frames_are_made_from_is_looked_at() {
    let f = Folder::new();
    f.write("p.pse", "color = color + texture(\"t.png\", 0.5, 0.5)\n");
    let image = |name: &str, value: &str| {
        f.good(&format!("run -e white*{value} --size 8x8 -o {name}"));
    };
    (1..=3).for_each(|i| image(&format!("i.{i}.exr"), "0.1"));
    image("t.png", "0.5");
    let run = "run p.pse -i i.#.exr --frames 1-3 -o o.#.exr --resume";
    f.good(run);
    // Written again with the same content.
    image("i.2.exr", "0.1");
    assert!(written(&f.good(run).err).is_empty());
    image("i.2.exr", "0.2");
    assert_eq!(written(&f.good(run).err), ["o.2.exr"]);
    image("t.png", "0.25");
    assert_eq!(written(&f.good(run).err).len(), 3, "the texture");
    // Another image made of a frame is not that frame.
    f.good("run -e color -i o.1.exr -o o.3.exr");
    assert_eq!(written(&f.good(run).err), ["o.3.exr"]);
}

#[test]
fn only_some_files_know_their_run() {
    let f = Folder::new();
    let run = "run -e white*frame --size 8x8 --frames 1-2 -o a.#.jpg --resume";
    f.good(run);
    let again = f.good(run);
    assert_eq!(written(&again.err).len(), 2);
    assert!(again.err.contains("a.1.jpg has no room for the hash"), "{}", again.err);
    f.good("run -e white*frame --size 8x8 --frames 1-2 -o a.#.png");
    let run = "run -e white*frame --size 8x8 --frames 1-2 -o a.#.png --resume";
    assert_eq!(written(&f.good(run).err).len(), 2, "they were written without --resume");
    f.bad(2, "run -e white -i - -o a.png --resume", &["--resume cannot use standard input"]);
    f.bad(2, "run -e white -o - --resume", &["--resume cannot use standard input"]);
}

const FAULTY: &str = "v = [1 2]\ncolor = white * v[frame == 2 || frame > 3 ? 3 : 1]\n";

#[test]
fn a_frame_that_fails_need_not_stop_the_others() {
    let f = Folder::new();
    f.write("p.pse", FAULTY);
    f.bad(1, "run p.pse --size 8x8 --frames 1-3 -o a.#.png", &["no element 3"]);
    assert!(f.path("a.1.png").exists() && !f.path("a.3.png").exists());
    let words = ["no element 3", "frame 2 failed", "3 of 6 frames failed: 2,4-5", "--frames 2,4-5"];
    f.bad(1, "run p.pse --size 8x8 --frames 1-5,3 -o b.#.png --keep-going", &words);
    assert!(["b.1.png", "b.3.png"].iter().all(|n| f.path(n).exists()) && !f.path("b.2.png").exists());
    // An input that is missing is the frame's fault, a program that is wrong is not.
    fs::copy(gbuffer("donut_320x180_plain_tiled64.exr"), f.path("i.2.exr")).expect("a file");
    f.bad(1, "run -e white -i i.#.exr --frames 1-2 -o c.#.png --keep-going", &["i.1.exr", "1 of 2 frames"]);
    assert!(f.path("c.2.png").exists());
    f.bad(1, "run -e color=( -i i.#.exr --frames 1-2 -o d.#.png --keep-going", &["never closed"]);
}

#[test]
fn a_farm_hears_how_far_a_run_has_come() {
    let f = Folder::new();
    let run = "run -e white*frame --size 8x8 --frames 1-4 -o a.#.png -q --progress openjd";
    let told = f.good(run).text;
    assert_eq!(
        told,
        "openjd_progress: 25.0\nopenjd_progress: 50.0\nopenjd_progress: 75.0\nopenjd_progress: 100.0\n"
    );
    let long = "run -e white*fBm(8*point) --size 900x900 --samples 4 -o a.png -q --progress openjd";
    let words: Vec<&str> = long.split(' ').collect();
    let ended = f.pse_with(&words, b"");
    assert!(ended.text.ends_with("openjd_progress: 100.0\n"), "{}{}", ended.text, ended.err);
    f.write("p.pse", FAULTY);
    let ended = f.pse("run p.pse --size 8x8 --frame 2 -o a.png --progress openjd");
    assert_eq!(ended.code, 1);
    assert!(ended.text.starts_with("openjd_fail: there is no element 3"), "{}", ended.text);
    f.bad(2, "run p.pse -o - --progress openjd", &["cannot both go to standard output"]);
}

#[test]
fn digests_are_of_the_numbers() {
    let f = Folder::new();
    f.write("p.pse", "color = white * frame * Noise(8 * point)\nn = normal\n");
    let size = "--size 60x40";
    let one = f.good(&format!("run p.pse {size} --frame 2 --hash -q")).text;
    assert_eq!(
        one.split_once("  ").map(|(digest, name)| (digest.len(), name)),
        Some((64, "p.pse\n")),
        "{one}"
    );
    assert!(!f.path("p.png").exists(), "only -o writes");
    let several = f.good(&format!("run p.pse {size} --frames 1-2 --hash -q -o a.#.exr --half")).text;
    assert!(f.path("a.2.exr").exists());
    let lines: Vec<&str> = several.lines().collect();
    assert_eq!(lines[1], one.trim_end().to_string() + " frame 2", "{several}");
    assert_ne!(lines[0][..64], lines[1][..64]);
    for options in ["--vars n", "--vars color,n", "--set frame=3", "--region 0,0,60,39", "--samples 2"] {
        let other = f.pse(&format!("run p.pse {size} --frame 2 --hash -q {options}")).text;
        assert!(other.len() < 64 || other[..64] != one[..64], "{options}");
    }
    f.bad(2, "run p.pse --hash -o -", &["cannot both go to standard output"]);
}

#[test]
fn folders_are_made_where_they_are_wanted() {
    let f = Folder::new();
    f.bad(1, "run -e white --size 8x8 -o a/b/c.png", &["there is no directory", "mkdir -p"]);
    f.good("run -e white --size 8x8 -o a/b/c.png --mkdir");
    assert!(f.path("a/b/c.png").exists());
}

/// The numbers that a run of `frame` wrote, as the program saw them.
fn frame_of(f: &Folder, arguments: &str) -> f32 {
    f.good(&format!("run -e color=white -e f=frame --vars f {arguments} -o frame.exr"));
    f.planes("frame.exr", "f")[0][0]
}

#[test]
fn numbers_of_frames_are_whole_and_exact() {
    let f = Folder::new();
    for n in [20240612, 20240613, 99999999] {
        f.good(&format!("run -e white*{} --size 4x4 -o i.{n}.exr", n % 10));
    }
    f.write("p.pse", "color = color + texture(\"t.#.exr\", 0.5, 0.5)\n");
    fs::copy(f.path("i.20240613.exr"), f.path("t.20240613.exr")).expect("a copy");
    // Input, texture and output, of numbers that no 32-bit float is.
    f.good("run p.pse -i i.#.exr --frame 20240613 -o o.#.exr --hash");
    assert_eq!(f.planes("o.20240613.exr", "color")[0][0], 6.0);
    f.good("run -e color -i i.#.exr --frames 20240612-20240613 -o p.%d.exr");
    assert_eq!(f.planes("p.20240612.exr", "color")[0][0], 2.0);
    f.good("run -e color -i i.@@.exr --frame 99999999 -o q.%09d.exr");
    assert_eq!(f.planes("q.099999999.exr", "color")[0][0], 9.0);
    // The program computes with 32-bit floats, which is said if it reads the number.
    let told = f.good("run -e white*frame --size 4x4 --frame 20240613 -o a.png").err;
    assert!(told.contains("the program reads frame 20240613 as 20240612"), "{told}");
    assert!(!f.good("run -e white --size 4x4 --frame 20240613 -o a.png").err.contains("20240612"));
    assert!(!f.good("run -e white*frame --size 4x4 --frame 16777216 -o a.png").err.contains("reads frame"));
    // Numbers below 0, one and several.
    assert_eq!(frame_of(&f, "--size 4x4 --frame -3"), -3.0);
    let files = |list: &str, name: &str| {
        written(&f.good(&format!("run -e white*frame --size 4x4 {list} -o {name}")).err).join(" ")
    };
    assert_eq!(files("--frames -3--1", "n.##.png"), "n.-3.png n.-2.png n.-1.png");
    assert_eq!(files("--frames=-1-1", "n.####.png"), "n.-001.png n.0000.png n.0001.png");
    assert_eq!(files("--frames -4", "n.%d.png"), "n.-4.png");
    assert_eq!(files("--frame -4", "n.%03d.png"), "n.-04.png");
    f.good("run -e white -i n.##.png --frames -3--1 -o m.##.png");
    // Other commands.
    f.good("deform head -e point*=2 --frames -2--1 -o h.#.obj -q");
    f.good("run -e white*frame --mesh h.#.obj --size 8x8 --frame -2 -o h.png");
    f.good("scene --mesh h.#.obj --size 8x8 --frame -1 -o h.#.exr");
    assert!(f.path("h.-1.exr").exists());
    f.write("v.pse", "function velocity(p)\n    return p\n");
    f.good("flow v.pse --ball 9 --frames -1-1 -o v.#.png");
    assert!(f.path("v.-1.png").exists());
    // What is no number of a frame.
    f.bad(2, "run -e white --frame 1-3", &["`1-3` is a list of frames; use --frames 1-3"]);
    f.bad(2, "trace -e white --frame 1,5", &["use --frames 1,5"]);
    f.bad(2, "run -e white --frame nan", &["`nan` is not a frame"]);
    f.bad(2, "run -e white --frames 1-3x0", &["a step of 0"]);
    f.bad(2, "run -e white --frames 1- -o a.#.png", &["a number is missing in `1-`"]);
    f.bad(2, "run -e white --frame 99999999999999999", &["too large for a frame"]);
}

#[test]
fn a_single_file_says_its_frame() {
    let f = Folder::new();
    f.good("scene card --size 4x4 -o clean.0003.exr");
    fs::copy(f.path("clean.0003.exr"), f.path("plain.exr")).expect("a copy");
    assert_eq!(frame_of(&f, "-i clean.0003.exr"), 3.0);
    assert_eq!(frame_of(&f, "-i clean.0003.exr --frame 7"), 7.0);
    assert_eq!(frame_of(&f, "-i plain.exr"), 0.0);
    // The header of a renderer's file.
    let blender = super::gbuffer("donut_480x270_blender50_half_dwaa.exr");
    assert_eq!(frame_of(&f, &format!("-i {blender}")), 1.0);
    // The input proper comes before those with names, and what disagrees says nothing.
    fs::copy(f.path("plain.exr"), f.path("sky_9.exr")).expect("a copy");
    assert_eq!(frame_of(&f, "-i clean.0003.exr -i bg=sky_9.exr"), 3.0);
    assert_eq!(frame_of(&f, "-i plain.exr -i bg=sky_9.exr"), 9.0);
    assert_eq!(frame_of(&f, "-i clean.0003.exr -i sky_9.exr"), 0.0);
    // It stands in the names of outputs and textures too, and is said where the program reads it.
    fs::copy(f.path("plain.exr"), f.path("t.0003.exr")).expect("a copy");
    f.write("p.pse", "color = white * frame + 0 * texture(\"t.####.exr\", 0.5, 0.5, channel = \"point\")\n");
    let told = f.good("run p.pse -i clean.0003.exr -o o.####.png").err;
    assert!(f.path("o.0003.png").exists(), "{told}");
    assert!(told.contains("using frame 3, from `clean.0003.exr`; --frame sets another"), "{told}");
    assert!(!f.good("run -e white -i clean.0003.exr -o o.png").err.contains("as `clean"), "nobody reads it");
    let traced = f.good("trace -e white*frame -i clean.0003.exr").text;
    assert!(traced.contains('3'), "{traced}");
    let repl = f.pse_with(&["repl", "-i", "clean.0003.exr"], b"frame\n");
    assert!(repl.text.starts_with('3'), "{}", repl.text);
    fs::write(f.path("m.0005.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("a mesh");
    f.good("deform m.0005.obj -e point+=frame -o n.####.obj");
    assert!(fs::read_to_string(f.path("n.0005.obj")).expect("a mesh").contains("v 5 5 5"));
}

#[test]
fn folders_have_no_numbers() {
    let f = Folder::new();
    for folder in ["job#12", "100%done", "a@@b"] {
        fs::create_dir(f.path(folder)).expect("a folder");
        f.good(&format!("scene card --size 4x4 -o {folder}/g.exr"));
        f.good(&format!("run -e point -i {folder}/g.exr -o {folder}/o.exr"));
        f.good(&format!("run -e white -i {folder}/g.exr --frames 1-2 -o {folder}/o.##.exr"));
        f.good(&format!("run -e color -i {folder}/o.##.exr --frames 1-2 -o {folder}/p.##.exr"));
        f.bad(2, &format!("run -e color -i {folder}/o.##.exr -o a.png"), &["needs a frame number"]);
        f.write("p.pse", format!("color = texture(\"{folder}/g.exr\", 0.5, 0.5, channel = \"point\")\n"));
        f.good("run p.pse --size 4x4 -o a.png");
        f.write("p.pse", format!("color = texture(\"{folder}/o.#.exr\", 0.5, 0.5)\n"));
        fs::copy(f.path(&format!("{folder}/o.01.exr")), f.path(&format!("{folder}/o.1.exr")))
            .expect("a copy");
        f.good("run p.pse --size 4x4 -o a.png --frame 1");
        f.good(&format!("join {folder}/g.exr -o {folder}/j.exr"));
    }
    // Beside a name with the number, folders that are not there may have it.
    f.good("run -e white --size 4x4 --frames 1-2 -o f.%d/a.#.png --mkdir");
    assert!(f.path("f.2/a.2.png").exists());
    // A file may be called so.
    fs::copy(f.path("job#12/g.exr"), f.path("take#2.exr")).expect("a copy");
    f.good("run -e point -i take#2.exr -o a.png");
    f.good("run -e point -i take#2.exr --frames 1-2 -o a.#.png");
}

#[test]
fn a_missing_number_is_said_once() {
    let f = Folder::new();
    f.good("run -e white --size 4x4 -o i.0001.exr");
    let text = "a = texture(\"sky.####.exr\", 0, 0) + texture(\"sky.####.exr\", 1, 1)\n\
                b = texture(\"fog.%d.exr\", 0, 0)\ncolor = a + b\n";
    f.write("p.pse", text);
    for n in 1..=2 {
        fs::copy(f.path("i.0001.exr"), f.path(&format!("sky.000{n}.exr"))).expect("a copy");
        fs::copy(f.path("i.0001.exr"), f.path(&format!("fog.{n}.exr"))).expect("a copy");
    }
    let once = |arguments: &str, name: &str| {
        let ended = f.pse(arguments);
        let running = ended.err.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(ended.code, 2, "{arguments}: {running}");
        assert!(running.contains(&format!("{name} needs a frame number, and none is given")), "{running}");
        assert!(running.contains("--frame 1"), "{running}");
        assert_eq!(running.matches('×').count(), 1, "{arguments}: {running}");
    };
    for command in ["run p.pse --size 4x4 -o a.png", "trace p.pse"] {
        once(command, "the texture `sky.####.exr`");
    }
    once("run -e color -i i.####.exr -o a.png", "i.####.exr");
    f.good("run -e white --size 4x4 -o plain.exr");
    once("run -e color -i plain.exr -i b=j.%d.exr -o a.png", "j.%d.exr");
    once("trace -e color -i i.####.exr", "i.####.exr");
    once("repl -i i.####.exr", "i.####.exr");
    once("flow v.pse -i i.####.exr -o a.png", "i.####.exr");
    once("deform m.#.obj -e point+=1 -o a.obj", "m.#.obj");
    once("scene --mesh m.#.obj -o a.exr", "m.#.obj");
    once("run -e white --mesh m.#.obj -o a.exr", "m.#.obj");
    once("join t.#.exr -o a.exr", "t.#.exr");
    f.write("s.pse", "function density(p)\n    return texture(\"sky.####.exr\", 0, 0).x - length(p)\n");
    once("scene --iso s.pse -o a.exr", "the texture `sky.####.exr`");
    once("run -e white --iso s.pse -o a.exr", "the texture `sky.####.exr`");
    f.bad(2, "run -e color -i i.####.exr --frame 2.5 -o a.png", &["the frame is 2.5", "whole"]);
    f.good("run p.pse --size 4x4 --frame 1 -o a.png");
}

#[test]
fn errors_name_the_frame_and_its_file() {
    let f = Folder::new();
    f.good("scene card --size 4x4 -o g.1.exr");
    f.good("run -e white --size 4x4 -o g.2.exr");
    let words = ["point", "This is frame 2, which reads `g.2.exr`."];
    f.bad(1, "run -e white*point.x -i g.#.exr --frames 1-2 -o o.#.png", &words);
    f.good("run -e color -i g.#.exr --frames 2 -o o.#.png");
    f.bad(1, "run -e color -i g.#.exr --frames 2-3 -o o.#.png", &["g.3.exr", "This is frame 3"]);
    f.write("p.pse", "v = [1 2]\ncolor = white * v[frame]\n");
    f.bad(1, "run p.pse --size 4x4 --frames 1-3 -o o.#.png", &["no element 3", "This is frame 3."]);
}
