//! A digest of what a run computed: names, shapes, size, and the bits of every number.

use pse::image::Image;

/// Takes in an image row by row; bands that are cut elsewhere give the same.
pub(super) struct Digest {
    hasher: blake3::Hasher,
    row: Vec<u8>,
}

impl Digest {
    /// Of an image with that many rows, of which `first` has the first ones.
    pub fn new(first: &Image<'_>, height: usize) -> Digest {
        let mut hasher = blake3::Hasher::new();
        hasher.update(format!("{} {height}\n", first.width).as_bytes());
        for variable in &first.variables {
            // No name has a blank or a line's end in it.
            hasher.update(format!("{} {}\n", variable.name, variable.shape).as_bytes());
        }
        Digest { hasher, row: Vec::new() }
    }

    /// The next rows.
    pub fn rows(&mut self, rows: &Image<'_>) {
        for y in 0..rows.height {
            self.row.clear();
            for plane in rows.variables.iter().flat_map(|v| &v.planes) {
                // Which NaN it is, is nobody's promise.
                let bits = |x: &f32| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() };
                let row = &plane[y * rows.width..][..rows.width];
                self.row.extend(row.iter().flat_map(|x| bits(x).to_le_bytes()));
            }
            self.hasher.update(&self.row);
        }
    }

    /// As 64 hexadecimal digits.
    pub fn finish(&self) -> String {
        self.hasher.finalize().to_hex().to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pse::image::Variable;
    use pse::internal::shape::Shape;

    fn digest(width: usize, name: &str, shape: Shape, planes: &[Vec<f32>], bands: &[usize]) -> String {
        let height = planes[0].len() / width;
        let mut digest: Option<Digest> = None;
        let mut top = 0;
        for band in bands {
            let part = |p: &Vec<f32>| p[top * width..(top + band) * width].to_vec();
            let variable = Variable::new(name, shape.clone(), planes.iter().map(part)).unwrap();
            let image = Image::new(width, *band, [variable]).unwrap();
            digest.get_or_insert_with(|| Digest::new(&image, height)).rows(&image);
            top += band;
        }
        digest.unwrap().finish()
    }

    #[test]
    fn it_is_of_all_that_was_computed_and_of_nothing_else() {
        let ramp: Vec<f32> = (0..12).map(|i| i as f32).collect();
        let whole = std::slice::from_ref(&ramp);
        let of = |planes: &[Vec<f32>], bands: &[usize]| digest(3, "a", Shape::Scalar, planes, bands);
        let one = of(whole, &[4]);
        assert_eq!(one.len(), 64);
        assert_eq!(one, of(whole, &[1, 2, 1]), "bands");
        let with = |x: f32| of(&[ramp.iter().map(|&v| if v == 0.0 { x } else { v }).collect()], &[4]);
        assert_ne!(one, with(-0.0), "every bit counts");
        assert_eq!(with(f32::NAN), with(-f32::NAN), "but NaN is NaN");
        assert_ne!(one, digest(3, "b", Shape::Scalar, whole, &[4]));
        assert_ne!(one, digest(4, "a", Shape::Scalar, whole, &[3]));
        let halves = [ramp[..6].to_vec(), ramp[6..].to_vec()];
        assert_ne!(one, digest(3, "a", Shape::Vector(2), &halves, &[2]));
    }
}
