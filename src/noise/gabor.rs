//! Gabor noise: Lagae, Lefebvre, Drettakis, Dutré, "Procedural Noise using Sparse Gabor Convolution", SIGGRAPH 2009.
//!
//! Impulses lie scattered over space, a Poisson process; about each stand waves under a Gaussian, with a
//! random phase, along a direction of its own or along a given one (see `impulses` for how they are found). The
//! spectrum is a band about the frequency: a Gaussian there, turned about the origin or, with a direction, at
//! both ends of it.
//!
//! The Gaussian ends at three deviations, where a window lets it go to 0 with slope 0.

use super::impulses::{self, Bell, CROWD, GAUSSIAN_RADIUS, Gabor, LEAST, Layout, UNIT, Waves, integral};
use super::kind::{Contract, Kind, Made, Smoothness, Unfit};
use super::options::{Opt, Params};
use std::f64::consts::{LN_2, PI};

/// Gabor noise.
pub static KIND: Kind = Kind {
    name: "gabor",
    brief: "random waves, each under a Gaussian: a band of frequencies",
    dimensions: 1..=3,
    options: &[Opt::Frequency, Opt::Bandwidth, Opt::Direction, Opt::Density, Opt::Period],
    contract: Contract {
        // Poisson's numbers have no bound.
        bounds: &[[f32::NEG_INFINITY, f32::INFINITY]; 3],
        mean: 0.0,
        deviation: 0.3,
        lattice: "any, as elsewhere",
        smoothness: Smoothness::C1,
        cost: 330.0,
        source: "Lagae et al. 2009, section 3",
        remarks: "Unbounded in principle; of a million points one is beyond ±1.7, and one of a thousand beyond ±1.05. \
                  By default frequency is 1 and bandwidth one octave, between the frequencies of half the amplitude; \
                  waves go along random directions; density is such that eight impulses lie in the Gaussian's \
                  volume. Waves reach 1.69 units then, and further at lower frequencies or less bandwidth: where they \
                  reach more than 3, a period must be a multiple of 2, or of 4, and so on. Sections of the noise in three \
                  dimensions show lower frequencies too; for a band in the plane take the noise in two.",
    },
    make: |d, params| match d {
        1 => make::<1>(params),
        2 => make::<2>(params),
        _ => make::<3>(params),
    },
};

/// The standard deviation.
const DEVIATION: f64 = 0.3;
/// Impulses in the Gaussian's volume, (2πσ²)^(D/2), by default: the excess kurtosis is 1.5 divided by it.
const IMPULSES: f64 = 8.0;
/// The longest period, in cells: up to here it is exact.
const LONGEST: f64 = (1 << 22) as f64;

fn make<const D: usize>(params: &Params) -> Made {
    let frequency = f64::from(params.number(Opt::Frequency, 1.0, 0.01..=100.0)?);
    let bandwidth = f64::from(params.number(Opt::Bandwidth, 1.0, 0.1..=4.0)?);
    // So far off the frequency the amplitude is half of what it is there.
    let half = frequency * (1.0 - 2.0 / (libm::exp2(bandwidth) + 1.0));
    let deviation = libm::sqrt(2.0 * LN_2) / (2.0 * PI * half);
    let radius = GAUSSIAN_RADIUS * deviation;
    let usual = IMPULSES / libm::pow(2.0 * PI * deviation * deviation, D as f64 / 2.0);
    let density = f64::from(params.number(Opt::Density, usual as f32, 0.0..=f32::MAX)?);
    let bell = Bell::gaussian(1.0);
    // Campbell's theorem; of cos² the mean is a half.
    let energy = 0.5 * density * libm::pow(radius, D as f64) * integral(D, 1.0, |r| bell.at(r) * bell.at(r));
    let layout =
        layout::<D>(params, |octave| Layout { octave, radius, density, scale: DEVIATION / energy.sqrt() })?;
    let side = layout.side();
    let waves = frequency * side * f64::from(UNIT);
    let waves = match impulses::direction::<D>(params)? {
        Some(direction) => Waves::Along(direction.map(|x| (x * waves) as f32)),
        None => Waves::Around(waves as f32),
    };
    impulses::field(Box::new(Gabor(Bell::gaussian(radius / side))), Some(waves), &layout, params)
}

/// A number to about two digits, as a reader would write it.
fn two(x: f64) -> String {
    let places = (1.0 - libm::floor(libm::log10(x))).max(0.0) as usize;
    let text = format!("{x:.places$}");
    if places > 0 { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

/// The layout of the best cells.
fn layout<const D: usize>(params: &Params, of: impl Fn(i32) -> Layout) -> Result<Layout, Unfit> {
    let period = params.period::<D>()?.unwrap_or([0.0; D]);
    // Half the radius to all of it; smaller ones, if the period needs them.
    let best = of(libm::floor(libm::log2(of(0).radius)) as i32);
    let most = period.iter().filter(|p| **p > 0.0).map(|p| (*p as u32).trailing_zeros() as i32);
    let octave = most.fold(best.octave, i32::min);
    let (layout, radius) = (of(octave), best.radius);
    if let Some(p) = period.iter().find(|p| f64::from(**p) > LONGEST * layout.side()) {
        let longest = LONGEST * layout.side();
        let message = format!("period must be at most {longest} for waves that reach {radius:.3} units");
        return Err(Unfit::of(Opt::Period, format!("{message}, found {p}")));
    }
    if layout.reaches() {
        let volume = libm::pow(layout.side(), D as f64);
        let (least, most, density) = (LEAST / volume, CROWD / volume, layout.density);
        if layout.fits(D) {
            return Ok(layout);
        }
        let message = format!(
            "density must be from {} to {} for waves that reach {radius:.2} units",
            two(least),
            two(most)
        );
        return Err(Unfit::of(Opt::Density, format!("{message}, found {density}")));
    }
    let message =
        format!("period must be a multiple of {} for waves that reach {radius:.1} units", best.side());
    Err(Unfit::of(Opt::Period, message).hint("Higher frequencies or more bandwidth reach less far."))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Isa;

    fn noise(params: &Params, p: &[Vec<f32>]) -> Vec<f32> {
        let mut out = vec![0.0; p[0].len()];
        let p: Vec<&[f32]> = p.iter().map(Vec::as_slice).collect();
        KIND.field(p.len(), params).unwrap().noise(Isa::detect(), &p, &mut out);
        out
    }

    #[test]
    fn known_values() {
        // Pinned: a change of these changes every picture.
        let p: Vec<Vec<f32>> = [0.5, 1.25, -2.75].map(|x| vec![x]).to_vec();
        let got: Vec<u32> = (1..=3).map(|d| noise(&Params::default(), &p[..d])[0].to_bits()).collect();
        assert_eq!(got, [0x3da0_8ea9, 0x3e1f_6dfb, 0xbf14_6758], "{got:x?}");
    }

    /// The power at frequencies along x, of the noise in the plane, and how much varies along y.
    fn spectrum(params: &Params, steps: usize) -> (Vec<f64>, f64) {
        const N: usize = 256;
        let (mut power, mut across) = (vec![0.0; N / 2], 0.0);
        for row in 0..60 {
            let x: Vec<f32> = (0..N).map(|i| i as f32 / steps as f32).collect();
            let y = vec![row as f32 * 7.3; N];
            let next = y.iter().map(|y| y + 0.05).collect();
            let (line, beside) = (noise(params, &[x.clone(), y]), noise(params, &[x, next]));
            across += line.iter().zip(&beside).map(|(a, b)| f64::from((a - b) * (a - b))).sum::<f64>();
            for (f, power) in power.iter_mut().enumerate() {
                let (mut re, mut im) = (0.0, 0.0);
                for (i, v) in line.iter().enumerate() {
                    let turn = 2.0 * PI * i as f64 / N as f64;
                    let v = f64::from(*v) * (1.0 - libm::cos(turn));
                    re += v * libm::cos(turn * f as f64);
                    im += v * libm::sin(turn * f as f64);
                }
                *power += re * re + im * im;
            }
        }
        let all: f64 = power.iter().sum();
        (power.iter().map(|p| p / all).collect(), across / (60 * N) as f64)
    }

    #[test]
    fn energy_lies_in_its_band() {
        // 8 samples a unit: 32 frequencies to a cycle.
        let along = Params::seeded(1).with(Opt::Direction, &[2.0, 0.0]);
        let (power, across) = spectrum(&along, 8);
        let share = |power: &[f64], from: f64, to: f64| -> f64 {
            power
                .iter()
                .enumerate()
                .filter(|(f, _)| (from..to).contains(&(*f as f64 / 32.0)))
                .map(|(_, p)| p)
                .sum()
        };
        assert!(share(&power, 0.5, 1.5) > 0.98, "{}", share(&power, 0.5, 1.5));
        // Of the power a quarter is left at 2/3 and 4/3: 76 % of a Gaussian lies between.
        let within = share(&power, 0.667, 1.333);
        assert!((within - 0.9).abs() < 0.05, "{within}");
        let (narrow, less) = spectrum(&along.clone().with(Opt::Bandwidth, &[0.4]), 8);
        assert!(share(&narrow, 0.8, 1.2) > 0.95 && less < across, "{less} {across}");
        let (turned, more) = spectrum(&Params::seeded(1).with(Opt::Direction, &[0.0, 1.0]), 8);
        assert!(share(&turned, 0.0, 0.5) > 0.9 && more > 3.0 * across, "{more} {across}");
        let (high, _) = spectrum(&along.with(Opt::Frequency, &[4.0]), 32);
        assert!(share(&high, 0.5, 1.5) > 0.98);
    }

    #[test]
    fn wrong_options_are_told() {
        let of = |params: &Params| match KIND.field(2, params) {
            Err(unfit) => unfit.message,
            Ok(_) => String::new(),
        };
        let plain = Params::default();
        for (params, message) in [
            (plain.clone().with(Opt::Density, &[100.0]), "density must be from 0.01 to 64"),
            (plain.clone().with(Opt::Density, &[0.0]), "density must be from"),
            (plain.clone().with(Opt::Frequency, &[0.0]), "frequency must be from 0.01 to 100"),
            (plain.clone().with(Opt::Bandwidth, &[9.0]), "bandwidth must be from 0.1 to 4"),
            (plain.clone().with(Opt::Direction, &[1.0, 0.0, 0.0]), "direction needs a number"),
            (
                plain.clone().with(Opt::Period, &[3.0]).with(Opt::Frequency, &[0.3]),
                "period must be a multiple of 4",
            ),
            (plain.with(Opt::Period, &[4e6]).with(Opt::Frequency, &[50.0]), "period must be at most"),
        ] {
            assert!(of(&params).starts_with(message), "{params:?}: {}", of(&params));
        }
    }
}
