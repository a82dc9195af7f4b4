//! A camera found from what it saw: the points of a G-buffer say where each pixel looks.
//!
//! Each pixel gives two linear equations in the twelve numbers of the matrix from points to columns and rows (the direct linear
//! transformation of photogrammetry). Their least squares solution is the eigenvector of the least eigenvalue of a matrix of 12 by 12.
//! Equations are weighted by one over the depth that the last solution found, so that errors count in pixels.

use super::points::PointSampler;
use super::projection::Projection;
use crate::image::{Image, Matrix4};
use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};
use std::fmt;

/// Fewer points than these say too little.
const MIN_POINTS: usize = 50;

/// The largest median distance, in pixels, between the middle of a pixel and where the camera sees its point. Pixel filters
/// move points by up to half a pixel.
const MAX_RESIDUAL: f64 = 0.6;

/// The largest standard error of the eye, as a share of its distance from the points.
const MAX_EYE_ERROR: f64 = 0.01;

/// How much larger than the least sum of squares the next one has to be; else both are noise.
const MIN_GAP: f64 = 20.0;

/// Thinner layers of points, as a share of their extent, count as flat if no camera is found.
const THIN: f64 = 3e-3;

/// How often the equations are solved again, with better weights and without the points that did not fit.
const ROUNDS: usize = 16;

/// A camera found from points, and how well it fits them.
#[derive(Clone, Debug)]
pub struct Resection {
    /// The camera.
    pub projection: Projection,
    /// The median distance, in pixels, between the middle of a pixel and where the camera sees its point.
    pub residual: f64,
    /// How many points were used.
    pub points: usize,
    /// The standard error of the eye's position, in units of space, if the points' errors are independent.
    pub eye_error: f64,
}

/// Why no camera was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ResectionError {
    /// The image has no variable `point` with three components.
    NoPoints,
    /// Too few pixels show a surface.
    TooFew(usize),
    /// All rays are parallel, so there is no eye.
    Orthographic,
    /// The points fit no pinhole camera: the median distance in pixels.
    NotPinhole(f64),
    /// All points lie in one plane.
    Flat,
    /// Many cameras fit the points about as well.
    Undetermined,
}

impl fmt::Display for ResectionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ResectionError::NoPoints => write!(f, "the input has no variable `point`"),
            ResectionError::TooFew(count) => {
                let s = if *count == 1 { "" } else { "s" };
                write!(
                    f,
                    "only {count} pixel{s} of a surface {} sampled",
                    if *count == 1 { "was" } else { "were" }
                )
            }
            ResectionError::Orthographic => {
                write!(f, "the rays through the pixels are parallel, as those of an orthographic camera")
            }
            ResectionError::NotPinhole(distance) => {
                write!(f, "no pinhole camera fits them")?;
                if *distance < 1e4 {
                    write!(f, " (the best one sees half of them {distance:.1} pixels or more away)")?;
                }
                write!(f, ", as with panoramas, distorting lenses, depth of field and motion blur")
            }
            ResectionError::Flat => {
                write!(f, "they lie in one plane, and many cameras fit them")
            }
            ResectionError::Undetermined => {
                write!(f, "many cameras fit them: they are nearly flat, or too noisy for their number")
            }
        }
    }
}

impl std::error::Error for ResectionError {}

/// The camera that saw the points of an image.
///
/// # Errors
/// If no pinhole camera saw them, or they do not determine it.
pub fn resect(image: &Image<'_>) -> Result<Resection, ResectionError> {
    let mut sampler = PointSampler::new(image);
    sampler.add(image);
    sampler.resect()
}

impl Resection {
    /// The matrices from the world to the camera and to the screen, in the conventions of the built-in scenes.
    pub fn spaces(&self) -> [Matrix4; 2] {
        self.projection.spaces()
    }
}

/// A point and the middle of the pixel that sees it.
type Pair = (DVec3, DVec2);

/// The camera of some pairs, for a picture of that size.
pub(super) fn solve(pairs: &[Pair], size: [usize; 2]) -> Result<Resection, ResectionError> {
    if pairs.len() < MIN_POINTS {
        return Err(ResectionError::TooFew(pairs.len()));
    }
    let units = Units::of(pairs, size).ok_or(ResectionError::Undetermined)?;
    let all: Vec<Pair> = pairs.iter().map(|pair| units.normalize(pair)).collect();
    let thickness = thickness(&all);
    // Up to rounding, all lie in one plane.
    if thickness < 3e-6 {
        return Err(ResectionError::Flat);
    }
    solve_normalized(&all, &units, size).map_err(|error| match error {
        ResectionError::NotPinhole(_) | ResectionError::Undetermined if thickness < THIN => {
            ResectionError::Flat
        }
        _ => error,
    })
}

fn solve_normalized(all: &[Pair], units: &Units, size: [usize; 2]) -> Result<Resection, ResectionError> {
    let mut kept = all.to_vec();
    let mut weights = vec![1.0; kept.len()];
    let mut residual = f64::INFINITY;
    let mut last = None;
    // Pixels at edges mix points of two surfaces: what lies far off is left out the next time.
    for _ in 0..ROUNDS {
        let solution = Solution::of(&kept, &weights).ok_or(ResectionError::Undetermined)?;
        let distance = |pair: &Pair| solution.place(pair.0).distance(pair.1) * units.extent;
        let mut distances: Vec<f64> =
            all.iter().map(distance).map(|d| if d.is_finite() { d } else { f64::MAX }).collect();
        distances.sort_by(f64::total_cmp);
        residual = distances[distances.len() / 2];
        // Far off a few wrong points bend the camera, and most of these are the worst.
        let limit = if residual > MAX_RESIDUAL { 1.5 * residual } else { 4.0 * residual + 1e-3 };
        kept = all
            .iter()
            .filter(|pair| solution.depth(pair.0) > 0.0 && distance(pair) <= limit)
            .copied()
            .collect();
        if kept.len() < (all.len() / 2).max(MIN_POINTS / 2) {
            return Err(ResectionError::NotPinhole(residual));
        }
        weights = kept.iter().map(|pair| units.extent / solution.depth(pair.0)).collect();
        last = Some(solution);
    }
    let solution = last.ok_or(ResectionError::Undetermined)?;
    if residual > MAX_RESIDUAL {
        return Err(ResectionError::NotPinhole(residual));
    }
    // A camera with parallel rays, which a pinhole far away imitates.
    let affine = affine_residual(&kept, units.extent);
    if affine.is_some_and(|affine| affine <= 1.5 * residual + 1e-3) {
        return Err(ResectionError::Orthographic);
    }
    if solution.values[1] < MIN_GAP * solution.values[0] {
        return Err(ResectionError::Undetermined);
    }
    let error = solution.eye_error(kept.len()).ok_or(ResectionError::Undetermined)?;
    let eye = solution.eye(&solution.vectors[0]).ok_or(ResectionError::Undetermined)?;
    if error > MAX_EYE_ERROR * eye.length() {
        return Err(ResectionError::Undetermined);
    }
    let projection = units.projection(&solution, size).ok_or(ResectionError::Undetermined)?;
    Ok(Resection { projection, residual, points: kept.len(), eye_error: error * units.spread })
}

/// The deviation of points from a plane, as a share of that along the shorter side of the plane.
fn thickness(pairs: &[Pair]) -> f64 {
    let mean = pairs.iter().map(|pair| pair.0).sum::<DVec3>() / pairs.len() as f64;
    let mut squares = [[0.0; 3]; 3];
    for (point, _) in pairs {
        let d = (*point - mean).to_array();
        squares
            .iter_mut()
            .zip(d)
            .for_each(|(row, x)| row.iter_mut().zip(d).for_each(|(sum, y)| *sum += x * y));
    }
    let mut values = eigen(squares).0;
    values.sort_by(f64::total_cmp);
    (values[0].max(0.0) / values[1]).sqrt()
}

/// Units in which all numbers are about 1, so that no digits are lost.
struct Units {
    /// The median point.
    middle: DVec3,
    /// The median distance from it.
    spread: f64,
    /// The middle of the picture.
    center: DVec2,
    /// Half of its longer side.
    extent: f64,
}

impl Units {
    fn of(pairs: &[Pair], size: [usize; 2]) -> Option<Units> {
        let median = |of: &dyn Fn(&Pair) -> f64| {
            let mut numbers: Vec<f64> = pairs.iter().map(of).collect();
            numbers.sort_by(f64::total_cmp);
            numbers[numbers.len() / 2]
        };
        let middle = DVec3::new(median(&|p| p.0.x), median(&|p| p.0.y), median(&|p| p.0.z));
        let spread = median(&|p| p.0.distance(middle));
        let center = DVec2::new(size[0] as f64, size[1] as f64) / 2.0;
        (spread > 0.0).then_some(Units { middle, spread, center, extent: center.max_element() })
    }

    fn normalize(&self, (point, pixel): &Pair) -> Pair {
        ((*point - self.middle) / self.spread, (*pixel - self.center) / self.extent)
    }

    /// The camera in units of space and pixels.
    fn projection(&self, solution: &Solution, size: [usize; 2]) -> Option<Projection> {
        let [x, y, depth] = rows(&solution.vectors[0]).map(|row| {
            let linear = row.truncate() / self.spread;
            linear.extend(row.w - linear.dot(self.middle))
        });
        Projection::of_rows(
            [x * self.extent + depth * self.center.x, y * self.extent + depth * self.center.y, depth],
            size,
        )
    }
}

/// The twelve numbers of a matrix as its rows.
fn rows(m: &[f64; 12]) -> [DVec4; 3] {
    [0, 1, 2].map(|i| DVec4::new(m[4 * i], m[4 * i + 1], m[4 * i + 2], m[4 * i + 3]))
}

/// The solutions of the equations, by how badly they fit.
struct Solution {
    /// Sums of squares, ascending.
    values: [f64; 12],
    /// The unit vectors that have them. The first is the camera, with points before it.
    vectors: [[f64; 12]; 12],
}

impl Solution {
    fn of(pairs: &[Pair], weights: &[f64]) -> Option<Solution> {
        let mut squares = [[0.0; 12]; 12];
        for ((point, pixel), weight) in pairs.iter().zip(weights) {
            let p = (*point * *weight).extend(*weight).to_array();
            for (axis, value) in pixel.to_array().into_iter().enumerate() {
                let mut row = [0.0; 12];
                for i in 0..4 {
                    row[4 * axis + i] = p[i];
                    row[8 + i] = -value * p[i];
                }
                for (sums, x) in squares.iter_mut().zip(row) {
                    sums.iter_mut().zip(row).for_each(|(sum, y)| *sum += x * y);
                }
            }
        }
        let (values, vectors) = eigen(squares);
        let mut order: [usize; 12] = std::array::from_fn(|i| i);
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        let mut solution = Solution {
            values: order.map(|i| values[i].max(0.0)),
            vectors: order.map(|i| std::array::from_fn(|j| vectors[j][i])),
        };
        if !solution.values.iter().all(|value| value.is_finite()) {
            return None;
        }
        // What is seen lies before the eye.
        let behind = pairs.iter().filter(|pair| solution.depth(pair.0) < 0.0).count();
        if 2 * behind > pairs.len() {
            solution.vectors[0] = solution.vectors[0].map(|x| -x);
        }
        Some(solution)
    }

    fn depth(&self, point: DVec3) -> f64 {
        rows(&self.vectors[0])[2].dot(point.extend(1.0))
    }

    fn place(&self, point: DVec3) -> DVec2 {
        let [column, row, depth] = rows(&self.vectors[0]).map(|row| row.dot(point.extend(1.0)));
        DVec2::new(column, row) / depth
    }

    /// The point that a matrix sees nowhere.
    fn eye(&self, m: &[f64; 12]) -> Option<DVec3> {
        let rows = rows(m);
        let lens = DMat3::from_cols_array_2d(&rows.map(|row| row.truncate().to_array())).transpose();
        let eye = lens.inverse() * -DVec3::new(rows[0].w, rows[1].w, rows[2].w);
        eye.is_finite().then_some(eye)
    }

    /// The standard error of the eye, from what is left of the equations, which are in pixels.
    fn eye_error(&self, points: usize) -> Option<f64> {
        const SMALL: f64 = 1e-7;
        let [camera, others @ ..] = &self.vectors;
        let freedom = (2 * points).checked_sub(11)?;
        let variance = self.values[0] / freedom as f64;
        let mut sum = 0.0;
        for (other, value) in others.iter().zip(&self.values[1..]) {
            let moved = |by: f64| self.eye(&std::array::from_fn(|i| camera[i] + by * other[i]));
            let change = (moved(SMALL)? - moved(-SMALL)?) / (2.0 * SMALL);
            // Noise adds to all sums of squares alike.
            let gap = value - self.values[0];
            sum += variance * value / (gap * gap) * change.length_squared();
        }
        Some(sum.sqrt()).filter(|error| error.is_finite())
    }
}

/// The median distance in pixels between pixels and where the best camera with parallel rays sees their points.
fn affine_residual(pairs: &[Pair], extent: f64) -> Option<f64> {
    let (mut squares, mut products) = (DMat4::ZERO, [DVec4::ZERO; 2]);
    for (point, pixel) in pairs {
        let p = point.extend(1.0);
        squares += DMat4::from_cols(p * p.x, p * p.y, p * p.z, p);
        products = [products[0] + p * pixel.x, products[1] + p * pixel.y];
    }
    let inverse = squares.inverse();
    let [x, y] = products.map(|product| inverse * product);
    let place = |point: DVec3| DVec2::new(x.dot(point.extend(1.0)), y.dot(point.extend(1.0)));
    let mut distances: Vec<f64> = pairs.iter().map(|(point, pixel)| place(*point).distance(*pixel)).collect();
    distances.sort_by(f64::total_cmp);
    distances.get(distances.len() / 2).map(|d| d * extent).filter(|d| d.is_finite())
}

/// Eigenvalues and, as columns, eigenvectors of a symmetric matrix, by Jacobi's rotations.
fn eigen<const N: usize>(mut a: [[f64; N]; N]) -> ([f64; N], [[f64; N]; N]) {
    let mut v: [[f64; N]; N] = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(i == j)));
    for _ in 0..40 {
        let off: f64 = (0..N).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| a[i][j] * a[i][j]).sum();
        if off == 0.0 {
            break;
        }
        for p in 0..N {
            for q in p + 1..N {
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
