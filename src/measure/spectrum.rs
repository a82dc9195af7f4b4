//! Power by frequency, of plane sections and of long straight ones.

use super::slope;
use rustfft::{Fft, FftPlanner, num_complex::Complex};
use std::sync::Arc;

/// Hann's window: how much of each of `count` samples enters. Its ends are 0, so that what does not repeat
/// after the section makes no edge.
fn window(count: usize) -> Vec<f64> {
    (0..count).map(|i| 0.5 - 0.5 * libm::cos(2.0 * std::f64::consts::PI * i as f64 / count as f64)).collect()
}

/// Cycles in the whole length of the transform's place, whatever their sign.
fn cycles(place: usize, count: usize) -> f64 {
    place.min(count - place) as f64
}

fn plan(count: usize) -> Arc<dyn Fft<f64>> {
    FftPlanner::new().plan_fft_forward(count)
}

/// The mean power spectrum of square plane sections.
///
/// The mean of a section is taken away, Hann's window laid over it, and the squared sizes of its Fourier
/// transform are scaled so that their sum is the section's variance. A noise's power at a frequency is that
/// of all the places of the transform about this distance from 0.
#[derive(Clone)]
pub struct Spectrum {
    side: usize,
    spacing: f64,
    sections: usize,
    /// The sum over sections, row after row.
    power: Vec<f64>,
    window: Vec<f64>,
    fft: Arc<dyn Fft<f64>>,
}

impl Spectrum {
    /// Of no section yet; each is to have `side` × `side` samples so far apart.
    ///
    /// # Panics
    /// If there are fewer than 4 samples to a side.
    pub fn new(side: usize, spacing: f64) -> Spectrum {
        assert!(side >= 4, "a section of {side} x {side} samples");
        let (power, window) = (vec![0.0; side * side], window(side));
        Spectrum { side, spacing, sections: 0, power, window, fft: plan(side) }
    }

    /// Adds a section's samples, row after row.
    ///
    /// # Panics
    /// If they are not as many as the spectrum is for.
    pub fn add(&mut self, samples: &[f32]) {
        let n = self.side;
        assert_eq!(samples.len(), n * n, "samples of a section");
        let mean = samples.iter().map(|&x| f64::from(x)).sum::<f64>() / samples.len() as f64;
        let mut rows: Vec<Complex<f64>> = Vec::with_capacity(n * n);
        for (row, wy) in samples.chunks_exact(n).zip(&self.window) {
            rows.extend(
                row.iter().zip(&self.window).map(|(&x, wx)| Complex::from((f64::from(x) - mean) * wx * wy)),
            );
        }
        self.fft.process(&mut rows);
        let mut columns = vec![Complex::default(); n * n];
        for (i, value) in rows.iter().enumerate() {
            columns[i % n * n + i / n] = *value;
        }
        self.fft.process(&mut columns);
        let squares: f64 = self.window.iter().map(|w| w * w).sum();
        let scale = 1.0 / (squares * squares * (n * n) as f64);
        for (i, value) in columns.iter().enumerate() {
            self.power[i % n * n + i / n] += value.norm_sqr() * scale;
        }
        self.sections += 1;
    }

    /// The difference between neighbouring frequencies, and the least that can be told apart: in cycles a unit.
    pub fn step(&self) -> f64 {
        1.0 / (self.side as f64 * self.spacing)
    }

    /// The highest frequency that the samples show in every direction: in cycles a unit.
    pub fn highest(&self) -> f64 {
        0.5 / self.spacing
    }

    /// Every place's frequency in cycles a unit, and its power.
    fn places(&self) -> impl Iterator<Item = (f64, f64)> {
        let n = self.side;
        let sections = self.sections.max(1) as f64;
        self.power.iter().enumerate().map(move |(i, power)| {
            let (x, y) = (cycles(i % n, n), cycles(i / n, n));
            ((x * x + y * y).sqrt() * self.step(), power / sections)
        })
    }

    /// The share of all power that lies at frequencies from `low` up to, and without, `high`.
    pub fn share(&self, low: f64, high: f64) -> f64 {
        let (mut within, mut all) = (0.0, 0.0);
        for (frequency, power) in self.places() {
            all += power;
            within += if (low..high).contains(&frequency) { power } else { 0.0 };
        }
        within / all
    }

    /// Rings about 0, each of the width of `steps` [steps](Spectrum::step), the middle of the first being 0: for each its
    /// frequency, its power, and how many places it has; up to [`highest`](Spectrum::highest).
    fn rings(&self, steps: f64) -> Vec<(f64, f64, f64)> {
        let width = self.step() * steps;
        let mut rings = vec![(0.0, 0.0, 0.0); (self.highest() / width).floor() as usize + 1];
        for (frequency, power) in self.places() {
            if let Some(ring) = rings.get_mut((frequency / width).round() as usize) {
                *ring = (ring.0 + frequency, ring.1 + power, ring.2 + 1.0);
            }
        }
        rings.iter().map(|(frequency, power, places)| (frequency / places, *power, *places)).collect()
    }

    /// Frequencies and the density of power in the plane of frequencies there: the mean over a ring, in squares of values
    /// over squares of cycles a unit. Its integral over the plane is the variance. That of white noise is level.
    pub fn density(&self) -> Vec<(f64, f64)> {
        let cell = self.step() * self.step();
        self.rings(1.0)
            .into_iter()
            .map(|(frequency, power, places)| (frequency, power / places / cell))
            .collect()
    }

    /// Frequencies and the power of all waves of this frequency, whatever their direction, by cycles a unit: the density
    /// times a circle's length. The area under it between two frequencies is, about, what [`share`](Spectrum::share) is the share of.
    pub fn energy(&self) -> Vec<(f64, f64)> {
        let circle = 2.0 * std::f64::consts::PI;
        self.density()
            .into_iter()
            .map(|(frequency, density)| (frequency, circle * frequency * density))
            .collect()
    }

    /// The power of the density of which it falls or rises between two frequencies: its slope where both axes are
    /// logarithmic. Each octave counts alike.
    pub fn slope(&self, low: f64, high: f64) -> f64 {
        // Means over thirds of an octave, or else the many high frequencies would outweigh the few low ones.
        let third = |frequency: f64| (3.0 * libm::log2(frequency / low)).floor() as usize;
        let mut parts = vec![(0.0, 0.0); third(high) + 1];
        for (frequency, power) in self.places() {
            if frequency >= low && frequency < high {
                let part = &mut parts[third(frequency)];
                *part = (part.0 + power, part.1 + 1.0);
            }
        }
        let known = parts.iter().enumerate().filter(|(_, (power, _))| *power > 0.0);
        slope(known.map(|(i, (power, places))| ((i as f64 + 0.5) / 3.0, libm::log2(power / places))))
    }
}

/// The mean power spectrum of long straight sections.
#[derive(Clone)]
pub struct LineSpectrum {
    spacing: f64,
    sections: usize,
    power: Vec<f64>,
    window: Vec<f64>,
    fft: Arc<dyn Fft<f64>>,
}

impl LineSpectrum {
    /// Of no section yet; each is to have so many samples so far apart.
    ///
    /// # Panics
    /// If there are fewer than 4.
    pub fn new(count: usize, spacing: f64) -> LineSpectrum {
        assert!(count >= 4, "a section of {count} samples");
        LineSpectrum {
            spacing,
            sections: 0,
            power: vec![0.0; count],
            window: window(count),
            fft: plan(count),
        }
    }

    /// Adds a section's samples.
    ///
    /// # Panics
    /// If they are not as many as the spectrum is for.
    pub fn add(&mut self, samples: &[f32]) {
        assert_eq!(samples.len(), self.power.len(), "samples of a section");
        let mean = samples.iter().map(|&x| f64::from(x)).sum::<f64>() / samples.len() as f64;
        let mut line: Vec<Complex<f64>> = samples
            .iter()
            .zip(&self.window)
            .map(|(&x, w)| Complex::from((f64::from(x) - mean) * w))
            .collect();
        self.fft.process(&mut line);
        let squares: f64 = self.window.iter().map(|w| w * w).sum();
        for (power, value) in self.power.iter_mut().zip(&line) {
            *power += value.norm_sqr() / (squares * samples.len() as f64);
        }
        self.sections += 1;
    }

    /// Frequencies in cycles a unit and amplitudes there, in bands of about so many cycles a unit: roots of the power by
    /// cycles a unit, that of a frequency and its negative taken together.
    pub fn amplitude(&self, band: f64) -> Vec<(f64, f64)> {
        let n = self.power.len();
        let step = 1.0 / (n as f64 * self.spacing);
        let wide = ((band / step).round() as usize).max(1);
        let half = &self.power[..n / 2];
        let bands = half.chunks(wide).enumerate().map(|(i, powers)| {
            let middle = (i * wide) as f64 + (powers.len() - 1) as f64 / 2.0;
            let mean = powers.iter().sum::<f64>() / (powers.len() * self.sections.max(1)) as f64;
            (middle * step, (2.0 * mean / step).sqrt())
        });
        bands.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::{Moments, Random};

    /// Waves of so many cycles a unit, of amplitude 1, in a direction.
    fn waves(side: usize, spacing: f64, [fx, fy]: [f64; 2]) -> Vec<f32> {
        let at = |i: usize| ((i % side) as f64 * fx + (i / side) as f64 * fy) * spacing;
        (0..side * side).map(|i| libm::sin(2.0 * std::f64::consts::PI * at(i)) as f32).collect()
    }

    #[test]
    fn a_sine_is_at_its_frequency() {
        let mut spectrum = Spectrum::new(128, 1.0 / 8.0);
        spectrum.add(&waves(128, 1.0 / 8.0, [0.6, 0.8]));
        spectrum.add(&waves(128, 1.0 / 8.0, [-0.8, 0.6]));
        assert_eq!((spectrum.step(), spectrum.highest()), (1.0 / 16.0, 4.0));
        assert!(spectrum.share(0.9, 1.1) > 0.97 && spectrum.share(0.0, 0.5) < 1e-3);
        assert!((spectrum.share(0.0, 100.0) - 1.0).abs() < 1e-12);
        let energy = spectrum.energy();
        let most = energy.iter().copied().fold((0.0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
        assert!((most.0 - 1.0).abs() < 0.04, "{most:?}");
        // Half a variance, but that the window lets only the middle count.
        let all: f64 = energy.iter().map(|(_, e)| e * spectrum.step()).sum();
        assert!((all - 0.5).abs() < 0.05, "{all}");
    }

    #[test]
    fn white_noise_is_level() {
        let mut random = Random::new(6);
        let mut spectrum = Spectrum::new(128, 0.5);
        let mut variance = 0.0;
        for _ in 0..8 {
            let samples: Vec<f32> = (0..128 * 128).map(|_| random.within(1.0) as f32).collect();
            variance += Moments::of(&samples).rms() * Moments::of(&samples).rms() / 8.0;
            spectrum.add(&samples);
        }
        // The area of the square of frequencies is 2² cycles a unit.
        for (frequency, density) in &spectrum.density()[8..] {
            assert!((density / (variance / 4.0) - 1.0).abs() < 0.3, "{frequency}: {density}");
        }
        assert!(spectrum.slope(0.1, 0.9).abs() < 0.1);
        let disc = std::f64::consts::PI * 0.25 / 4.0;
        assert!((spectrum.share(0.0, 0.5) - disc).abs() < 0.01);
    }

    #[test]
    fn a_slope_is_found() {
        // White noise, summed along x and then along y: of waves along an axis the power falls by f^-2.
        let mut random = Random::new(7);
        let mut spectrum = Spectrum::new(256, 1.0);
        for _ in 0..4 {
            let steps: Vec<f64> = (0..256).map(|_| random.within(1.0)).collect();
            let sums: Vec<f32> = steps
                .iter()
                .scan(0.0, |sum, x| {
                    *sum += x;
                    Some(*sum as f32)
                })
                .collect();
            spectrum.add(&(0..256 * 256).map(|i| sums[i % 256]).collect::<Vec<_>>());
        }
        // A ring's places are as many as its frequency, and only two of them are on the axis: one more power.
        let slope = spectrum.slope(0.05, 0.4);
        assert!((slope + 3.0).abs() < 0.35, "{slope}");
    }

    #[test]
    fn a_long_line() {
        let mut random = Random::new(8);
        let mut spectrum = LineSpectrum::new(8192, 1.0 / 4.0);
        for _ in 0..4 {
            let noise: Vec<f32> = (0..8192)
                .map(|i| {
                    let wave = libm::sin(2.0 * std::f64::consts::PI * 0.5 * i as f64 / 4.0);
                    (wave + random.within(0.1)) as f32
                })
                .collect();
            spectrum.add(&noise);
        }
        let amplitude = spectrum.amplitude(0.05);
        let most = amplitude.iter().copied().fold((0.0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
        assert!((most.0 - 0.5).abs() < 0.05, "{most:?}");
        // All the power, of which the wave has a half and the white noise 0.01 / 3.
        let all: f64 = amplitude.iter().map(|(_, a)| a * a * 0.05).sum();
        assert!((all - 0.5033).abs() < 0.02, "{all}");
        let level = amplitude.last().unwrap().1;
        assert!((level * level * 2.0 - 0.01 / 3.0).abs() < 0.001, "{level}");
    }
}
