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
    assert!(again.err.contains("1 of 3 frames were there already"), "{}", again.err);
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
    assert!(again.err.contains("a.1.jpg cannot hold the hash"), "{}", again.err);
    f.good("run -e white*frame --size 8x8 --frames 1-2 -o a.#.png");
    let run = "run -e white*frame --size 8x8 --frames 1-2 -o a.#.png --resume";
    assert_eq!(written(&f.good(run).err).len(), 2, "they were written without --resume");
    f.bad(2, "run -e white -i - -o a.png --resume", &["--resume is for files"]);
    f.bad(2, "run -e white -o - --resume", &["--resume is for files"]);
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
