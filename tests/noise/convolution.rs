//! Noises whose spectrum or covariance is asked for: sparse convolution (Lewis 1989, section 4; Peachey) and Wiener
//! interpolation (Lewis, section 5).

use super::measured::{self, Points, field, moved, spectrum, values};
use pse::internal::lanes::Isa;
use pse::measure::{Moments, Random, correlation, slope};
use pse::noise::{Field, Kind, Opt, Params};

/// A kernel of sparse convolution, by the distance from its middle.
type Kernel = fn(f64) -> f64;

fn cosine(r: f64) -> f64 {
    if r < 1.0 { 0.5 + 0.5 * libm::cos(std::f64::consts::PI * r) } else { 0.0 }
}

fn catmull_rom(r: f64) -> f64 {
    match r {
        r if r < 1.0 => 0.5 * (2.0 + r * r * (-5.0 + r * 3.0)),
        r if r < 2.0 => 0.5 * (4.0 + r * (-8.0 + r * (5.0 - r))),
        _ => 0.0,
    }
}

/// The covariance of impulses with this kernel over a distance, but for a factor: the kernel, times itself moved,
/// integrated over space. In cylinders about the line between the two middles.
fn overlap(kernel: Kernel, distance: f64) -> f64 {
    const STEP: f64 = 1.0 / 40.0;
    let mut sum = 0.0;
    for i in 0..80 {
        let radius = (f64::from(i) + 0.5) * STEP;
        for j in -80..160 {
            let (a, b) = ((f64::from(j) + 0.5) * STEP, (f64::from(j) + 0.5) * STEP - distance);
            let of = |x: f64| kernel((radius * radius + x * x).sqrt());
            sum += radius * of(a) * of(b);
        }
    }
    sum
}

/// The power spectrum on a plane through the solid: the Fourier transform of the covariance there, which is round.
fn expected_density(kernel: Kernel) -> impl Fn(f64) -> f64 {
    const STEP: f64 = 1.0 / 32.0;
    let covariance: Vec<(f64, f64)> = (0..128)
        .map(|i| (f64::from(i) + 0.5) * STEP)
        .map(|distance| (distance, overlap(kernel, distance)))
        .collect();
    move |frequency| {
        let turn = 2.0 * std::f64::consts::PI * frequency;
        covariance.iter().map(|(r, c)| r * c * libm::j0(turn * r)).sum()
    }
}

/// The correlation of two lists of numbers.
fn alike(a: &[f64], b: &[f64]) -> f64 {
    let single = |x: &[f64]| x.iter().map(|x| *x as f32).collect::<Vec<f32>>();
    correlation(&single(a), &single(b))
}

/// The correlation of a field with itself over distances along a direction.
fn correlations(noise: &dyn Field, direction: &[f64], distances: &[f64]) -> Vec<f64> {
    let points = Random::new(30).points(direction.len(), 200_000, 500.0, 1.0 / 4096.0);
    let here = values(noise, &points);
    distances.iter().map(|d| correlation(&here, &values(noise, &moved(&points, direction, *d)))).collect()
}

const DIAGONAL: [f64; 3] = [0.577_350_269; 3];

/// By how much the correlations along an axis and along the diagonal of a cell differ.
fn lopsided(noise: &dyn Field) -> f64 {
    let distances: Vec<f64> = (1..=12).map(|i| f64::from(i) / 8.0).collect();
    let straight = correlations(noise, &[0.0, 1.0, 0.0], &distances);
    let slant = correlations(noise, &DIAGONAL, &distances);
    straight.iter().zip(slant).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn sparse(params: &Params) -> Option<std::sync::Arc<dyn Field>> {
    Kind::from_name("sparse_convolution").map(|kind| field(kind, 3, params))
}

#[test]
fn the_spectrum_of_sparse_convolution_is_its_kernels() {
    for (name, kernel) in [("cosine", cosine as Kernel), ("catmull_rom", catmull_rom)] {
        let Some(noise) = sparse(&Params::default().with_choice(Opt::Kernel, name)) else { return };
        let found = spectrum(|p, out| noise.noise(Isa::detect(), p, out), 3).density();
        let expected = expected_density(kernel);
        let rings: Vec<_> =
            found.into_iter().filter(|(frequency, _)| (0.05..1.5).contains(frequency)).collect();
        let densities: Vec<f64> = rings.iter().map(|(_, density)| *density).collect();
        let expected: Vec<f64> = rings.iter().map(|(frequency, _)| expected(*frequency)).collect();
        let likeness = alike(&densities, &expected);
        println!("{name}: {likeness:.4}");
        assert!(likeness >= 0.985, "{name}: {likeness}");
    }
}

#[test]
fn the_more_impulses_the_nearer_to_normal() {
    let points = Random::new(31).points(3, 1 << 19, 500.0, 1.0 / 4096.0);
    let mut known = Vec::new();
    for density in [1.0, 2.0, 4.0, 8.0_f32] {
        let Some(noise) = sparse(&Params::default().with(Opt::Density, &[density])) else { return };
        let m = Moments::of(&values(&*noise, &points));
        println!("{density} impulses a cell: excess kurtosis {:.3}", m.kurtosis);
        assert!(m.kurtosis > 0.0, "{density}: {}", m.kurtosis);
        known.push((libm::log2(f64::from(density)), libm::log2(m.kurtosis)));
    }
    let power = slope(known);
    assert!((power + 1.0).abs() < 0.15, "excess kurtosis goes with density to the {power}");
}

#[test]
fn sparse_convolution_is_round() {
    let Some(noise) = sparse(&Params::default()) else { return };
    let gradient = field(Kind::from_name("gradient").expect("gradient noise"), 3, &Params::default());
    let (sparse, gradient) = (lopsided(&*noise), lopsided(&*gradient));
    println!("sparse convolution {sparse:.4}, gradient {gradient:.4}");
    assert!(sparse < 0.05 && gradient < 0.09, "sparse convolution {sparse}, gradient {gradient}");
}

#[test]
fn wiener_noise_has_the_covariance_that_is_asked_for() {
    let Some(kind) = Kind::from_name("wiener") else { return };
    let noise = field(kind, 3, &Params::default().with(Opt::Width, &[0.5]));
    let distances: Vec<f64> = (0..=16).map(|i| f64::from(i) / 8.0).collect();
    let asked: Vec<f64> = distances.iter().map(|d| libm::exp(-d * d / (2.0 * 0.25))).collect();
    for direction in [[0.0, 1.0, 0.0], DIAGONAL, [0.6, 0.0, 0.8]] {
        let found = correlations(&*noise, &direction, &distances);
        let worst = found.iter().zip(&asked).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let likeness = alike(&found, &asked);
        println!("along {direction:?}: off by {worst:.3} at most, correlation {likeness:.4}");
        assert!(worst <= 0.15 && likeness >= 0.98, "along {direction:?}: {worst}, {likeness}");
    }
}

#[test]
fn wiener_noise_passes_through_the_values_of_its_lattice() {
    let Some(kind) = Kind::from_name("wiener") else { return };
    let points: Points = Random::new(32).points(3, 4000, 1000.0, 1.0);
    // At lattice points nothing is interpolated: whatever the covariance, the same random numbers are there.
    let at = |params: Params| values(&*field(kind, 3, &params), &points);
    let known = at(Params::default());
    for other in [
        Params::default().with(Opt::Width, &[0.4]),
        Params::default().with(Opt::Width, &[0.6]),
        Params::default().with_choice(Opt::Covariance, "oscillatory"),
    ] {
        // But for a factor, which keeps the deviation what it is.
        let likeness = correlation(&known, &at(other));
        assert!(likeness > 0.99999, "{likeness}");
    }
    // And they have nothing to do with each other.
    for direction in [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 2.0, 0.0]] {
        let beside = values(&*field(kind, 3, &Params::default()), &moved(&points, &direction, 1.0));
        assert!(correlation(&known, &beside).abs() < 0.06, "{direction:?}");
    }
    assert!(measured::one("wiener").is_some());
}
