use super::*;
use crate::image::{Image, Input, ReadOptions, Variable, read};
use crate::scene;
use crate::shape::Shape;
use glam::DVec3;

#[test]
fn a_camera_is_found_from_what_it_saw() {
    let options = scene::Options { width: 90, height: 60, ..scene::Options::default() };
    let mut image = scene::render("floor", &options).expect("a scene");
    let written = Projection::of(&image).expect("a camera");
    image.metadata.attributes = Default::default();
    let found = Projection::of(&image).expect("a camera");
    assert!(found.eye().distance(written.eye()) < 1e-3, "{} {}", found.eye(), written.eye());
    for point in [[0.0, 0.0, 0.0], [1.0, -2.0, 1.5], [-3.0, 4.0, 0.2]].map(glam::DVec3::from) {
        assert!(found.place(point).distance(written.place(point)) < 1e-2);
        assert!((found.depth(point) - written.depth(point)).abs() < 1e-3);
    }
    // What is written into a header is read from it again.
    found.note(&mut image.metadata);
    let again = Projection::of(&image).expect("a camera");
    assert!(again.eye().distance(written.eye()) < 1e-3);
    let camera = image.metadata.attributes.matrix("worldToCamera").expect("a matrix");
    let original = scene::render("floor", &options).expect("a scene").metadata.attributes;
    for (a, b) in
        camera.iter().flatten().zip(original.matrix("worldToCamera").expect("a matrix").iter().flatten())
    {
        assert!((a - b).abs() < 1e-3, "{camera:?}");
    }
    // A plane alone fits many cameras.
    let mut plane = scene::render("card", &options).expect("a scene");
    plane.metadata.attributes = Default::default();
    assert_eq!(Projection::of(&plane).err(), Some(ResectionError::Flat));
}

/// Points and numbers of surfaces, and the metadata, of a file of the tests.
fn gbuffer(name: &str) -> Image<'static> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gbuffers").join(name);
    let file = read(Input::Path(path), &ReadOptions::default()).expect("a file");
    file.rows(&["point", "surface"]).expect("variables").read(0..file.size()[1]).expect("rows")
}

/// The distance of the found eye from the right one, and the largest angle in radians between the right `I` and the one from
/// the found eye.
fn errors(image: &Image<'_>, eye: DVec3) -> [f64; 2] {
    let found = resect(image).unwrap_or_else(|e| panic!("{e}")).projection.eye();
    let angle = |point: [f32; 3]| {
        let point = DVec3::from(point.map(f64::from));
        (point - eye).normalize().cross((point - found).normalize()).length()
    };
    let angles = surfaces(image).flatten().filter(|p| *p != [0.0; 3]).map(angle);
    [found.distance(eye), angles.fold(0.0, f64::max)]
}

/// The figures of docs/gbuffers.md.
#[test]
fn cameras_of_built_in_scenes_are_found_to_single_precision() {
    let mut worst = [0f64; 2];
    for scene in ["donut", "vase", "sphere", "bubble", "star", "floor"] {
        for (size, eye, fov) in [
            ([320, 240], None, None),
            ([640, 480], Some([4.0, -7.0, 5.0]), None),
            ([64, 48], Some([-6.0, -4.0, 3.0]), Some(50.0)),
            ([200, 300], Some([-3.0, -5.0, 2.0]), Some(70.0)),
        ] {
            let options = scene::Options {
                width: size[0],
                height: size[1],
                eye,
                look_at: eye.map(|_| [0.0; 3]),
                fov,
                ..scene::Options::default()
            };
            let mut image = scene::render(scene, &options).expect("a scene");
            let written = Projection::of(&image).expect("a camera");
            image.metadata.attributes = Default::default();
            let eye = eye.map_or(written.eye(), DVec3::from);
            let [distance, angle] = errors(&image, eye);
            worst = [worst[0].max(distance / eye.length()), worst[1].max(angle)];
        }
    }
    println!("built-in scenes: {worst:?}");
    assert!(worst[0] < 1e-6 && worst[1] < 1e-6, "{worst:?}");
}

#[test]
fn cameras_of_renders_are_found() {
    let eye = DVec3::new(3.0, -11.2, 5.25);
    for (name, distance, angle) in [
        ("donut_480x270_plain_f32_zip.exr", 1e-4, 1e-5),
        ("donut_320x180_blender50_antialiased.exr", 1e-4, 1e-5),
        ("donut_320x180_plain_nonfinite.exr", 1e-4, 1e-5),
        ("donut_320x180_plain_datawindow_crop.exr", 1e-4, 1e-5),
        ("donut_320x180_plain_datawindow_overscan.exr", 1e-4, 1e-5),
        ("donut_320x180_plain_filtered_ids.exr", 2e-3, 2e-4),
        ("donut_480x270_allhalf_piz.exr", 2e-2, 2e-3),
        ("donut_480x270_blender50_half_dwaa.exr", 5e-2, 5e-3),
    ] {
        let image = gbuffer(name);
        let found = errors(&image, eye);
        println!("{name}: {found:?}, residual {}", resect(&image).map_or(f64::NAN, |found| found.residual));
        assert!(found[0] < distance && found[1] < angle, "{name}: {found:?}");
    }
}

/// An image whose pixels see these points, all of surface 1.
fn seen(size: [usize; 2], point: impl Fn(f64, f64) -> DVec3) -> Image<'static> {
    let points: Vec<DVec3> = (0..size[0] * size[1])
        .map(|i| point((i % size[0]) as f64 + 0.5, (i / size[0]) as f64 + 0.5))
        .collect();
    let plane = |of: fn(&DVec3) -> f64| points.iter().map(|p| of(p) as f32).collect::<Vec<f32>>();
    let variables = [
        Variable::new("point", Shape::Vector(3), [plane(|p| p.x), plane(|p| p.y), plane(|p| p.z)]),
        Variable::new("surface", Shape::Scalar, [vec![1.0; points.len()]]),
    ];
    Image::new(size[0], size[1], variables.map(|v| v.expect("a variable"))).expect("an image")
}

/// A bumpy wall about `far` before the eye.
fn bumps(x: f64, y: f64, far: f64) -> f64 {
    far + libm::sin(x / 7.0) + libm::cos(y / 5.0) + f64::from((x as u32 / 16) % 2)
}

/// A number from 0 to 1 that differs from pixel to pixel.
fn noise(x: f64, y: f64, salt: f64) -> f64 {
    let x = libm::sin(x * 12.9898 + y * 78.233 + salt * 37.719) * 43758.5453;
    x - x.floor()
}

#[test]
fn what_is_no_pinhole_camera_is_not_taken_for_one() {
    let size = [160, 120];
    let orthographic = seen(size, |x, y| DVec3::new(x / 20.0, bumps(x, y, 9.0), -y / 20.0));
    assert_eq!(resect(&orthographic).err(), Some(ResectionError::Orthographic));
    let panorama = seen(size, |x, y| {
        let (longitude, latitude) =
            (x / 160.0 * std::f64::consts::TAU, (0.5 - y / 120.0) * std::f64::consts::PI);
        let across = libm::cos(latitude);
        let direction =
            DVec3::new(libm::sin(longitude) * across, libm::cos(longitude) * across, libm::sin(latitude));
        direction * bumps(x, y, 9.0)
    });
    assert!(
        matches!(resect(&panorama).err(), Some(ResectionError::NotPinhole(_))),
        "{:?}",
        resect(&panorama)
    );
    for round in [1.0, 2048.0] {
        // A plane askew, exact to single precision or rounded as halves are.
        let flat = seen(size, |x, y| {
            let ray = DVec3::new((x - 80.0) / 100.0, 1.0, (60.0 - y) / 100.0);
            let point = ray * 8.0 / ray.dot(DVec3::new(0.2, 1.0, 0.3));
            if round > 1.0 { (point * round / 8.0).round() * 8.0 / round } else { point }
        });
        assert_eq!(resect(&flat).err(), Some(ResectionError::Flat), "{round}");
    }
    let few = seen([8, 6], |x, y| DVec3::new(x - 4.0, bumps(x, y, 9.0), 3.0 - y));
    assert_eq!(resect(&few).err(), Some(ResectionError::TooFew(48)));
    let none = seen([0, 0], |_, _| DVec3::ZERO);
    assert_eq!(resect(&none).err(), Some(ResectionError::TooFew(0)));
}

/// What a perspective camera at the origin sees, looking along y.
fn perspective(size: [usize; 2], scale: DVec3) -> Image<'static> {
    let [w, h] = size.map(|n| n as f64);
    seen(size, |x, y| DVec3::new((x - w / 2.0) / w, 1.0, (h / 2.0 - y) / w) * scale * bumps(x, y, 9.0))
}

#[test]
fn odd_cameras_are_found() {
    // Mirrored, squeezed, far away from the origin, with a constant point as background, without numbers of surfaces.
    for scale in [DVec3::ONE, DVec3::new(-1.0, 1.0, 1.0), DVec3::new(2.0, 1.0, 1.0), DVec3::splat(1e-3)] {
        let mut image = perspective([160, 120], scale);
        let found = resect(&image).unwrap_or_else(|e| panic!("{scale}: {e}"));
        assert!(found.projection.eye().length() < 1e-4 * scale.y, "{scale}: {}", found.projection.eye());
        // x to the right, y to the top, and the camera looks along -z.
        let [camera, screen] = found.spaces();
        let expected = [scale.x.signum(), 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0];
        for (a, b) in camera.iter().take(3).flat_map(|row| &row[..3]).zip(expected) {
            assert!((f64::from(*a) - b).abs() < 1e-4, "{scale}: {camera:?}");
        }
        assert!(screen.iter().flatten().all(|x| x.is_finite()));
        for plane in &mut image.variables[1].planes {
            plane.to_mut().fill(0.0);
        }
        for plane in &mut image.variables[0].planes {
            plane.to_mut()[..6000].fill(7.0);
        }
        let found = resect(&image).unwrap_or_else(|e| panic!("{scale}: {e}"));
        assert!(found.projection.eye().length() < 1e-4 * scale.y, "{scale}: {}", found.projection.eye());
    }
}

#[test]
fn bands_do_not_change_what_is_found() {
    let image = perspective([400, 300], DVec3::ONE);
    let whole = resect(&image).expect("a camera");
    for rows in [1, 7, 64, 299] {
        let mut sampler = PointSampler::new(&image);
        for top in (0..300).step_by(rows) {
            let bottom = 300.min(top + rows);
            let part = |v: &Variable<'_>| {
                let planes = v.planes.iter().map(|p| p[top * 400..bottom * 400].to_vec());
                Variable::new(&v.name, v.shape.clone(), planes.collect::<Vec<_>>()).expect("a variable")
            };
            let mut band = Image::new(400, bottom - top, image.variables.iter().map(part)).expect("a band");
            band.metadata.origin = [0, top as i32];
            sampler.add(&band);
        }
        let found = sampler.resect().expect("a camera");
        assert_eq!(found.spaces(), whole.spaces(), "{rows}");
        assert_eq!(found.projection.eye(), whole.projection.eye(), "{rows}");
    }
}

fn jumps(image: &Image<'_>) -> Jumps {
    let mut counter = JumpCounter::default();
    counter.add(image);
    counter.finish(resect(image).ok().map(|found| found.projection).as_ref())
}

#[test]
fn clean_points_do_not_jump() {
    for name in [
        "donut_480x270_plain_f32_zip.exr",
        "donut_320x180_blender50_antialiased.exr",
        "donut_320x180_plain_nonfinite.exr",
        "donut_320x180_plain_datawindow_crop.exr",
        "donut_320x180_plain_filtered_ids.exr",
        "donut_480x270_allhalf_piz.exr",
        "donut_480x270_blender50_half_dwaa.exr",
    ] {
        let found = jumps(&gbuffer(name));
        let lossy = name.contains("dwaa");
        assert!(!found.noisy && (lossy || found.jumps == 0) && found.tested > 1000, "{name}: {found:?}");
    }
    for scene in scene::scenes() {
        let options = scene::Options { width: 120, height: 90, ..scene::Options::default() };
        let found = jumps(&scene::render(scene.name, &options).expect("a scene"));
        assert!(!found.noisy, "{}: {found:?}", scene.name);
    }
    // Hairs of one surface before another part of it: each point is on its pixel's ray.
    let hair = seen([160, 120], |x, y| {
        let far = if noise(x, y, 0.0) < 0.3 { 6.0 } else { 9.0 };
        DVec3::new((x - 80.0) / 160.0, 1.0, (60.0 - y) / 160.0) * far
    });
    let found = jumps(&hair);
    assert!(!found.noisy && found.jumps == 0, "{found:?}");
}

#[test]
fn random_samples_of_a_lens_jump() {
    // A wide lens focused at 5: what lies at about 9 is blurred by some seven pixels. Half of the picture is.
    let size = [160, 120];
    let blurred = seen(size, |x, y| {
        let angle = std::f64::consts::TAU * noise(x, y, 1.0);
        let radius = 0.5 * noise(x, y, 2.0).sqrt();
        let lens = DVec3::new(radius * libm::cos(angle), 0.0, radius * libm::sin(angle));
        let focus = DVec3::new((x - 80.0) / 160.0, 1.0, (60.0 - y) / 160.0) * 5.0;
        let far = if x > 80.0 { bumps(x, y, 9.0) } else { bumps(x, y, 0.0) * 0.02 + 5.0 };
        lens + (focus - lens) * far / 5.0
    });
    let found = jumps(&blurred);
    assert!(found.noisy, "{found:?} {:?}", resect(&blurred));
}
