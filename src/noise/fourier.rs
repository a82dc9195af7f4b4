//! Fourier spectral synthesis: Saupe 1988 and Voss 1988 (both in "The Science of Fractal Images"), as told by
//! Peachey, "Explicit Noise Algorithms" and "Fourier Spectral Synthesis".
//!
//! The noise is the sum of all waves that fit into a period, a whole number of times along each axis, up to a
//! highest frequency. Their amplitudes are complex Gaussian numbers of variance |f|^-beta, so that phases are
//! even on the circle. An inverse Fourier transform sums the waves at the points of a table, once, when the
//! field is made; a spline stands for the sum between the points, see `table` and `spline`.
//!
//! - |f|^-beta is the density of power at the frequency vector f, in as many dimensions as the noise has. A
//!   section of one dimension fewer, be it a plane through space or a line on a plane, gathers the power of
//!   all f that look alike in it: its density is as frequency^(1 - beta), where that still falls, and far
//!   below the highest frequency; towards that it falls faster, as ever fewer waves are left to gather. What
//!   is called 1/f noise is beta 1, 2, 3 in one, two, three dimensions; fractional Brownian motion of
//!   exponent H is 2H + 1, 2H + 2, 2H + 3.
//! - If beta is not given, lines through noise of any dimension would fall as frequency^(-5/3) if there were
//!   no highest frequency, as fluctuations in turbulent air do (Kolmogorov 1941), and with them clouds. In
//!   three dimensions lines were measured to fall as -1.7 about 0.1 cycle a unit and -2.1 about 0.3, planes
//!   as -2.7 about 0.15 and -2.8 about 0.3.
//! - The highest frequency is 3/4 of what the table's points could tell apart. What the spline adds to the
//!   sum, waves above 1.25 cycles a unit, is then half a percent of it in size, and 3 % with beta 0, in three
//!   dimensions.

use super::fft::Complex;
use super::field::{ByTiles, Field};
use super::hash;
use super::kind::{Contract, Kind, Smoothness, Unfit};
use super::lattice::{Endless, Lattice};
use super::options::{Opt, Params};
use super::table::{Table, gaussian, period, place, size};
use std::sync::Arc;

/// Spectral synthesis, 1988.
pub static KIND: Kind = Kind {
    name: "fourier",
    brief: "a table filled by Fourier synthesis, power falling as a power of frequency: clouds in one call",
    dimensions: 1..=3,
    options: &[Opt::Beta],
    contract: Contract {
        // Measured: the extremes of 300 seeds (in one dimension 2000), rounded up. A sum of so many waves is
        // Gaussian, and has no bounds of use.
        bounds: &[[-1.4, 1.4], [-1.6, 1.6], [-1.7, 1.7]],
        mean: 0.0,
        deviation: 0.3,
        lattice: "Gaussian, as everywhere",
        smoothness: Smoothness::C2,
        cost: 3.6,
        source: "Saupe 1988 and Voss 1988, as described by Peachey, \"Fourier Spectral Synthesis\"",
        remarks: "It repeats after 512 units in one dimension, 256 in two, 32 in three. Waves have up to 3/4 \
                  cycle a unit. Its values are Gaussian: the bounds are the extremes of 300 seeds. Mean and \
                  deviation are those of a whole period. Most of the power is in the longest waves, so \
                  within a few units it varies less than the deviation says, and what lies some units apart \
                  is alike; multiply the coordinates to see more of it. `beta` is of the density of power in \
                  as many dimensions as the point has; if not given it is 5/3, 8/3 or 11/3, of which lines, \
                  well below the highest frequency, fall as 5/3, as in clouds. Where points lie close \
                  together it costs as much as `gradient`; the first use makes a table of 1 MB.",
    },
    make: |d, params| {
        Ok(match d {
            1 => Arc::new(ByTiles(synthesis::<1>(params)?)) as Arc<dyn Field>,
            2 => Arc::new(ByTiles(synthesis::<2>(params)?)),
            _ => Arc::new(ByTiles(synthesis::<3>(params)?)),
        })
    },
};

/// The highest frequency, in cycles a unit.
const HIGHEST: f64 = 0.75;

fn synthesis<const D: usize>(params: &Params) -> Result<Table<D>, Unfit> {
    const USUAL: [f32; 3] = [5.0 / 3.0, 8.0 / 3.0, 11.0 / 3.0];
    let beta = params.number(Opt::Beta, USUAL[D - 1], 0.0..=8.0)?;
    Ok(Table::of_spectrum(spectrum::<D>(params.seed, f64::from(beta))))
}

/// How often the wave of a place in the table of waves goes into a period, along each axis.
fn cycles<const D: usize>(i: usize) -> [i32; D] {
    let half = size(D) as i32 / 2;
    place::<D>(i).map(|k| if (k as i32) < half { k as i32 } else { k as i32 - 2 * half })
}

/// The amplitudes of all waves. Those of f and -f are conjugate, so that their sum is real.
fn spectrum<const D: usize>(seed: u32, beta: f64) -> Vec<Complex> {
    let lattice = Lattice::<_, D>::new(seed, Endless);
    let mut spectrum = vec![Complex::default(); size(D).pow(D as u32)];
    for (i, wave) in spectrum.iter_mut().enumerate() {
        let k = cycles::<D>(i);
        let frequency = f64::from(k.iter().map(|k| k * k).sum::<i32>()).sqrt() / period(D) as f64;
        if frequency == 0.0 || frequency > HIGHEST {
            continue;
        }
        // Of the two, one is random: that of which the last number that is not 0 is positive.
        let mirrored = k.iter().rev().find(|k| **k != 0).is_some_and(|k| *k < 0);
        let joined = (0..D).fold(0, |joined, axis| {
            joined ^ lattice.key(axis, if mirrored { -k[axis] } else { k[axis] } as f32)
        });
        let [re, im] = gaussian(hash::point(joined));
        let amplitude = Complex { re, im } * libm::pow(frequency, -0.5 * beta);
        *wave = if mirrored { amplitude.conjugate() } else { amplitude };
    }
    spectrum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Isa;

    /// Points anywhere, as many as there are.
    fn points<const D: usize>(n: u32) -> Vec<Vec<f32>> {
        let number = |i: u32| (hash::mix(i) >> 8) as f32 / 8192.0 - 1024.0;
        (0..D as u32).map(|k| (0..n).map(|i| number(4 * i + k)).collect()).collect()
    }

    fn noise<const D: usize>(params: &Params, p: &[Vec<f32>]) -> Vec<f32> {
        let p: Vec<&[f32]> = p.iter().map(Vec::as_slice).collect();
        let mut out = vec![0.0; p[0].len()];
        KIND.field(D, params).unwrap().noise(Isa::detect(), &p, &mut out);
        out
    }

    /// The error of the spline, relative to the standard deviation, against the sum of all waves.
    fn error<const D: usize>(beta: f32) -> f64 {
        let spectrum = spectrum::<D>(7, f64::from(beta));
        let scale = 0.3 / spectrum.iter().map(|wave| wave.square()).sum::<f64>().sqrt();
        let p = points::<D>(40);
        let got = noise::<D>(&Params::seeded(7).with(Opt::Beta, &[beta]), &p);
        let mut squares = 0.0;
        for (lane, got) in got.iter().enumerate() {
            let mut sum = Complex::default();
            for (i, wave) in spectrum.iter().enumerate().filter(|(_, wave)| wave.square() > 0.0) {
                let k = cycles::<D>(i);
                let turns: f64 = (0..D).map(|a| f64::from(k[a]) * f64::from(p[a][lane])).sum();
                sum = sum + *wave * Complex::unit(turns / period(D) as f64 * 2.0 * std::f64::consts::PI);
            }
            assert!(sum.im.abs() * scale < 1e-9);
            squares += (sum.re * scale - f64::from(*got)) * (sum.re * scale - f64::from(*got));
        }
        (squares / 40.0).sqrt() / 0.3
    }

    #[test]
    fn is_the_sum_of_its_waves() {
        // What is left is what the spline adds above the band.
        for (error, most) in [
            (error::<1>(5.0 / 3.0), 0.006),
            (error::<2>(8.0 / 3.0), 0.005),
            (error::<3>(11.0 / 3.0), 0.01),
            (error::<3>(0.0), 0.05),
        ] {
            assert!(error < most, "{error}");
        }
    }

    fn check_spectrum<const D: usize>(beta: f64) {
        let spectrum = spectrum::<D>(3, beta);
        // By octave; each wave has twice the power of a Gaussian number.
        let mut octaves = [(0.0, 0.0); 12];
        for (i, wave) in spectrum.iter().enumerate() {
            let f = cycles::<D>(i).iter().map(|k| f64::from(k * k)).sum::<f64>().sqrt() / period(D) as f64;
            if f == 0.0 || f > HIGHEST {
                assert_eq!(*wave, Complex::default());
                continue;
            }
            let octave = &mut octaves[libm::log2(f * period(D) as f64 + 0.01) as usize];
            octave.0 += wave.square() * libm::pow(f, beta) / 2.0;
            octave.1 += 1.0;
        }
        // The power of a few waves can be anything.
        for (octave, (power, waves)) in octaves.iter().enumerate().filter(|(_, o)| o.1 >= 16.0) {
            // They come in pairs.
            let tolerance = 4.0 * libm::sqrt(2.0 / waves);
            let mean = power / waves;
            assert!((mean - 1.0).abs() < tolerance, "{D}-D octave {octave}: {mean}, {waves} waves");
        }
    }

    #[test]
    fn power_falls_as_told() {
        check_spectrum::<1>(5.0 / 3.0);
        check_spectrum::<2>(0.0);
        check_spectrum::<2>(4.0);
        check_spectrum::<3>(11.0 / 3.0);
    }

    #[test]
    fn options() {
        let made = |beta: &[f32]| KIND.field(2, &Params::default().with(Opt::Beta, beta)).map(|_| ());
        assert!(made(&[0.0]).is_ok() && made(&[8.0]).is_ok());
        assert_eq!(made(&[-1.0]).unwrap_err().message, "beta must be from 0 to 8, found -1");
        assert!(made(&[f32::NAN]).is_err() && made(&[1.0, 2.0]).is_err());
        assert!(KIND.field(4, &Params::default()).is_err());
        let p = points::<2>(64);
        let usual = noise::<2>(&Params::default(), &p);
        assert_eq!(usual, noise::<2>(&Params::default().with(Opt::Beta, &[8.0 / 3.0]), &p));
        assert_ne!(usual, noise::<2>(&Params::default().with(Opt::Beta, &[2.5]), &p));
    }

    #[test]
    fn known_values() {
        // Pinned: a change of these changes every picture.
        let p = points::<3>(2);
        let got = [noise::<1>(&Params::default(), &p[..1]), noise::<2>(&Params::seeded(1), &p[..2])].concat();
        let got = [got, noise::<3>(&Params::default(), &p)].concat();
        let known = [0x3e8302e8, 0xbe9a90f1, 0xbe9a647e, 0xbd014718, 0x3e909243, 0xbd20269c];
        let bits: Vec<u32> = got.iter().map(|v| v.to_bits()).collect();
        assert_eq!(bits, known, "{got:?}");
    }
}
