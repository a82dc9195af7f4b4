//! Where trajectories begin.

use super::Vector;
use crate::gbuffer::surfaces;
use crate::image::Image;

/// The centres of the cells of a grid over a box, with x fastest.
pub fn grid(cells: [usize; 3], low: [f64; 3], high: [f64; 3]) -> Vec<Vector> {
    let [nx, ny, nz] = cells;
    let place = |i: usize, axis: usize| {
        let t = (i as f64 + 0.5) / cells[axis] as f64;
        (low[axis] + (high[axis] - low[axis]) * t) as f32
    };
    let mut seeds = Vec::with_capacity(nx * ny * nz);
    for z in 0..nz {
        for y in 0..ny {
            seeds.extend((0..nx).map(|x| [place(x, 0), place(y, 1), place(z, 2)]));
        }
    }
    seeds
}

/// `count` points spread evenly over the sphere of this radius around the origin: one in each of `count` slices of
/// equal height, each rotated from the last by the golden angle.
pub fn ball(count: usize, radius: f64) -> Vec<Vector> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count)
        .map(|i| {
            let z = 1.0 - (2 * i + 1) as f64 / count as f64;
            let across = (1.0 - z * z).max(0.0).sqrt();
            let angle = golden * i as f64;
            [across * libm::cos(angle), across * libm::sin(angle), z].map(|x| (x * radius) as f32)
        })
        .collect()
}

/// The visible points of an image, in every `every`th column and row with a surface. Empty if it has no `point`.
pub fn visible(image: &Image<'_>, every: usize) -> Vec<Vector> {
    let every = every.max(1);
    let all: Vec<Option<Vector>> = surfaces(image).collect();
    let middles = |length: usize| (every / 2..length).step_by(every);
    let rows = middles(image.height).take_while(|_| !all.is_empty());
    rows.flat_map(|row| middles(image.width).map(move |column| (row, column)))
        .filter_map(|(row, column)| all[row * image.width + column])
        .collect()
}
