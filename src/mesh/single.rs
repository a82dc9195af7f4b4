//! Doubles that stand for singles: which numbers a format of 32-bit floats holds without loss.

use super::Mesh;

/// The double nearest to the shortest decimal number that reads as `x`: 1.1 for the single nearest to 1.1. It has few
/// digits as text, and converts back to `x`.
pub fn decimal(x: f32) -> f64 {
    const POWERS: [f64; 23] = [
        1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17,
        1e18, 1e19, 1e20, 1e21, 1e22,
    ];
    let exact = f64::from(x);
    if x == 0.0 || !x.is_finite() {
        return exact;
    }
    // Six digits, or up to nine if need be. Both numbers of the quotient are exact, so it is the double nearest to the decimal.
    let before = libm::log10(exact.abs()).floor() as i32;
    for digits in 6..=9 {
        let shift = digits - 1 - before;
        let Some(&power) = POWERS.get(shift.unsigned_abs() as usize) else { break };
        let short =
            if shift >= 0 { (exact * power).round() / power } else { (exact / power).round() * power };
        if short as f32 == x {
            return short;
        }
    }
    x.to_string().parse().unwrap_or(exact)
}

/// The single that stands for a number: one that has just its value, or whose shortest decimal has. (The latter may be off by
/// half a step of singles, as 500000.1 is by 0.006.)
fn single(x: f64) -> Option<f32> {
    let nearest = x as f32;
    (f64::from(nearest) == x || decimal(nearest) == x).then_some(nearest)
}

/// Formats a number in its shortest form: as a single if it equals one, otherwise as a double.
pub fn shortest(x: f64) -> String {
    single(x).map_or_else(|| x.to_string(), |x| x.to_string())
}

impl Mesh {
    /// Whether points keep their places as singles: all of them are singles, or the mesh is near the origin and singles stand for
    /// its numbers.
    pub(super) fn fits_singles(&self) -> bool {
        let mut numbers = self.points.iter().flatten();
        match self.coarse_step() {
            Some(_) => numbers.all(|&c| f64::from(c as f32) == c),
            None => numbers.all(|&c| single(c).is_some()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_and_its_shortest_decimal_stand_for_each_other() {
        let mut state = 1u64;
        let mut all =
            vec![0.0, -0.0, 1.1, 0.1, -3.25, 16_777_216.0, f32::MAX, f32::MIN_POSITIVE, 1e-45, 1e22];
        for _ in 0..200_000 {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            all.push(f32::from_bits((state >> 32) as u32));
        }
        for x in all.into_iter().filter(|x| x.is_finite()) {
            let short = decimal(x);
            assert_eq!(short as f32, x);
            assert_eq!(single(short), Some(x));
            assert_eq!(single(f64::from(x)), Some(x));
            // Not more digits than the standard library writes for the single.
            assert!(short.to_string().len() <= x.to_string().len(), "{x} {short}");
        }
        assert_eq!([decimal(1.1), decimal(0.3)], [1.1, 0.3]);
        assert_eq!([single(1.0 / 3.0), single(0.123_456_789_012)], [None; 2]);
    }
}
