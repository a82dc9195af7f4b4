//! `pixelsize`: how far apart neighbouring pixels lie in the space of `point`.

use crate::image::Image;
use crate::shape::Shape;
use rayon::prelude::*;

/// One number a pixel: the larger of the distances to the neighbours along the row and along the column, on
/// the same surface. Along each, the neighbour after the pixel is taken, or the one before it where that is
/// of another surface. Where there is none at all, and for an image without `point`, it is one pixel of a
/// unit-high image.
pub(super) fn plane(image: &Image<'_>) -> Vec<f32> {
    let (width, height) = (image.width, image.height);
    let [_, rows] = image.resolution();
    let unit = 1.0 / rows.max(1) as f32;
    let mut out = vec![unit; width * height];
    let Some(point) = image.variable("point").filter(|p| matches!(p.shape, Shape::Vector(1..))) else {
        return out;
    };
    let surface = image.variable("surface").filter(|s| s.shape == Shape::Scalar);
    let distance = |a: usize, b: usize| -> Option<f32> {
        if let Some(surface) = surface
            && surface.planes[0][a] != surface.planes[0][b]
        {
            return None;
        }
        let squares = point.planes.iter().map(|p| (p[a] - p[b]) * (p[a] - p[b]));
        let length = squares.sum::<f32>().sqrt();
        (length.is_finite() && length > 0.0).then_some(length)
    };
    out.par_chunks_mut(width.max(1)).enumerate().for_each(|(row, out)| {
        for (column, out) in out.iter_mut().enumerate() {
            let here = row * width + column;
            let beside = |after: bool, before: bool, step: usize| {
                let next = if after { distance(here, here + step) } else { None };
                next.or_else(|| if before { distance(here, here - step) } else { None })
            };
            let across = beside(column + 1 < width, column > 0, 1);
            let down = beside(row + 1 < height, row > 0, width);
            if let Some(size) = across.into_iter().chain(down).reduce(f32::max) {
                *out = size;
            }
        }
    });
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Variable;

    #[test]
    fn neighbours_of_the_same_surface_decide() {
        // Two surfaces side by side; the second's points are twice as far apart.
        let x = vec![0.0, 1.0, 10.0, 12.0];
        let image = Image {
            width: 4,
            height: 1,
            variables: vec![
                Variable { name: "point".into(), shape: Shape::Vector(1), planes: vec![x.into()] },
                Variable {
                    name: "surface".into(),
                    shape: Shape::Scalar,
                    planes: vec![vec![1.0, 1.0, 2.0, 2.0].into()],
                },
            ],
            metadata: Default::default(),
        };
        assert_eq!(plane(&image), [1.0, 1.0, 2.0, 2.0]);
    }

    #[test]
    fn without_points_a_unit_high_image() {
        let image = Image { width: 3, height: 2, ..Image::default() };
        assert_eq!(plane(&image), [0.5; 6]);
    }
}
