//! What holds for every function of the table. Their examples are run by `tests/language/reference.rs`.

mod canonical;
mod filtered;

use super::{ParamKind, all};
use crate::program::{Error, Program, RunOptions};
use crate::value::PixelValue;

/// The value of an expression.
fn value(code: &str) -> Result<PixelValue, Error> {
    let program = Program::compile(&format!("found = {code}"))?;
    let mut values = program.eval_pixel(&[], &RunOptions::default())?;
    Ok(values.pop().expect("an assigned variable").1)
}

/// The message of the error that an expression has.
fn message(code: &str) -> String {
    value(code).expect_err(code).diagnostics[0].message.clone()
}

/// Asserts that two expressions have one value.
fn gives(code: &str, expected: &str) {
    let (found, wanted) = (value(code).unwrap(), value(expected).unwrap());
    let near = |(x, y): (&f32, &f32)| {
        x == y || (x.is_nan() && y.is_nan()) || (x - y).abs() <= 1e-5 * x.abs().max(y.abs()).max(1.0)
    };
    let alike = found.shape() == wanted.shape() && found.cells().iter().zip(wanted.cells()).all(near);
    assert!(alike, "{code} gives {found}, not {wanted}");
}

#[test]
fn every_entry_is_complete() {
    let mut names = std::collections::HashSet::new();
    for b in all() {
        assert!(names.insert(b.name), "{} stands twice", b.name);
        assert!(b.brief.ends_with(['.', '`']) || b.brief.ends_with(')'), "{}: {}", b.name, b.brief);
        assert!(b.brief.chars().count() < 100 && !b.brief.contains('\n'), "{}: a long line", b.name);
        assert!(!b.examples.is_empty(), "{} has no example", b.name);
        assert!(b.examples.iter().any(|e| e.code.contains(b.name)), "{}: no example of it", b.name);
        let last = b.params.len() - 1;
        for (k, p) in b.params.iter().enumerate() {
            assert!(k == last || !matches!(p.kind, ParamKind::Rest(_)), "{}: a rest before the last", b.name);
            assert!(b.params[..k].iter().all(|q| q.name != p.name), "{}: {} stands twice", b.name, p.name);
            let optional = p.default.is_some() || matches!(p.kind, ParamKind::Choice(_));
            let after = b.params[..k].iter().any(|q| q.default.is_some());
            assert!(optional || !after, "{}: {} must be given after a default", b.name, p.name);
        }
        let count = match b.kernel {
            super::Kernel::Map1(_) => 1,
            super::Kernel::Map2(_) => 2,
            super::Kernel::Maps(_) => b.params.len().clamp(3, 4),
            super::Kernel::Fold(_) | super::Kernel::Whole(_) | super::Kernel::Shadowed(_) => b.params.len(),
        };
        assert_eq!(b.params.len(), count, "{} has another number of parameters than its kernel", b.name);
    }
}

#[test]
fn faults_say_what_was_found() {
    assert_eq!(message("cross([1 2 3], [1 2])"), "`cross()` needs a vector of 3, found a vector of 2");
    assert_eq!(
        message("dot([1 2 3], [1 2])"),
        "`dot()` needs vectors of one length, found a vector of 3 and a vector of 2"
    );
    assert_eq!(message("mod([1 2 3], [1 2])"), "`mod()` meets vectors of different lengths, 3 and 2");
    assert_eq!(
        message("Noise([1 2 3 4 5])"),
        "`Noise()` takes a scalar or a vector of 1 to 4, found a vector of 5"
    );
    assert_eq!(message("spline(0.5, 1, 2, 3)"), "`spline()` needs at least 4 knots, found 3");
    assert_eq!(message("inverse([1 2])"), "`inverse()` needs a matrix, found a vector of 2");
    assert_eq!(
        message("identity(300)"),
        "`identity()`: the value would have 90000 numbers, and the limit is 65536"
    );
    assert_eq!(message("max([])"), "`max()` of an empty vector has no value");
    assert_eq!(
        message("multiply([[1 2] [3 4]], [1 2 3])"),
        "`multiply()` of a matrix of 2 columns needs 2 rows, found 3"
    );
}

#[test]
fn functions_of_vectors_meet_vectors_of_vectors() {
    gives("norm([[3 4] [6 8]])", "[5 10]");
    gives("cross([[1 0 0] [0 1 0]], [0 0 1])", "[[0 -1 0] [1 0 0]]");
    gives("hsv_to_rgb([[0 1 1] [0.5 0 2]])", "[[1 0 0] [2 2 2]]");
    gives("transform(translation([1 1 1]), [[0 0 0] [1 2 3]])", "[[1 1 1] [2 3 4]]");
    gives("Noise([[1 2] [3 4]]) - [Noise([1 2]) Noise([3 4])]", "[0 0]");
    gives("distance([[0 0] [1 1]], [[0 2] [1 4]])", "[2 3]");
    gives("clamp([[-1 2] 0.5])", "[[0 1] 0.5]");
}

#[test]
fn a_splines_form_does_not_matter() {
    gives("spline(0.3, 1, 4, 2, 8, 5)", "spline(0.3, [1 4 2 8 5])[1]".trim_end_matches("[1]"));
    gives("spline(0.3, [1 2], [4 0], [2 2], [8 1])", "[spline(0.3, 1, 4, 2, 8) spline(0.3, 2, 0, 2, 1)]");
    gives("spline(-3, 1, 4, 2, 8, 5)", "4");
    gives("spline(1/0, 1, 4, 2, 8, 5)", "8");
    gives("isnan(spline(0/0, 1, 4, 2, 8, 5))", "1");
    gives("linear(0.5, 0, [1 2])", "[0.5 1]");
}

#[test]
fn splines_follow_the_paper() {
    // Peachey's code, but for its last span, which is one too far.
    fn direct(x: f32, knots: &[f32]) -> f32 {
        let spans = knots.len() - 3;
        let x = x.clamp(0.0, 1.0) * spans as f32;
        let span = (x as usize).min(spans - 1);
        let (x, k) = (x - span as f32, &knots[span..]);
        let c3 = -0.5 * k[0] + 1.5 * k[1] - 1.5 * k[2] + 0.5 * k[3];
        let c2 = k[0] - 2.5 * k[1] + 2.0 * k[2] - 0.5 * k[3];
        let c1 = -0.5 * k[0] + 0.5 * k[2];
        ((c3 * x + c2) * x + c1) * x + k[1]
    }
    for count in [4, 5, 7, 66, 67, 80] {
        let knots: Vec<f32> = (0..count).map(|i| ((i * i * 7) % 11) as f32 - 3.0).collect();
        let text: Vec<String> = knots.iter().map(f32::to_string).collect();
        for i in 0..=40 {
            let t = i as f32 / 40.0;
            let found = value(&format!("spline({t}, [{}])", text.join(" "))).unwrap();
            let expected = direct(t, &knots);
            assert!((found.cells()[0] - expected).abs() < 1e-4, "{count} knots at {t}");
        }
    }
}

#[test]
fn matrices_are_undone_by_their_inverses() {
    for m in ["[[1 2] [3 5]]", "[[1 2 0] [0 3 5] [7 1 1]]", "[[1 2 0 4] [0 3 5 1] [7 1 1 2] [2 0 1 3]]"] {
        let n = m.matches('[').count() - 1;
        gives(&format!("multiply({m}, inverse({m}))"), &format!("identity({n})"));
        gives(&format!("determinant(inverse({m})) * determinant({m})"), "1");
    }
    gives(
        "determinant(transpose([[1 2 0 4] [0 3 5 1] [7 1 1 2] [2 0 1 3]]))",
        "determinant([[1 2 0 4] [0 3 5 1] [7 1 1 2] [2 0 1 3]])",
    );
    gives("multiply(rotation(1, [1 2 3]), transpose(rotation(1, [1 2 3])))", "identity(4)");
    gives("transform(rotation(0.7, [1 2 3]), [4 5 6])", "rotate([4 5 6], 0.7, [1 2 3])");
    gives("dot(ntransform(scaling([2 3 4]), [1 1 0]), vtransform(scaling([2 3 4]), [1 -1 0]))", "0");
    gives("rotate([1 2 3], 1, [0 0 0])", "[1 2 3]");
}

#[test]
fn light_bends_as_snell_says() {
    for degrees in [0.0f32, 10.0, 40.0, 80.0] {
        for ratio in [1.0 / 1.5, 1.0, 1.2] {
            let code =
                format!("refract([sin(radians({degrees})) -cos(radians({degrees})) 0], [0 1 0], {ratio})");
            let bent: Vec<f32> = value(&code).unwrap().cells().to_vec();
            let sine = ratio * libm::sin(f64::from(degrees).to_radians());
            if sine > 1.0 {
                assert_eq!(bent, [0.0; 3]);
            } else {
                assert!((f64::from(bent[0]) - sine).abs() < 1e-5, "{code}");
                assert!((f64::from(bent[1]) + (1.0 - sine * sine).sqrt()).abs() < 1e-5, "{code}");
            }
        }
    }
}

#[test]
fn colours_come_back() {
    for color in ["[0.2 0.5 0.9]", "[1 0 0]", "[0.9 0.8 0.1]", "[0.3 0.3 0.3]", "[0 0 0]", "[0.5 0.1 0.4]"] {
        gives(&format!("hsv_to_rgb(rgb_to_hsv({color}))"), color);
        gives(&format!("hsl_to_rgb(rgb_to_hsl({color}))"), color);
        gives(&format!("srgb_to_linear(linear_to_srgb({color}))"), color);
    }
    gives("hsv_to_rgb([-2/3 1 1 0.5])", "[0 1 0 0.5]");
    // The joint of the curve's two parts.
    gives("srgb_to_linear(0.04045)", "0.0031308");
}

/// Against Planck's law under the colour matching functions, by the fits of Wyman, Sloan and Shirley (2013).
#[test]
fn black_bodies_follow_planck() {
    fn lobe(x: f64, mean: f64, below: f64, above: f64) -> f64 {
        let t = (x - mean) * if x < mean { below } else { above };
        libm::exp(-0.5 * t * t)
    }
    for kelvin in [1500.0, 2800.0, 4000.0, 5800.0, 6500.0, 9000.0, 14000.0] {
        let mut xyz = [0.0f64; 3];
        for nm in (360..=830).map(f64::from) {
            let power = libm::pow(nm, -5.0) / (libm::exp(1.438_776_9e7 / (nm * kelvin)) - 1.0);
            xyz[0] += power
                * (0.362 * lobe(nm, 442.0, 0.0624, 0.0374) + 1.056 * lobe(nm, 599.8, 0.0264, 0.0323)
                    - 0.065 * lobe(nm, 501.1, 0.0490, 0.0382));
            xyz[1] +=
                power * (0.821 * lobe(nm, 568.8, 0.0213, 0.0247) + 0.286 * lobe(nm, 530.9, 0.0613, 0.0322));
            xyz[2] +=
                power * (1.217 * lobe(nm, 437.0, 0.0845, 0.0278) + 0.681 * lobe(nm, 459.0, 0.0385, 0.0725));
        }
        let [x, y, z] = xyz;
        let rgb = [
            3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
            -0.969266 * x + 1.8760108 * y + 0.041556 * z,
            0.0556434 * x - 0.2040259 * y + 1.0572252 * z,
        ];
        let top = rgb.iter().copied().fold(0.0, f64::max);
        let found: Vec<f32> = value(&format!("blackbody({kelvin})")).unwrap().cells().to_vec();
        for (found, wanted) in found.iter().zip(rgb) {
            assert!(
                (f64::from(*found) - (wanted / top).max(0.0)).abs() < 0.02,
                "{kelvin}: {found} {}",
                wanted / top
            );
        }
    }
}
