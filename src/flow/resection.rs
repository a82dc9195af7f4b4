//! A camera found from what it saw: the points of a G-buffer say where each pixel looks.
//!
//! Each pixel gives two linear equations in the twelve numbers of the matrix from points to columns and rows (the direct linear
//! transformation of photogrammetry). Their least squares solution is the eigenvector of the least eigenvalue of a matrix of 12 by 12.

use super::projection::Projection;
use super::seeds::surfaces;
use crate::image::Image;
use glam::{DVec2, DVec3, DVec4};

/// Pixels that are asked, about: enough for what single precision leaves open.
const PIXELS: usize = 20_000;
/// So far from its middle, in pixels, a point may be seen at most by the mean camera that is found. (Points of
/// antialiased edges lie elsewhere.)
const DOUBT: f64 = 0.6;

/// The camera, if the image has points of a solid scene and these fit one.
pub(super) fn find(image: &Image<'_>) -> Option<Projection> {
    let seen = pairs(image);
    if seen.len() < 100 {
        return None;
    }
    let mut kept: Vec<(DVec3, DVec2)> = seen.clone();
    let mut found = None;
    // Pixels at edges mix points of two surfaces: what lies far off is left out the next time.
    for _ in 0..3 {
        let projection = solve(&kept, image.resolution())?;
        let off = |(point, pixel): &(DVec3, DVec2)| projection.place(*point).distance(*pixel);
        let mut distances: Vec<f64> = kept.iter().map(off).collect();
        distances.sort_by(f64::total_cmp);
        let usual = distances[distances.len() / 2];
        kept.retain(|pair| off(pair) <= 4.0 * usual + 1e-3);
        found = Some((projection, usual));
        if kept.len() < seen.len() / 2 {
            return None;
        }
    }
    found
        .filter(|(projection, usual)| {
            *usual < DOUBT && kept.iter().all(|(point, _)| projection.depth(*point) > 0.0)
        })
        .map(|(projection, _)| projection)
}

/// Points of the image, with the middles of the pixels that see them.
fn pairs(image: &Image<'_>) -> Vec<(DVec3, DVec2)> {
    let [left, top] = image.metadata.origin;
    let step = ((image.width * image.height / PIXELS) as f64).sqrt() as usize + 1;
    let mut pairs = Vec::new();
    for (at, point) in surfaces(image).enumerate() {
        let (row, column) = (at / image.width, at % image.width);
        let Some(point) =
            point.filter(|p| row % step == 0 && column % step == 0 && p.iter().all(|x| x.abs() < 1e8))
        else {
            continue;
        };
        let middle = [(column as i32 + left) as f64 + 0.5, (row as i32 + top) as f64 + 0.5];
        pairs.push((DVec3::from(point.map(f64::from)), DVec2::from(middle)));
    }
    pairs
}

/// The matrix that fits best.
fn solve(pairs: &[(DVec3, DVec2)], size: [usize; 2]) -> Option<Projection> {
    // In units in which all numbers are about 1, so that no digits are lost.
    let count = pairs.len() as f64;
    let middle = pairs.iter().map(|p| p.0).sum::<DVec3>() / count;
    let spread = (pairs.iter().map(|p| p.0.distance_squared(middle)).sum::<f64>() / count).sqrt();
    let centre = DVec2::new(size[0] as f64, size[1] as f64) / 2.0;
    let extent = centre.max_element();
    let mut squares = [[0.0; 12]; 12];
    for (point, pixel) in pairs {
        let p = ((*point - middle) / spread).extend(1.0).to_array();
        let q = (*pixel - centre) / extent;
        for (axis, value) in [q.x, q.y].into_iter().enumerate() {
            let mut row = [0.0; 12];
            for i in 0..4 {
                row[4 * axis + i] = p[i];
                row[8 + i] = -value * p[i];
            }
            for i in 0..12 {
                for j in 0..12 {
                    squares[i][j] += row[i] * row[j];
                }
            }
        }
    }
    let (values, vectors) = eigen(squares);
    let mut order: Vec<usize> = (0..12).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    // Points of one plane fit many cameras.
    if values[order[1]] < 1e-9 * values[order[11]] {
        return None;
    }
    let m: [f64; 12] = std::array::from_fn(|i| vectors[i][order[0]]);
    let row = |i: usize| {
        let linear = DVec3::new(m[4 * i], m[4 * i + 1], m[4 * i + 2]) / spread;
        linear.extend(m[4 * i + 3] - linear.dot(middle))
    };
    let depth = row(2);
    let rows = [row(0) * extent + depth * centre.x, row(1) * extent + depth * centre.y, depth];
    // What is seen lies before the eye.
    let sign = depth.dot(pairs[pairs.len() / 2].0.extend(1.0)).signum();
    Projection::of_rows(rows.map(|row: DVec4| row * sign), size)
}

/// Eigenvalues and, as columns, eigenvectors of a symmetric matrix, by Jacobi's rotations.
fn eigen(mut a: [[f64; 12]; 12]) -> ([f64; 12], [[f64; 12]; 12]) {
    let mut v: [[f64; 12]; 12] = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(i == j)));
    for _ in 0..40 {
        let off: f64 =
            (0..12).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| a[i][j] * a[i][j]).sum();
        if off == 0.0 {
            break;
        }
        for p in 0..12 {
            for q in p + 1..12 {
                if a[p][q] == 0.0 {
                    continue;
                }
                let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
                let c = 1.0 / (t * t + 1.0).sqrt();
                let s = t * c;
                for row in &mut a {
                    (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                }
                let (above, below) = (a[p], a[q]);
                a[p] = std::array::from_fn(|k| c * above[k] - s * below[k]);
                a[q] = std::array::from_fn(|k| s * above[k] + c * below[k]);
                for row in &mut v {
                    (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                }
            }
        }
    }
    (std::array::from_fn(|i| a[i][i]), v)
}
