//! Even random numbers, the same everywhere: where to take samples.

/// A generator of even random numbers ("splitmix64" of G. Steele, D. Lea and C. Flood, 2014).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// That of a seed.
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let h = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let h = (h ^ (h >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        h ^ (h >> 31)
    }

    /// A number in 0 … 1, without the 1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A number in `-size` … `size`.
    pub fn within(&mut self, size: f64) -> f64 {
        (2.0 * self.unit() - 1.0) * size
    }

    /// The coordinates of points in a cube of `-size` … `size`, a list a coordinate; each is a multiple of `grain`.
    pub fn points(&mut self, dimensions: usize, count: usize, size: f64, grain: f64) -> Vec<Vec<f32>> {
        let one = |random: &mut Random| ((random.within(size) / grain).round() * grain) as f32;
        (0..dimensions).map(|_| (0..count).map(|_| one(self)).collect()).collect()
    }

    /// A vector of length 1, of even direction.
    pub fn direction(&mut self, dimensions: usize) -> Vec<f64> {
        loop {
            // From within the ball, neither near its middle nor outside.
            let v: Vec<f64> = (0..dimensions).map(|_| self.within(1.0)).collect();
            let square: f64 = v.iter().map(|x| x * x).sum();
            if (0.01..=1.0).contains(&square) {
                return v.iter().map(|x| x / square.sqrt()).collect();
            }
        }
    }

    /// Two directions at right angles; in one dimension the second is no direction, but 0.
    pub fn frame(&mut self, dimensions: usize) -> [Vec<f64>; 2] {
        let along = self.direction(dimensions);
        if dimensions == 1 {
            return [along, vec![0.0]];
        }
        loop {
            let other = self.direction(dimensions);
            let common: f64 = along.iter().zip(&other).map(|(a, b)| a * b).sum();
            let rest = 1.0 - common * common;
            if rest > 0.01 {
                let across = other.iter().zip(&along).map(|(b, a)| (b - common * a) / rest.sqrt());
                return [along.clone(), across.collect()];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_even() {
        let mut random = Random::new(1);
        let mut tenths = [0; 10];
        (0..100_000).for_each(|_| tenths[(random.unit() * 10.0) as usize] += 1);
        assert!(tenths.iter().all(|n| (9_700..10_300).contains(n)), "{tenths:?}");
        let points = random.points(3, 100, 2.0, 0.25);
        assert!(points.iter().flatten().all(|x| x.abs() <= 2.0 && (x * 4.0).fract() == 0.0));
    }

    #[test]
    fn frames_are_at_right_angles() {
        let mut random = Random::new(2);
        for dimensions in 2..=4 {
            for _ in 0..100 {
                let [u, v] = random.frame(dimensions);
                let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
                assert!((dot(&u, &u) - 1.0).abs() < 1e-9 && (dot(&v, &v) - 1.0).abs() < 1e-9);
                assert!(dot(&u, &v).abs() < 1e-9);
            }
        }
        assert_eq!(random.frame(1)[1], [0.0]);
    }
}
