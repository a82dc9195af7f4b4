//! What is particular to Wiener interpolation.

// Loops over axes and lanes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::*;
use crate::lanes::Isa;
use crate::noise::Field;

/// Even numbers in -size … size, from a linear congruence.
struct Random(u64);

impl Random {
    fn within(&mut self, size: f32) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as f32 / (1_u32 << 30) as f32 - 1.0) * size
    }

    fn points(&mut self, dimensions: usize, n: usize, size: f32) -> Vec<Vec<f32>> {
        (0..dimensions).map(|_| (0..n).map(|_| self.within(size)).collect()).collect()
    }
}

fn slices(p: &[Vec<f32>]) -> Vec<&[f32]> {
    p.iter().map(Vec::as_slice).collect()
}

fn noise(field: &dyn Field, isa: Isa, p: &[&[f32]]) -> Vec<f32> {
    let mut out = vec![0.0; p[0].len()];
    field.noise(isa, p, &mut out);
    out
}

fn derivative(field: &dyn Field, isa: Isa, p: &[&[f32]]) -> Vec<Vec<f32>> {
    let mut out = vec![vec![0.0; p[0].len()]; p.len()];
    field.derivative(isa, p, &mut out.iter_mut().map(Vec::as_mut_slice).collect::<Vec<_>>());
    out
}

fn bits(x: &[f32]) -> Vec<u32> {
    x.iter().map(|x| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() }).collect()
}

fn power(x: f32, n: i32) -> f64 {
    (0..n).map(|_| f64::from(x)).product()
}

const KNOTS: [f32; 6] = [2.0, 1.5, 0.5, 0.1, -0.05, 0.02];

/// Every way to interpolate.
fn ways() -> Vec<Params> {
    let plain = Params::seeded(5);
    let oscillatory = plain.clone().with_choice(Opt::Covariance, "oscillatory");
    let four = [
        plain.clone(),
        plain.clone().with(Opt::Width, &[0.25]),
        plain.clone().with(Opt::Width, &[2.0]),
        oscillatory.clone(),
        oscillatory.with(Opt::Width, &[0.5]).with(Opt::Frequency, &[0.4]),
        plain.with(Opt::Knots, &KNOTS),
    ];
    four.iter().flat_map(|p| [p.clone(), p.clone().with(Opt::Neighbours, &[3.0])]).collect()
}

/// The covariance over distance that is asked for, found anew.
fn covariance(params: &Params, dimensions: usize, distance: f64) -> f64 {
    let or = |option, default| params.vector(option).map_or(default, |v| f64::from(v[0]));
    if params.vector(Opt::Knots).is_some() {
        // Trust the spline, which has its own test.
        return Covariance::new(dimensions, params).unwrap().at(distance * distance, dimensions);
    }
    let bell = |width: f64| libm::exp(-0.5 * (distance / width) * (distance / width));
    if params.choice(Opt::Covariance) == 0 {
        return bell(or(Opt::Width, 0.5));
    }
    let x = 2.0 * std::f64::consts::PI * or(Opt::Frequency, 0.75) * distance;
    // The mean of cos(x u), with u the first coordinate of points on the sphere.
    let mut sums = (0.0, 0.0);
    for i in 0..4000 {
        let angle = std::f64::consts::PI * (f64::from(i) + 0.5) / 4000.0;
        let share = libm::pow(libm::sin(angle), dimensions as f64 - 2.0);
        sums.0 += share * libm::cos(x * libm::cos(angle));
        sums.1 += share;
    }
    bell(or(Opt::Width, 0.7)) * if dimensions == 1 { libm::cos(x) } else { sums.0 / sums.1 }
}

/// Solves by elimination.
fn solve(mut rows: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let n = right.len();
    for i in 0..n {
        for k in 0..n {
            let share = rows[k][i] / rows[i][i];
            if k != i && share != 0.0 {
                let (from, to) = (rows[i].clone(), &mut rows[k]);
                to.iter_mut().zip(from).for_each(|(a, b)| *a -= share * b);
                right[k] -= share * right[i];
            }
        }
    }
    (0..n).map(|i| right[i] / rows[i][i]).collect()
}

/// Neighbours of a point, and the weights C⁻¹c of theirs; the last number is 1 - cᵗC⁻¹c.
fn reference(params: &Params, known: &dyn Fn(f64) -> f64, p: &[f32]) -> (Vec<Vec<f32>>, Vec<f64>, f64) {
    let d = p.len();
    let n = if params.vector(Opt::Neighbours).is_some() { 3 } else { 4_usize };
    let base = |x: f32| if n == 3 { (x + 0.5).floor() - 1.0 } else { x.floor() - 1.0 };
    let place = |i: usize, k: usize| base(p[k]) + (i / n.pow(k as u32) % n) as f32;
    let points: Vec<Vec<f32>> = (0..n.pow(d as u32)).map(|i| (0..d).map(|k| place(i, k)).collect()).collect();
    let between = |a: &[f32], b: &[f32]| {
        let square: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a - b) * f64::from(a - b)).sum();
        known(square.sqrt())
    };
    let c: Vec<f64> = points.iter().map(|q| between(q, p)).collect();
    let rows = points.iter().map(|q| points.iter().map(|r| between(q, r)).collect()).collect();
    let weights = solve(rows, c.clone());
    let error = 1.0 - c.iter().zip(&weights).map(|(a, b)| a * b).sum::<f64>();
    (points, weights, error)
}

#[test]
fn it_is_the_sum_that_lewis_gives() {
    for params in ways() {
        for d in 1..=3 {
            let (field, seedless) = (KIND.field(d, &params).unwrap(), params.clone().reseeded(0));
            let errors = wiener_error(d, &seedless).unwrap();
            let p = Random(d as u64).points(d, if d == 3 { 12 } else { 100 }, 20.0);
            let (got, told) =
                (noise(&*field, Isa::detect(), &slices(&p)), noise(&*errors, Isa::detect(), &slices(&p)));
            // Distances are many, but squares between lattice points few.
            let kept = std::cell::RefCell::new(std::collections::HashMap::new());
            let known = |distance: f64| {
                *kept
                    .borrow_mut()
                    .entry(distance.to_bits())
                    .or_insert_with(|| covariance(&params, d, distance) / covariance(&params, d, 0.0))
            };
            // Near distance 0 knots are no polynomial in its square, which the table is of.
            let tolerance = if params.vector(Opt::Knots).is_some() { 1e-4 } else { 1e-5 };
            for i in 0..got.len() {
                let at: Vec<f32> = p.iter().map(|p| p[i]).collect();
                let (points, weights, error) = reference(&params, &known, &at);
                let columns: Vec<Vec<f32>> = (0..d).map(|k| points.iter().map(|q| q[k]).collect()).collect();
                let values = noise(&*field, Isa::detect(), &slices(&columns));
                let sum: f64 = values.iter().zip(&weights).map(|(v, w)| f64::from(*v) * w).sum();
                assert!((f64::from(got[i]) - sum).abs() < 1e-5, "{params:?} {at:?}: {} {sum}", got[i]);
                assert!(
                    (f64::from(told[i]) - error.max(0.0)).abs() < tolerance,
                    "{params:?} {at:?}: {} {error}",
                    told[i]
                );
            }
        }
    }
}

#[test]
fn lattice_points_keep_their_values() {
    let mut random = Random(3);
    let p: Vec<Vec<f32>> = (0..3).map(|_| (0..3000).map(|_| random.within(1e4).floor()).collect()).collect();
    let known = noise(&*KIND.field(3, &Params::seeded(5)).unwrap(), Isa::detect(), &slices(&p));
    // The same for all but for a factor: exactly where weights are fitted so, else but for rounding.
    for params in ways() {
        let got = noise(&*KIND.field(3, &params).unwrap(), Isa::detect(), &slices(&p));
        let products = |a: &[f32], b: &[f32]| -> f64 {
            a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
        };
        let factor = products(&got, &known) / products(&known, &known);
        for (got, known) in got.iter().zip(&known) {
            assert!((f64::from(*got) - factor * f64::from(*known)).abs() < 5e-6, "{params:?} {got} {known}");
        }
    }
    // Gaussian enough: mean, variance, third and fourth moments.
    let moment = |n: i32| known.iter().map(|v| power(*v, n)).sum::<f64>() / 3000.0;
    let deviation = moment(2).sqrt();
    assert!((deviation - 0.3513).abs() < 0.015 && moment(1).abs() < 0.02, "{deviation} {}", moment(1));
    let scaled = |n: i32| moment(n) / power(deviation as f32, n);
    assert!((scaled(4) - 2.7).abs() < 0.2 && scaled(3).abs() < 0.15, "{} {}", scaled(4), scaled(3));
    assert!(known.iter().all(|v| v.abs() <= 1.2171));
}

#[test]
fn the_deviation_is_a_quarter() {
    for params in ways() {
        for d in 1..=3 {
            let p = Random(4).points(d, 100_000, 60_000.0);
            let values = noise(&*KIND.field(d, &params).unwrap(), Isa::detect(), &slices(&p));
            let moment = |n: i32| values.iter().map(|v| power(*v, n)).sum::<f64>() / 1e5;
            assert!((moment(2).sqrt() - 0.25).abs() < 0.005, "{params:?} {d}-D: {}", moment(2).sqrt());
            assert!(moment(1).abs() < 0.005);
        }
    }
}

#[test]
fn the_covariance_is_about_what_was_asked_for() {
    // Width ½ is the best one for a gaussian: the lattice has it nearly.
    let oscillatory = Params::default().with_choice(Opt::Covariance, "oscillatory");
    for params in [Params::default(), Params::default().with(Opt::Neighbours, &[3.0]), oscillatory] {
        let field = KIND.field(3, &params).unwrap();
        let p = Random(5).points(3, 60_000, 300.0);
        let here = noise(&*field, Isa::detect(), &slices(&p));
        for direction in [[1.0, 0.0, 0.0], [0.48, 0.64, 0.6], [3.0_f32.sqrt().recip(); 3]] {
            let (mut measured, mut asked) = (Vec::new(), Vec::new());
            for step in 0..=20 {
                let distance = 0.125 * step as f32;
                let q: Vec<Vec<f32>> =
                    (0..3).map(|k| p[k].iter().map(|x| x + direction[k] * distance).collect()).collect();
                let there = noise(&*field, Isa::detect(), &slices(&q));
                let products = here.iter().zip(&there).map(|(a, b)| f64::from(*a) * f64::from(*b));
                measured.push(products.sum::<f64>() / (6e4 * 0.0625));
                asked.push(covariance(&params, 3, f64::from(distance)));
            }
            let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
            let off = |x: &[f64]| x.iter().map(|v| v - mean(x)).collect::<Vec<f64>>();
            let products = |a: &[f64], b: &[f64]| off(a).iter().zip(off(b)).map(|(a, b)| a * b).sum::<f64>();
            let alike = products(&measured, &asked)
                / (products(&measured, &measured) * products(&asked, &asked)).sqrt();
            let worst = measured.iter().zip(&asked).fold(0.0_f64, |w, (a, b)| w.max((a - b).abs()));
            assert!(worst < 0.15 && alike > 0.98, "{params:?} {direction:?}: {worst} {alike}");
        }
    }
}

#[test]
fn the_gaussian_is_continuous_across_cells() {
    // To the bit: at a face the weights of all but the lattice points in it are 0.
    let mut random = Random(6);
    for d in 1..=4 {
        let field = KIND.field(d, &Params::default()).unwrap();
        for axis in 0..d {
            let mut p = random.points(d, 500, 20.0);
            p[axis].iter_mut().for_each(|x| *x = x.floor());
            let at = noise(&*field, Isa::detect(), &slices(&p));
            let below = |x: f32| if x > 0.0 { x.next_down() } else { x - 1e-20 };
            p[axis].iter_mut().for_each(|x| *x = below(*x));
            let before = noise(&*field, Isa::detect(), &slices(&p));
            for (at, before) in at.iter().zip(&before) {
                assert!((at - before).abs() < 1e-5, "{d}-D axis {axis}: {at} {before}");
            }
        }
    }
}

#[test]
fn derivatives_are_those_of_the_very_noise() {
    let h = 1.0 / 256.0;
    let errors = ways().into_iter().map(|p| (p.clone().reseeded(0), true));
    for (params, of_error) in ways().into_iter().map(|p| (p, false)).chain(errors) {
        for d in 1..=4 {
            let made = if of_error { wiener_error(d, &params) } else { KIND.field(d, &params) };
            let Ok(field) = made else { continue };
            let mut p = Random(7).points(d, 1000, 10.0);
            // Differences must not reach over a face, be it of the cells of four neighbours or of three.
            p.iter_mut().flatten().for_each(|x| {
                let quarter = (2.0 * *x).floor() * 0.5 + 0.25;
                *x = quarter + (*x - quarter) * 0.9;
            });
            let exact = derivative(&*field, Isa::detect(), &slices(&p));
            for k in 0..d {
                let (mut up, mut down) = (p.clone(), p.clone());
                up[k].iter_mut().for_each(|x| *x += h);
                down[k].iter_mut().for_each(|x| *x -= h);
                let (up, down) = (
                    noise(&*field, Isa::detect(), &slices(&up)),
                    noise(&*field, Isa::detect(), &slices(&down)),
                );
                for i in 0..1000 {
                    let difference = (up[i] - down[i]) / (2.0 * h);
                    assert!(
                        (difference - exact[k][i]).abs() < 4e-3,
                        "{params:?} {d}-D {}: {difference} {}",
                        k,
                        exact[k][i]
                    );
                }
            }
        }
    }
}

#[test]
fn the_error_is_none_at_lattice_points_and_some_between() {
    for params in ways().into_iter().map(|p| p.reseeded(0)) {
        for d in 1..=3 {
            let field = wiener_error(d, &params).unwrap();
            let whole: Vec<Vec<f32>> = (0..d).map(|k| vec![k as f32 - 7.0, 0.0, 1e6, -3e7]).collect();
            let none = noise(&*field, Isa::detect(), &slices(&whole));
            assert!(none.iter().all(|e| (0.0..2e-6).contains(e)), "{params:?} {none:?}");
            if params.vector(Opt::Knots).is_none() {
                let p = Random(8).points(d, 1000, 9.0);
                let some = noise(&*field, Isa::detect(), &slices(&p));
                let known = |i: usize| p.iter().all(|p| (p[i] - p[i].round()).abs() < 0.15);
                assert!((0..1000).all(|i| some[i] < 1.0 && (some[i] > 1e-6 || known(i))), "{params:?}");
            }
        }
    }
    // By hand: in the middle between two points, with 3 neighbours of width ½, of which the third hardly matters.
    let error = wiener_error(1, &Params::default().with(Opt::Neighbours, &[3.0])).unwrap();
    let middle = noise(&*error, Isa::detect(), &[&[0.5]])[0];
    let by_two = 1.0 - 2.0 * libm::exp(-1.0) / (1.0 + libm::exp(-2.0));
    assert!((f64::from(middle) - by_two).abs() < 0.01, "{middle} {by_two}");
}

#[test]
fn it_repeats_with_its_period() {
    for params in ways() {
        let params = params.with(Opt::Period, &[3.0, 0.0, 16.0]);
        let field = KIND.field(3, &params).unwrap();
        // Exact sums.
        let mut p = Random(9).points(3, 500, 40.0);
        p.iter_mut().flatten().for_each(|x| *x = (*x * 64.0).floor() / 64.0);
        let mut q = p.clone();
        q[0].iter_mut().for_each(|x| *x += 3.0);
        q[2].iter_mut().for_each(|x| *x -= 32.0);
        assert_eq!(
            bits(&noise(&*field, Isa::detect(), &slices(&p))),
            bits(&noise(&*field, Isa::detect(), &slices(&q)))
        );
        q[1].iter_mut().for_each(|x| *x += 3.0);
        assert_ne!(
            bits(&noise(&*field, Isa::detect(), &slices(&p))),
            bits(&noise(&*field, Isa::detect(), &slices(&q)))
        );
    }
    assert!(KIND.field(2, &Params::default().with(Opt::Period, &[1.5])).is_err());
}

#[test]
fn what_does_not_fit_is_told() {
    let plain = Params::default();
    let oscillatory = plain.clone().with_choice(Opt::Covariance, "oscillatory");
    let knots = |values: &[f32]| plain.clone().with(Opt::Knots, values);
    for (params, d, option, message) in [
        (
            plain.clone().with(Opt::Neighbours, &[5.0]),
            3,
            Opt::Neighbours,
            "neighbours must be 3 or 4, found 5",
        ),
        (plain.clone().with(Opt::Neighbours, &[4.0, 4.0]), 2, Opt::Neighbours, "a vector of 2"),
        (plain.clone().with(Opt::Width, &[0.1]), 3, Opt::Width, "width must be from 0.25 to 2, found 0.1"),
        (
            plain.clone().with(Opt::Frequency, &[1.0]),
            3,
            Opt::Frequency,
            "the gaussian covariance has no frequency",
        ),
        (oscillatory.clone().with(Opt::Frequency, &[f32::NAN]), 3, Opt::Frequency, "found NaN"),
        (
            oscillatory.clone().with(Opt::Frequency, &[0.1]).with(Opt::Width, &[2.0]),
            3,
            Opt::Width,
            "not positive definite",
        ),
        (oscillatory, 4, Opt::Covariance, "of 4 coordinates there is the gaussian covariance only"),
        (knots(&[1.0]), 3, Opt::Knots, "at least 2 values, found 1"),
        (knots(&[1.0, f32::INFINITY]), 3, Opt::Knots, "must be finite, found inf"),
        (knots(&[0.0, 0.0]), 3, Opt::Knots, "above 0, found 0"),
        (knots(&[1.0, 0.9, 0.8, 0.7]), 3, Opt::Knots, "not positive definite"),
        (
            knots(&[1.0, -2.0, 0.0]),
            1,
            Opt::Knots,
            "between lattice points 0, 1 and 2 apart it is 1, -2.00 and 0.00",
        ),
        (knots(&KNOTS).with(Opt::Width, &[0.5]), 3, Opt::Width, "given by knots has no width"),
    ] {
        let unfit = KIND.field(d, &params).err().unwrap();
        assert!(unfit.option == Some(option) && unfit.message.contains(message), "{}", unfit.message);
        assert_eq!(wiener_error(d, &params).err(), Some(unfit));
    }
}

#[test]
fn every_instruction_set_length_and_order_gives_the_same_bits() {
    for params in ways() {
        for d in 1..=4 {
            let Ok(field) = KIND.field(d, &params) else { continue };
            let error = wiener_error(d, &params.clone().reseeded(0)).unwrap();
            // Some scattered, some that stay in a cell for a while, some awkward.
            let mut p = Random(10).points(d, 300, 1000.0);
            for i in 100..200 {
                for p in &mut p {
                    p[i] = p[99] + (i as f32 - 100.0) * 0.01;
                }
            }
            let awkward = [f32::NAN, f32::INFINITY, 1e30, -1e30, 8_388_608.0, -0.0, 1e-45, -1e-10];
            for (i, x) in awkward.into_iter().enumerate() {
                p[i % d][i * 30 + 3] = x;
            }
            for field in [&field, &error] {
                let one = |i: usize| p.iter().map(|p| vec![p[i]]).collect::<Vec<_>>();
                let alone: Vec<f32> =
                    (0..300).map(|i| noise(&**field, Isa::baseline(), &slices(&one(i)))[0]).collect();
                let slopes = derivative(&**field, Isa::baseline(), &slices(&p));
                for isa in [Isa::baseline(), Isa::detect()] {
                    for start in [0, 1, 45, 200, 293] {
                        let cut: Vec<&[f32]> = p.iter().map(|p| &p[start..]).collect();
                        assert_eq!(bits(&noise(&**field, isa, &cut)), bits(&alone[start..]), "{params:?}");
                        for (got, known) in derivative(&**field, isa, &cut).iter().zip(&slopes) {
                            assert_eq!(bits(got), bits(&known[start..]), "{params:?}");
                        }
                    }
                }
                for (i, value) in alone.iter().enumerate() {
                    let finite = p.iter().all(|p| p[i].is_finite());
                    assert!(value.is_nan() != finite && slopes.iter().all(|s| s[i].is_nan() != finite));
                }
            }
        }
    }
}

#[test]
fn known_values() {
    // Pinned: a change of these changes pictures. Of no seed.
    let p = [0.4, 1.25, -2.75, 100.125];
    let got: Vec<f32> = ways()
        .into_iter()
        .flat_map(|params| {
            let params = params.reseeded(0);
            (1..=4).filter_map(move |d| {
                let columns: Vec<&[f32]> = p[..d].iter().map(std::slice::from_ref).collect();
                Some(noise(&*KIND.field(d, &params).ok()?, Isa::detect(), &columns)[0])
            })
        })
        .collect();
    #[rustfmt::skip]
    let known = [
        0x3d25c9d0, 0xbe07f38f, 0xbe83dea7, 0x3ef9dabb, 0x3d3e03ab, 0xbe180d35, 0xbe883459,
        0x3ef624eb, 0x3d1f5ada, 0xbda4e323, 0xbe1be210, 0x3e44bf37, 0x3d1f5ded, 0xbda4e57c,
        0xbe1be310, 0x3e44bc4b, 0x3d10750f, 0xbdda7b73, 0xbe683b2a, 0x3ee671b3, 0x3d0fb1a7,
        0xbe391b8c, 0xbea72706, 0x3ef05271, 0x3c751c2a, 0xbd7e90b4, 0xbe61ac91, 0x3c4b8100,
        0xbd8afe6f, 0xbe639227, 0x3d82af0f, 0xbe129caa, 0xbe8dd5dc, 0x3d8157d3, 0xbe132850,
        0xbe8eb6c1, 0x3d0a21bb, 0xbdf51281, 0xbe86400b, 0x3d2ff90b, 0xbe19c181, 0xbe8a309d,
    ];
    assert_eq!(bits(&got), known, "{:x?} {got:?}", bits(&got));
}
