//! Gabor noise: Lagae, Lefebvre, Drettakis, Dutré, "Procedural Noise using Sparse Gabor Convolution", SIGGRAPH 2009.
//!
//! Impulses lie scattered over space, a Poisson process; about each stand waves under a Gaussian, with a
//! random phase, and along a direction of its own or along a given one. The spectrum is a band about the
//! frequency: its Gaussian, turned about the origin or, with a direction, at both ends of it.

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
        bounds: &[[f32::NEG_INFINITY, f32::INFINITY]; 3],
        mean: 0.0,
        deviation: 0.3,
        lattice: "any",
        smoothness: Smoothness::C1,
        cost: 10.0,
        source: "Lagae et al. 2009, section 3",
        remarks: "",
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

fn make<const D: usize>(params: &Params) -> Made {
    let frequency = f64::from(params.number(Opt::Frequency, 1.0, 0.01..=100.0)?);
    let bandwidth = f64::from(params.number(Opt::Bandwidth, 1.0, 0.1..=4.0)?);
    // At half the band's width, to either side, the amplitude is half of what it is in the middle.
    let half = frequency * (1.0 - 2.0 / (libm::exp2(bandwidth) + 1.0));
    let deviation = libm::sqrt(2.0 * LN_2) / (2.0 * PI * half);
    let radius = GAUSSIAN_RADIUS * deviation;
    let default = IMPULSES / libm::pow(2.0 * PI * deviation * deviation, D as f64 / 2.0);
    let density = f64::from(params.number(Opt::Density, default as f32, 1e-9..=1e9)?);
    let bell = Bell::gaussian(1.0);
    let energy = 0.5 * density * libm::pow(radius, D as f64) * integral(D, 1.0, |r| bell.at(r) * bell.at(r));
    let layout = |octave: i32| Layout { octave, radius, density, scale: DEVIATION / energy.sqrt() };
    // Cells of a half to the whole radius, or smaller ones, if the period needs them.
    let octave = libm::floor(libm::log2(radius)) as i32;
    let most = octave.min(params.period::<D>()?.map_or(i32::MAX, divisible));
    let Some(layout) = (most - 8..=most).rev().map(layout).find(|layout| layout.fits(D)) else {
        return Err(unfit::<D>(&layout(octave), most));
    };
    let side = layout.side();
    let bell = Bell::gaussian(radius / side);
    let waves = frequency * side * f64::from(UNIT);
    let waves = match impulses::direction::<D>(params)? {
        Some(direction) => Waves::Along(direction.map(|x| (x * waves) as f32)),
        None => Waves::Around(waves as f32),
    };
    impulses::field(Box::new(Gabor(bell)), Some(waves), &layout, params)
}

/// The largest power of two, or rather its logarithm, by which all periods are divisible.
fn divisible<const D: usize>(period: [f32; D]) -> i32 {
    period.iter().filter(|p| **p > 0.0).map(|p| (*p as u32).trailing_zeros() as i32).min().unwrap_or(i32::MAX)
}

fn unfit<const D: usize>(best: &Layout, most: i32) -> Unfit {
    let (side, radius) = (best.side(), best.radius);
    if most < best.octave && best.fits(D) {
        let message = format!("period must be a multiple of {side} for waves that reach {radius:.1} units");
        return Unfit::of(Opt::Period, message).hint("Higher frequencies or more bandwidth reach less far.");
    }
    let volume = libm::pow(side, D as f64);
    let (least, most) = (LEAST / volume, CROWD / volume);
    let message =
        format!("density must be from {least:.3} to {most:.3} for waves that reach {radius:.2} units");
    Unfit::of(Opt::Density, format!("{message}, found {}", best.density))
}
