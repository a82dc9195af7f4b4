//! The discrete Fourier transform of periodic tables, by the fast algorithm (Cooley and Tukey 1965, radix 2).
//!
//! Why one of our own: libraries choose their algorithm by the machine they find, with fused multiply-adds on
//! one and without on the next, so the last bits would differ. What is made here gets into pictures, which
//! are the same everywhere: plain f64 arithmetic in a fixed order, sines and cosines of the crate `libm`.

use std::ops::{Add, Mul, Sub};

/// A complex number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Complex {
    pub re: f64,
    pub im: f64,
}

impl Complex {
    /// The number of length 1 at an angle.
    pub(super) fn unit(angle: f64) -> Complex {
        let (im, re) = libm::sincos(angle);
        Complex { re, im }
    }

    /// The number mirrored at the real axis.
    pub(super) fn conjugate(self) -> Complex {
        Complex { im: -self.im, ..self }
    }

    /// The square of its length.
    pub(super) fn square(self) -> f64 {
        self.re * self.re + self.im * self.im
    }
}

impl Add for Complex {
    type Output = Complex;
    fn add(self, other: Complex) -> Complex {
        Complex { re: self.re + other.re, im: self.im + other.im }
    }
}

impl Sub for Complex {
    type Output = Complex;
    fn sub(self, other: Complex) -> Complex {
        Complex { re: self.re - other.re, im: self.im - other.im }
    }
}

impl Mul for Complex {
    type Output = Complex;
    fn mul(self, other: Complex) -> Complex {
        Complex { re: self.re * other.re - self.im * other.im, im: self.re * other.im + self.im * other.re }
    }
}

impl Mul<f64> for Complex {
    type Output = Complex;
    fn mul(self, factor: f64) -> Complex {
        Complex { re: self.re * factor, im: self.im * factor }
    }
}

/// From values to the waves that they are a sum of, or back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    /// The mean product of the values with e^(-2πi k·x / size), for each k.
    Forward,
    /// The sum of the waves e^(2πi k·x / size), for each x.
    Inverse,
}

/// Transforms a table of `size` numbers along each of D axes, the first being the fastest; `size` is a power
/// of two. Negative frequencies stand where they are found modulo `size`.
///
/// # Panics
/// If the table is not of `size`^D numbers.
pub(super) fn transform<const D: usize>(table: &mut [Complex], size: usize, direction: Direction) {
    assert!(size.is_power_of_two() && table.len() == size.pow(D as u32), "{} numbers", table.len());
    let sign = if direction == Direction::Forward { -1.0 } else { 1.0 };
    let turn = |k: usize| sign * 2.0 * std::f64::consts::PI * k as f64 / size as f64;
    let turns: Vec<Complex> = (0..size / 2).map(|k| Complex::unit(turn(k))).collect();
    let factor = if direction == Direction::Forward { 1.0 / size as f64 } else { 1.0 };
    let mut line = vec![Complex::default(); size];
    for axis in 0..D {
        let step = size.pow(axis as u32);
        for block in table.chunks_exact_mut(step * size) {
            for first in 0..step {
                for (number, from) in line.iter_mut().zip(block[first..].iter().step_by(step)) {
                    *number = *from * factor;
                }
                transform_line(&mut line, &turns);
                for (number, to) in line.iter().zip(block[first..].iter_mut().step_by(step)) {
                    *to = *number;
                }
            }
        }
    }
}

/// One line, given the powers of its first root of unity.
fn transform_line(line: &mut [Complex], turns: &[Complex]) {
    let size = line.len();
    // In the order of the bits reversed, even and odd numbers of each half stand in halves of their own.
    let mut reversed = 0;
    for i in 1..size {
        // One more, counted from the highest bit down.
        let mut bit = size / 2;
        while reversed & bit != 0 {
            reversed ^= bit;
            bit /= 2;
        }
        reversed |= bit;
        if i < reversed {
            line.swap(i, reversed);
        }
    }
    let mut half = 1;
    while half < size {
        for pair in line.chunks_exact_mut(2 * half) {
            let (even, odd) = pair.split_at_mut(half);
            for ((even, odd), turn) in even.iter_mut().zip(odd).zip(turns.iter().step_by(size / (2 * half))) {
                let turned = *odd * *turn;
                (*even, *odd) = (*even + turned, *even - turned);
            }
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Some numbers without order.
    fn numbers(n: usize) -> Vec<Complex> {
        let part = |i: usize| (i.wrapping_mul(0x9E37_79B1) >> 7 & 0xFFFF) as f64 / 65536.0 - 0.5;
        (0..n).map(|i| Complex { re: part(2 * i), im: part(2 * i + 1) }).collect()
    }

    /// The sum as it is defined.
    fn direct<const D: usize>(table: &[Complex], size: usize, direction: Direction) -> Vec<Complex> {
        let sign = if direction == Direction::Forward { -1.0 } else { 1.0 };
        let scale = if direction == Direction::Forward { 1.0 / table.len() as f64 } else { 1.0 };
        let at = |i: usize, axis: usize| i / size.pow(axis as u32) % size;
        (0..table.len())
            .map(|k| {
                let sum = table.iter().enumerate().fold(Complex::default(), |sum, (x, number)| {
                    let product = (0..D).map(|axis| at(k, axis) * at(x, axis)).sum::<usize>() % size;
                    let angle = sign * 2.0 * std::f64::consts::PI * product as f64 / size as f64;
                    sum + *number * Complex::unit(angle)
                });
                sum * scale
            })
            .collect()
    }

    fn check<const D: usize>(size: usize) {
        let table = numbers(size.pow(D as u32));
        for direction in [Direction::Forward, Direction::Inverse] {
            let mut fast = table.clone();
            transform::<D>(&mut fast, size, direction);
            for (fast, known) in fast.iter().zip(direct::<D>(&table, size, direction)) {
                assert!((*fast - known).square() < 1e-24, "{D}-D, {size}: {fast:?} {known:?}");
            }
        }
        let mut back = table.clone();
        transform::<D>(&mut back, size, Direction::Forward);
        transform::<D>(&mut back, size, Direction::Inverse);
        assert!(back.iter().zip(&table).all(|(a, b)| (*a - *b).square() < 1e-28));
    }

    #[test]
    fn is_the_sum_of_its_definition() {
        for size in [2, 4, 8, 64, 256] {
            check::<1>(size);
        }
        check::<2>(16);
        check::<3>(2);
        check::<3>(8);
    }

    #[test]
    fn the_same_bits_on_every_machine() {
        // Pinned: a change of these changes pictures.
        let mut table = numbers(4096);
        transform::<3>(&mut table, 16, Direction::Inverse);
        let mixed = table.iter().fold(0_u64, |mixed, number| {
            (mixed ^ number.re.to_bits()).rotate_left(7).wrapping_mul(0x9E37_79B9_7F4A_7C15)
                ^ number.im.to_bits()
        });
        assert_eq!(mixed, 9_364_991_460_371_015_952);
    }
}
