//! A noise of a sheet, from the words that name it: a kind or a sum of octaves of one, with its options.

use crate::cli::failure::Failure;
use pse::internal::lanes::Isa;
use pse::internal::resolve::names::nearest;
use pse::noise::sums::{Form, Sum};
use pse::noise::{Field, KINDS, Kind, OPTIONS, Opt, Params, Unfit};
use std::sync::Arc;

/// The sums of octaves: name, form, offset.
const SUMS: [(&str, Form, f32); 5] = [
    ("turbulence", Form::Turbulence, 0.0),
    ("fractalsum", Form::Fractal, 0.0),
    ("fBm", Form::Fractal, 0.0),
    ("ridged", Form::Ridged, 1.0),
    ("hybrid", Form::Hybrid, 0.7),
];

/// What is the same for all rows.
pub struct Common<'a> {
    pub set: &'a [String],
    pub seed: f32,
    pub dimensions: Option<usize>,
}

/// A noise to be shown.
pub struct Row {
    /// What it is called: `gradient`, `turbulence:gradient`.
    pub name: String,
    /// Options, as they were given.
    pub options: Vec<String>,
    /// How many coordinates its points have.
    pub dimensions: usize,
    /// Is it a sum of octaves?
    pub is_sum: bool,
    form: Option<(Form, f32)>,
    /// One, or one for each octave.
    fields: Vec<Arc<dyn Field>>,
}

/// Every kind and every sum, of those that there are for so many coordinates. (Without fBm, which is fractalsum here:
/// they differ in what they take.)
pub fn all(common: &Common<'_>) -> Result<Vec<Row>, Failure> {
    let fits = |kind: &&&Kind| common.dimensions.is_none_or(|d| kind.dimensions.contains(&d));
    let kinds = KINDS.iter().filter(fits).map(|kind| kind.name);
    let sums = SUMS.iter().map(|(name, ..)| *name).filter(|name| *name != "fBm");
    kinds.chain(sums).map(|name| Row::new(name, common)).collect()
}

/// The kind of a name.
pub fn kind(name: &str) -> Result<&'static Kind, Failure> {
    Kind::from_name(name).ok_or_else(|| {
        let failure = Failure::usage(format!("there is no kind of noise called `{name}`"));
        if SUMS.iter().any(|(sum, ..)| *sum == name) {
            return failure
                .hint(format!("It is a sum of octaves, which can be of any kind; see `pse doc {name}`."));
        }
        match nearest(name, names()) {
            Some(near) => failure.hint(format!("Did you mean {near}?")),
            None => failure.hint(format!("There are {}.", names().collect::<Vec<_>>().join(", "))),
        }
    })
}

/// All that a row can show.
fn names() -> impl Iterator<Item = &'static str> {
    KINDS.iter().map(|kind| kind.name).chain(SUMS.iter().map(|(name, ..)| *name))
}

impl Row {
    /// From `KIND`, `SUM` or `SUM:KIND`, followed by options with commas between.
    pub fn new(text: &str, common: &Common<'_>) -> Result<Row, Failure> {
        let mut parts = text.split(',');
        let name = parts.next().unwrap_or_default().trim();
        let (sum, kind_name) = match name.split_once(':') {
            Some((sum, kind)) => (Some(sum), Some(kind)),
            None if SUMS.iter().any(|(sum, ..)| *sum == name) => (Some(name), None),
            None => (None, Some(name)),
        };
        let form = sum.map(form).transpose()?;
        let kind = kind_name.map_or(Ok(KINDS[0]), kind)?;
        // What has no = goes on with the vector before it.
        let mut options: Vec<String> = Vec::new();
        for part in parts {
            match options.last_mut() {
                Some(last) if !part.contains('=') => {
                    last.push(',');
                    last.push_str(part);
                }
                _ => options.push(part.to_string()),
            }
        }
        let mut params = Params::seeded((common.seed + 0.0).to_bits());
        for option in common.set.iter().chain(&options) {
            params = set(params, option)?;
        }
        let dimensions = common.dimensions.unwrap_or(kind.usual_dimensions());
        let fields = fields(kind, dimensions, &params, form.is_some()).map_err(unfit)?;
        let options = common.set.iter().cloned().chain(options).collect();
        Ok(Row { name: name.into(), options, dimensions, is_sum: form.is_some(), form, fields })
    }

    /// The values at points; a sum has the octaves below `high` cycles a unit.
    pub fn sample(&self, high: f32, p: &[&[f32]], out: &mut [f32]) {
        let isa = Isa::detect();
        let Some((form, offset)) = self.form else { return self.fields[0].noise(isa, p, out) };
        let all = |x: f32| vec![x; out.len()];
        let (one, half, two) = (all(1.0), all(0.5), all(2.0));
        Sum {
            form,
            fields: &self.fields,
            low: &one,
            high: &all(high),
            fade: &one,
            size: &one,
            octaves: &all(24.0),
            lacunarity: &two,
            gain: &half,
            offset: &all(offset),
        }
        .run(isa, p, out);
    }
}

/// The noise of each octave; they differ only with a period, which is that of the sum.
fn fields(
    kind: &'static Kind,
    dimensions: usize,
    params: &Params,
    is_sum: bool,
) -> Result<Vec<Arc<dyn Field>>, Unfit> {
    let Some(period) = params.vector(Opt::Period).filter(|_| is_sum) else {
        return Ok(vec![kind.field(dimensions, params)?]);
    };
    let octave = |i: i32| {
        let scaled: Vec<f32> = period.iter().map(|p| p * (1 << i) as f32).collect();
        kind.field(dimensions, &params.clone().with(Opt::Period, &scaled))
    };
    let mut fields = vec![octave(0)?];
    // So many as a sheet shows; with a very long period fewer, of which the last stands for those that follow.
    fields.extend((1..6).map_while(|i| octave(i).ok()));
    Ok(fields)
}

fn form(name: &str) -> Result<(Form, f32), Failure> {
    let found = SUMS.iter().find(|(sum, ..)| *sum == name);
    found.map(|(_, form, offset)| (*form, *offset)).ok_or_else(|| {
        let sums = SUMS.map(|(sum, ..)| sum);
        Failure::usage(format!("there is no sum called `{name}`")).hint(format!(
            "Before the colon write {} or {}.",
            sums[..4].join(", "),
            sums[4]
        ))
    })
}

fn unfit(Unfit { message, hint, .. }: Unfit) -> Failure {
    let failure = Failure::usage(message);
    if let Some(hint) = hint { failure.hint(hint) } else { failure }
}

/// The parameters with `seed=VALUE`, or with `OPTION=VALUE`.
fn set(params: Params, text: &str) -> Result<Params, Failure> {
    let Some((name, value)) = text.split_once('=').map(|(name, value)| (name.trim(), value.trim())) else {
        return Err(Failure::usage(format!("`{text}` is not a setting"))
            .hint("Write it as density=3, kernel=gabor or period=4,4,0."));
    };
    let numbers = || -> Option<Vec<f32>> {
        let inner = value.trim_start_matches('[').trim_end_matches(']');
        let words = inner.split([',', ' ']).filter(|word| !word.is_empty());
        words.map(|word| word.parse().ok()).collect::<Option<Vec<f32>>>().filter(|all| !all.is_empty())
    };
    let no_number = || Failure::usage(format!("{name} is a number or a vector of numbers, found `{value}`"));
    if name == "seed" {
        let [seed] = numbers().ok_or_else(no_number)?[..] else { return Err(no_number()) };
        return Ok(params.reseeded((seed + 0.0).to_bits()));
    }
    let Some(info) = OPTIONS.iter().find(|info| info.name == name) else {
        let failure = Failure::usage(format!("no noise takes an option called `{name}`"));
        let all = || OPTIONS.iter().map(|info| info.name).chain(["seed"]);
        return Err(match nearest(name, all()) {
            Some(near) => failure.hint(format!("Did you mean {near}?")),
            None => failure.hint(format!("There are {}.", all().collect::<Vec<_>>().join(", "))),
        });
    };
    if info.choices.is_empty() {
        return Ok(params.with(info.option, &numbers().ok_or_else(no_number)?));
    }
    if info.choices.contains(&value) {
        return Ok(params.with_choice(info.option, value));
    }
    let failure = Failure::usage(format!("{name} cannot be `{value}`"));
    Err(match nearest(value, info.choices.iter().copied()) {
        Some(near) => failure.hint(format!("Did you mean {near}?")),
        None => failure.hint(format!("It is one of {}.", info.choices.join(", "))),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: Common<'static> = Common { set: &[], seed: 0.0, dimensions: None };

    fn at(row: &Row, p: [f32; 3]) -> f32 {
        let mut out = [0.0];
        row.sample(4.0, &[&[p[0]], &[p[1]], &[p[2]]], &mut out);
        out[0]
    }

    fn row(text: &str) -> Row {
        Row::new(text, &PLAIN).unwrap_or_else(|e| panic!("{text}: {e:?}"))
    }

    #[test]
    fn rows_are_what_they_say() {
        let p = [0.3, 0.6, 0.2];
        let gradient = row("gradient");
        assert!(!gradient.is_sum && gradient.dimensions == 3);
        assert_eq!(at(&row("perlin1985,seed=0"), p), at(&row("perlin1985"), p));
        assert_ne!(at(&row("perlin1985,seed=1"), p), at(&row("perlin1985"), p));
        let two = [0.6, 1.2, 0.4];
        let both = at(&gradient, p).abs() + 0.5 * at(&gradient, two).abs();
        assert_eq!(at(&row("turbulence:gradient"), p), both);
        assert_eq!(at(&row("turbulence"), p), at(&row("turbulence:perlin1985"), p));
        let periodic = row("fractalsum:gradient,period=4,4,2");
        assert_eq!(periodic.options, ["period=4,4,2"]);
        assert_eq!(at(&periodic, [0.25, 0.5, 0.125]), at(&periodic, [4.25, -3.5, 2.125]));
        assert_eq!(at(&row("gradient,period=[4 4 2]"), p), at(&row("gradient,period=4,4,2"), p));
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (text, words) in [
            ("gradiant", "no kind of noise called `gradiant`"),
            ("turbo:gradient", "no sum called `turbo`"),
            ("turbulence:turbulence", "no kind of noise called `turbulence`"),
            ("gradient,density=3", "takes no density"),
            ("gradient,perod=3", "no noise takes an option called `perod`"),
            ("gradient,period=x", "period is a number"),
            ("gradient,period", "`period` is not a setting"),
            ("gradient,kernel=gabr", "kernel cannot be `gabr`"),
            ("gradient,period=2.5", "whole number"),
        ] {
            let failure = Row::new(text, &PLAIN).err().unwrap_or_else(|| panic!("{text} is taken"));
            let Failure::Usage(diagnostic) = failure else { panic!("{text}: {failure:?}") };
            assert!(diagnostic.message.contains(words), "{text}: {}", diagnostic.message);
        }
        let four = Common { dimensions: Some(4), ..PLAIN };
        assert_eq!(Row::new("gradient", &four).map(|r| r.dimensions).ok(), Some(4));
    }
}
