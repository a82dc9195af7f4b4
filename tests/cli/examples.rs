//! Runs `examples/*.pse` by the command lines in their head comments, at a small size, and compares the pictures
//! with those in `tests/pictures`, bit for bit. `UPDATE=1 cargo test --release --test cli examples` rewrites them:
//! look at them before you keep them. `tests/digests.txt` has digests of what they compute, before it is encoded.

use std::path::{Path, PathBuf};
use std::process::Command;

const SIZE: [u32; 2] = [96, 72];

/// How examples are run.
const KINDS: [&str; 2] = ["pse run ", "pse flow "];

/// The command lines of an example.
fn commands(text: &str) -> Vec<String> {
    text.lines()
        .filter_map(|l| l.strip_prefix("# "))
        .filter(|l| KINDS.iter().any(|kind| l.starts_with(kind)))
        .map(String::from)
        .collect()
}

/// The command that is tested: this build's, or another one, as of another machine: `PSE_COMMAND='qemu-aarch64 -L … pse'`.
fn tested() -> String {
    std::env::var("PSE_COMMAND").unwrap_or_else(|_| format!("'{}'", env!("CARGO_BIN_EXE_pse")))
}

/// The same at a small size, with the tested binary and more options. Frames are cut to three.
fn small(command: &str, [width, height]: [u32; 2], more: &str) -> String {
    let mut line = String::new();
    for part in command.split('|') {
        let part = part.trim().replacen("pse ", &format!("{} ", tested()), 1) + " -q";
        let mut words: Vec<&str> = part.split(' ').collect();
        if let Some(i) = words.iter().position(|w| *w == "--size") {
            words.drain(i..i + 2);
        }
        let mut part = words.join(" ").replace("--frames 1-24", "--frames 1-3");
        if !part.contains(" -i ") {
            part += &format!(" --size {width}x{height}");
        }
        part += more;
        if !line.is_empty() {
            line += " | ";
        }
        line += &part;
    }
    line
}

/// The command lines of all examples, those that read pictures after those that make them; and their files.
fn all(work: &Path) -> (Vec<String>, Vec<PathBuf>) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut programs: Vec<PathBuf> = std::fs::read_dir(root.join("examples"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "pse"))
        .collect();
    programs.sort();
    assert!(programs.len() >= 20, "only {} examples", programs.len());
    std::os::unix::fs::symlink(root.join("examples"), work.join("examples")).unwrap();
    let mut lines: Vec<String> = Vec::new();
    for path in &programs {
        let text = std::fs::read_to_string(path).unwrap();
        let found = commands(&text);
        assert!(!found.is_empty(), "{} does not say how to run it", path.display());
        lines.extend(found);
    }
    // What reads a picture runs after what makes it: two rounds are enough for two inputs in a row.
    lines.sort_by_key(|l| (l.contains(" -i ") && !l.contains('|'), l.contains("=")));
    (lines, programs)
}

#[test]
fn examples_run_as_their_comments_say_and_look_as_they_did() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let work = tempfile::tempdir().unwrap();
    let (lines, programs) = all(work.path());
    for line in &lines {
        let output = Command::new("sh")
            .arg("-c")
            .arg(small(line, SIZE, ""))
            .current_dir(work.path())
            .output()
            .unwrap();
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{line}\n{errors}");
        assert!(!errors.contains("NaN"), "{line}\n{errors}");
    }
    let kept = root.join("tests/pictures");
    let update = std::env::var_os("UPDATE").is_some();
    let mut differ = Vec::new();
    for path in &programs {
        let name = path.file_stem().unwrap().to_string_lossy().to_string();
        let picture = [format!("{name}.png"), format!("{name}.0003.png")].map(|f| work.path().join(f));
        let Some(picture) = picture.iter().find(|p| p.exists()) else { continue };
        let stored = kept.join(format!("{name}.png"));
        if update {
            std::fs::copy(picture, &stored).unwrap();
            continue;
        }
        let read = |p: &Path| image::open(p).unwrap_or_else(|e| panic!("{}: {e}", p.display())).to_rgba8();
        let (found, expected) = (read(picture), read(&stored));
        let off = found.iter().zip(expected.iter()).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
        if found.dimensions() != expected.dimensions() || off > 0 {
            differ.push(format!("{name} differs by up to {off} of 255"));
        }
    }
    assert!(differ.is_empty(), "{}\nUPDATE=1 rewrites the pictures", differ.join("\n"));
    // The flame is the same in two steps and through a pipe.
    let bytes = |f: &str| std::fs::read(work.path().join(f)).unwrap();
    assert_eq!(bytes("flame_color.png"), bytes("flame_piped.png"));
}

/// What all examples compute, run with these options and this instruction set: a line each, the digest and the command.
/// `None`: this machine does not have that instruction set.
fn digests(isa: &str, options: &str) -> Option<String> {
    let work = tempfile::tempdir().unwrap();
    let mut text = String::new();
    // Lines are drawn, not computed at pixels.
    for line in all(work.path()).0.into_iter().filter(|line| !line.starts_with("pse flow ")) {
        let mut command = small(&line, [32, 24], options);
        // With --hash only what -o names is written, and later commands read it.
        if !command.contains(" -o ") {
            let name = line.split(['/', '.']).nth(1).unwrap_or("out");
            command += &format!(" -o {name}.png");
        }
        let output = Command::new("sh")
            .arg("-c")
            .arg(command + " --hash")
            .current_dir(work.path())
            .env("PSE_SIMD", isa)
            .output()
            .unwrap();
        let errors = String::from_utf8_lossy(&output.stderr);
        if errors.contains("this machine has no") {
            return None;
        }
        assert!(output.status.success(), "{line}\n{errors}");
        let told = String::from_utf8(output.stdout).unwrap();
        for told in told.lines() {
            let (digest, of) = told.split_at(64);
            let frame = of.split_once(" frame ").map_or(String::new(), |(_, n)| format!("  # frame {n}"));
            text += &format!("{digest}  {line}{frame}\n");
        }
    }
    Some(text)
}

#[test]
fn examples_compute_the_same_numbers_everywhere() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/digests.txt");
    let found = digests("auto", "").unwrap();
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&path, &found).unwrap();
    }
    let stored = std::fs::read_to_string(&path).unwrap();
    let compare = |found: &str, how: &str| {
        let differ: Vec<&str> =
            found.lines().zip(stored.lines()).filter(|(a, b)| a != b).map(|(a, _)| &a[66..]).collect();
        assert!(
            differ.is_empty(),
            "{how}: other numbers in\n{}\nUPDATE=1 rewrites {}",
            differ.join("\n"),
            path.display()
        );
        assert_eq!(
            found.lines().count(),
            stored.lines().count(),
            "{how}: UPDATE=1 rewrites {}",
            path.display()
        );
    };
    compare(&found, "as it is");
    let ways = [
        ("auto", " --threads 1 --batch 1"),
        ("auto", " --threads 2 --batch 4096"),
        ("auto", " --threads 2 --batch 100"),
        ("baseline", " --threads 1"),
        ("avx2", " --threads 2"),
        ("avx512", " --threads 2"),
        ("auto", " --no-optimize"),
    ];
    for (isa, options) in ways {
        match digests(isa, options) {
            Some(found) => compare(&found, &format!("{isa}{options}")),
            None => eprintln!("skipped: this machine has no {isa}"),
        }
    }
}
