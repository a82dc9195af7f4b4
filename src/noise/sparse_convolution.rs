//! Sparse convolution noise: Lewis 1989, section 4; Peachey's scnoise.
//!
//! Impulses lie scattered over space, a Poisson process, with sizes even in -1 … 1; each adds a kernel to its
//! surroundings (see `impulses` for how they are found). The spectrum is the kernel's, and the noise shows neither
//! axes nor lattice.
//!
//! With few impulses the noise is lumpy; with ten within a kernel's reach it can hardly be told from one of
//! infinitely many (Lewis, section 4.1). Its variance is the density, times the mean square of the sizes, times the
//! integral of the kernel's square; it is made the same for every kernel and density. scnoise of Peachey is
//! that of `kernel` "catmull_rom" and `density` 3, but that it has three impulses in every cell.

use super::impulses::{
    self, Bell, CROWD, CatmullRom, Curve, Gabor, LEAST, Layout, Profile, STEPS, UNIT, Waves, integral,
    mean_cosine,
};
use super::kind::{Contract, Kind, Made, Smoothness, Unfit};
use super::options::{Opt, Params};

/// Sparse convolution noise.
pub static KIND: Kind = Kind {
    name: "sparse_convolution",
    brief: "random impulses convolved with a kernel: no axes show",
    dimensions: 1..=4,
    options: &[Opt::Density, Opt::Kernel, Opt::Knots, Opt::Frequency, Opt::Direction, Opt::Period],
    contract: Contract {
        // Poisson's numbers have no bound.
        bounds: &[[f32::NEG_INFINITY, f32::INFINITY]; 4],
        mean: 0.0,
        deviation: 0.3,
        lattice: "any, as elsewhere",
        smoothness: Smoothness::C1,
        cost: 19.0,
        source: "Lewis 1989, section 4; Peachey, \"Sparse Convolution Noise\"",
        remarks: "Unbounded in principle; of a million points one is beyond ±1.9, and one of a thousand beyond ±1.14. \
                  By default density is 3 and the kernel `cosine`, ½ + ½ cos πr; `gaussian` has deviation ⅓; both \
                  reach one unit, as do `knots`, of which the last must be 0. `catmull_rom` reaches two, so it \
                  takes about six times as long. `gabor` is the Gaussian times a cosine of `frequency`, by default 1, along \
                  `direction`, by default the first axis. The excess kurtosis is about 2 / density.",
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
    let density = f64::from(params.number(Opt::Density, DENSITY, LEAST as f32..=CROWD as f32)?);
    let kernel = params.choice(Opt::Kernel);
    let knots = params.vector(Opt::Knots);
    if knots.is_some() && params.vector(Opt::Kernel).is_some() {
        return Err(Unfit::of(Opt::Knots, "knots are a kernel of their own, found one by name beside them"));
    }
    if kernel != 3 {
        let waves = [Opt::Frequency, Opt::Direction].into_iter().find(|o| params.vector(*o).is_some());
        if let Some(option) = waves {
            let message = format!("{} is for the kernel \"gabor\", found another", option.name());
            return Err(Unfit::of(option, message));
        }
    }
    if let Some(knots) = knots {
        let curve = curve(knots)?;
        return radial::<D>(curve, 1.0, density, params, |r| curve.at(r));
    }
    match kernel {
        0 => {
            let bell = Bell::cosine(1.0);
            let layout = layout::<D>(1.0, density, |r| bell.at(r) * bell.at(r));
            impulses::fused_field::<_, D>(bell, &layout, params)
        }
        1 => radial::<D>(CatmullRom, 2.0, density, params, CatmullRom::at),
        2 => {
            let bell = Bell::gaussian(1.0);
            radial::<D>(bell, 1.0, density, params, |r| bell.at(r))
        }
        _ => gabor::<D>(density, params),
    }
}

/// The field of a kernel whose value is given over the distance.
fn radial<const D: usize>(
    profile: impl Profile + 'static,
    radius: f64,
    density: f64,
    params: &Params,
    value: impl Fn(f64) -> f64,
) -> Made {
    let layout = layout::<D>(radius, density, |r| value(r) * value(r));
    impulses::field::<D>(Box::new(profile), None, &layout, params)
}

fn gabor<const D: usize>(density: f64, params: &Params) -> Made {
    let frequency = f64::from(params.number(Opt::Frequency, 1.0, 0.0..=64.0)?);
    let first = std::array::from_fn(|k| if k == 0 { 1.0 } else { 0.0 });
    let direction = impulses::direction::<D>(params)?.unwrap_or(first);
    let waves = direction.map(|x| (x * frequency * f64::from(UNIT)) as f32);
    let bell = Bell::gaussian(1.0);
    // Of cos² the mean over all directions.
    let wave = |r: f64| 0.5 + 0.5 * mean_cosine(D, 2.0 * frequency * r);
    let layout = layout::<D>(1.0, density, |r| bell.at(r) * bell.at(r) * wave(r));
    impulses::field(Box::new(Gabor(bell)), Some(Waves::Even(waves)), &layout, params)
}

/// The layout for a kernel of which the mean square is given over the distance.
fn layout<const D: usize>(radius: f64, density: f64, square: impl Fn(f64) -> f64) -> Layout {
    // Campbell's theorem.
    let variance = density * SIZES * integral(D, radius, square);
    Layout { octave: 0, radius, density, scale: DEVIATION / variance.sqrt() }
}

fn curve(knots: &[f32]) -> Result<Curve, Unfit> {
    let unfit = |message: String| Err(Unfit::of(Opt::Knots, message));
    if !(2..=STEPS + 1).contains(&knots.len()) {
        return unfit(format!("knots must be from 2 to {} values, found {}", STEPS + 1, knots.len()));
    }
    if let Some(x) = knots.iter().find(|x| !x.is_finite()) {
        return unfit(format!("knots must be finite, found {x}"));
    }
    let most = knots.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
    match *knots {
        [.., last] if last != 0.0 => {
            unfit(format!("the last knot must be 0, for the kernel ends there, found {last}"))
        }
        _ if most == 0.0 => unfit("knots must not all be 0".to_string()),
        // Only the shape matters.
        _ => Ok(Curve::new(&knots.iter().map(|x| x / most).collect::<Vec<_>>())),
    }
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

    /// Points that fill a box evenly.
    fn points(d: usize, n: usize) -> Vec<Vec<f32>> {
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 40) as f32 / (1 << 23) as f32 - 1.0) * 200.0
        };
        (0..d).map(|_| (0..n).map(|_| random()).collect()).collect()
    }

    /// Mean, standard deviation, excess kurtosis.
    fn moments(x: &[f32]) -> [f64; 3] {
        let n = x.len() as f64;
        let mean = x.iter().map(|x| f64::from(*x)).sum::<f64>() / n;
        let power = |p: f64| x.iter().map(|x| libm::pow(f64::from(*x) - mean, p)).sum::<f64>() / n;
        [mean, power(2.0).sqrt(), power(4.0) / (power(2.0) * power(2.0)) - 3.0]
    }

    #[test]
    fn known_values() {
        // Pinned: a change of these changes every picture.
        let p: Vec<Vec<f32>> = [0.5, 1.25, -2.75, 100.125].map(|x| vec![x]).to_vec();
        let got: Vec<u32> = (1..=4).map(|d| noise(&Params::default(), &p[..d])[0].to_bits()).collect();
        assert_eq!(got, [0x3d60_29c6, 0x3e25_40f4, 0x3d4b_5ddd, 0x3c8b_4ef8], "{got:x?}");
    }

    #[test]
    fn the_deviation_is_the_same_for_every_kernel_and_density() {
        let p = points(3, 60_000);
        let plain = Params::seeded(3);
        let mut all = vec![plain.clone(), plain.clone().with(Opt::Knots, &[0.0, 7.0, -3.0, 0.0])];
        for kernel in ["catmull_rom", "gaussian", "gabor"] {
            all.push(plain.clone().with(Opt::Density, &[1.0]).with_choice(Opt::Kernel, kernel));
        }
        for params in all {
            let [mean, deviation, _] = moments(&noise(&params, &p));
            assert!(mean.abs() < 0.01 && (deviation - 0.3).abs() < 0.008, "{params:?}: {mean} {deviation}");
        }
        // Excess kurtosis is 9/5 · ∫h⁴ / (∫h²)² / density.
        let h = |r: f64| 0.5 + 0.5 * libm::cos(std::f64::consts::PI * r);
        let (second, fourth) =
            (integral(3, 1.0, |r| h(r) * h(r)), integral(3, 1.0, |r| h(r) * h(r) * h(r) * h(r)));
        for density in [0.25, 1.0, 4.0, 16.0] {
            let [mean, deviation, excess] =
                moments(&noise(&plain.clone().with(Opt::Density, &[density]), &p));
            assert!(mean.abs() < 0.01 && (deviation - 0.3).abs() < 0.008, "{density}: {mean} {deviation}");
            let known = 1.8 * fourth / (second * second) / f64::from(density);
            assert!((excess - known).abs() < 0.15 * known + 0.05, "{density}: {excess} {known}");
        }
    }

    #[test]
    fn no_axis_and_no_place_in_a_cell_is_preferred() {
        let p = points(3, 200_000);
        let here = noise(&Params::seeded(1), &p);
        let covariance = |u: [f32; 3]| {
            let q: Vec<Vec<f32>> = (0..3).map(|k| p[k].iter().map(|x| x + u[k]).collect()).collect();
            let there = noise(&Params::seeded(1), &q);
            here.iter().zip(&there).map(|(a, b)| f64::from(a * b)).sum::<f64>() / (here.len() as f64 * 0.09)
        };
        for distance in [0.3, 0.6, 0.9] {
            let third = distance / 3.0_f32.sqrt();
            let axis = covariance([0.0, distance, 0.0]);
            for u in [[third; 3], [third, -third, third], [distance, 0.0, 0.0], [0.0, 0.0, distance]] {
                let turned = covariance(u);
                assert!((axis - turned).abs() < 0.01, "over {distance}: {axis} {turned}");
            }
        }
        for at in [0.0, 0.5] {
            let p: Vec<Vec<f32>> = p.iter().map(|x| x.iter().map(|x| x.floor() + at).collect()).collect();
            let [_, deviation, _] = moments(&noise(&Params::seeded(1), &p));
            assert!((deviation - 0.3).abs() < 0.004, "at {at}: {deviation}");
        }
    }

    #[test]
    fn knots_of_the_spline_are_its_kernel() {
        let curve = Curve::new(&[1.0, 0.0, 0.0]);
        for i in 0..40 {
            let r = f64::from(i) / 40.0;
            assert!((curve.at(r) - CatmullRom::at(2.0 * r)).abs() < 1e-6, "{r}");
        }
    }

    #[test]
    fn wrong_options_are_told() {
        let of = |params: &Params| match KIND.field(3, params) {
            Err(unfit) => unfit.message,
            Ok(_) => String::new(),
        };
        let plain = Params::default();
        for (params, message) in [
            (plain.clone().with(Opt::Density, &[0.0]), "density must be from 0.01 to 64, found 0"),
            (plain.clone().with(Opt::Knots, &[1.0, 0.5]), "the last knot must be 0"),
            (plain.clone().with(Opt::Knots, &[1.0]), "knots must be from 2 to 33 values, found 1"),
            (plain.clone().with(Opt::Knots, &[0.0, 0.0]), "knots must not all be 0"),
            (plain.clone().with(Opt::Knots, &[f32::NAN, 0.0]), "knots must be finite, found NaN"),
            (
                plain.clone().with(Opt::Knots, &[1.0, 0.0]).with_choice(Opt::Kernel, "cosine"),
                "knots are a kernel",
            ),
            (plain.clone().with(Opt::Frequency, &[2.0]), "frequency is for the kernel \"gabor\""),
            (
                plain.clone().with_choice(Opt::Kernel, "gabor").with(Opt::Direction, &[1.0]),
                "direction needs a number",
            ),
            (
                plain.clone().with_choice(Opt::Kernel, "gabor").with(Opt::Direction, &[0.0; 3]),
                "direction must have",
            ),
            (plain.with(Opt::Period, &[1.5]), "period must be a whole number"),
        ] {
            assert!(of(&params).starts_with(message), "{params:?}: {}", of(&params));
        }
    }
}
