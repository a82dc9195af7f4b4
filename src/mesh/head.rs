//! A head, by formula: a ball of quads, on which features are pulled out and pushed in.

use super::{Corner, Face, Mesh};
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// Quads along an edge of the cube that the ball is made of.
const STEPS: i32 = 34;

/// A head of about seven thousand quads, two units high, y up, that looks along z: a prototype for deformations.
pub fn head() -> Mesh {
    let mut mesh = Mesh { surfaces: vec!["head".into()], ..Mesh::default() };
    let mut points: HashMap<[i32; 3], u32> = HashMap::new();
    let mut uvs: HashMap<(u32, bool), u32> = HashMap::new();
    let mut turns: Vec<f64> = Vec::new();
    for side in 0..6 {
        for (i, j) in (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| (i, j))) {
            let corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[i, j]| {
                // Steps from -STEPS to STEPS along each axis of the cube.
                let (a, b) = (2 * i - STEPS, 2 * j - STEPS);
                let cell = match side {
                    0 => [STEPS, a, b],
                    1 => [-STEPS, b, a],
                    2 => [b, STEPS, a],
                    3 => [a, -STEPS, b],
                    4 => [a, b, STEPS],
                    _ => [b, a, -STEPS],
                };
                *points.entry(cell).or_insert_with(|| {
                    let point = shape(direction(cell));
                    turns.push(0.5 + libm::atan2(point.x, point.z) / std::f64::consts::TAU);
                    mesh.points.push(point.as_vec3().as_dvec3().to_array());
                    mesh.points.len() as u32 - 1
                })
            });
            // u goes once around, and the seam at the back must not go back through all of it.
            let right = corners.iter().any(|&p| turns[p as usize] > 0.75);
            mesh.faces.push(Face { first: mesh.corners.len() as u32, corners: 4, surface: 0 });
            for point in corners {
                let u = turns[point as usize];
                let wraps = right && u < 0.25;
                let uv = *uvs.entry((point, wraps)).or_insert_with(|| {
                    let v = (mesh.points[point as usize][1] + 1.3) / 2.3;
                    mesh.uvs.push([u + f64::from(wraps), v].map(|c| f64::from(c as f32)));
                    mesh.uvs.len() as u32 - 1
                });
                mesh.corners.push(Corner { point, normal: None, uv: Some(uv) });
            }
        }
    }
    mesh.complete_normals();
    mesh
}

/// The direction of a place of the cube, with more of them where the face is.
fn direction(cell: [i32; 3]) -> DVec3 {
    // Tangents make the steps of the ball even.
    let even = |n: i32| libm::tan(f64::from(n) / f64::from(STEPS) * std::f64::consts::FRAC_PI_4);
    let d = DVec3::from(cell.map(even)).normalize();
    let angle = libm::acos(d.z.clamp(-1.0, 1.0));
    let closer = angle - 0.38 * libm::sin(angle);
    let across = d.truncate().normalize_or_zero() * libm::sin(closer);
    across.extend(libm::cos(closer))
}

/// A smooth hill of height 1 at 0, seen from a distance in units of its width.
fn hill(x: f64, y: f64) -> f64 {
    libm::exp(-(x * x + y * y))
}

/// 0 below `low`, 1 above `high`, smoothly.
fn step(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Where a direction of the ball is on the head.
fn shape(d: DVec3) -> DVec3 {
    let DVec3 { x, y, z } = d;
    // The skull: longer than wide, its back full, the jaw narrow and further forward.
    let low = step(0.15, -0.85, y);
    let mut p = DVec3::new(0.72 * x, y, 0.9 * z);
    p.x *= 1.0 - 0.22 * low;
    p.z += 0.12 * low * step(-0.3, 0.8, z);
    p.z -= 0.13 * step(0.0, -1.0, z) * step(-0.5, 0.3, y);
    p.z -= 0.06 * step(0.35, 0.9, y) * step(0.0, 1.0, z);
    // The temples go in a little, the face is flatter than a ball.
    p.x *= 1.0 - 0.06 * hill((y - 0.25) / 0.3, (z - 0.45) / 0.35);
    p.z -= 0.05 * step(0.5, 1.0, z);
    p += step(0.05, 0.45, z) * features(x.abs(), y) * DVec3::new(0.25 * x, 0.1 * y, 1.0).normalize();

    // Ears: a rim with a hollow in it, standing off the side of the head.
    let ear = DVec2::new((z + 0.02 - 0.15 * (y - 0.05)) / 0.13, (y - 0.06) / 0.2);
    let far = ear.length();
    let outside = step(0.72, 0.95, x.abs());
    let rim = hill((far - 0.75) / 0.35, 0.0) * step(1.5, 1.0, far) * (1.0 - 0.6 * step(0.0, 1.0, ear.x));
    p.x += x.signum() * outside * (0.075 * rim + 0.02 * step(1.1, 0.7, far));
    p.z -= outside * 0.05 * step(1.5, 0.5, far) * step(0.5, -1.0, ear.x);

    // The neck: what is lowest goes down, as wide as a neck.
    let neck = step(-0.72, -0.9, y - 0.12 * z);
    let wide = DVec3::new(1.25 * x, 0.0, 1.2 * z - 0.05).clamp_length_max(0.4) - DVec3::new(0.0, 0.0, 0.1);
    let down = 0.33 * neck.max(step(-0.85, -0.97, y)) * step(-0.72, -0.93, y);
    p.lerp(wide.with_y(p.y), neck).with_y(p.y - down)
}

/// How far the face stands out of the ball, by the distance from its middle and by height.
fn features(side: f64, y: f64) -> f64 {
    let at = |x: f64, y0: f64, width: f64, height: f64| hill((side - x) / width, (y - y0) / height);
    // Brows, sockets with eyes in them and a slit between the lids, cheekbones, cheeks.
    let mut out = 0.06 * at(0.24, 0.245, 0.2, 0.06) + 0.02 * at(0.0, 0.25, 0.1, 0.08);
    out -= 0.15 * at(0.29, 0.12, 0.14, 0.085);
    out += 0.105 * at(0.29, 0.11, 0.08, 0.055);
    out -= 0.03 * at(0.29, 0.105, 0.1, 0.013);
    out += 0.05 * at(0.48, -0.05, 0.16, 0.11);
    out -= 0.03 * at(0.42, -0.32, 0.13, 0.14);
    // The nose rises towards its tip, and ends there; its wings, and holes.
    let along = ((0.2 - y) / 0.33).clamp(0.0, 1.0);
    let bridge = hill(side / (0.065 + 0.05 * along), 0.0) * step(0.3, 0.15, y) * step(-0.21, -0.125, y);
    out += bridge * (0.04 + 0.17 * along * along.sqrt());
    out += 0.07 * at(0.11, -0.115, 0.055, 0.05);
    out -= 0.03 * at(0.06, -0.17, 0.035, 0.022);
    // Lips, with the mouth between them, and the chin.
    out += 0.035 * at(0.0, -0.36, 0.24, 0.15);
    out += 0.04 * at(0.0, -0.305, 0.17, 0.035) - 0.014 * at(0.0, -0.25, 0.03, 0.04);
    out -= 0.055 * at(0.0, -0.352, 0.2, 0.018);
    out += 0.045 * at(0.0, -0.405, 0.14, 0.038);
    out -= 0.035 * at(0.0, -0.475, 0.18, 0.035);
    out + 0.13 * at(0.0, -0.62, 0.19, 0.1)
}
