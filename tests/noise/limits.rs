//! Which rule holds for which kind, and the limits of each kind's spectrum.

use super::measured::Measured;
use pse::noise::Smoothness;

/// What a noise should be like; every kind is, but for the exceptions of its [`Limits`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Its mean is 0, within 5 % of its deviation.
    Centred,
    /// No step across the faces of cells: of the value below 0.002 deviations, of the slope below 0.03 rms slopes.
    Seamless,
    /// It is as smooth as its contract says; if that is of kinks or steps, it has them.
    Smooth,
    /// The derivative is that of differences, within 1 % of the rms slope.
    Derivative,
    /// Over a distance it changes alike in all directions: mean squares differ by a quarter at most.
    Isotropic,
    /// Plane sections have the same variance however they are turned, within a quarter.
    Turned,
    /// 10⁶ units away the deviation is 0.75 to 1.3 of that about the origin.
    Far,
    /// No correlation above 0.16 with itself moved by 4 … 65536.
    Unrepeated,
    /// Another seed gives an unrelated noise.
    Seeds,
}

/// All of them.
pub const RULES: [Rule; 9] = [
    Rule::Centred,
    Rule::Seamless,
    Rule::Smooth,
    Rule::Derivative,
    Rule::Isotropic,
    Rule::Turned,
    Rule::Far,
    Rule::Unrepeated,
    Rule::Seeds,
];

/// What holds for a kind alone.
pub struct Limits {
    pub name: &'static str,
    /// Shares of the power of plane sections, from and to: below 0.3 cycles a unit, between 0.3 and 0.7, above 1.
    pub below: [f64; 2],
    pub band: [f64; 2],
    pub above: [f64; 2],
    /// The largest steps of value and slope across faces, and the rms of that of the slope, where they may be larger than
    /// [`Rule::Seamless`] says.
    pub steps: [f64; 3],
    /// The rules that do not hold, and why.
    pub but: &'static [(Rule, &'static str)],
}

const ANY: [f64; 2] = [0.0, 1.0];
const NARROW: [f64; 3] = [0.002, 0.03, 0.03];

const fn free(name: &'static str) -> Limits {
    Limits { name, below: ANY, band: ANY, above: ANY, steps: NARROW, but: &[] }
}

/// Of kinds with a table, in which the longest waves are the strongest.
const LONG_WAVES: &[(Rule, &str)] = &[
    (Rule::Unrepeated, "it has a table, which repeats"),
    (Rule::Seeds, "a few long waves are most of it, and are alike by chance"),
    (Rule::Turned, "a few long waves are most of it, and lie somehow"),
];

/// Every kind that there is to be. What the numbers of Peachey's figure 2.37 say, and the contracts.
pub static EXPECTED: [Limits; 17] = [
    Limits { below: [0.15, 0.45], band: [0.48, 1.0], above: [0.0, 0.03], ..free("perlin1985") },
    Limits { below: [0.0, 0.26], band: [0.58, 1.0], above: [0.0, 0.03], ..free("gradient") },
    Limits { below: [0.0, 0.26], band: [0.55, 1.0], above: [0.0, 0.04], ..free("improved") },
    Limits { below: [0.33, 0.5], above: [0.0, 0.005], ..free("value") },
    Limits { above: [0.0, 0.01], ..free("value_gradient") },
    Limits { above: [0.0, 0.03], ..free("hermite") },
    Limits { above: [0.0, 0.005], ..free("lattice_convolution") },
    Limits { above: [0.0, 0.005], ..free("sparse_convolution") },
    // Each cell has neighbours of its own, and a step to the next where those are too few.
    Limits { above: [0.0, 0.005], steps: [0.02, 0.3, 0.15], ..free("wiener") },
    Limits {
        but: &[
            (Rule::Seamless, "each cell has a value of its own"),
            (Rule::Derivative, "it is 0 wherever there is one"),
            (Rule::Isotropic, "cells are cubes"),
        ],
        ..free("white")
    },
    Limits { but: &[(Rule::Turned, "it is made of noises along the axes")], ..free("composed") },
    free("gardner"),
    Limits { below: [0.8, 1.0], above: [0.0, 0.005], but: LONG_WAVES, ..free("fourier") },
    Limits {
        below: [0.8, 1.0],
        above: [0.0, 0.01],
        but: &[LONG_WAVES[0], LONG_WAVES[1]],
        ..free("midpoint")
    },
    free("simplex"),
    Limits {
        but: &[
            (Rule::Centred, "distances are not negative"),
            (Rule::Seamless, "it has a kink wherever the nearest of two points changes"),
        ],
        ..free("cellular")
    },
    free("gabor"),
];

/// The limits of a kind; nothing but the rules for one that is not in the list.
pub fn of(name: &'static str) -> Limits {
    let found = EXPECTED.iter().find(|limits| limits.name == name);
    found.map_or(free(name), |found| Limits { ..*found })
}

impl Limits {
    /// Why a rule does not hold, if it does not.
    pub fn exception(&self, rule: Rule) -> Option<&'static str> {
        self.but.iter().find(|(r, _)| *r == rule).map(|(_, why)| *why)
    }
}

/// Does a rule hold for what was measured? With the numbers that tell.
pub fn holds(rule: Rule, m: &Measured, limits: &Limits) -> (bool, String) {
    let at_most =
        |what: &str, found: f64, limit: f64| (found <= limit, format!("{what} {found:.4}, at most {limit}"));
    match rule {
        Rule::Centred => at_most("mean over deviation", m.moments.mean.abs() / m.moments.deviation, 0.05),
        Rule::Seamless => {
            let value = at_most("step of the value", m.value_jump, limits.steps[0]);
            let slope = at_most("step of the slope", m.slope_jump, limits.steps[1]);
            let usual = at_most("its rms", m.usual_slope_jump, limits.steps[2]);
            (value.0 && slope.0 && usual.0, format!("{}; {}; {}", value.1, slope.1, usual.1))
        }
        Rule::Smooth => {
            // More than two derivatives are not looked at, and small steps of higher ones are not seen; but a kink is.
            let (found, promised) = (m.smoothness, m.kind.contract.smoothness);
            let told = found == promised || promised > Smoothness::C0;
            (
                found >= promised.min(Smoothness::C2) && told,
                format!("it is {found}, and should be {promised}"),
            )
        }
        Rule::Derivative => at_most("rms error over rms slope", m.derivative, 0.01),
        Rule::Isotropic => at_most("ratio of changes", m.isotropy, 1.25),
        Rule::Turned => at_most("ratio of variances", m.planes, 1.25),
        Rule::Far => ((0.75..=1.3).contains(&m.far), format!("far deviation {:.4}, 0.75 to 1.3", m.far)),
        Rule::Unrepeated => at_most("correlation", m.shift, 0.16),
        Rule::Seeds => at_most("correlation", m.seeds, 0.05),
    }
}
