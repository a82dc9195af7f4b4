//! Roots of polynomials on an interval, none missed and none invented.
//!
//! A polynomial written in the Bernstein basis of an interval has there at most as many roots as its coefficients have
//! changes of sign, and exactly one if they have one. So an interval is halved until each part has none or one;
//! closed formulas for the quartic, by contrast, cancel away their digits just where a ray grazes a torus.

/// A part narrower than this share of the interval, that still may hold two roots, holds a touch and no crossing.
const NARROWEST: f64 = 1e-13;

/// The real roots of a polynomial of degree `N - 1` in an interval, in ascending order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Roots<const N: usize> {
    at: [f64; N],
    count: usize,
}

impl<const N: usize> Roots<N> {
    /// The crossings of zero of `sum(power[k] * x^k)` for x in `low..high`, found to the last bits of a double.
    pub fn of(power: &[f64; N], low: f64, high: f64) -> Roots<N> {
        let unit = stretch(power, low, high - low);
        let mut roots = Roots { at: [0.0; N], count: 0 };
        roots.isolate(to_bernstein(&unit), 0.0, 1.0, &unit);
        for root in &mut roots.at {
            *root = low + *root * (high - low);
        }
        roots
    }

    /// The roots.
    pub fn as_slice(&self) -> &[f64] {
        &self.at[..self.count]
    }

    fn push(&mut self, root: f64) {
        // Rounding may show a root twice at the border of two parts; there are never more than the degree.
        if self.count < N {
            self.at[self.count] = root;
            self.count += 1;
        }
    }

    /// Adds the roots of `unit` in `low..low + width`, where its Bernstein coefficients are `b`.
    fn isolate(&mut self, b: [f64; N], low: f64, width: f64, unit: &[f64; N]) {
        match sign_changes(&b) {
            (0, _) => {}
            (1, rising) => self.push(refine(unit, low, low + width, rising)),
            _ if width < NARROWEST => {}
            _ => {
                let (left, right) = halve(b);
                let half = width / 2.0;
                self.isolate(left, low, half, unit);
                if right[0] == 0.0 {
                    self.push(low + half);
                }
                self.isolate(right, low + half, half, unit);
            }
        }
    }
}

/// The value of a polynomial and of its derivative.
pub(super) fn evaluate<const N: usize>(power: &[f64; N], x: f64) -> (f64, f64) {
    let (mut value, mut slope) = (0.0, 0.0);
    for &c in power.iter().rev() {
        slope = slope * x + value;
        value = value * x + c;
    }
    (value, slope)
}

/// The polynomial `p(low + width * x)`.
fn stretch<const N: usize>(power: &[f64; N], low: f64, width: f64) -> [f64; N] {
    let mut out = *power;
    // Shift by repeated synthetic division, then scale.
    for first in 0..N {
        for k in (first..N - 1).rev() {
            out[k] += low * out[k + 1];
        }
    }
    let mut factor = 1.0;
    for c in &mut out {
        *c *= factor;
        factor *= width;
    }
    out
}

/// Coefficients in the Bernstein basis of 0..1: `b[i] = sum over k <= i of choose(i, k) / choose(n, k) * a[k]`.
pub(super) fn to_bernstein<const N: usize>(power: &[f64; N]) -> [f64; N] {
    let n = N - 1;
    let mut b = *power;
    let mut choose = 1.0;
    for (k, c) in b.iter_mut().enumerate() {
        *c /= choose;
        choose = choose * (n - k) as f64 / (k + 1) as f64;
    }
    // Pascal's triangle of sums applies choose(i, k).
    for first in 1..N {
        for i in (first..N).rev() {
            b[i] += b[i - 1];
        }
    }
    b
}

/// De Casteljau's construction at the middle: the coefficients of both halves.
fn halve<const N: usize>(mut b: [f64; N]) -> ([f64; N], [f64; N]) {
    let mut left = b;
    for (level, corner) in left.iter_mut().enumerate().skip(1) {
        for i in 0..N - level {
            b[i] = 0.5 * (b[i] + b[i + 1]);
        }
        *corner = b[0];
    }
    // What remains of the triangle is its right edge: b[i] after N - 1 - i averagings.
    (left, b)
}

/// How often the sign changes, zeros left out, and whether it goes up at the first change.
fn sign_changes<const N: usize>(b: &[f64; N]) -> (usize, bool) {
    let (mut changes, mut rising, mut last) = (0, false, 0.0);
    for &c in b {
        if c * last < 0.0 {
            if changes == 0 {
                rising = c > 0.0;
            }
            changes += 1;
        }
        if c != 0.0 {
            last = f64::signum(c);
        }
    }
    (changes, rising)
}

/// The one root between `low` and `high`, by Newton's steps, and by halving where those leave the bracket.
fn refine<const N: usize>(power: &[f64; N], mut low: f64, mut high: f64, rising: bool) -> f64 {
    let mut x = 0.5 * (low + high);
    // Halving alone needs 53 rounds.
    for _ in 0..64 {
        let (value, slope) = evaluate(power, x);
        if value == 0.0 {
            return x;
        }
        if (value < 0.0) == rising {
            low = x;
        } else {
            high = x;
        }
        let newton = x - value / slope;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - x).abs() <= f64::EPSILON {
            return next;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The polynomial with those roots.
    fn product(roots: [f64; 4]) -> [f64; 5] {
        let mut p = [1.0, 0.0, 0.0, 0.0, 0.0];
        for root in roots {
            for k in (0..5).rev() {
                p[k] = if k > 0 { p[k - 1] } else { 0.0 } - root * p[k];
            }
        }
        p
    }

    #[test]
    fn finds_each_root_in_the_interval_and_no_other() {
        let p = product([-3.0, 0.25, 1.5, 1.501]);
        let found = Roots::of(&p, -1.0, 2.0);
        let expected = [0.25, 1.5, 1.501];
        assert_eq!(found.as_slice().len(), 3);
        for (a, b) in found.as_slice().iter().zip(expected) {
            assert!((a - b).abs() < 1e-11, "{a} instead of {b}");
        }
        assert!(Roots::of(&p, 0.3, 1.4).as_slice().is_empty());
    }

    #[test]
    fn finds_roots_in_the_very_middle() {
        // 0 is where the interval is halved first, 1 and -1 where it is halved next.
        let expected = [-1.0, 0.0, 0.5, 1.0];
        let found = Roots::of(&product(expected), -2.0, 2.0);
        assert_eq!(found.as_slice().len(), 4);
        for (a, b) in found.as_slice().iter().zip(expected) {
            assert!((a - b).abs() < 1e-13, "{a} instead of {b}");
        }
    }

    #[test]
    fn a_touch_is_no_crossing() {
        assert!(Roots::of(&[0.09, -0.6, 1.0], 0.0, 1.0).as_slice().len() <= 2);
        assert!(Roots::of(&[0.0900001, -0.6, 1.0], 0.0, 1.0).as_slice().is_empty());
        assert_eq!(Roots::of(&[0.0899999, -0.6, 1.0], 0.0, 1.0).as_slice().len(), 2);
    }

    #[test]
    fn nothing_and_not_a_number_have_no_roots() {
        assert!(Roots::of(&[0.0; 5], 0.0, 1.0).as_slice().is_empty());
        assert!(Roots::of(&[f64::NAN; 5], 0.0, 1.0).as_slice().is_empty());
    }

    #[test]
    fn bernstein_coefficients_end_in_the_values_at_the_ends() {
        let p = [1.0, -2.0, 0.5, 3.0];
        let b = to_bernstein(&p);
        assert_eq!(b[0], 1.0);
        assert!((b[3] - 2.5).abs() < 1e-15);
        let (left, right) = halve(b);
        assert_eq!(left[3], right[0]);
        assert!((left[3] - evaluate(&p, 0.5).0).abs() < 1e-15);
    }
}
