//! Sparse convolution noise: Lewis 1989, section 4; Peachey's scnoise.
//!
//! Impulses lie scattered over space, a Poisson process, with sizes even in -1 … 1; each adds a kernel to its
//! surroundings. See `impulses` for how they are found. The spectrum is the kernel's, and the noise shows neither
//! axes nor lattice: where impulses lie is the lattice's doing, but it is as likely anywhere.
//!
//! With few impulses the noise is lumpy; with ten within a kernel's reach it can hardly be told from one of
//! infinitely many (Lewis, section 4.1). Its size is that of the kernel's square, integrated, times the
//! density, and is made [`DEVIATION`] for every kernel and density.

use super::impulses::{
    self, Bell, CROWD, CatmullRom, Curve, Gabor, LEAST, Layout, Profile, STEPS, UNIT, Waves, integral,
    mean_cosine,
};
use super::kind::{Contract, Kind, Made, Smoothness, Unfit};
use super::options::{Opt, Params};

/// Sparse convolution noise.
pub static KIND: Kind = Kind {
    name: "sparse_convolution",
    brief: "random impulses convolved with a kernel",
    dimensions: 1..=4,
    options: &[Opt::Density, Opt::Kernel, Opt::Knots, Opt::Frequency, Opt::Direction, Opt::Period],
    contract: Contract {
        bounds: &[[f32::NEG_INFINITY, f32::INFINITY]; 4],
        mean: 0.0,
        deviation: 0.3,
        lattice: "any",
        smoothness: Smoothness::C1,
        cost: 10.0,
        source: "Lewis 1989, section 4; Peachey, \"Sparse Convolution Noise\"",
        remarks: "",
    },
    make: |d, params| match d {
        1 => make::<1>(params),
        2 => make::<2>(params),
        3 => make::<3>(params),
        _ => make::<4>(params),
    },
};

/// The standard deviation.
const DEVIATION: f64 = 0.3;
/// The mean square of the impulses' sizes.
const SIZES: f64 = 1.0 / 3.0;
/// Impulses a cell: within the default kernel's reach lie 6, 9, 13 or 15 of them, for one to four dimensions.
const DENSITY: f32 = 3.0;

fn make<const D: usize>(params: &Params) -> Made {
    let density = params.number(Opt::Density, DENSITY, LEAST as f32..=CROWD as f32)?;
    let frequency = params.number(Opt::Frequency, 1.0, 0.0..=64.0)?;
    let kernel = params.choice(Opt::Kernel);
    if let Some(knots) = params.vector(Opt::Knots) {
        if params.vector(Opt::Kernel).is_some() {
            return Err(Unfit::of(Opt::Knots, "knots are a kernel of their own, found a kernel beside them"));
        }
        waves_only_for_gabor(params)?;
        let curve = curve(knots)?;
        return field::<D>(Box::new(curve), None, 1.0, density, params, |r| curve.at(r) * curve.at(r));
    }
    if kernel != 3 {
        waves_only_for_gabor(params)?;
    }
    match kernel {
        0 => {
            let bell = Bell::cosine(1.0);
            field::<D>(Box::new(bell), None, 1.0, density, params, |r| bell.at(r) * bell.at(r))
        }
        1 => field::<D>(Box::new(CatmullRom), None, 2.0, density, params, |r| {
            CatmullRom::at(r) * CatmullRom::at(r)
        }),
        2 => {
            let bell = Bell::gaussian(1.0);
            field::<D>(Box::new(bell), None, 1.0, density, params, |r| bell.at(r) * bell.at(r))
        }
        _ => {
            let bell = Bell::gaussian(1.0);
            let waves =
                impulses::direction::<D>(params)?.unwrap_or(std::array::from_fn(|k| [1.0, 0.0][k.min(1)]));
            let waves = waves.map(|x| (x * f64::from(frequency) * f64::from(UNIT)) as f32);
            // The mean over all directions of the square of the cosine.
            let square = |r: f64| 0.5 + 0.5 * mean_cosine(D, 2.0 * f64::from(frequency) * r);
            field::<D>(Box::new(Gabor(bell)), Some(Waves::Even(waves)), 1.0, density, params, |r| {
                bell.at(r) * bell.at(r) * square(r)
            })
        }
    }
}

/// The field of a kernel, of which the mean square is given over the distance.
fn field<const D: usize>(
    profile: Box<dyn Profile>,
    waves: Option<Waves<D>>,
    radius: f64,
    density: f32,
    params: &Params,
    square: impl Fn(f64) -> f64,
) -> Made {
    // Campbell's theorem.
    let variance = f64::from(density) * SIZES * integral(D, radius, square);
    let layout =
        Layout { octave: 0, radius, density: f64::from(density), scale: DEVIATION / variance.sqrt() };
    impulses::field(profile, waves, &layout, params)
}

fn waves_only_for_gabor(params: &Params) -> Result<(), Unfit> {
    match [Opt::Frequency, Opt::Direction].into_iter().find(|option| params.vector(*option).is_some()) {
        None => Ok(()),
        Some(option) => {
            Err(Unfit::of(option, format!("{} is for the kernel \"gabor\", found another", option.name())))
        }
    }
}

fn curve(knots: &[f32]) -> Result<Curve, Unfit> {
    let unfit = |message: String| Err(Unfit::of(Opt::Knots, message));
    if !(2..=STEPS + 1).contains(&knots.len()) {
        return unfit(format!("knots must be from 2 to {} values, found {}", STEPS + 1, knots.len()));
    }
    if let Some(x) = knots.iter().find(|x| x.is_nan() || x.abs() > 1e6) {
        return unfit(format!("knots must be from -1000000 to 1000000, found {x}"));
    }
    match *knots {
        [.., last] if last != 0.0 => {
            unfit(format!("the last knot must be 0, where the kernel ends, found {last}"))
        }
        _ if knots.iter().all(|x| *x == 0.0) => unfit("knots must not all be 0".to_string()),
        _ => Ok(Curve::new(knots)),
    }
}
