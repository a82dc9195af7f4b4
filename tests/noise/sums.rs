//! Sums of octaves: Peachey, "Spectral Synthesis", figures 2.38 and 2.39.

use super::measured::field;
use pse::internal::lanes::Isa;
use pse::measure::{Moments, Random, Section, Spectrum};
use pse::noise::sums::{Form, Sum};
use pse::noise::{Kind, Params};

/// The sum of the octaves 1, 2, 4 … below `high` of a kind.
fn sum(form: Form, kind: &str, high: f32, p: &[&[f32]], out: &mut [f32]) {
    let fields = [field(Kind::from_name(kind).expect(kind), p.len(), &Params::default())];
    let all = |x: f32| vec![x; out.len()];
    let (one, half, two, none) = (all(1.0), all(0.5), all(2.0), all(0.0));
    let (octaves, high) = (all(24.0), all(high));
    Sum {
        form,
        fields: &fields,
        low: &one,
        high: &high,
        fade: &none,
        size: &one,
        octaves: &octaves,
        lacunarity: &two,
        gain: &half,
        offset: &none,
    }
    .run(Isa::detect(), p, out);
}

/// The kinds whose octaves are told apart.
fn kinds() -> impl Iterator<Item = &'static str> {
    ["perlin1985", "gradient", "improved"].into_iter().filter(|name| Kind::from_name(name).is_some())
}

#[test]
fn spectra_fall_by_the_fourth_power() {
    for kind in kinds() {
        for form in [Form::Fractal, Form::Turbulence] {
            let mut random = Random::new(40);
            let mut spectrum = Spectrum::new(512, 1.0 / 64.0);
            for _ in 0..4 {
                let section = Section::tilted(&mut random, 3, 512, 1.0 / 64.0, 300.0);
                spectrum.add(&section.sample(|p, out| sum(form, kind, 32.0, p, out)));
            }
            // The amplitude of an octave is 1/f, so the energy of an octave of frequencies is as 1/f², and that of
            // an equal area of the plane of frequencies as 1/f⁴.
            let slope = spectrum.slope(0.7, 16.0);
            println!("{form:?} of {kind}: density ~ f^{slope:.2}");
            assert!((-4.6..=-3.3).contains(&slope), "{form:?} of {kind}: {slope}");
        }
    }
}

#[test]
fn turbulence_has_kinks_and_no_sign() {
    const STEP: f64 = 1.0 / 1024.0;
    for kind in kinds() {
        let mut random = Random::new(41);
        let mut turns = [[0.0_f64; 2]; 2];
        for _ in 0..16 {
            let origin: Vec<f64> = (0..3).map(|_| random.within(8.0)).collect();
            let line = Section::line(&origin, &random.direction(3), 8192, STEP);
            for (turns, form) in turns.iter_mut().zip([Form::Fractal, Form::Turbulence]) {
                let values = line.sample(|p, out| sum(form, kind, 8.0, p, out));
                let m = Moments::of(&values);
                match form {
                    Form::Turbulence => assert!(m.least >= 0.0, "{kind}: {}", m.least),
                    _ => assert!(m.least < 0.0 && m.most > 0.0, "{kind}: {} … {}", m.least, m.most),
                }
                // How much the slope turns within a step, and within two.
                for (turn, step) in turns.iter_mut().zip([1, 2]) {
                    let bend = |w: &[f32]| f64::from(w[2 * step] - 2.0 * w[step] + w[0]).abs() / step as f64;
                    *turn = values.windows(2 * step + 1).map(bend).fold(*turn, f64::max);
                }
            }
        }
        let ratio = turns.map(|[one, two]| one / two);
        println!("{kind}: fractalsum {:.3}, turbulence {:.3}", ratio[0], ratio[1]);
        assert!(ratio[0] < 0.6, "the slope of fractalsum of {kind} is continuous: {}", ratio[0]);
        // A kink half-way between samples turns two thirds as much within a step as within two, any other more.
        assert!(ratio[1] > 0.65, "the slope of turbulence of {kind} jumps: {}", ratio[1]);
    }
}
