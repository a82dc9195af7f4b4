//! Solids: surfaces found and missed, normals, meshes, what is soft.

use pse::mesh::Mesh;
use pse::solid::{Isosurface, SolidOptions};
use pse::{Compiler, Image, PixelValue, RunOptions};
use std::collections::HashMap;

fn options(width: usize, height: usize) -> SolidOptions {
    let mut options = SolidOptions::default();
    (options.view.width, options.view.height) = (width, height);
    options
}

fn solid(text: &str, options: &SolidOptions) -> Isosurface<'static> {
    Isosurface::new(&Compiler::new(), "solid", text, options, &RunOptions::default()).expect("a solid")
}

fn plane<'a>(image: &'a Image<'_>, name: &str, i: usize) -> &'a [f32] {
    &image.variable(name).unwrap_or_else(|| panic!("{name}")).planes[i]
}

fn vector(image: &Image<'_>, name: &str, pixel: usize) -> [f64; 3] {
    [0, 1, 2].map(|i| f64::from(plane(image, name, i)[pixel]))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Where a ray meets a sphere of that radius about the origin.
fn to_sphere(eye: [f64; 3], direction: [f64; 3], radius: f64) -> Option<f64> {
    let along = dot(eye, direction);
    let square = along * along - dot(eye, eye) + radius * radius;
    (square > 0.0).then(|| -along - square.sqrt())
}

const EYE: [f64; 3] = [1.0, -5.0, 2.0];

fn seen_from_eye(width: usize, height: usize) -> SolidOptions {
    let mut options = options(width, height);
    (options.view.eye, options.view.look_at, options.view.fov) = (Some(EYE), Some([0.0; 3]), Some(32.0));
    options
}

/// Pixels that differ from the sphere's formula by more than a hair: holes, and what is where nothing should be.
fn wrong(image: &Image<'_>, radius: f64) -> usize {
    let differs = |pixel: &usize| {
        let ray = vector(image, "I", *pixel);
        let seen = plane(image, "surface", 0)[*pixel] > 0.0;
        match to_sphere(EYE, ray, radius) {
            None => seen,
            Some(distance) => {
                let there: [f64; 3] = std::array::from_fn(|i| EYE[i] + distance * ray[i]);
                let found = vector(image, "point", *pixel);
                let away: f64 = (0..3).map(|i| (there[i] - found[i]) * (there[i] - found[i])).sum();
                // Where the ray touches, a rounding is long along it.
                let slant = dot(there, ray).abs() / radius;
                !seen || away.sqrt() > 2e-6 / slant.max(1e-3)
            }
        }
    };
    (0..image.width * image.height).filter(differs).count()
}

#[test]
fn a_ball_has_its_formulas_points() {
    // Distances, the square of it, and far steeper than that.
    for text in [
        "function density(p)\n    return 1 - length(p)",
        "function density(p)\n    return 1 - dot(p, p)",
        "function density(p)\n    return 100 * (1 - dot(p, p) * dot(p, p))",
        "function density(p)\n    return 1 / length(p) - 1",
    ] {
        let image = solid(text, &seen_from_eye(200, 150)).rows(0..150).expect("a picture");
        assert_eq!(wrong(&image, 1.0), 0, "{text}");
    }
}

#[test]
fn thin_shells_have_no_holes() {
    // A fiftieth of the box, and a thousandth.
    for thickness in [0.06, 0.003] {
        let text = format!("function density(p)\n    return {} - abs(length(p) - 1)", thickness / 2.0);
        for lipschitz in [None, Some(1.0)] {
            let options = SolidOptions { lipschitz, ..seen_from_eye(200, 150) };
            let image = solid(&text, &options).rows(0..150).expect("a picture");
            assert_eq!(wrong(&image, 1.0 + thickness / 2.0), 0, "{thickness} {lipschitz:?}");
        }
    }
}

#[test]
fn a_step_ends_and_is_found() {
    let text = "function density(p)\n    return length(p) < 1 ? 1 : -1";
    let image = solid(text, &seen_from_eye(120, 90)).rows(0..90).expect("a picture");
    assert!(wrong(&image, 1.0) <= 2, "{}", wrong(&image, 1.0));
}

const CORAL: &str = "function density(p)
    noise = Noise(4 * p) + 0.5 * Noise(8 * p) + 0.25 * Noise(16 * p)
    return (0.5 + noise) * (1 - smoothstep(0.7, 1.3, length(p))) - 0.4";

#[test]
fn a_noisy_solid_is_what_tiny_steps_find() {
    let (width, height) = (128, 96);
    let solid = solid(CORAL, &seen_from_eye(width, height));
    let image = solid.rows(0..height).expect("a picture");
    let program = Compiler::new().entrance("density", &["point"]).compile("coral", CORAL).expect("a program");
    let run = RunOptions { pixelsize: Some(0.02), ..RunOptions::default() };
    let pixels = width * height;
    let rays: Vec<[f64; 3]> = (0..pixels).map(|i| vector(&image, "I", i)).collect();
    let step = 0.001;
    let mut found = vec![None; pixels];
    let mut near = 3.0;
    while near < 8.0 {
        let point =
            |axis: usize| rays.iter().map(|ray| (EYE[axis] + near * ray[axis]) as f32).collect::<Vec<f32>>();
        let planes = [point(0), point(1), point(2)];
        let inside = |i: usize| planes.iter().all(|p| p[i].abs() <= 1.5);
        if !(0..pixels).any(|i| inside(i) && found[i].is_none()) {
            near += step;
            continue;
        }
        let point = pse::Variable::new("point", pse::Shape::Vector(3), planes.clone()).expect("points");
        let report = program.run(&Image::new(pixels, 1, [point]).expect("points"), &run).expect("densities");
        for (i, &density) in plane(&report.image, "density", 0).iter().enumerate() {
            if inside(i) && found[i].is_none() && density > 0.0 {
                found[i] = Some(near);
            }
        }
        near += step;
    }
    let equal = (0..pixels).filter(|&i| {
        let seen = plane(&image, "surface", 0)[i] > 0.0;
        match found[i] {
            None => !seen,
            Some(distance) => {
                let point = vector(&image, "point", i);
                let own = (0..3).map(|a| (point[a] - EYE[a]) * (point[a] - EYE[a])).sum::<f64>().sqrt();
                seen && (own - distance).abs() < 2.0 * step
            }
        }
    });
    let (equal, hit) = (equal.count(), found.iter().flatten().count());
    println!("{equal} of {pixels} pixels are equal, {hit} of them on the solid");
    assert!(hit > pixels / 5, "{hit}");
    assert!(equal as f64 > 0.999 * pixels as f64, "{equal} of {pixels}");
}

/// Dnoise is the exact gradient of Noise.
const EXACT: &str = "
function gradient(p)
    return 3 * Dnoise(3 * p)";

const BUMPS: &str = "function density(p)
    return Noise(3 * p)";

#[test]
fn exact_and_difference_normals_agree() {
    let options = SolidOptions { level: 0.1, ..seen_from_eye(160, 120) };
    let (exact, by_difference) = (solid(&(BUMPS.to_string() + EXACT), &options), solid(BUMPS, &options));
    assert!(exact.has_gradient() && !by_difference.has_gradient());
    let (a, b) = (exact.rows(0..120).expect("a picture"), by_difference.rows(0..120).expect("a picture"));
    assert!((0..3).all(|i| plane(&a, "point", i) == plane(&b, "point", i)));
    let mut seen = 0;
    for pixel in (0..160 * 120).filter(|&i| plane(&a, "surface", 0)[i] > 0.0) {
        let (a, b) = (vector(&a, "normal", pixel), vector(&b, "normal", pixel));
        assert!((dot(a, a) - 1.0).abs() < 1e-5);
        assert!(dot(a, b) > 0.999, "{a:?} {b:?}");
        seen += 1;
    }
    assert!(seen > 3000, "{seen}");
}

#[test]
fn a_box_cuts_flat() {
    let mut options = SolidOptions { bounds: [[-1.5, -0.5, -1.5], [1.5, 0.5, 1.5]], ..options(60, 60) };
    (options.view.eye, options.view.look_at, options.view.fov) =
        (Some([0.0, -6.0, 0.0]), Some([0.0; 3]), Some(30.0));
    let image =
        solid("function density(p)\n    return 1 - length(p)", &options).rows(0..60).expect("a picture");
    let middle = 30 * 60 + 30;
    assert_eq!(vector(&image, "normal", middle), [0.0, -1.0, 0.0]);
    assert!((vector(&image, "point", middle)[1] + 0.5).abs() < 1e-6);
    assert!((plane(&image, "depth", 0)[middle] - 5.5).abs() < 1e-5);
    assert_eq!(plane(&image, "depth", 0)[0], 1e10);
}

#[test]
fn rows_and_threads_change_nothing() {
    let options = seen_from_eye(96, 64);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| solid(CORAL, &options).rows(0..64).expect("a picture"))
    };
    let (one, three) = (on(1), on(3));
    let other = solid(CORAL, &options);
    let parts: Vec<_> = [0..5, 5..40, 40..64].map(|rows| other.rows(rows).expect("rows")).into();
    for (v, variable) in one.variables.iter().enumerate() {
        for (i, plane) in variable.planes.iter().enumerate() {
            let bits = |plane: &[f32]| plane.iter().map(|x| x.to_bits()).collect::<Vec<u32>>();
            assert_eq!(bits(plane), bits(&three.variables[v].planes[i]), "{}", variable.name);
            let joined: Vec<u32> = parts.iter().flat_map(|part| bits(&part.variables[v].planes[i])).collect();
            assert_eq!(bits(plane), joined, "{}", variable.name);
        }
    }
}

/// What is wrong with a mesh that should be closed, all around and once; else its Euler characteristic and its volume.
fn closed(mesh: &Mesh) -> (i64, f64) {
    let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
    let mut volume = 0.0;
    for face in &mesh.faces {
        let corners = mesh.corners_of(face);
        for (i, corner) in corners.iter().enumerate() {
            let next = corners[(i + 1) % corners.len()].point;
            assert_ne!(corner.point, next);
            *edges.entry((corner.point, next)).or_default() += 1;
        }
        let [a, b, c] = [0, 1, 2].map(|i| mesh.points[corners[i].point as usize].map(f64::from));
        let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        volume += dot(a, cross) / 6.0;
    }
    for (&(a, b), &count) in &edges {
        assert_eq!(count, 1, "the edge {a} {b} has {count} faces on its left");
        assert!(edges.contains_key(&(b, a)), "the edge {a} {b} is open");
    }
    let used: std::collections::HashSet<u32> = mesh.corners.iter().map(|c| c.point).collect();
    assert_eq!(used.len(), mesh.points.len(), "points without faces");
    (mesh.points.len() as i64 - edges.len() as i64 / 2 + mesh.faces.len() as i64, volume)
}

fn meshed(text: &str, resolution: usize) -> Mesh {
    solid(text, &options(8, 8)).mesh(resolution, &|_| ()).expect("a mesh")
}

#[test]
fn meshes_are_closed_and_face_outwards() {
    use std::f64::consts::PI;
    let ball = meshed("function density(p)\n    return 1 - length(p)", 48);
    let (euler, volume) = closed(&ball);
    assert_eq!(euler, 2);
    assert!((volume / (4.0 / 3.0 * PI) - 1.0).abs() < 0.01, "{volume}");
    for (point, normal) in ball.points.iter().zip(&ball.normals) {
        let (point, normal) = (point.map(f64::from), normal.map(f64::from));
        assert!((dot(point, point) - 1.0).abs() < 2e-4, "{point:?}");
        assert!(dot(point, normal) > 0.9999, "{point:?} {normal:?}");
    }
    let (euler, volume) =
        closed(&meshed("function density(p)\n    return 0.4 - length([length([p.x p.y]) - 0.9 p.z])", 64));
    assert_eq!(euler, 0);
    assert!((volume / (2.0 * PI * PI * 0.9 * 0.16) - 1.0).abs() < 0.01, "{volume}");
    // All is inside: the box itself, but for its edges.
    let (euler, volume) = closed(&meshed("function density(p)\n    return 1", 64));
    assert_eq!(euler, 2);
    assert!((volume / 27.0 - 1.0).abs() < 0.01, "{volume}");
}

#[test]
fn meshes_of_anything_are_closed() {
    // Every case of a cell comes up: corners inside and outside by chance.
    closed(&meshed("function density(p)\n    return Noise(17 * p)", 40));
    closed(&meshed("function density(p)\n    return random(31 * p) - 0.5", 24));
    let (_, volume) = closed(&meshed(CORAL, 64));
    assert!(volume > 0.1, "{volume}");
}

#[test]
fn what_is_soft_dims_by_its_depth() {
    let text = "function density(p)\n    return length(p) < 1 ? 0.8 : 0
function emission(p)\n    return [1 0.5 0]";
    let options = SolidOptions { soft: true, step: Some(0.002), ..seen_from_eye(24, 18) };
    let image = solid(text, &options).rows(0..18).expect("a picture");
    for pixel in 0..24 * 18 {
        let ray = vector(&image, "I", pixel);
        let alpha = f64::from(plane(&image, "alpha", 0)[pixel]);
        let along = dot(EYE, ray);
        let chord = 2.0 * (along * along - dot(EYE, EYE) + 1.0).max(0.0).sqrt();
        assert!((alpha - (1.0 - libm::exp(-0.8 * chord))).abs() < 3e-3, "{alpha} {chord}");
        let color = vector(&image, "color", pixel);
        assert!((color[0] - alpha).abs() < 1e-6 && (color[1] - 0.5 * alpha).abs() < 1e-6);
    }
    // Far denser than needed: nothing comes through, and all is seen at the front.
    let dense = text.replace("0.8", "1000");
    let image = solid(&dense, &options).rows(0..18).expect("a picture");
    let middle = 9 * 24 + 12;
    assert_eq!(plane(&image, "alpha", 0)[middle], 1.0);
    let distance = to_sphere(EYE, vector(&image, "I", middle), 1.0).expect("a hit");
    let forward = f64::from(plane(&image, "depth", 0)[middle]);
    assert!((forward - distance).abs() < 0.01, "{forward} {distance}");
}

#[test]
fn errors_say_what_to_do() {
    let fails = |text: &str, options: &SolidOptions, set: &[(&str, f32)]| {
        let set = set.iter().map(|(name, value)| (name.to_string(), PixelValue::from(*value))).collect();
        let run = RunOptions { set, ..RunOptions::default() };
        let made = Isosurface::new(&Compiler::new(), "solid", text, options, &run);
        match made.and_then(|solid| solid.rows(0..8)) {
            Ok(_) => panic!("no error: {text}"),
            Err(error) => error.to_string(),
        }
    };
    let plain = options(8, 8);
    let ball = "function density(p)\n    return 1 - length(p)";
    assert!(fails("color = white", &plain, &[]).contains("no function `density(point)`"));
    let vector = fails("function density(p)\n    return p", &plain, &[]);
    assert_eq!(
        vector,
        "`density(point)` gives a vector of 3; Return one number: above the level inside, below it outside."
    );
    let nan = fails("function density(p)\n    return p.x < 0.3 ? 1 : sqrt(-1 - p.x)", &plain, &[]);
    assert!(nan.starts_with("`density` is NaN at "), "{nan}");
    assert!(fails(ball, &plain, &[("size", 1.0)]).contains("no param `size` to set"));
    let mut inside = plain.clone();
    inside.view.eye = Some([0.5, 0.0, 0.0]);
    inside.view.look_at = Some([2.0, 0.0, 0.0]);
    let message = fails(ball, &inside, &[]);
    assert!(
        message.starts_with("the eye, 0.5,0,0, is inside the solid; Move it out, for example to --eye "),
        "{message}"
    );
    let bounds = |low: [f64; 3], high: [f64; 3]| SolidOptions { bounds: [low, high], ..plain.clone() };
    assert!(fails(ball, &bounds([1.0; 3], [1.0; 3]), &[]).starts_with("the box is empty"));
    assert!(fails(ball, &bounds([100.0; 3], [100.001; 3]), &[]).contains("too far from the origin"));
    let flat = SolidOptions { lipschitz: Some(0.0), ..plain.clone() };
    assert!(fails(ball, &flat, &[]).contains("not a positive number"));
    let mesh = solid(ball, &plain).mesh(1, &|_| ()).expect_err("too coarse");
    assert!(mesh.to_string().contains("Give 2 to 4096"), "{mesh}");
    assert_eq!(
        solid(ball, &bounds([1.1; 3], [2.0; 3])).rows(0..8).map(|_| 0).ok(),
        Some(0),
        "nothing to see is no error"
    );
}
