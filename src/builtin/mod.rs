//! The built-in functions: one table, one entry a function, with its signature, documentation and kernel.
//!
//! To add a function, add an entry to the file of its group. The resolver reads the signature, the
//! evaluator calls the kernel, `pse doc` and `docs/builtins.md` print the documentation, and the tests run
//! its examples; nothing else has to know.

mod apply;
mod arithmetic;
mod call;
mod color;
mod derivatives;
mod lists;
mod lookups;
mod matrices;
mod noise;
mod noise_kind;
mod noise_sums;
pub mod reference;
mod shaping;
mod splines;
mod steps;
mod table;
#[cfg(test)]
mod tests;
mod trigonometry;
mod vectors;

pub use arithmetic::{max, min};
pub use call::{Call, Fault, map2};
pub use lookups::Asked;
pub use noise::noise_fields;
pub use noise_sums::Octaves;
pub use splines::Curve;
pub use vectors::inverse;

use crate::lanes::{Arg, Isa};
use crate::value::Value;
use std::collections::HashMap;
use std::sync::LazyLock;

/// A built-in function.
pub struct Builtin {
    /// Its name in programs.
    pub name: &'static str,
    /// What it takes, in order.
    pub params: &'static [Param],
    /// What it does, in one line.
    pub brief: &'static str,
    /// More of it, in Markdown: ranges, units, edge cases, source. May be empty.
    pub doc: &'static str,
    /// At least one; each is run by the tests.
    pub examples: &'static [Example],
    /// How it is computed.
    pub kernel: Kernel,
}

/// A parameter of a built-in function.
#[derive(Clone, Copy, Debug)]
pub struct Param {
    /// Its name, for calls by name and for the documentation.
    pub name: &'static str,
    /// Its default as an expression of the language, such as `1` or `pixelsize`; `None` if it must be given.
    pub default: Option<&'static str>,
    /// What may be given.
    pub kind: ParamKind,
    /// Does it belong to some choice of another parameter, so that signatures show no more than `…`?
    pub minor: bool,
}

/// What a parameter takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParamKind {
    /// A value.
    Value,
    /// At least so many values; the last parameter only.
    Rest(usize),
    /// A string, one of these. The kernel gets its index as a uniform scalar.
    Choice(&'static [&'static str]),
    /// A string that names something: a file, a channel. The kernel gets a number that the resolver gives it.
    Text,
}

/// An expression, and an expression with the same value.
#[derive(Clone, Copy, Debug)]
pub struct Example {
    /// For instance `max(1, [0 2])`.
    pub code: &'static str,
    /// For instance `[1 2]`.
    pub gives: &'static str,
}

/// An example, short to write.
const fn ex(code: &'static str, gives: &'static str) -> Example {
    Example { code, gives }
}

/// A kernel of two numbers a lane, either of which may be one for all lanes.
pub type Lanes2 = fn(Isa, Arg<'_>, Arg<'_>, &mut [f32]);

/// A kernel of several numbers a lane, any of which may be one for all lanes.
pub type LanesN = fn(Isa, &[Arg<'_>], &mut [f32]);

/// How a function is computed.
#[derive(Clone, Copy)]
pub enum Kernel {
    /// Component by component, of one argument.
    Map1(fn(Isa, &[f32], &mut [f32])),
    /// Component by component, of two.
    Map2(Lanes2),
    /// Component by component, of three or four.
    Maps(LanesN),
    /// Of any number: component by component from the left, as `max` of many is the `max` of two.
    Fold(Lanes2),
    /// Whatever looks at whole values.
    Whole(fn(&Call<'_>) -> Result<Value, Fault>),
    /// The like, and also at the pixels' shadows: a program that calls it runs with them.
    Shadowed(fn(&Call<'_>) -> Result<Value, Fault>),
}

/// A group of functions: a heading and its table, in the order of the documentation.
pub struct Group {
    /// The heading.
    pub title: &'static str,
    /// Its functions.
    pub functions: &'static [Builtin],
}

/// Every built-in function by group.
pub static GROUPS: &[Group] = &[
    Group { title: "Arithmetic", functions: arithmetic::FUNCTIONS },
    Group { title: "Trigonometry", functions: trigonometry::FUNCTIONS },
    Group { title: "Vectors in space", functions: vectors::FUNCTIONS },
    Group { title: "Vectors as lists", functions: lists::FUNCTIONS },
    Group { title: "Matrices", functions: matrices::FUNCTIONS },
    Group { title: "Steps", functions: steps::FUNCTIONS },
    Group { title: "Shaping", functions: shaping::FUNCTIONS },
    Group { title: "Derivatives", functions: derivatives::FUNCTIONS },
    Group { title: "Splines", functions: splines::FUNCTIONS },
    Group { title: "Look-ups", functions: lookups::FUNCTIONS },
    Group { title: "Colour", functions: color::FUNCTIONS },
    Group { title: "Noise", functions: noise::FUNCTIONS },
    Group { title: "Sums of noise", functions: noise_sums::FUNCTIONS },
];

static BY_NAME: LazyLock<HashMap<&'static str, &'static Builtin>> =
    LazyLock::new(|| all().map(|b| (b.name, b)).collect());

/// Every built-in function.
pub fn all() -> impl Iterator<Item = &'static Builtin> {
    GROUPS.iter().flat_map(|g| g.functions)
}

/// The function of that name.
pub fn find(name: &str) -> Option<&'static Builtin> {
    BY_NAME.get(name).copied()
}

impl Param {
    /// A parameter that must be given.
    pub const fn new(name: &'static str) -> Param {
        Param { name, default: None, kind: ParamKind::Value, minor: false }
    }

    /// A parameter with a default, an expression of the language.
    pub const fn or(name: &'static str, default: &'static str) -> Param {
        Param { name, default: Some(default), kind: ParamKind::Value, minor: false }
    }

    /// Any number of values, but at least so many.
    pub const fn rest(name: &'static str, least: usize) -> Param {
        Param { name, default: None, kind: ParamKind::Rest(least), minor: false }
    }

    /// A string out of a list; the first is the default.
    pub const fn choice(name: &'static str, of: &'static [&'static str]) -> Param {
        Param { name, default: None, kind: ParamKind::Choice(of), minor: false }
    }

    /// A string that names something and must be given.
    pub const fn text(name: &'static str) -> Param {
        Param { name, default: None, kind: ParamKind::Text, minor: false }
    }

    /// A string that names something, or `""` for the usual thing.
    pub const fn text_or(name: &'static str) -> Param {
        Param { name, default: Some("\"\""), kind: ParamKind::Text, minor: false }
    }
}

impl Param {
    /// A parameter that only some choices of another have: a number or a vector, not given if `[]`, or one of
    /// some strings.
    pub const fn option(name: &'static str, of: &'static [&'static str]) -> Param {
        let param = if of.is_empty() { Param::or(name, "[]") } else { Param::choice(name, of) };
        Param { minor: true, ..param }
    }
}

impl std::fmt::Debug for Builtin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.signature())
    }
}

impl Builtin {
    /// How much there is to compute, for a lane: 1 is about an operator on scalars.
    pub fn work(&self) -> u32 {
        match self.kernel {
            // The kinds of noise are what the minor parameters are for, and images what strings name.
            Kernel::Whole(_) if self.params.iter().any(|p| p.minor || p.kind == ParamKind::Text) => 32,
            Kernel::Whole(_) | Kernel::Shadowed(_) => 6,
            _ => 3,
        }
    }

    /// As a call is written: `clamp(x, low = 0, high = 1)`.
    pub fn signature(&self) -> String {
        let minor = self.params.iter().any(|p| p.minor).then(|| "…".to_string());
        let params: Vec<String> = self
            .params
            .iter()
            .filter(|p| !p.minor)
            .map(|p| match (p.kind, p.default) {
                (ParamKind::Rest(_), _) => format!("{}, …", p.name),
                (ParamKind::Choice(of), _) => format!("{} = \"{}\"", p.name, of[0]),
                (ParamKind::Value | ParamKind::Text, Some(default)) => format!("{} = {default}", p.name),
                (ParamKind::Value | ParamKind::Text, None) => p.name.to_string(),
            })
            .chain(minor)
            .collect();
        format!("{}({})", self.name, params.join(", "))
    }
}
