//! Meshes on the command line.

use assert_cmd::Command;
use pse::mesh;
use std::path::{Path, PathBuf};

fn suzanne(ending: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/meshes/suzanne.{ending}"))
}

fn points(path: &Path) -> Vec<[f64; 3]> {
    mesh::read(path, &|_, _| ()).expect("a mesh").mesh.points
}

fn run(folder: &Path, words: &[&str]) -> (bool, String) {
    let output = Command::cargo_bin("pse").unwrap().args(words).current_dir(folder).output().unwrap();
    (output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn the_commands_take_meshes() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let mesh = suzanne("glb");
    let mesh = mesh.to_str().unwrap();
    let (good, said) = run(here, &["scene", "--mesh", mesh, "-o", "g.exr", "--size", "64x48"]);
    assert!(good && said.contains("wrote g.exr (64x48)"), "{said}");
    // At once, and in two steps, are the same.
    let lines = ["run", "-e", "color = 0.5 * (normal + 1)", "--hash"];
    let hash = |more: &[&str]| {
        let output =
            Command::cargo_bin("pse").unwrap().args(lines).args(more).current_dir(here).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    assert_eq!(hash(&["-i", "g.exr"]), hash(&["--mesh", mesh, "--size", "64x48"]));
    assert_ne!(hash(&["-i", "g.exr"]), hash(&["--mesh", mesh, "--size", "64x48", "--up", "z"]));
    assert_ne!(hash(&["-i", "g.exr"]), hash(&["--mesh", mesh, "--size", "64x48", "--samples", "4"]));
    let (good, said) = run(here, &["run", "-e", "color = white", "--mesh", mesh, "--scene", "vase"]);
    assert!(!good && said.contains("--scene and --mesh cannot be combined"), "{said}");
    let (good, said) = run(here, &["scene", "--mesh", "none.obj"]);
    assert!(!good && said.contains("there is no such file"), "{said}");

    // --resume looks into the file.
    std::fs::copy(mesh, here.join("a.glb")).unwrap();
    let words =
        ["run", "-e", "color = normal", "--mesh", "a.glb", "--size", "16x16", "-o", "a.png", "--resume"];
    assert!(run(here, &words).1.contains("wrote a.png"));
    assert!(run(here, &words).1.contains("skipped 1 of 1 frames"));
    mesh::head().write(&here.join("a.glb")).unwrap();
    assert!(run(here, &words).1.contains("wrote a.png"));
}

#[test]
fn deform_from_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let (good, said) =
        run(here, &["deform", "head", "-e", "point += frame * [0 1 0]", "-o", "h.##.obj", "--frames", "1-3"]);
    assert!(good, "{said}");
    assert!(said.contains("wrote h.02.obj"), "{said}");
    let [head, third] = [mesh::head(), mesh::read(&here.join("h.03.obj"), &|_, _| ()).expect("a mesh").mesh];
    let [x, y, z] = head.points[5];
    assert_eq!(third.points[5].map(|c| c as f32), [x as f32, y as f32 + 3.0, z as f32]);
    assert!((2000..8000).contains(&head.points.len()), "{}", head.points.len());
    assert!(head.faces.iter().all(|face| face.corners == 4));
    // Closed: each edge has a face on either side.
    let mut edges = std::collections::HashMap::new();
    for face in &head.faces {
        let corners = head.corners_of(face);
        for i in 0..4 {
            let [a, b] = [corners[i].point, corners[(i + 1) % 4].point];
            *edges.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
        }
    }
    assert!(edges.values().all(|&n| n == 0));

    let (good, said) = run(here, &["deform", "h.01.obj", "-e", "color = normal", "-o", "b.obj"]);
    assert!(!good && said.contains("does not assign `point`") && said.contains("for example"), "{said}");
    let (good, said) = run(here, &["deform", "h.01.obj", "-e", "point += 1", "-o", "h.01.obj"]);
    assert!(!good && said.contains("is the input"), "{said}");
    let (good, said) = run(here, &["deform", "h.01.obj", "-e", "point += depth", "-o", "b.ply"]);
    assert!(!good && said.contains("A vertex of this mesh has point, normal, uv."), "{said}");
    let (good, said) = run(here, &["deform", "h.01.obj", "-e", "point += 1", "-o", "b.glb"]);
    assert!(good && said.contains("wrote b.glb"), "{said}");
}

#[test]
fn a_seam_does_not_tear() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let glb = suzanne("glb");
    let words = ["-e", "point += 0.2 * normal * turbulence(4 * point)", "-e", "print(point)", "-o", "b.obj"];
    let (good, said) = run(here, &[&["deform", glb.to_str().unwrap()], &words[..]].concat());
    assert!(good && said.contains("more lines not shown"), "{said}");
    let (before, after) = (points(&glb), points(&here.join("b.obj")));
    assert_eq!(before.len(), after.len());
    let mut moved = std::collections::HashMap::new();
    for (old, new) in before.iter().zip(&after) {
        assert_eq!(*moved.entry(old.map(f64::to_bits)).or_insert(new), new, "the vertices at {old:?} part");
    }
    assert!(moved.len() < before.len());
    let far = before.iter().zip(&after).filter(|(a, b)| a != b).count();
    assert!(far > before.len() * 9 / 10, "{far} vertices have moved");
    let (good, said) = run(here, &["deform", "head", "-e", "point += Du(point)", "-o", "c.obj"]);
    assert!(!good && said.contains("Vertices have no neighbouring pixels"), "{said}");
}

#[test]
fn far_meshes_are_reported_and_recentered() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let text = "v 448262.1 4649776.5 0\nv 448264.1 4649776.5 0\nv 448264.1 4649778.5 0\nv 448262.1 4649778.5 0\nf 1 2 3 4\n";
    std::fs::write(here.join("far.obj"), text).unwrap();
    let run = |words: &[&str]| {
        let output = Command::cargo_bin("pse").unwrap().args(words).current_dir(here).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{said}");
        said + &String::from_utf8_lossy(&output.stdout)
    };
    let said = run(&["scene", "--mesh", "far.obj", "-o", "a.exr", "--size", "16x16"]);
    assert!(said.contains("`point`, in 32-bit floats, has steps of 0.5. Add --recenter"), "{said}");
    let said = run(&["scene", "--mesh", "far.obj", "--recenter", "-o", "b.exr", "--size", "16x16"]);
    assert!(said.contains("moved 448263.1,0,4649777.5 to the origin"), "{said}");
    assert!(!said.contains("steps of"), "{said}");
    let said = run(&["info", "b.exr"]);
    assert!(said.contains("point"), "{said}");
    let hash = |more: &[&str]| {
        run(&[&["run", "-e", "color = point", "--mesh", "far.obj", "--size", "16x16", "--hash", "-q"], more]
            .concat())
    };
    assert_eq!(hash(&["--recenter"]), hash(&["--recenter=448263.1,0,4649777.5"]));
    assert_ne!(hash(&["--recenter"]), hash(&[]));

    let said = run(&["deform", "far.obj", "-e", "point = point", "-o", "same.obj"]);
    assert!(said.contains("Add --recenter"), "{said}");
    assert_eq!(std::fs::read_to_string(here.join("same.obj")).unwrap(), format!("o mesh\n{text}"));
    let said = run(&["deform", "far.obj", "-e", "point += [0.01 0 0]", "-o", "right.obj", "--recenter"]);
    assert!(!said.contains("Add --recenter"), "{said}");
    let [x, y, z] = points(&here.join("right.obj"))[0];
    assert!((x - 448_262.11).abs() < 1e-7 && [y, z] == [4_649_776.5, 0.0], "{x} {y} {z}");
}
