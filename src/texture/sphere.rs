//! From directions to places in pictures of all that is around.
//!
//! Directions have y up. Latitude and longitude are those of OSL and OpenImageIO: the middle of the image is +z, its
//! top +y, and from the middle to the right one turns towards -x. Sides of a cube are those of OpenGL and RenderMan.

use crate::math;
use std::f32::consts::{PI, TAU};

/// A direction with z up as one with y up: +x, the middle of Blender's images, becomes +z, and +z becomes +y.
pub fn turned_z_up([x, y, z]: [f32; 3]) -> [f32; 3] {
    [y, z, x]
}

/// Where in an image by latitude and longitude a direction is seen: s, v, and the cosine of its latitude.
pub(super) fn latitude_longitude([x, y, z]: [f32; 3]) -> ([f64; 2], f32) {
    let flat = math::hypot(x, z);
    let s = math::atan2(-x, z) / TAU + 0.5;
    let v = 0.5 - math::atan2(y, flat) / PI;
    // No direction is as good as any.
    let cosine = if flat == 0.0 && y == 0.0 { 1.0 } else { flat / math::hypot(flat, y) };
    ([s.into(), v.into()], cosine)
}

/// Which side of a cube a direction meets, and where on it. Sides are numbered +x -x +y -y +z -z.
pub(super) fn side_of([x, y, z]: [f64; 3]) -> (usize, f64, f64) {
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    let (side, along, down, far) = if ax >= ay && ax >= az {
        if x >= 0.0 { (0, -z, -y, ax) } else { (1, z, -y, ax) }
    } else if ay >= az {
        if y >= 0.0 { (2, x, z, ay) } else { (3, x, -z, ay) }
    } else if z >= 0.0 {
        (4, x, -y, az)
    } else {
        (5, -x, -y, az)
    };
    // No direction is as good as any.
    let far = if far == 0.0 { 1.0 } else { far };
    (side, 0.5 * (along / far + 1.0), 0.5 * (down / far + 1.0))
}

/// The direction in which a place of a side is seen; also beyond its edges.
pub(super) fn on_side(side: usize, s: f64, v: f64) -> [f64; 3] {
    let (a, d) = (2.0 * s - 1.0, 2.0 * v - 1.0);
    match side {
        0 => [1.0, -d, -a],
        1 => [-1.0, -d, a],
        2 => [a, 1.0, d],
        3 => [a, -1.0, -d],
        4 => [a, -d, 1.0],
        _ => [-a, -d, -1.0],
    }
}

/// Where a side stands in the image of a cube.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seat {
    /// Counted in sides.
    pub column: usize,
    /// Counted in sides.
    pub row: usize,
    /// Does it stand on its head?
    pub turned: bool,
}

/// How many texels a side of a cube has along each edge, and where the sides stand in an image of so many columns and
/// rows; `None` if that is no image of a cube.
pub(super) fn sides(width: usize, height: usize) -> Option<(usize, [Seat; 6])> {
    let upright = |list: [(usize, usize); 6]| list.map(|(column, row)| Seat { column, row, turned: false });
    let fits =
        |columns: usize, rows: usize| width * rows == height * columns && width.is_multiple_of(columns);
    if fits(6, 1) {
        Some((height, upright([0, 1, 2, 3, 4, 5].map(|i| (i, 0)))))
    } else if fits(1, 6) {
        Some((width, upright([0, 1, 2, 3, 4, 5].map(|i| (0, i)))))
    } else if fits(3, 2) {
        Some((width / 3, upright([0, 1, 2, 3, 4, 5].map(|i| (i % 3, i / 3)))))
    } else if fits(4, 3) {
        Some((width / 4, upright([(2, 1), (0, 1), (1, 0), (1, 2), (1, 1), (3, 1)])))
    } else if fits(3, 4) {
        let mut list = upright([(2, 1), (0, 1), (1, 0), (1, 2), (1, 1), (1, 3)]);
        list[5].turned = true;
        Some((width / 3, list))
    } else {
        None
    }
}
