//! Named spaces: from an image's header, from options, from a scene's camera.

use pse::image::Matrix4;
use pse::scene::{Options, render};
use pse::{Program, RunOptions, Shape};

fn planes(text: &str, image: &pse::Image<'_>, name: &str, options: RunOptions<'_>) -> Vec<Vec<f32>> {
    let program = Program::compile(text).unwrap_or_else(|e| panic!("{e}"));
    let outputs = Some(vec![name.to_string()]);
    let report = program.run(image, &RunOptions { outputs, ..options }).unwrap_or_else(|e| panic!("{e}"));
    report.image.variables[0].planes.iter().map(|p| p.to_vec()).collect()
}

/// A scene knows its camera: depth, place on the screen and direction are those of its pixels.
#[test]
fn a_scene_has_a_camera_and_a_screen() {
    let view = Options { width: 64, height: 48, scale: 2.0, ..Options::default() };
    let image = render("donut", &view).unwrap();
    let hit: Vec<bool> = image.variable("surface").unwrap().planes[0].iter().map(|s| *s > 0.0).collect();
    let run = |text: &str| planes(text, &image, "v", RunOptions::default());
    let camera = run("v = transform(\"camera\", point)\n");
    let screen = run("v = transform(\"screen\", point)\n");
    let back = run("v = transform(\"camera\", \"world\", transform(\"world\", \"camera\", point))\n");
    let eye = run("v = direction(point - eye)\n");
    for i in (0..64 * 48).filter(|&i| hit[i]) {
        let near = |a: f32, b: f32, what: &str| {
            assert!((a - b).abs() < 2e-5 * (1.0 + b.abs()), "{what} {i}: {a}, {b}")
        };
        let of = |name: &str, cell: usize| image.variable(name).unwrap().planes[cell][i];
        near(-camera[2][i], of("depth", 0), "depth");
        near(screen[0][i], ((i % 64) as f32 + 0.5) / 64.0, "x");
        near(screen[1][i], 1.0 - ((i / 64) as f32 + 0.5) / 48.0, "y");
        near(1.0 / screen[2][i], of("depth", 0), "z");
        for cell in 0..3 {
            near(back[cell][i], of("point", cell), "there and back");
            near(eye[cell][i], of("I", cell), "eye");
        }
    }
    // Without `I` it is made of the points and the eye; written to a file and read again, the camera is still there.
    let mut without = image.clone();
    without.variables.retain(|v| v.name != "I");
    let bytes = pse::image::encode("a.exr", pse::image::Format::Exr, &without, &Default::default()).unwrap();
    let file = pse::image::read(pse::image::Input::from_bytes("a.exr", bytes), &Default::default()).unwrap();
    let made = planes("v = I\n", &file.load_all().unwrap(), "v", RunOptions::default());
    let derived = planes("v = I + Du(I) * 0\n", &file.load_all().unwrap(), "v", RunOptions::default());
    for i in (0..64 * 48).filter(|&i| hit[i]) {
        for cell in 0..3 {
            let given = image.variable("I").unwrap().planes[cell][i];
            assert!((made[cell][i] - given).abs() < 1e-5 && derived[cell][i] == made[cell][i]);
        }
    }
}

#[test]
fn spaces_are_given_by_options() {
    let image = pse::Image::new(1, 1, []).unwrap();
    let moved: Matrix4 =
        [[2.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 4.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    let options = || RunOptions { spaces: vec![("object".into(), moved)], ..RunOptions::default() };
    let value = |text: &str| planes(text, &image, "v", options()).iter().map(|p| p[0]).collect::<Vec<_>>();
    assert_eq!(value("v = transform(\"object\", [1 2 3])\n"), [3.0, 2.0, 12.0]);
    assert_eq!(value("v = vtransform(\"object\", [1 2 3])\n"), [2.0, 2.0, 12.0]);
    assert_eq!(value("v = transform(\"object\", \"world\", [3 2 12])\n"), [1.0, 2.0, 3.0]);
    assert_eq!(
        value("function f(p)\n    return transform(\"object\", p)\nv = f([1 2 3])\n"),
        [3.0, 2.0, 12.0]
    );
    assert_eq!(value("if begin_frame\n    o = transform(\"object\", [0 0 0])\nv = o\n"), [1.0, 0.0, 0.0]);
    let program = Program::compile("v = 1 + eye\n").unwrap();
    let camera = RunOptions { spaces: vec![("camera".into(), moved)], ..RunOptions::default() };
    let report = program.run(&image, &camera).unwrap();
    assert_eq!(report.image.variables[0].shape, Shape::Vector(3));
    assert_eq!(report.image.variables[0].planes[0][0], 0.5);
    assert!(program.inputs().all(|name| name == "eye"));
}
