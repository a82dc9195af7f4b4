//! The camera of images whose header has none: options, and what the points tell.

use super::{Folder, gbuffer, load};
use libm::{cosf, sinf};
use pse::image::{WriteOptions, write};
use pse::{Image, Shape, Variable, scene};
use std::path::Path;

const TILED: &str = "donut_320x180_plain_tiled64.exr";

/// Writes a scene as a renderer does that leaves its camera out.
fn blind(f: &Folder, name: &str, scene: &str, options: &scene::Options) {
    let mut image = scene::render(scene, options).expect(scene);
    image.metadata.attributes = Default::default();
    image.variables.retain(|v| v.name != "I");
    write(&f.path(name), &image, &WriteOptions::default()).expect(name);
}

/// Writes an image whose pixels see these points.
fn seen(f: &Folder, name: &str, point: impl Fn(f32, f32) -> [f32; 3]) {
    let points: Vec<[f32; 3]> = (0..64 * 48).map(|i| point((i % 64) as f32, (i / 64) as f32)).collect();
    let planes = [0, 1, 2].map(|i| points.iter().map(|p| p[i]).collect::<Vec<f32>>());
    let point = Variable::new("point", Shape::Vector(3), planes).expect("points");
    let image = Image::new(64, 48, [point]).expect("an image");
    write(&f.path(name), &image, &WriteOptions::default()).expect(name);
}

fn largest(a: &[Vec<f32>], b: &[Vec<f32>]) -> f32 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.map(|(a, b)| if a == b { 0.0 } else { (a - b).abs() }).fold(0.0, f32::max)
}

#[test]
fn a_render_without_a_camera_has_i_and_eye() {
    let f = Folder::new();
    f.write("i.pse", "color = surface ? I : 0\nwhere = eye\n");
    for file in
        [TILED, "donut_320x180_plain_datawindow_crop.exr", "donut_320x180_plain_datawindow_overscan.exr"]
    {
        let file = gbuffer(file);
        let ended = f.good(&format!("run i.pse -i {file} --vars color,where -o found.exr"));
        assert!(
            ended.err.contains("camera found from the points: eye [3 -11.2 5.25], residual 0"),
            "{}",
            ended.err
        );
        let ended =
            f.good(&format!("run i.pse -i {file} --vars color,where -o given.exr --eye 3,-11.2,5.25"));
        assert!(!ended.err.contains("camera found"), "{}", ended.err);
        assert!(largest(&f.planes("found.exr", "color"), &f.planes("given.exr", "color")) < 2e-6);
        assert!(largest(&f.planes("found.exr", "where"), &f.planes("given.exr", "where")) < 1e-4);
        // What the file holds stays what it is: no attributes are added, but for the software that wrote it.
        let attributes = |path: &Path| {
            let image = load(path);
            image.metadata.attributes.iter().filter(|(name, _)| *name != "software").count()
        };
        assert_eq!(attributes(&f.path("found.exr")), attributes(file.as_ref()));
    }
    let ended = f.good(&format!("run i.pse -i {} -o found.exr -q", gbuffer(TILED)));
    assert!(ended.err.is_empty(), "{}", ended.err);
}

#[test]
fn a_render_without_a_camera_has_its_spaces() {
    let f = Folder::new();
    f.write("s.pse", "s = transform(\"screen\", point)\nc = transform(\"camera\", point)\noff = surface ? norm([s.x s.y] * resolution - [pixel.x resolution.y - pixel.y]) : 0\ndeep = surface ? abs(c.z + depth) : 0\n");
    for file in ["donut_320x180_blender50_singlepart_f32_zip.exr", "donut_320x180_multipart_named.exr"] {
        f.good(&format!("run s.pse -i {} --vars off,deep -o s.exr", gbuffer(file)));
        for (name, limit) in [("off", 0.02), ("deep", 1e-4)] {
            let worst = f.planes("s.exr", name).concat().into_iter().fold(0.0, f32::max);
            assert!(worst < limit, "{file}: {name} {worst}");
        }
    }
    f.write("w.pse", "s = transform(\"screen\", point)\noff = surface ? norm([s.x s.y] * resolution - [pixel.x resolution.y - pixel.y]) : 0\n");
    for file in ["donut_320x180_plain_datawindow_crop.exr", "donut_320x180_plain_datawindow_overscan.exr"] {
        f.good(&format!("run w.pse -i {} -o s.exr", gbuffer(file)));
        let worst = f.planes("s.exr", "off").concat().into_iter().fold(0.0, f32::max);
        assert!(worst < 0.02, "{file}: {worst}");
    }
}

#[test]
fn parts_of_a_picture_have_the_camera_of_the_whole() {
    let f = Folder::new();
    f.write("i.pse", "color = 100 * transform(\"camera\", point) + I\n");
    let file = gbuffer(TILED);
    f.good(&format!("run i.pse -i {file} -o whole.exr"));
    f.good(&format!("run i.pse -i {file} -o small.exr --memory 64 --threads 1"));
    assert_eq!(f.planes("small.exr", "color"), f.planes("whole.exr", "color"));
    for tile in 1..=4 {
        f.good(&format!("run i.pse -i {file} -o t.{{tile}}.exr --tile {tile}/2x2"));
    }
    f.good("join t.{tile}.exr --tiles 2x2 -o joined.exr");
    assert_eq!(f.planes("joined.exr", "color"), f.planes("whole.exr", "color"));
    f.good(&format!("run i.pse -i {file} -o region.exr --region 160,70,192,90"));
    let (region, whole) = (f.planes("region.exr", "color"), f.planes("whole.exr", "color"));
    for (part, all) in region.iter().zip(&whole) {
        for row in 0..20 {
            assert_eq!(part[row * 32..][..32], all[(row + 10) * 64 + 10..][..32]);
        }
    }
}

#[test]
fn each_frame_has_its_own_camera() {
    let f = Folder::new();
    for (frame, eye) in [(1, [4.0, -7.0, 5.0]), (2, [-3.0, -6.0, 2.0])] {
        let options = scene::Options {
            width: 96,
            height: 72,
            eye: Some(eye),
            look_at: Some([0.0; 3]),
            fov: Some(40.0),
            ..Default::default()
        };
        blind(&f, &format!("g.{frame}.exr"), "floor", &options);
    }
    let ended = f.good("run -e eye -i g.#.exr -o e.#.exr --frames 1-2");
    for (file, eye) in [("e.1.exr", [4.0, -7.0, 5.0]), ("e.2.exr", [-3.0, -6.0, 2.0])] {
        let found: Vec<f32> = f.planes(file, "color").iter().map(|p| p[0]).collect();
        assert!(found.iter().zip(eye).all(|(a, b)| (a - b).abs() < 1e-4), "{found:?}");
    }
    assert!(ended.err.contains("g.1.exr: camera found from the points: eye [4 -7 5]"), "{}", ended.err);
    assert!(ended.err.contains("g.2.exr: camera found from the points: eye [-3 -6 2]"), "{}", ended.err);
}

#[test]
fn all_commands_find_it() {
    let f = Folder::new();
    let file = gbuffer(TILED);
    f.write("i.pse", "where = eye\ncolor = I\n");
    let ended = f.good(&format!("trace i.pse -i {file} --pixel 180,80"));
    assert!(ended.err.contains("camera found from the points: eye [3 -11.2 5.25]"), "{}", ended.err);
    assert!(ended.text.contains("-11.2"), "{}", ended.text);
    let ended = f.good(&format!("check i.pse -i {file}"));
    assert!(ended.err.is_empty(), "{}", ended.err);
    let ended = f.pse_with(&["repl", "-i", &file], b"round(100 * eye)\nround(100 * eye)\n");
    assert!(ended.code == 0 && ended.text.contains("[300 -1120 525]"), "{}\n{}", ended.text, ended.err);
    assert_eq!(ended.err.matches("camera found").count(), 1, "{}", ended.err);
    f.write("up.pse", "function velocity(p)\n    return [0 0 1]\n");
    let ended = f.good(&format!("flow up.pse -i {file} --every 16 --steps 2 -o o.exr"));
    assert!(ended.err.contains("camera found from the points: eye [3 -11.2 5.25]"), "{}", ended.err);
    assert!(
        f.good(&format!("info {file}"))
            .text
            .contains("note: Camera found from the points: eye [3 -11.2 5.25]")
    );
    // A scene's file has its camera in the header, and a program's own `eye` is its own.
    f.good("scene donut -o g.exr --size 32x24");
    assert!(!f.good("info g.exr").text.contains("amera found"));
    f.write("own.pse", "param eye = [0 -5 5]\nI = direction(point - eye)\ncolor = I\n");
    for run in [format!("run own.pse -i {file} -o a.exr"), "run i.pse -i g.exr -o a.exr".into()] {
        let ended = f.good(&run);
        assert!(!ended.err.contains("camera found"), "{}", ended.err);
    }
}

#[test]
fn options_give_the_camera_of_an_image() {
    let f = Folder::new();
    let options = scene::Options {
        width: 96,
        height: 72,
        eye: Some([4.0, -7.0, 5.0]),
        look_at: Some([0.0, 0.0, 0.5]),
        fov: Some(40.0),
        ..Default::default()
    };
    blind(&f, "g.exr", "floor", &options);
    f.write(
        "s.pse",
        "s = transform(\"screen\", point)\nc = transform(\"camera\", point)\ncolor = surface ? s + c : 0\n",
    );
    f.good("run s.pse -i g.exr -o found.exr");
    let ended = f.good("run s.pse -i g.exr -o given.exr --eye 4,-7,5 --look-at 0,0,0.5 --fov 40");
    assert!(!ended.err.contains("camera found"), "{}", ended.err);
    assert!(largest(&f.planes("found.exr", "color"), &f.planes("given.exr", "color")) < 1e-4);
    // A header with the matrix to the screen alone tells where the eye is.
    f.good("scene floor -o h.exr --size 96x72 --eye 4,-7,5 --look-at 0,0,0.5 --fov 40");
    let mut image = load(&f.path("h.exr"));
    let screen = image.metadata.attributes.matrix("worldToNDC").expect("a matrix");
    image.metadata.attributes = Default::default();
    image.metadata.attributes.set_matrix("worldToNDC", &screen);
    write(&f.path("ndc.exr"), &image, &WriteOptions::default()).expect("a file");
    let ended = f.good("run -e eye -i ndc.exr -o e.exr");
    assert!(!ended.err.contains("camera found"), "{}", ended.err);
    let found: Vec<f32> = f.planes("e.exr", "color").iter().map(|p| p[0]).collect();
    assert!(found.iter().zip([4.0, -7.0, 5.0]).all(|(a, b)| (a - b).abs() < 1e-4), "{found:?}");
}

/// The whole message where no camera is found.
#[test]
fn messages_say_why_there_is_no_camera() {
    let f = Folder::new();
    f.write("eye.pse", "color = direction(point - eye)\n");
    f.write("i.pse", "color = I\n");
    f.write("space.pse", "color = transform(\"camera\", point)\n");
    f.write("up.pse", "function velocity(p)\n    return [0 0 1]\n");
    let bump = |x: f32, y: f32| sinf(x / 5.0) + cosf(y / 7.0) + (x / 16.0).floor() % 2.0;
    seen(&f, "parallel.exr", |x, y| [x, bump(x, y), -y]);
    seen(&f, "panorama.exr", |x, y| {
        let (a, b) = (x / 64.0 * std::f32::consts::TAU, (0.5 - y / 48.0) * std::f32::consts::PI);
        [sinf(a) * cosf(b), cosf(a) * cosf(b), sinf(b)].map(|d| d * (9.0 + bump(x, y)))
    });
    blind(&f, "flat.exr", "card", &scene::Options { width: 64, height: 48, ..Default::default() });
    seen(&f, "few.exr", |x, y| if x + y < 5.0 { [x, 1.0 + y, x * y] } else { [0.0; 3] });
    f.good("run -e [0.5,0.5,0.5] --scene card --size 8x8 -o picture.png");
    for (name, command) in [
        ("parallel", "run eye.pse -i parallel.exr -o a.png"),
        ("panorama", "run i.pse -i panorama.exr -o a.png"),
        ("flat", "run space.pse -i flat.exr -o a.png"),
        ("few", "run eye.pse -i few.exr -o a.png"),
        ("no_points", "run -e eye -i picture.png -o a.png"),
        ("flow", "flow up.pse -i flat.exr -o a.png"),
    ] {
        let ended = f.pse(command);
        assert_eq!(ended.code, 1, "pse {command}\n{}", ended.err);
        insta::with_settings!({ snapshot_path => "../errors/camera", prepend_module_to_snapshot => false }, {
            insta::assert_snapshot!(name, ended.err);
        });
        assert!(!f.path("a.png").exists());
    }
}

#[test]
fn info_warns_of_noisy_points() {
    let f = Folder::new();
    for name in [TILED, "donut_320x180_blender50_antialiased.exr", "donut_480x270_blender50_half_dwaa.exr"] {
        let info = f.good(&format!("info {}", gbuffer(name))).text;
        assert!(!info.contains("jumps from pixel to pixel"), "{name}: {info}");
    }
    // One random sample of a lens in each pixel, focused before what is seen.
    let noise = |x: f32, y: f32, salt: f32| {
        let n = sinf(x * 12.9898 + y * 78.233 + salt * 37.719) * 43_758.547;
        n - n.floor()
    };
    seen(&f, "lens.exr", |x, y| {
        let (angle, radius) = (noise(x, y, 1.0) * std::f32::consts::TAU, 0.2 * noise(x, y, 2.0).sqrt());
        let lens = [radius * cosf(angle), 0.0, radius * sinf(angle)];
        let focus = [(x - 31.5) / 64.0 * 5.0, 5.0, (23.5 - y) / 64.0 * 5.0];
        let far = 9.0 + sinf(x / 9.0);
        std::array::from_fn(|i| lens[i] + (focus[i] - lens[i]) * far / 5.0)
    });
    let info = f.good("info lens.exr").text;
    assert!(info.contains("`point` jumps from pixel to pixel"), "{info}");
}
