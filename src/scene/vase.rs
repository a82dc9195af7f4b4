//! The outline of the vase: foot, stem, belly, shoulder, neck and lip, and the wall inside.

use super::lathe::Lathe;
use super::spline::{polyline, spline};
use glam::DVec3;

/// How high the vase is. It is large beside the other scenes, because the marble of the paper has its layers 2π apart.
pub(super) const HEIGHT: f64 = 10.0;

/// The vase, standing on z = 0 around the z axis; v is 1 at the top of the lip.
pub(super) fn vase() -> Lathe {
    // Each pair is the distance from the axis and the height.
    let mut outline = polyline(&[[0.0, 0.0], [1.72, 0.0]]);
    // The foot: a torus that sits on a plinth.
    outline.extend(spline(&[[1.72, 0.0], [1.95, 0.2], [1.72, 0.42]], [1.0, 0.0], [-1.0, 0.0]));
    outline.extend(polyline(&[[1.72, 0.42], [1.6, 0.42]]));
    // Stem, belly, shoulder, neck, and out to the lip.
    outline.extend(spline(
        &[
            [1.6, 0.42],
            [1.05, 0.8],
            [0.92, 1.2],
            [1.3, 1.85],
            [2.15, 3.0],
            [2.95, 4.35],
            [3.3, 5.75],
            [2.95, 7.0],
            [2.05, 7.85],
            [1.4, 8.5],
            [1.28, 9.1],
            [1.6, 9.65],
            [2.02, 9.84],
            [2.1, 9.94],
            [2.0, HEIGHT],
        ],
        [-0.8, 0.6],
        [-1.0, 0.0],
    ));
    let outside = outline.len();
    outline.extend(spline(
        &[
            [2.0, HEIGHT],
            [1.5, 9.82],
            [1.1, 9.2],
            [1.2, 8.45],
            [1.9, 7.7],
            [2.75, 6.9],
            [3.08, 5.75],
            [2.73, 4.4],
            [1.9, 3.1],
            [0.95, 2.2],
            [0.0, 1.9],
        ],
        [-1.0, 0.0],
        [-1.0, 0.0],
    ));
    Lathe::new(DVec3::ZERO, &outline, outside)
}
