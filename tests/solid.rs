//! Solids: surfaces found and missed, normals, meshes, what is soft, and the command.

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
                let away: f64 = (0..3).map(|i| (there[i] - found[i]).powi(2)).sum();
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
    let (width, height) = (160, 120);
    let solid = solid(CORAL, &seen_from_eye(width, height));
    let image = solid.rows(0..height).expect("a picture");
    let program = Compiler::new().entrance("density", &["point"]).compile("coral", CORAL).expect("a program");
    let run = RunOptions { pixelsize: Some(0.02), ..RunOptions::default() };
    let pixels = width * height;
    let rays: Vec<[f64; 3]> = (0..pixels).map(|i| vector(&image, "I", i)).collect();
    let step = 0.0005;
    let (mut found, mut last) = (vec![None; pixels], vec![-1.0f32; pixels]);
    let mut near = 3.0;
    while near < 8.0 {
        let point = |axis: usize| rays.iter().map(|ray| (EYE[axis] + near * ray[axis]) as f32).collect::<Vec<f32>>();
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
            last[i] = density;
        }
        near += step;
    }
    let equal = (0..pixels).filter(|&i| {
        let seen = plane(&image, "surface", 0)[i] > 0.0;
        match found[i] {
            None => !seen,
            Some(distance) => {
                let point = vector(&image, "point", i);
                let own = (0..3).map(|a| (point[a] - EYE[a]).powi(2)).sum::<f64>().sqrt();
                seen && (own - distance).abs() < 2.0 * step
            }
        }
    });
    let (equal, hit) = (equal.count(), found.iter().flatten().count());
    println!("{equal} of {pixels} equal, {hit} hit; {:?}", solid.told());
    assert!(hit > pixels / 5, "{hit}");
    assert!(equal as f64 > 0.999 * pixels as f64, "{equal} of {pixels}");
}
