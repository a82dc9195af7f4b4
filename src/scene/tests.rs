//! Every scene, seen from outside.

use super::gather::View;
use super::*;
use crate::image::Image;
use glam::DVec3;

fn options(width: usize, height: usize) -> Options {
    Options { width, height, ..Options::default() }
}

fn picture(name: &str, width: usize, height: usize) -> Image<'static> {
    render(name, &options(width, height)).expect(name)
}

/// The variable's planes at a pixel.
fn at(image: &Image, name: &str, pixel: usize) -> DVec3 {
    let planes = &image.variable(name).expect(name).planes;
    DVec3::from_array([0, 1, 2].map(|i| planes.get(i).map_or(0.0, |p| f64::from(p[pixel]))))
}

/// The numbers of `surface` as text: a dot where nothing was hit.
fn silhouette(image: &Image) -> String {
    let surface = &image.variable("surface").expect("surface").planes[0];
    let rows = surface.chunks(image.width).map(|row| {
        row.iter().map(|&s| if s == 0.0 { '.' } else { char::from(b'0' + s as u8) }).collect::<String>()
    });
    rows.collect::<Vec<_>>().join("\n")
}

#[test]
fn the_donut_shows_its_hole() {
    let expected = "
........................
.........111111.........
......111111111111......
.....11111111111111.....
....1111111111111111....
...111111111111111111...
..11111111111111111111..
..11111111111111111111..
..1111111......1111111..
.11111111......11111111.
..11111111....11111111..
..11111111111111111111..
..11111111111111111111..
..11111111111111111111..
...111111111111111111...
....1111111111111111....
.....11111111111111.....
.......1111111111.......
...........11...........
........................
";
    assert_eq!(silhouette(&picture("donut", 24, 20)), expected.trim());
}

#[test]
fn the_vase_has_foot_belly_neck_and_lip() {
    let expected = "
.................
....111111111....
....111111111....
.....1111111.....
.....1111111.....
.....1111111.....
....111111111....
..1111111111111..
..1111111111111..
.111111111111111.
.111111111111111.
.111111111111111.
.111111111111111.
.111111111111111.
..1111111111111..
..1111111111111..
...11111111111...
....111111111....
.....1111111.....
......11111......
......11111......
.....1111111.....
....111111111....
.....1111111.....
.......111.......
.................
";
    assert_eq!(silhouette(&picture("vase", 17, 26)), expected.trim());
}

#[test]
fn surfaces_cover_what_they_should() {
    for (name, surface, low, high) in [
        ("sphere", 1, 0.55, 0.62),
        ("bubble", 1, 0.47, 0.53),
        ("donut", 1, 0.40, 0.70),
        ("vase", 1, 0.30, 0.40),
        ("star", 1, 0.14, 0.18),
        ("star", 2, 0.82, 0.86),
        ("card", 1, 1.0, 1.0),
        ("ocean", 1, 0.50, 0.65),
        ("window", 1, 0.50, 0.85),
        ("plane", 1, 0.60, 0.95),
        ("floor", 1, 0.55, 0.85),
        ("floor", 2, 0.03, 0.15),
        ("floor", 3, 0.03, 0.15),
        ("floor", 4, 0.03, 0.15),
        ("floor", 5, 0.03, 0.15),
    ] {
        let image = picture(name, 120, 120);
        let count = image.variables[0].planes[0].iter().filter(|&&s| s == surface as f32).count();
        let share = count as f64 / 14400.0;
        assert!((low..=high).contains(&share), "surface {surface} of {name} covers {share}");
    }
}

#[test]
fn every_pixel_keeps_the_conventions() {
    for scene in scenes() {
        let image = picture(scene.name, 64, 48);
        let (eye, look_at) = (DVec3::from(scene.eye), DVec3::from(scene.look_at));
        let forward = (look_at - eye).normalize();
        for i in 0..64 * 48 {
            let context = format!("{} at {} {}", scene.name, i % 64, i / 64);
            let get = |name| at(&image, name, i);
            assert!((get("I").length() - 1.0).abs() < 1e-6, "{context}");
            if get("surface").x == 0.0 {
                for name in ["point", "normal", "uv", "dPdu", "dPdv"] {
                    assert_eq!(get(name), DVec3::ZERO, "{name} of {context}");
                }
                assert_eq!(get("depth").x, 1e10, "{context}");
                continue;
            }
            assert!(get("surface").x <= scene.surfaces.len() as f64);
            let (point, normal) = (get("point"), get("normal"));
            let far = 1e-6 * (point - eye).length();
            assert!((normal.length() - 1.0).abs() < 1e-6, "{context}");
            assert!(normal.dot(get("I")) < 1e-6, "{context}: the normal faces away");
            for name in ["dPdu", "dPdv"] {
                assert!(
                    normal.dot(get(name)).abs() < 1e-6 * get(name).length().max(1.0),
                    "{name} of {context}"
                );
            }
            let handed = get("dPdu").cross(get("dPdv")).dot(normal);
            assert!(handed > 0.0, "{context}: left-handed by {handed}");
            assert!((get("depth").x - (point - eye).dot(forward)).abs() < far, "{context}");
            assert!(((point - eye).normalize() - get("I")).length() < 1e-6, "{context}");
        }
    }
}

#[test]
fn derivatives_are_those_of_the_point_over_uv() {
    for scene in scenes() {
        let view = View::new(scene, &options(40, 30)).expect(scene.name);
        let (mut tested, mut hits) = (0, 0);
        for i in 0..40 * 30 {
            let (column, row) = (f64::from(i % 40) + 0.5, f64::from(i / 40) + 0.5);
            let Some((surface, hit)) = view.nearest(&view.camera.ray(column, row)) else { continue };
            hits += 1;
            for (right, down) in [(1e-4, 0.0), (0.0, 1e-4)] {
                let Some((other, next)) = view.nearest(&view.camera.ray(column + right, row + down)) else {
                    continue;
                };
                let step = next.uv - hit.uv;
                // Over an edge, a seam or a silhouette there is no derivative to compare.
                if other != surface || step.x.abs() > 0.5 || next.normal.dot(hit.normal) < 0.9999 {
                    continue;
                }
                let moved = next.point - hit.point;
                let foretold = hit.dpdu * step.x + hit.dpdv * step.y;
                let error = (moved - foretold).length();
                assert!(
                    error < 2e-2 * moved.length(),
                    "{} at {column} {row}: {moved} {foretold}",
                    scene.name
                );
                tested += 1;
            }
        }
        assert!(tested > 2 * hits * 9 / 10, "{}: only {tested} of {hits} pixels", scene.name);
    }
}

#[test]
fn points_lie_on_their_surfaces() {
    let residual = |name: &str, distance: &dyn Fn(DVec3) -> f64| {
        let image = picture(name, 80, 60);
        for i in (0..4800).filter(|&i| at(&image, "surface", i).x > 0.0) {
            let point = at(&image, "point", i);
            assert!(distance(point).abs() < 1e-6 * point.length().max(1.0), "{name}: {point}");
        }
    };
    residual("sphere", &|p| p.length() - 1.0);
    residual("donut", &|p| libm::hypot(libm::hypot(p.x, p.y) - 1.0, p.z) - 0.5);
    residual("ocean", &|p| p.z);
    residual("window", &|p| p.y);
    residual("card", &|p| p.y);
}

#[test]
fn the_bubble_has_a_far_side() {
    let image = picture("bubble", 50, 40);
    for i in (0..2000).filter(|&i| at(&image, "surface", i).x > 0.0) {
        let (near, far) = (at(&image, "point", i), at(&image, "exit_point", i));
        assert!((far.length() - 1.0).abs() < 1e-6);
        assert!((far - at(&image, "exit_normal", i)).length() < 1e-6, "the normal points out of the bubble");
        assert!((far - near).dot(at(&image, "I", i)) > 0.0);
        assert!((far - near).cross(at(&image, "I", i)).length() < 1e-6, "both are on the ray");
    }
    assert!(picture("sphere", 2, 2).variable("exit_point").is_none());
}

#[test]
fn rows_cross_the_outlines_no_more_often_than_the_shapes_do() {
    for (name, most) in [("donut", 4), ("vase", 4), ("sphere", 2), ("window", 2), ("ocean", 0)] {
        let image = picture(name, 300, 225);
        for row in image.variables[0].planes[0].chunks(300) {
            let changes = row.windows(2).filter(|p| p[0] != p[1]).count();
            assert!(changes <= most, "{name} changes {changes} times along a row");
        }
    }
}

#[test]
fn neighbouring_normals_of_the_vase_show_no_speckles() {
    // A pixel unlike both neighbours in a row, which are alike, would be a ray that slipped through the wall.
    let image = picture("vase", 200, 300);
    for i in 1..200 * 300 - 1 {
        let [a, b, c] = [i - 1, i, i + 1].map(|i| at(&image, "normal", i));
        assert!(a.dot(c) < 0.99 || a.dot(b) > 0.9, "speckle at {} {}", i % 200, i / 200);
    }
}

#[cfg(feature = "threads")]
#[test]
fn the_result_does_not_depend_on_threads() {
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| picture("floor", 150, 100))
    };
    let (one, two) = (on(1), on(2));
    for (a, b) in one.variables.iter().zip(&two.variables) {
        for (p, q) in a.planes.iter().zip(&b.planes) {
            assert!(p.iter().zip(q.iter()).all(|(x, y)| x.to_bits() == y.to_bits()), "{} differs", a.name);
        }
    }
}

#[test]
fn any_size_will_do_and_nothing_is_ever_nan() {
    for scene in scenes() {
        for (width, height) in [(1, 1), (1, 9), (9, 1), (2, 2), (5, 200)] {
            let image = picture(scene.name, width, height);
            for variable in &image.variables {
                assert_eq!(variable.shape.cells(), variable.planes.len(), "{}", variable.name);
                for plane in &variable.planes {
                    assert_eq!(plane.len(), width * height);
                    assert!(plane.iter().all(|v| v.is_finite()), "{} of {}", variable.name, scene.name);
                }
            }
        }
    }
}

#[test]
fn odd_cameras_give_no_nan() {
    let eyes = [[0.0, 0.0, 30.0], [0.0, -30.0, 5.0], [30.0, 1.0, 1e-3], [-9e4, 9e4, 9e4], [0.0, 40.0, 2.0]];
    for scene in scenes() {
        for eye in eyes {
            if scene.name == "window" && eye[1] == 0.0 {
                // In the pane's own plane, which is an error.
                continue;
            }
            for fov in [1e-9, 1.0, 179.9] {
                let options =
                    Options { eye: Some(eye), look_at: Some([0.0; 3]), fov: Some(fov), ..options(15, 15) };
                let image = render(scene.name, &options).expect(scene.name);
                let mut values = image.variables.iter().flat_map(|v| &v.planes).flat_map(|p| p.iter());
                assert!(values.all(|v| v.is_finite()), "{} from {eye:?}", scene.name);
            }
        }
    }
}

#[test]
fn scale_enlarges_the_space_and_keeps_the_picture() {
    let (one, ten) = (picture("donut", 40, 30), render("donut", &Options { scale: 10.0, ..options(40, 30) }));
    let ten = ten.expect("a donut");
    assert_eq!(silhouette(&one), silhouette(&ten));
    for i in 0..1200 {
        for name in ["point", "dPdu", "dPdv"] {
            assert!((at(&one, name, i) * 10.0 - at(&ten, name, i)).length() < 1e-4, "{name}");
        }
        for name in ["normal", "uv", "I", "surface"] {
            assert_eq!(at(&one, name, i), at(&ten, name, i), "{name}");
        }
    }
}

#[test]
fn errors_say_what_to_do() {
    let say = |name: &str, options: Options| render(name, &options).expect_err("an error").to_string();
    let small = || options(4, 4);
    let seen_from = |eye| Options { eye: Some(eye), ..small() };
    assert_eq!(say("donat", small()), "there is no scene `donat`; did you mean `donut`?");
    assert!(say("qqq", small()).ends_with("plane, floor"), "{}", say("qqq", small()));
    assert_eq!(
        say("donut", options(0, 480)),
        "a picture of 0x480 has no pixels; give at least one column and one row"
    );
    assert!(say("donut", options(usize::MAX, 2)).ends_with("is too large; give at most 1073741824 pixels"));
    assert_eq!(
        say("sphere", seen_from([0.5, 0.0, 0.0])),
        "the eye is in the sphere; move it out, for example to 0,-6,0"
    );
    assert!(say("donut", seen_from([1.2, 0.0, 0.1])).starts_with("the eye is in the donut"));
    assert!(say("vase", seen_from([3.2, 0.0, 5.75])).starts_with("the eye is in the vase"));
    assert!(say("ocean", seen_from([0.0, -5.0, -1.0])).starts_with("the eye is in the water"));
    assert!(say("floor", seen_from([2.05, 0.35, 0.5])).starts_with("the eye is in the cube"));
    assert!(say("window", seen_from([9.0, 0.0, 3.0])).starts_with("the eye is in the window"));
    let away = Options { eye: Some([0.0, -5.0, 0.0]), look_at: Some([0.0, -9.0, 0.0]), ..small() };
    assert!(say("card", away).contains("look towards 0,0,0"));
    for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(say("donut", Options { scale, ..small() }).contains("0.001 to 1000"));
    }
    let still = Options { look_at: Some([4.0, 0.0, 8.0]), scale: 2.0, ..seen_from([4.0, 0.0, 8.0]) };
    assert!(say("donut", still).contains("4,0,8"));
    let error = render("donut", &options(0, 1)).expect_err("an error");
    assert_eq!(error.diagnostic().hints, [error.hint()]);
}
