//! What the contracts promise, and what holds for every kind in all its dimensions.

use super::measured::{self, Points, field, slices, slopes, values};
use pse::internal::lanes::Isa;
use pse::measure::Random;
use pse::noise::{KINDS, Kind, Opt, Params, Smoothness};

/// Every kind in every number of dimensions.
fn cases() -> impl Iterator<Item = (&'static Kind, usize)> {
    KINDS.iter().flat_map(|kind| kind.dimensions.clone().map(move |d| (*kind, d)))
}

/// The same, with the default options and with every other word of each option that is one of some words, where there is
/// a noise of that.
fn variants() -> impl Iterator<Item = (&'static Kind, usize, Params)> {
    cases().flat_map(|(kind, d)| {
        let words = kind.options.iter().flat_map(|option| {
            let others = option.info().choices.iter().skip(1);
            others.map(|word| Params::default().with_choice(*option, word))
        });
        let words = words.filter(move |params| kind.field(d, params).is_ok());
        std::iter::once(Params::default()).chain(words).map(move |params| (kind, d, params))
    })
}

#[test]
fn every_word_is_taken() {
    for kind in KINDS {
        for (option, word) in
            kind.options.iter().flat_map(|o| o.info().choices.iter().map(move |word| (*o, *word)))
        {
            let params = Params::default().with_choice(option, word);
            let taken = kind.dimensions.clone().any(|d| kind.field(d, &params).is_ok());
            assert!(taken, "{kind:?} says that it takes {}, but not {word}", option.name());
        }
    }
}

fn bits(x: &[f32]) -> Vec<u32> {
    x.iter().map(|x| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() }).collect()
}

#[test]
fn values_are_within_their_bounds() {
    for m in measured::all() {
        let usual = m.kind.usual_dimensions();
        for (d, range) in m.kind.dimensions.clone().zip(&m.ranges) {
            let [least, most] = m.kind.bounds(d);
            assert!(least < most, "{:?} {d}-D: bounds {least} … {most}", m.kind);
            let seen = if d == usual {
                [range[0].min(m.moments.least), range[1].max(m.moments.most)]
            } else {
                *range
            };
            assert!(
                seen[0] >= least && seen[1] <= most,
                "{:?} {d}-D: {seen:?} not in {least} … {most}",
                m.kind
            );
        }
        assert_eq!(m.kind.contract.bounds.len(), m.ranges.len(), "{:?}: a pair a dimension", m.kind);
    }
}

#[test]
fn mean_and_deviation_are_as_promised() {
    for m in measured::all() {
        let (promised, found) = (&m.kind.contract, &m.moments);
        let off = (found.mean - f64::from(promised.mean)).abs() / found.deviation;
        assert!(off < 0.02, "{:?}: mean {:.5}, promised {}", m.kind, found.mean, promised.mean);
        let ratio = found.deviation / f64::from(promised.deviation);
        assert!(
            (ratio - 1.0).abs() < 0.02,
            "{:?}: deviation {:.5}, promised {}",
            m.kind,
            found.deviation,
            promised.deviation
        );
    }
}

#[test]
fn gradient_noise_is_zero_at_lattice_points() {
    for d in 1..=4 {
        let points = Random::new(20).points(d, 5000, 1000.0, 1.0);
        let Some(kind) = Kind::from_name("gradient") else { panic!("no gradient noise") };
        assert!(values(&*field(kind, d, &Params::default()), &points).iter().all(|&n| n == 0.0));
    }
}

#[test]
fn the_value_of_perlin1985_at_lattice_points_is_even() {
    let points = Random::new(21).points(3, 50_000, 1000.0, 1.0);
    let kind = Kind::from_name("perlin1985").expect("the default kind");
    let values = values(&*field(kind, 3, &Params::default()), &points);
    let histogram = pse::measure::Histogram::of(&values, -0.5, 0.5, 10);
    assert_eq!(histogram.counts.iter().sum::<usize>(), values.len(), "all are within a half");
    for density in histogram.densities() {
        assert!((density - 1.0).abs() < 0.06, "{density}");
    }
}

#[test]
fn improved_has_a_continuous_second_derivative() {
    // That of `gradient` jumps by several times its rms; what is left here is the third derivative.
    let Some(gradient) = measured::one("gradient") else { panic!("no gradient noise") };
    assert!(gradient.bend_jump > 1.0, "{}", gradient.bend_jump);
    if let Some(improved) = measured::one("improved") {
        assert!(improved.bend_jump < 0.05, "{}", improved.bend_jump);
        assert!(improved.smoothness >= Smoothness::C2);
    }
}

#[test]
fn hardly_a_value_is_beyond_one() {
    // Bounds are those of the rarest gradients; what pictures see is this.
    for (name, share) in [("perlin1985", 1e-5), ("gradient", 1e-4), ("improved", 1e-5)] {
        let points = Random::new(23).points(3, 1_000_000, 1000.0, 1e-4);
        let kind = Kind::from_name(name).expect(name);
        let values = values(&*field(kind, 3, &Params::default()), &points);
        let beyond = values.iter().filter(|v| v.abs() > 1.0).count();
        assert!(beyond as f64 <= share * 1e6, "{name}: {beyond} of a million");
        assert!(values.iter().all(|v| v.abs() < 1.3), "{name}");
    }
}

#[test]
fn derivatives_are_those_of_differences_in_all_dimensions() {
    for (kind, d) in cases() {
        let limits = super::limits::of(kind.name);
        if d == kind.usual_dimensions() || limits.exception(super::limits::Rule::Derivative).is_some() {
            continue;
        }
        let noise = &*field(kind, d, &Params::default());
        let rms = {
            let slopes = slopes(noise, &Random::new(22).points(d, 1 << 14, 100.0, 1.0 / 4096.0));
            pse::measure::Moments::of(&slopes.concat()).rms()
        };
        let error = measured::derivative_error(noise, d, kind.contract.smoothness) / rms;
        assert!(error < 0.01, "{kind:?} {d}-D: {error}");
    }
}

/// Points with all kinds of numbers among them.
fn awkward(d: usize) -> Points {
    let mut p = Random::new(23).points(d, 257, 1000.0, 1.0 / 4096.0);
    let odd =
        [f32::NAN, f32::INFINITY, 1e30, -1e30, 8_388_608.0, -0.0, 1e-45, -1e-10, f32::NEG_INFINITY, f32::MAX];
    for (i, x) in odd.into_iter().enumerate() {
        p[i % d][i * 24 + 3] = x;
    }
    p
}

#[test]
fn every_instruction_set_and_number_of_lanes_gives_the_same_bits() {
    for (kind, d, params) in variants() {
        let noise = field(kind, d, &params);
        let p = awkward(d);
        let run = |isa: Isa, p: &[&[f32]]| {
            let mut value = vec![0.0; p[0].len()];
            noise.noise(isa, p, &mut value);
            let mut slopes = vec![vec![0.0; p[0].len()]; d];
            noise.derivative(isa, p, &mut slopes.iter_mut().map(Vec::as_mut_slice).collect::<Vec<_>>());
            slopes.push(value);
            slopes.iter().map(|x| bits(x)).collect::<Vec<_>>()
        };
        let known = run(Isa::baseline(), &slices(&p));
        assert!(known == run(Isa::detect(), &slices(&p)), "{kind:?} {d}-D {params:?}");
        for n in [1, 7, 64, 65, 256] {
            let cut: Vec<&[f32]> = p.iter().map(|x| &x[257 - n..]).collect();
            let tail: Vec<Vec<u32>> = known.iter().map(|x| x[257 - n..].to_vec()).collect();
            assert!(run(Isa::detect(), &cut) == tail, "{kind:?} {d}-D {params:?}, {n} lanes");
        }
    }
}

#[test]
fn not_a_number_gives_not_a_number() {
    for (kind, d, params) in variants() {
        let noise = field(kind, d, &params);
        for k in 0..d {
            let mut p = vec![vec![0.3]; d];
            p[k] = vec![f32::NAN];
            assert!(values(&*noise, &p)[0].is_nan(), "{kind:?} {d}-D {params:?} by coordinate {k}");
            assert!(
                slopes(&*noise, &p).iter().any(|s| s[0].is_nan()),
                "{kind:?} {d}-D slope by coordinate {k}"
            );
        }
    }
}

#[test]
fn huge_coordinates_are_harmless() {
    for (kind, d, params) in variants() {
        let noise = field(kind, d, &params);
        // Other words may have other bounds.
        let [least, most] = match params.given().next() {
            None => kind.bounds(d),
            Some(_) => [f32::MIN, f32::MAX],
        };
        for x in [8_388_609.0, -8_388_609.0, 1e20, -1e20, f32::MAX, f32::MIN] {
            let value = values(&*noise, &vec![vec![x]; d])[0];
            assert!(
                value.is_nan() || (least..=most).contains(&value),
                "{kind:?} {d}-D {params:?} at {x}: {value}"
            );
        }
        for x in [f32::INFINITY, f32::NEG_INFINITY] {
            // Nothing is promised, but that it ends.
            let _ = (values(&*noise, &vec![vec![x]; d]), slopes(&*noise, &vec![vec![x]; d]));
        }
    }
}

#[test]
fn periods_repeat() {
    for (kind, d, params) in variants().filter(|(kind, ..)| kind.options.contains(&Opt::Period)) {
        let period = &[3.0, 5.0, 4.0, 7.0][..d];
        let noise = field(kind, d, &params.clone().with(Opt::Period, period));
        // Multiples of 1/16 are exact, here and a few periods away.
        let here = Random::new(24).points(d, 2000, 50.0, 1.0 / 16.0);
        for k in 0..d {
            for times in [1.0, -3.0, 20.0] {
                let mut there = here.clone();
                there[k].iter_mut().for_each(|x| *x += times * period[k]);
                let shown = || format!("{kind:?} {d}-D {params:?} axis {k} by {times}");
                assert!(values(&*noise, &here) == values(&*noise, &there), "{}", shown());
                assert!(slopes(&*noise, &here) == slopes(&*noise, &there), "slope of {}", shown());
            }
        }
        // It is a noise within, and not another's copy.
        let plain = field(kind, d, &params);
        assert!(values(&*noise, &here) != values(&*plain, &here), "{kind:?} {d}-D {params:?}");
    }
}
