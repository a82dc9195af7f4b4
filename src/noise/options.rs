//! What kinds of noise can be given: one table of options, each with its name, its values and what it means.

use super::kind::Unfit;
use smallvec::SmallVec;

/// Something that a kind of noise can be given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Opt {
    /// After how many cells the noise repeats, along each axis.
    Period,
    /// How much of each of two noises.
    Weights,
    /// How noises of fewer dimensions are put together.
    Composition,
    /// How many impulses a cell has, on average.
    Density,
    /// What stands about each impulse.
    Kernel,
    /// What waves there are: cycles a unit.
    Frequency,
    /// Along which axis waves go.
    Direction,
    /// How wide the band of frequencies is.
    Bandwidth,
    /// How noise is correlated over distance.
    Covariance,
    /// How far it is correlated.
    Width,
    /// A curve over distance, of the user's own.
    Knots,
    /// How many lattice points along each axis are looked at.
    Neighbours,
    /// How steeply the spectrum falls.
    Beta,
    /// How much of the size is left at half the distance.
    Roughness,
    /// What is told of the points scattered over cells.
    Feature,
    /// What distance is.
    Metric,
    /// How far points are scattered.
    Jitter,
}

/// An option's entry.
pub struct Info {
    /// Which one it is of.
    pub option: Opt,
    /// Its name, as the functions take it.
    pub name: &'static str,
    /// The words that it can be, the first being the default; empty if it is a number or a vector.
    pub choices: &'static [&'static str],
    /// What it means, in Markdown.
    pub doc: &'static str,
}

/// All of them, in the order of [`Opt`].
pub static OPTIONS: [Info; 17] = [
    info(
        Opt::Period,
        "period",
        "the period of the noise along each axis, a whole number of units; one for all axes, or one for each, 0 for none",
    ),
    info(Opt::Weights, "weights", "the weights of the value noise and of the gradient noise"),
    choice(
        Opt::Composition,
        "composition",
        &["product", "sum"],
        "the combination of noises of fewer dimensions",
    ),
    info(Opt::Density, "density", "the mean number of impulses in a unit cell"),
    choice(
        Opt::Kernel,
        "kernel",
        &["cosine", "catmull_rom", "gaussian", "gabor"],
        "the kernel around each impulse",
    ),
    info(Opt::Frequency, "frequency", "the frequency of the waves, in cycles per unit"),
    info(Opt::Direction, "direction", "the direction of the waves, a vector"),
    info(Opt::Bandwidth, "bandwidth", "the width of the band of frequencies, in octaves"),
    choice(
        Opt::Covariance,
        "covariance",
        &["gaussian", "oscillatory"],
        "the form of the correlation over distance",
    ),
    info(Opt::Width, "width", "the distance of correlation: the covariance's standard deviation, in units"),
    info(
        Opt::Knots,
        "knots",
        "your own curve over distance, instead of a named one: its values at equal steps, the first at 0",
    ),
    info(Opt::Neighbours, "neighbours", "the number of lattice points along each axis that are used"),
    info(
        Opt::Beta,
        "beta",
        "the slope of the spectrum: the power density at a frequency, in the dimensions of the point, is frequency ^ -beta",
    ),
    info(Opt::Roughness, "roughness", "the size of detail at half the scale, 0 to 1"),
    choice(
        Opt::Feature,
        "feature",
        &["F1", "F2", "F2-F1", "id"],
        "the feature of the scattered points: the distance to the nearest, to the second nearest, the difference of the two, or a random number for each region",
    ),
    choice(Opt::Metric, "metric", &["euclidean", "manhattan", "chebyshev"], "the distance function"),
    info(Opt::Jitter, "jitter", "the scatter of the points in their cells, 0 to 1"),
];

const fn info(option: Opt, name: &'static str, doc: &'static str) -> Info {
    Info { option, name, choices: &[], doc }
}

const fn choice(
    option: Opt,
    name: &'static str,
    choices: &'static [&'static str],
    doc: &'static str,
) -> Info {
    Info { option, name, choices, doc }
}

impl Opt {
    /// Its entry.
    pub fn info(self) -> &'static Info {
        &OPTIONS[self as usize]
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        self.info().name
    }
}

/// The parameters of a noise: a seed, and those options that are given.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Params {
    /// Another seed is another noise of the same kind.
    pub seed: u32,
    /// In the order of [`Opt`], each once.
    given: SmallVec<[(Opt, SmallVec<[f32; 4]>); 2]>,
}

impl Params {
    /// No options.
    pub fn seeded(seed: u32) -> Params {
        Params { seed, ..Params::default() }
    }

    /// The same with another seed.
    pub fn reseeded(self, seed: u32) -> Params {
        Params { seed, ..self }
    }

    /// With one more option: a number, the components of a vector, or the place of a word among its choices.
    pub fn with(mut self, option: Opt, value: &[f32]) -> Params {
        let place = self.given.partition_point(|(o, _)| *o < option);
        if self.given.get(place).is_some_and(|(o, _)| *o == option) {
            self.given.remove(place);
        }
        self.given.insert(place, (option, value.into()));
        self
    }

    /// With a word for an option.
    ///
    /// # Panics
    /// If the option has no such choice.
    pub fn with_choice(self, option: Opt, word: &str) -> Params {
        let place = option.info().choices.iter().position(|c| *c == word);
        let place = place.unwrap_or_else(|| panic!("{} can't be `{word}`", option.name()));
        self.with(option, &[place as f32])
    }

    /// The options that are given.
    pub fn given(&self) -> impl Iterator<Item = Opt> {
        self.given.iter().map(|(o, _)| *o)
    }

    /// The same to the bit (as `==` says it, a NaN would differ from itself).
    pub(super) fn same_as(&self, other: &Params) -> bool {
        let bits = |p: &Params| -> SmallVec<[u32; 8]> {
            p.given.iter().flat_map(|(_, v)| v.iter().map(|x| x.to_bits())).collect()
        };
        let shape = |p: &Params| -> SmallVec<[(Opt, usize); 4]> {
            p.given.iter().map(|(o, v)| (*o, v.len())).collect()
        };
        self.seed == other.seed && shape(self) == shape(other) && bits(self) == bits(other)
    }

    /// The components of an option, if it is given.
    pub fn vector(&self, option: Opt) -> Option<&[f32]> {
        self.given.iter().find(|(o, _)| *o == option).map(|(_, v)| &v[..])
    }

    /// The place of an option's word among its choices.
    pub fn choice(&self, option: Opt) -> usize {
        self.vector(option).map_or(0, |v| v[0] as usize)
    }

    /// The number of an option, which must lie within `range`.
    ///
    /// # Errors
    /// If it is a vector, or out of range.
    pub fn number(
        &self,
        option: Opt,
        default: f32,
        range: std::ops::RangeInclusive<f32>,
    ) -> Result<f32, Unfit> {
        let (least, most) = (*range.start(), *range.end());
        match self.vector(option) {
            None => Ok(default),
            Some(&[x]) if range.contains(&x) => Ok(x),
            Some(&[x]) => {
                Err(Unfit::of(option, format!("{} must be from {least} to {most}, found {x}", option.name())))
            }
            Some(v) => {
                let message = format!("{} is a number, found a vector of {}", option.name(), v.len());
                Err(Unfit::of(option, message))
            }
        }
    }

    /// The period along each axis, in cells; 0 where there is none; `None` if there is none at all.
    ///
    /// # Errors
    /// If it is not one whole number, or one for each axis.
    pub fn period<const D: usize>(&self) -> Result<Option<[f32; D]>, Unfit> {
        let Some(given) = self.vector(Opt::Period) else { return Ok(None) };
        let period: [f32; D] = match *given {
            [p] => [p; D],
            _ => given.try_into().map_err(|_| {
                let message = format!(
                    "period needs a number for each of the point's {D} coordinates, found {}",
                    given.len()
                );
                Unfit::of(Opt::Period, message)
            })?,
        };
        match period.iter().find(|p| !(**p >= 0.0 && **p <= LONGEST_PERIOD && p.fract() == 0.0)) {
            None => Ok(period.iter().any(|p| *p > 0.0).then_some(period)),
            Some(p) => {
                let message = format!("period must be a whole number from 0 to {LONGEST_PERIOD}, found {p}");
                Err(Unfit::of(Opt::Period, message)
                    .hint("The lattice repeats, so it repeats by whole cells."))
            }
        }
    }
}

/// Up to here products of whole numbers that are met in wrapping a coordinate are exact.
const LONGEST_PERIOD: f32 = (1 << 22) as f32;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_order() {
        for (i, info) in OPTIONS.iter().enumerate() {
            assert_eq!(info.option as usize, i, "{}", info.name);
        }
    }

    #[test]
    fn what_is_given_is_found() {
        let params = Params::seeded(3).with(Opt::Jitter, &[0.5]).with(Opt::Period, &[4.0, 0.0]);
        assert_eq!(params.vector(Opt::Period), Some(&[4.0, 0.0][..]));
        assert_eq!(params.number(Opt::Jitter, 1.0, 0.0..=1.0), Ok(0.5));
        assert_eq!(params.number(Opt::Density, 3.0, 0.0..=9.0), Ok(3.0));
        assert_eq!(params.period::<2>(), Ok(Some([4.0, 0.0])));
        assert!(params.period::<3>().is_err());
        assert!(Params::default().with(Opt::Period, &[2.5]).period::<1>().is_err());
        assert_eq!(Params::default().with(Opt::Period, &[0.0]).period::<3>(), Ok(None));
        assert!(params.clone().same_as(&params) && !params.same_as(&Params::seeded(3)));
    }
}
