//! Meshes far from the origin, of any size, and of faces that coincide.

use super::{at, ball, of, picture, read};
use pse::image::Image;
use pse::mesh::{Corner, Deform, Face, Mesh};
use pse::scene::{Model, Options, Renderer};
use pse::{Program, RunOptions};
use std::sync::Arc;
use std::time::{Duration, Instant};

const SIZE: [usize; 2] = [80, 60];

fn options() -> Options {
    Options { width: SIZE[0], height: SIZE[1], ..Options::default() }
}

/// A ball with bumps, so that no two places look the same.
fn bumpy(steps: usize) -> Mesh {
    let mut mesh = of("obj", ball(steps)).unwrap();
    for p in &mut mesh.points {
        let size = 1.0 + 0.1 * libm::sin(5.0 * p[0] + 3.0 * p[1]) * libm::sin(4.0 * p[2]);
        *p = p.map(|c| c * size);
    }
    mesh
}

/// The mesh so many times as large, and elsewhere.
fn moved(mesh: &Mesh, size: f64, offset: [f64; 3]) -> Mesh {
    let mut mesh = mesh.clone();
    mesh.points.iter_mut().for_each(|p| *p = [0, 1, 2].map(|i| p[i] * size + offset[i]));
    mesh
}

/// How many pixels are covered in one picture and not in the other, and the largest angle between normals in degrees.
fn differences(one: &Image<'_>, other: &Image<'_>) -> (usize, f64) {
    let (mut parted, mut angle) = (0, 0.0f64);
    for i in 0..SIZE[0] * SIZE[1] {
        let [a, b] = [one, other].map(|image| at(image, "surface", i % SIZE[0], i / SIZE[0])[0] != 0.0);
        parted += usize::from(a != b);
        if a && b {
            let [a, b] = [one, other].map(|image| at(image, "normal", i % SIZE[0], i / SIZE[0]));
            let distance: f64 = a.iter().zip(&b).map(|(a, b)| f64::from((a - b) * (a - b))).sum();
            angle = angle.max(distance.sqrt().to_degrees());
        }
    }
    (parted, angle)
}

#[test]
fn a_mesh_looks_the_same_wherever_and_however_large_it_is() {
    let near = bumpy(20);
    let expected = picture(near.clone(), &options());
    let covered = expected.variable("surface").unwrap().planes[0].iter().filter(|&&s| s == 1.0).count();
    assert!(covered > 1000, "{covered}");
    let utm = [448_262.25, 4_649_776.5, 312.0];
    let earth = [-2_694_892.125, -4_297_557.25, 3_854_579.5];
    for (size, offset) in [
        (1.0, utm),
        (1.0, earth),
        // A millimetre, and a tenth of one.
        (1e-3, earth),
        (1e-4, earth),
        (1e3, earth.map(|c| c * 1e4)),
        (1e-30, [0.0; 3]),
        (1e30, [0.0; 3]),
        (1e36, [1e37, 0.0, -1e37]),
        (1e-36, [1e-34, 0.0, 1e-33]),
    ] {
        let image = picture(moved(&near, size, offset), &options());
        let (parted, angle) = differences(&expected, &image);
        // The doubles of the file are off by a share of the ball.
        let rounding = offset.iter().fold(0.0, |most: f64, c| most.max(c.abs())) * 1e-16 / size;
        assert!(
            parted <= 1 && angle < 0.01 + 6e3 * rounding,
            "{size} {offset:?}: {parted} pixels, {angle} degrees"
        );
        // The one rounding is that of the point to 32 bits.
        let step = offset.iter().fold(size, |most: f64, c| most.max(c.abs())) * 2e-7;
        for pixel in [SIZE[0] * SIZE[1] / 2 + SIZE[0] / 2, SIZE[0] * SIZE[1] / 3 + SIZE[0] / 2] {
            let [a, b] =
                [&expected, &image].map(|image| at(image, "point", pixel % SIZE[0], pixel / SIZE[0]));
            for i in 0..3 {
                let (a, b) = (f64::from(a[i]) * size + offset[i], f64::from(b[i]));
                assert!((a - b).abs() <= step, "{size} {offset:?}: {a} {b}");
            }
        }
    }
}

#[test]
fn near_and_far_objects_in_one_file_keep_their_shape_and_speed() {
    let near = bumpy(60);
    let eye = Options { eye: Some([2.0, -7.0, 2.0]), look_at: Some([0.0; 3]), fov: Some(25.0), ..options() };
    let expected = picture(near.clone(), &eye);
    let mut both = near.clone();
    let first = both.corners.len() as u32;
    for point in [[6.4e6, 6.4e6, 0.0], [6.4e6 + 1.0, 6.4e6, 0.0], [6.4e6, 6.4e6, 1.0]] {
        both.corners.push(Corner { point: both.points.len() as u32, normal: None, uv: None });
        both.points.push(point);
    }
    both.faces.push(Face { first, corners: 3, surface: 0 });
    let start = Instant::now();
    let image = picture(both, &eye);
    let (parted, angle) = differences(&expected, &image);
    assert!(parted == 0 && angle < 0.01, "{parted} pixels, {angle} degrees");
    // Were the near ball one heap of boxes, each of the rays would meet fourteen thousand triangles.
    assert!(start.elapsed() < Duration::from_secs(20), "{:?}", start.elapsed());
}

/// A mesh of those polygons.
fn polygons(list: impl IntoIterator<Item = Vec<[f64; 3]>>) -> Mesh {
    let mut mesh = Mesh { surfaces: vec!["mesh".into()], ..Mesh::default() };
    for polygon in list {
        let (first, corners) = (mesh.corners.len() as u32, polygon.len() as u32);
        for point in polygon {
            mesh.corners.push(Corner { point: mesh.points.len() as u32, normal: None, uv: None });
            mesh.points.push(point);
        }
        mesh.faces.push(Face { first, corners, surface: 0 });
    }
    mesh
}

#[test]
fn faces_that_coincide_cost_no_more_than_others() {
    let quad = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let turned = |i: usize| (0..4).map(|k| quad[(i + k) % 4]).collect::<Vec<_>>();
    let above = Options { eye: Some([0.0, 0.0, 6.0]), look_at: Some([0.0; 3]), fov: Some(25.0), ..options() };
    let count = 40_000;
    let heaps: [(&str, Mesh); 4] = [
        ("copies of a triangle", polygons((0..count).map(|_| quad[..3].to_vec()))),
        ("copies of a quad that begin anywhere", polygons((0..count).map(turned))),
        (
            "copies that look either way",
            polygons(
                (0..count)
                    .map(|i| if i % 2 == 0 { turned(0) } else { turned(i).into_iter().rev().collect() }),
            ),
        ),
        (
            "triangles around one centre",
            polygons((0..count).map(|i| {
                let size = (i + 1) as f64 / count as f64;
                [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]].map(|p| p.map(|c| c * size)).to_vec()
            })),
        ),
    ];
    for (what, mesh) in heaps {
        let start = Instant::now();
        let image = picture(mesh, &above);
        assert_eq!(at(&image, "surface", SIZE[0] / 2, SIZE[1] / 2 + 2), [1.0], "{what}");
        assert_eq!(at(&image, "normal", SIZE[0] / 2, SIZE[1] / 2 + 2), [0.0, 0.0, 1.0], "{what}");
        assert!(start.elapsed() < Duration::from_secs(30), "{what}: {:?}", start.elapsed());
    }
}

#[test]
fn of_faces_in_one_plane_the_first_is_seen_everywhere() {
    // Two sheets in a slanted plane, cut along other diagonals; no pixel may show the second one through the first.
    let corner = |u: f64, v: f64| [u, v, 0.3 * u + 0.7 * v];
    let one = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let other = [corner(-1.3, -1.1), corner(1.2, -1.4), corner(1.3, 1.1), corner(-1.2, 1.3)];
    for (first, second) in [(one, other), (other, one)] {
        let mut mesh = polygons([first.to_vec(), second.to_vec()]);
        mesh.faces[1].surface = 1;
        mesh.surfaces = vec!["first".into(), "second".into()];
        let first = mesh.faces[0];
        let alone = Mesh { faces: vec![first], ..mesh.clone() };
        let eye =
            Options { eye: Some([1.0, -5.0, 6.0]), look_at: Some([0.0; 3]), fov: Some(25.0), ..options() };
        let [both, alone] = [mesh, alone].map(|mesh| picture(mesh, &eye));
        for i in 0..SIZE[0] * SIZE[1] {
            let [both, alone] =
                [&both, &alone].map(|image| at(image, "surface", i % SIZE[0], i / SIZE[0])[0]);
            assert!(alone == 0.0 || both == 1.0, "pixel {i}");
        }
    }
}

#[test]
fn corners_at_one_place_have_a_normal() {
    // A ball of quads only: at the poles two corners of each lie at one place.
    let (rings, around) = (6, 8);
    let mut text = String::new();
    for i in 0..=rings {
        let a = std::f64::consts::PI * f64::from(i) / f64::from(rings);
        for j in 0..around {
            let b = std::f64::consts::TAU * f64::from(j) / f64::from(around);
            let (x, z) = (libm::sin(a) * libm::sin(b), libm::sin(a) * libm::cos(b));
            let [x, z] = [x, z].map(|c| if i == 0 || i == rings { 0.0 } else { c });
            text += &format!("v {x} {} {z}\n", libm::cos(a));
        }
    }
    for i in 0..rings {
        for j in 0..around {
            let [a, b] = [i * around + j + 1, i * around + (j + 1) % around + 1];
            text += &format!("f {a} {} {} {b}\n", a + around, b + around);
        }
    }
    let mut mesh = of("obj", &text).unwrap();
    mesh.complete_normals();
    for corner in &mesh.corners {
        let normal = mesh.normals[corner.normal.expect("a normal") as usize];
        let point = mesh.points[corner.point as usize];
        let cosine: f64 = point.iter().zip(&normal).map(|(a, b)| a * b).sum();
        assert!(
            (normal.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-6 && cosine > 0.99,
            "{point:?} {normal:?}"
        );
        if point[1].abs() == 1.0 {
            assert!(normal[0].abs() < 1e-7 && normal[2].abs() < 1e-7, "{normal:?}");
        }
    }
    // So it is in the space of a deformation.
    let deform = Deform::new(of("obj", &text).unwrap());
    let normal = at(&deform.image(), "normal", 0, 0);
    assert!(normal[0].abs() < 1e-7 && normal[1] == 1.0 && normal[2].abs() < 1e-7, "{normal:?}");
    // A seam whose sides differ by rounding, here and far away.
    for far in [0.0, 4e6] {
        let (right, left) = (far + 1.0, far - 1.0);
        let seam = format!(
            "v {far} 0 0\nv {right} 0 -1\nv {right} 1 -1\nv {far} 1 0\n\
             v {far} 0 1.2e-16\nv {left} 0 -1\nv {left} 1 -1\nv {far} 1 -1e-17\nf 1 2 3 4\nf 5 8 7 6\n"
        );
        let mut seam = of("obj", &seam).unwrap();
        seam.complete_normals();
        let normal = |i: usize| seam.normals[seam.corners[i].normal.unwrap() as usize];
        assert_eq!([normal(4), normal(5)], [normal(0), normal(3)]);
        assert!(normal(0)[0].abs() < 1e-7 && normal(1)[0] > 0.7, "{:?} {:?}", normal(0), normal(1));
    }
    // Corners that come twice in a face, and faces that are a line.
    let mut odd =
        of("obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 1 2 2 3 4 4 1\nf 1 2 2\nf 1 1 1 1\n").unwrap();
    odd.complete_normals();
    assert!(odd.corners[..8].iter().all(|c| odd.normals[c.normal.unwrap() as usize] == [0.0, 0.0, 1.0]));
}

#[test]
fn what_a_program_does_not_move_stays_to_the_last_digit() {
    let folder = tempfile::tempdir().unwrap();
    let text = "o far\nv 448262.123456 4649776.654321 12.3456789012\nv 448263.1 4649776.6 0.1\nv 448262.5 4649777.25 -0.0000001\n\
                v 448262 4649777 1\nvt 0.123456789012 0.1\nvt 1000.0625001 0.7\nvt 0.3 0.9\nvn 0.577350269189 0.5 0.1\nvn 0 0 1\n\
                f 1/1/1 2/2/1 3/3/2\nf 1/1/1 3/3/2 4/1/2\n";
    let still = Program::compile("point = point").unwrap();
    let run = |deform: &Deform, program: &Program| {
        let report = program.run(&deform.image(), &RunOptions::default()).unwrap();
        deform.moved(&report.image).unwrap()
    };
    let mesh = of("obj", text).unwrap();
    assert_eq!(run(&Deform::new(mesh.clone()), &still), mesh);
    assert_eq!(run(&Deform::around(mesh.clone(), [448_262.1, 4_649_776.6, 0.0]), &still), mesh);
    // Each format holds them: OBJ as text, PLY as doubles, GLB as floats beside a translation.
    let path = |name: &str| folder.path().join(name);
    mesh.write(&path("a.obj")).unwrap();
    assert_eq!(std::fs::read_to_string(path("a.obj")).unwrap(), text);
    mesh.write(&path("a.ply")).unwrap();
    let ply = read(&path("a.ply")).unwrap().mesh;
    assert!(ply.points.iter().all(|p| mesh.points.contains(p)), "{:?}", ply.points);
    assert_eq!(run(&Deform::new(ply.clone()), &still), ply);
    mesh.write(&path("a.glb")).unwrap();
    let glb = read(&path("a.glb")).unwrap().mesh;
    for p in &glb.points {
        let near = |q: &[f64; 3]| p.iter().zip(q).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(mesh.points.iter().any(near), "{p:?}");
    }
    // A number of few digits may still be none of a single's: 448262.1 is 448262.09375 there.
    let short = moved(&bumpy(4), 1.0, [448_262.1, 0.0, 0.0]);
    let short =
        Mesh { points: short.points.iter().map(|p| p.map(|c| (c * 10.0).round() / 10.0)).collect(), ..short };
    short.write(&path("short.ply")).unwrap();
    assert_eq!(read(&path("short.ply")).unwrap().mesh.points, short.points);
    glb.write(&path("b.glb")).unwrap();
    assert_eq!(read(&path("b.glb")).unwrap().mesh.points, glb.points);

    // One vertex moves: its faces' normals are new, all other coordinates are what they were.
    let up = Program::compile("if point.z > 5\n    point = [point.x point.y 7.1]").unwrap();
    let after = run(&Deform::new(mesh.clone()), &up);
    assert_eq!(after.points[0], [mesh.points[0][0], mesh.points[0][1], 7.1]);
    assert_eq!(after.points[1..], mesh.points[1..]);
    assert_ne!(after.normals, mesh.normals);
    // Around the middle nothing is lost of a small step.
    let step = Program::compile("point += [0.001 0 0]").unwrap();
    let origin = mesh.round_middle();
    for (before, after) in mesh.points.iter().zip(&run(&Deform::around(mesh.clone(), origin), &step).points) {
        assert!((after[0] - before[0] - 0.001).abs() < 1e-6, "{before:?} {after:?}");
    }
}

#[test]
fn nodes_of_gltf_may_be_far_away() {
    let near = bumpy(12);
    let folder = tempfile::tempdir().unwrap();
    let glb = |mesh: Mesh, name: &str| {
        let path = folder.path().join(name);
        mesh.write(&path).unwrap();
        read(&path).unwrap().mesh
    };
    let mut far = glb(moved(&near, 1.0, [-2_694_892.1, -4_297_557.2, 3_854_579.3]), "far.glb");
    assert!(far.coarse_step().is_some() && near.coarse_step().is_none());
    far.translate([2_694_892.1, 4_297_557.2, -3_854_579.3]);
    let near = glb(near, "near.glb");
    let (parted, angle) = differences(&picture(near, &options()), &picture(far, &options()));
    assert!(parted <= 1 && angle < 0.01, "{parted} pixels, {angle} degrees");
}

#[test]
fn given_eyes_are_in_the_world_and_errors_too() {
    let offset = [448_262.25, 4_649_776.5, 312.0];
    let near = bumpy(12);
    let eye = [2.0, -7.0, 2.0];
    let by_hand = |offset: [f64; 3]| Options {
        eye: Some([0, 1, 2].map(|i| eye[i] + offset[i])),
        look_at: Some(offset),
        fov: Some(25.0),
        ..options()
    };
    let far = moved(&near, 1.0, offset);
    let (parted, angle) =
        differences(&picture(near, &by_hand([0.0; 3])), &picture(far.clone(), &by_hand(offset)));
    assert!(parted == 0 && angle < 0.01, "{parted} pixels, {angle} degrees");
    let model = Arc::new(Model::new(far).unwrap());
    let bad = Options { eye: Some(offset), ..by_hand(offset) };
    let error = Renderer::of_model(&model, &bad).err().unwrap().to_string();
    assert!(error.contains("448262.25,4649776.5,312"), "{error}");
}
