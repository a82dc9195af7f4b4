//! `pixelsize`: how far apart neighbouring pixels lie in the space of `point`.

use super::input::Inputs;
use super::steps::Steps;
use crate::parallel::for_rows;

/// One number a pixel, by the steps of the image's points. Where they tell nothing, and for an image without `point`, it
/// is one pixel of a unit-high image.
pub(super) fn measure(inputs: &Inputs<'_>, steps: &Steps<'_>, threads: bool, out: &mut Vec<f32>) {
    let [_, rows] = inputs.resolution();
    let unit = 1.0 / rows.max(1) as f32;
    out.clear();
    out.resize(inputs.width * inputs.height, unit);
    for_rows(threads, out, inputs.width, |row, out| {
        for (column, out) in out.iter_mut().enumerate() {
            if let Some(size) = steps.pixel_size(column, row) {
                *out = size;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Image, Variable};
    use crate::shape::Shape;

    fn plane(image: &Image<'_>) -> Vec<f32> {
        let (inputs, mut staged, mut out) = (Inputs::of(image), Vec::new(), Vec::new());
        let steps = Steps::of(&inputs, Default::default(), &mut staged, true);
        measure(&inputs, &steps, true, &mut out);
        out
    }

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
