//! The arguments that every function of noise takes: which kind, its seed and its options.

use super::Param;
use super::call::{Call, Fault};
use crate::noise::{Field, Info, KINDS, Kind, OPTIONS, Opt, Params, Unfit, related_seed};
use crate::shape::Shape;
use crate::value::{Planes, Value};
use smallvec::SmallVec;
use std::sync::Arc;

/// The names of the kinds, as `kind` takes them.
const NAMES: [&str; KINDS.len()] = {
    let mut names = [""; KINDS.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = KINDS[i].name;
        i += 1;
    }
    names
};

/// How many parameters a function has, of which so many are its own.
pub const fn params_of(own: usize) -> usize {
    own + 2 + OPTIONS.len()
}

/// A function's own parameters, followed by `kind`, `seed` and the options of all kinds.
pub const fn with_kind<const OWN: usize, const ALL: usize>(own: [Param; OWN]) -> [Param; ALL] {
    assert!(ALL == params_of(OWN));
    let mut params = [Param::choice("kind", &NAMES); ALL];
    let mut i = 0;
    while i < OWN {
        params[i] = own[i];
        i += 1;
    }
    params[OWN + 1] = Param::or("seed", "0");
    let mut i = 0;
    while i < OPTIONS.len() {
        params[OWN + 2 + i] = Param::option(OPTIONS[i].name, OPTIONS[i].choices);
        i += 1;
    }
    params
}

/// The coordinates of a point, 1 to 4 of them.
pub fn coordinates(p: &Value) -> Result<&Planes, Fault> {
    match p.shape {
        Shape::Scalar | Shape::Vector(1..=4) => Ok(&p.planes),
        _ => Err(Fault::of(0, format!("takes a scalar or a vector of 1 to 4, found {}", p.shape))),
    }
}

/// A seed: every number is another one, 0 and -0 the same, and all that are no number.
pub fn seed(call: &Call<'_>, arg: usize) -> Result<u32, Fault> {
    let seed = call.same_everywhere(arg)? + 0.0;
    // The sign of a NaN differs from machine to machine.
    Ok(if seed.is_nan() { f32::NAN } else { seed }.to_bits())
}

/// The kind, which is the argument `first`, and the parameters that follow it.
pub fn kind_and_params(call: &Call<'_>, first: usize) -> Result<(&'static Kind, Params), Fault> {
    let kind = KINDS[place(call, first)];
    let params = Params::seeded(seed(call, first + 1)?);
    Ok((kind, with_options(call, params, first + 2, OPTIONS.iter())?))
}

/// The parameters with what the arguments from `first` on say of these options, one argument each.
pub fn with_options<'a>(
    call: &Call<'_>,
    mut params: Params,
    first: usize,
    options: impl Iterator<Item = &'a Info>,
) -> Result<Params, Fault> {
    for (i, info) in options.enumerate() {
        let arg = first + i;
        let value = &call.args[arg];
        match value.shape {
            _ if !info.choices.is_empty() => {
                // The first word is the default, given or not.
                if place(call, arg) > 0 {
                    params = params.with(info.option, &[place(call, arg) as f32]);
                }
            }
            Shape::Vector(0) => {}
            Shape::Scalar | Shape::Vector(_) => {
                let numbers: Result<SmallVec<[f32; 8]>, Fault> =
                    value.planes.iter().map(|plane| call.settle(plane)).collect();
                params = params.with(info.option, &numbers?);
            }
            _ => {
                let message =
                    format!("{} is a number or a vector of numbers, found {}", info.name, value.shape);
                return Err(Fault::of(arg, message));
            }
        }
    }
    Ok(params)
}

/// The place of a word among its choices.
fn place(call: &Call<'_>, arg: usize) -> usize {
    call.args[arg].as_uniform().unwrap_or(0.0) as usize
}

/// A field of the kind that the arguments from `first` on ask for.
pub fn field(call: &Call<'_>, first: usize, dimensions: usize) -> Result<Arc<dyn Field>, Fault> {
    let (kind, params) = kind_and_params(call, first)?;
    make(kind, dimensions, &params, first)
}

/// `N` unrelated fields of that kind; the first is that of [`field`].
pub fn fields<const N: usize>(
    call: &Call<'_>,
    first: usize,
    dimensions: usize,
) -> Result<[Arc<dyn Field>; N], Fault> {
    let (kind, params) = kind_and_params(call, first)?;
    let related = |i| params.clone().reseeded(related_seed(params.seed, i));
    let made: Result<Vec<_>, Fault> =
        (0..N as u32).map(|i| make(kind, dimensions, &related(i), first)).collect();
    Ok(made?.try_into().unwrap_or_else(|_| unreachable!("as many as were asked for")))
}

/// A field, with its faults told of the arguments from `first` on.
pub fn make(
    kind: &'static Kind,
    dimensions: usize,
    params: &Params,
    first: usize,
) -> Result<Arc<dyn Field>, Fault> {
    kind.field(dimensions, params).map_err(|unfit| fault(unfit, |option| first + 2 + option as usize))
}

/// What is unfit as a fault, of the argument that gives the option.
pub fn fault(unfit: Unfit, arg: impl Fn(Opt) -> usize) -> Fault {
    let fault = Fault::of(unfit.option.map_or(0, arg), unfit.message);
    if let Some(hint) = unfit.hint { fault.hint(hint) } else { fault }
}
