//! What a kind of noise is, what its author and its tests promise of it, and how one is made.

use super::field::Field;
use super::kinds::KINDS;
use super::options::{Opt, Params};
use std::ops::RangeInclusive;
use std::sync::{Arc, Mutex, PoisonError};

/// A noise algorithm: an entry of [`KINDS`].
pub struct Kind {
    /// Its name, as the functions take it.
    pub name: &'static str,
    /// What it is, in a line.
    pub brief: &'static str,
    /// How many coordinates a point may have.
    pub dimensions: RangeInclusive<usize>,
    /// What it can be given beside a seed.
    pub options: &'static [Opt],
    /// What it promises.
    pub contract: Contract,
    /// Makes a field for points of so many coordinates (one of `dimensions`), with options out of `options`.
    pub make: fn(usize, &Params) -> Made,
}

/// A field, or why there is none.
pub type Made = Result<Arc<dyn Field>, Unfit>;

/// What holds for a kind with its default options. The tests measure it.
#[derive(Clone, Copy, Debug)]
pub struct Contract {
    /// Bounds of the values, one pair for each number of dimensions, in order.
    pub bounds: &'static [[f32; 2]],
    /// The mean, in three dimensions (or as many as it has, if fewer).
    pub mean: f32,
    /// The standard deviation, likewise.
    pub deviation: f32,
    /// The value where all coordinates are whole numbers.
    pub lattice: &'static str,
    /// How smooth it is.
    pub smoothness: Smoothness,
    /// The time for a point, relative to `gradient`: three dimensions, scattered points, as measured.
    pub cost: f32,
    /// Where it is from: paper and section.
    pub source: &'static str,
    /// What else one should know, in Markdown; may be empty.
    pub remarks: &'static str,
}

/// How many derivatives are continuous.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Smoothness {
    /// Not even the value.
    Discontinuous,
    /// The value; the slope jumps.
    C0,
    /// The first derivatives too.
    C1,
    /// The second derivatives too.
    C2,
    /// The third derivatives too.
    C3,
    /// All of them.
    Analytic,
}

impl std::fmt::Display for Smoothness {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Smoothness::Discontinuous => "discontinuous",
            Smoothness::C0 => "C⁰",
            Smoothness::C1 => "C¹",
            Smoothness::C2 => "C²",
            Smoothness::C3 => "C³",
            Smoothness::Analytic => "C^∞",
        })
    }
}

/// Why a kind can't be made so.
#[derive(Clone, Debug, PartialEq)]
pub struct Unfit {
    /// The option that is wrong; `None` if it is the number of coordinates.
    pub option: Option<Opt>,
    /// One sentence without a full stop.
    pub message: String,
    /// How to mend it.
    pub hint: Option<String>,
}

impl Unfit {
    /// An option is wrong.
    pub fn of(option: Opt, message: impl Into<String>) -> Unfit {
        Unfit { option: Some(option), message: message.into(), hint: None }
    }

    /// The same with a way to mend it.
    pub fn hint(mut self, text: impl Into<String>) -> Unfit {
        self.hint = Some(text.into());
        self
    }
}

impl Kind {
    /// The kind of this name.
    pub fn from_name(name: &str) -> Option<&'static Kind> {
        KINDS.iter().copied().find(|kind| kind.name == name)
    }

    /// The number of dimensions for which mean and deviation are given: three, or the most that it has.
    pub fn usual_dimensions(&self) -> usize {
        3.clamp(*self.dimensions.start(), *self.dimensions.end())
    }

    /// The bounds of its values for so many coordinates.
    ///
    /// # Panics
    /// If it has not so many dimensions.
    pub fn bounds(&self, dimensions: usize) -> [f32; 2] {
        self.contract.bounds[dimensions - self.dimensions.start()]
    }

    /// A field of this kind for points of so many coordinates. What takes long to make, such as a table, is
    /// made once and kept for later calls with the same parameters, whatever the thread.
    ///
    /// # Errors
    /// If the kind has no such dimension or option, or if an option has a value that it can't have.
    pub fn field(&'static self, dimensions: usize, params: &Params) -> Made {
        if !self.dimensions.contains(&dimensions) {
            return Err(self.no_dimension(dimensions));
        }
        if let Some(option) = params.given().find(|option| !self.options.contains(option)) {
            return Err(self.no_option(option));
        }
        let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
        let same =
            |k: &Kept| std::ptr::eq(k.kind, self) && k.dimensions == dimensions && k.params.same_as(params);
        if let Some(i) = kept.iter().position(same) {
            // The one used last stands first.
            kept[..=i].rotate_right(1);
            return Ok(Arc::clone(&kept[0].field));
        }
        let field = (self.make)(dimensions, params)?;
        kept.truncate(MOST_KEPT - 1);
        kept.insert(0, Kept { kind: self, dimensions, params: params.clone(), field: Arc::clone(&field) });
        Ok(field)
    }

    fn no_dimension(&self, found: usize) -> Unfit {
        let (least, most) = (*self.dimensions.start(), *self.dimensions.end());
        let has = if least == most { most.to_string() } else { format!("{least} to {most}") };
        let fitting: Vec<&str> =
            KINDS.iter().filter(|k| k.dimensions.contains(&found)).map(|k| k.name).collect();
        let unfit = Unfit {
            option: None,
            message: format!("`{}` is a noise of {has} coordinates, found {found}", self.name),
            hint: None,
        };
        if fitting.is_empty() {
            unfit
        } else {
            unfit.hint(format!("With {found} there are {}.", fitting.join(", ")))
        }
    }

    fn no_option(&self, option: Opt) -> Unfit {
        let takers: Vec<&str> =
            KINDS.iter().filter(|k| k.options.contains(&option)).map(|k| k.name).collect();
        let own: Vec<&str> = self.options.iter().map(|o| o.name()).collect();
        let own = if own.is_empty() { "nothing but a seed".to_string() } else { own.join(", ") };
        Unfit::of(option, format!("`{}` noise takes no {}", self.name, option.name())).hint(format!(
            "It takes {own}; {} is for {}.",
            option.name(),
            takers.join(", ")
        ))
    }
}

impl std::fmt::Debug for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

/// So many fields are kept, the ones used last.
const MOST_KEPT: usize = 64;

/// Fields that have been made. One list for all threads: a lookup is once a batch, and a table that two threads
/// ask for at the same time is made once.
static KEPT: Mutex<Vec<Kept>> = Mutex::new(Vec::new());

struct Kept {
    kind: &'static Kind,
    dimensions: usize,
    params: Params,
    field: Arc<dyn Field>,
}
