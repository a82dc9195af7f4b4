//! Runs `examples/*.pse` by the command lines in their head comments, at a small size, and compares the pictures
//! with those in `tests/pictures`, bit for bit. `UPDATE=1 cargo test --release --test examples` rewrites them:
//! look at them before you keep them.
#![cfg(unix)]

use std::path::{Path, PathBuf};
use std::process::Command;

const SIZE: [u32; 2] = [96, 72];

/// The command lines of an example.
fn commands(text: &str) -> Vec<String> {
    text.lines().filter_map(|l| l.strip_prefix("# ")).filter(|l| l.starts_with("pse run ")).map(String::from).collect()
}

/// The same at the small size, with the tested binary. Frames are cut to three.
fn small(command: &str) -> String {
    let mut line = String::new();
    for part in command.split('|') {
        let part = part.trim().replacen("pse run", &format!("'{}' run -q", env!("CARGO_BIN_EXE_pse")), 1);
        let mut words: Vec<&str> = part.split(' ').collect();
        if let Some(i) = words.iter().position(|w| *w == "--size") {
            words.drain(i..i + 2);
        }
        let mut part = words.join(" ").replace("--frames 1-24", "--frames 1-3");
        if !part.contains(" -i ") {
            part += &format!(" --size {}x{}", SIZE[0], SIZE[1]);
        }
        if !line.is_empty() {
            line += " | ";
        }
        line += &part;
    }
    line
}

#[test]
fn examples_run_as_their_comments_say_and_look_as_they_did() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let work = tempfile::tempdir().unwrap();
    let mut programs: Vec<PathBuf> = std::fs::read_dir(root.join("examples"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "pse"))
        .collect();
    programs.sort();
    assert!(programs.len() >= 20, "only {} examples", programs.len());
    std::os::unix::fs::symlink(root.join("examples"), work.path().join("examples")).unwrap();
    let mut lines: Vec<String> = Vec::new();
    for path in &programs {
        let text = std::fs::read_to_string(path).unwrap();
        let found = commands(&text);
        assert!(!found.is_empty(), "{} does not say how to run it", path.display());
        lines.extend(found);
    }
    // What reads a picture runs after what makes it: two rounds are enough for two inputs in a row.
    lines.sort_by_key(|l| (l.contains(" -i ") && !l.contains('|'), l.contains("=")));
    for line in &lines {
        let output = Command::new("sh").arg("-c").arg(small(line)).current_dir(work.path()).output().unwrap();
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
