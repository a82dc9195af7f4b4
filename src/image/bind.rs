//! Which channels are which variable, decided once from the names; and what to say when none is.
//!
//! A group whose name is known becomes a canonical variable (`point`, `normal`, …); every group can
//! also be read by its own last name. If several groups could be the same canonical variable, the
//! spelling that comes first in the table of `names` wins; with the same spelling, one
//! without a prefix wins over one with, and any over Blender's `Composite`; otherwise the variable is
//! ambiguous, which is an error only for a program that reads it.

use super::error::{ErrorKind, ImageError};
use super::names::{self, Group};
use crate::shape::Shape;
use std::str::FromStr;

/// `name=channels`, given by the user: the variable `name` is these channels, whatever the names say.
///
/// The right side is a group of channels (`ViewLayer.Position`), a single channel
/// (`ViewLayer.IndexOB.X`), or several channels with commas (`A.R,A.G`). The end of a name is enough
/// where only one name ends so, and case counts only where it has to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mapping {
    /// The variable.
    pub name: String,
    /// The channels, as written.
    pub channels: String,
}

impl FromStr for Mapping {
    type Err = ImageError;

    fn from_str(text: &str) -> Result<Mapping, ImageError> {
        let wrong = |why: &str| {
            Err(ImageError::new(ErrorKind::Mapping, format!("`{text}` is no mapping: {why}"))
                .hint("Write it as --map point=ViewLayer.Position."))
        };
        let Some((name, channels)) = text.split_once('=') else { return wrong("it has no `=`") };
        let (name, channels) = (name.trim(), channels.trim());
        if channels.is_empty() {
            return wrong("no channels stand after the `=`");
        }
        if name.is_empty() || names::identifier(name) != name {
            return wrong("what stands before the `=` is no variable name");
        }
        Ok(Mapping { name: name.into(), channels: channels.into() })
    }
}

/// The channels that a variable is read from.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// The group's name as `--map` takes it.
    pub group: String,
    /// The channels' places in [`File::channels`](super::File::channels), one a cell of the shape.
    pub channels: Vec<usize>,
    /// How they nest.
    pub shape: Shape,
}

/// A variable that a file offers.
#[derive(Clone, Debug, PartialEq)]
pub struct Binding {
    /// Its name in programs.
    pub name: String,
    /// Is it a second name of channels that already are another variable?
    pub alias: bool,
    /// Where it comes from: one, or several if it is ambiguous; never none.
    pub candidates: Vec<Candidate>,
}

/// Less is better: the spelling's place in the table, then how deep the name is.
type Rank = (usize, usize);

/// The rank of a group's own name, below every known spelling.
const OWN: usize = 1000;

/// The variables of a file with channels of these full names, after the user's mappings.
pub(crate) fn bind(file: &str, channels: &[String], maps: &[Mapping]) -> Result<Vec<Binding>, ImageError> {
    let groups = names::groups(channels);
    let mut offers: Vec<(String, Rank, Candidate, usize)> = Vec::new();
    for (index, group) in groups.iter().enumerate() {
        let depth = match group.path.split('.').next() {
            Some(first) if first.eq_ignore_ascii_case("composite") => 2,
            _ => usize::from(group.path.contains('.')),
        };
        let shown = shown(group, channels);
        for (name, rank, used) in names::canonical(group) {
            let shape = if used.len() == 1 { Shape::Scalar } else { Shape::Vector(used.len() as u32) };
            let from = used.iter().map(|&i| group.channels[i]).collect();
            let candidate = Candidate { group: shown.clone(), channels: from, shape };
            offers.push((name.to_string(), (rank, depth), candidate, index));
        }
        let whole = Candidate { group: shown, channels: group.channels.clone(), shape: group.shape.clone() };
        offers.push((group.own.clone(), (OWN, depth), whole, index));
        if group.path.is_empty() {
            // The beauty's channels, which have no group name, can be read one by one.
            for &channel in &group.channels {
                let name = channels[channel].clone();
                let one = Candidate { group: name.clone(), channels: vec![channel], shape: Shape::Scalar };
                offers.push((names::identifier(&name), (OWN, depth), one, index));
            }
        }
    }
    // Keep the best offers for each name.
    let mut bindings: Vec<(Binding, Rank, usize)> = Vec::new();
    for (name, rank, candidate, index) in offers {
        match bindings.iter_mut().find(|(b, _, _)| b.name == name) {
            None => bindings.push((Binding { name, alias: false, candidates: vec![candidate] }, rank, index)),
            Some((binding, best, at)) if rank < *best => {
                binding.candidates = vec![candidate];
                (*best, *at) = (rank, index);
            }
            Some((binding, best, at)) if rank == *best && *at != index => binding.candidates.push(candidate),
            Some(_) => {}
        }
    }
    let canonical: Vec<usize> = bindings.iter().filter(|(_, r, _)| r.0 < OWN).map(|(_, _, i)| *i).collect();
    let mut bindings: Vec<Binding> = bindings
        .into_iter()
        .map(|(mut binding, rank, index)| {
            binding.alias = rank.0 == OWN && canonical.contains(&index);
            binding
        })
        .collect();
    for map in maps {
        apply(map, file, channels, &groups, &mut bindings)?;
    }
    Ok(bindings)
}

/// A group's name as `--map` takes it: at the root, where it has none, its channels.
fn shown(group: &Group, channels: &[String]) -> String {
    let names: Vec<&str> = group.channels.iter().map(|&c| channels[c].as_str()).collect();
    match group.path.is_empty() {
        true => names.join(","),
        false => group.path.clone(),
    }
}

fn apply(
    map: &Mapping,
    file: &str,
    channels: &[String],
    groups: &[Group],
    bindings: &mut Vec<Binding>,
) -> Result<(), ImageError> {
    let mut put = |name: &str, candidate: Candidate| {
        let binding = Binding { name: name.to_string(), alias: false, candidates: vec![candidate] };
        match bindings.iter_mut().find(|b| b.name == name) {
            Some(old) => *old = binding,
            None => bindings.push(binding),
        }
    };
    if map.channels.contains(',') {
        let picked = map.channels.split(',').map(|part| {
            match pick(part.trim(), channels.iter().map(String::as_str)).as_slice() {
                [one] => Ok(*one),
                found => Err(unmapped(map, part.trim(), found, file, channels, groups)),
            }
        });
        let from = picked.collect::<Result<Vec<usize>, _>>()?;
        let shape = Shape::Vector(from.len() as u32);
        put(&map.name, Candidate { group: map.channels.clone(), channels: from, shape });
        return Ok(());
    }
    match pick(&map.channels, groups.iter().map(|g| g.path.as_str())).as_slice() {
        [] => {}
        [one] => {
            let group = &groups[*one];
            // A known variable takes as many components as it has: a point three, an id one.
            let wanted = match map.name.as_str() {
                "point" | "normal" | "color" | "albedo" => 3,
                "uv" => 2,
                "surface" | "depth" | "alpha" => 1,
                _ => group.channels.len(),
            };
            let whole = wanted >= group.channels.len();
            let shape = match wanted {
                _ if whole => group.shape.clone(),
                1 => Shape::Scalar,
                n => Shape::Vector(n as u32),
            };
            let from = group.channels.iter().copied().take(wanted).collect();
            let shown = shown(group, channels);
            if map.name == "color"
                && let Some(a) = group.letters.find('a')
            {
                let from = vec![group.channels[a]];
                put("alpha", Candidate { group: shown.clone(), channels: from, shape: Shape::Scalar });
            }
            put(&map.name, Candidate { group: shown, channels: from, shape });
            return Ok(());
        }
        several => {
            let found: Vec<String> = several.iter().map(|&g| groups[g].path.clone()).collect();
            return Err(several_match(map, &map.channels, &found, file));
        }
    }
    match pick(&map.channels, channels.iter().map(String::as_str)).as_slice() {
        [one] => {
            let group = channels[*one].clone();
            put(&map.name, Candidate { group, channels: vec![*one], shape: Shape::Scalar });
            Ok(())
        }
        found => Err(unmapped(map, &map.channels, found, file, channels, groups)),
    }
}

/// The names that `wanted` means: the name itself, else in another case, else as the end of a name.
fn pick<'a>(wanted: &str, names: impl Iterator<Item = &'a str> + Clone) -> Vec<usize> {
    let lower = wanted.to_lowercase();
    let tail = format!(".{lower}");
    let tests: [&dyn Fn(&str) -> bool; 4] =
        [&|n| n == wanted, &|n| n.to_lowercase() == lower, &|n| n.ends_with(&format!(".{wanted}")), &|n| {
            n.to_lowercase().ends_with(&tail)
        }];
    for test in tests {
        let found: Vec<usize> = names.clone().enumerate().filter(|(_, n)| test(n)).map(|(i, _)| i).collect();
        if !found.is_empty() {
            return found;
        }
    }
    Vec::new()
}

fn several_match(map: &Mapping, wanted: &str, found: &[String], file: &str) -> ImageError {
    let message =
        format!("`{wanted}` in --map {}={} fits several channels of `{file}`", map.name, map.channels);
    let mut error = ImageError::new(ErrorKind::Mapping, message);
    for name in found {
        error = error.hint(format!("This one: --map {}", argument(&map.name, name)));
    }
    error
}

fn unmapped(
    map: &Mapping,
    wanted: &str,
    found: &[usize],
    file: &str,
    channels: &[String],
    groups: &[Group],
) -> ImageError {
    if !found.is_empty() {
        let found: Vec<String> = found.iter().map(|&c| channels[c].clone()).collect();
        return several_match(map, wanted, &found, file);
    }
    let message = format!("--map {}={}: `{file}` has no channels `{wanted}`", map.name, map.channels);
    let mut error = ImageError::new(ErrorKind::Mapping, message);
    let shown: Vec<String> = groups.iter().map(|g| shown(g, channels)).collect();
    if let Some(near) = nearest(wanted, shown.iter().map(String::as_str)) {
        error = error.hint(format!("Did you mean --map {}?", argument(&map.name, near)));
    }
    error.hint(format!("It has {}.", list(shown.iter().map(String::as_str))))
}

/// `name=group`, quoted where the shell would want it.
fn argument(name: &str, group: &str) -> String {
    match group.chars().all(|c| c.is_ascii_alphanumeric() || "._-,:".contains(c)) {
        true => format!("{name}={group}"),
        false => format!("'{name}={group}'"),
    }
}

/// Names in a row, in quotes; a very long row is cut.
fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.collect();
    let mut text: Vec<String> = names.iter().take(40).map(|n| format!("`{n}`")).collect();
    if names.len() > 40 {
        text.push(format!("{} more", names.len() - 40));
    }
    text.join(", ")
}

/// The name most like `wanted`, if one is like it at all.
fn nearest<'a>(wanted: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let lower = wanted.to_lowercase();
    names
        .map(|name| {
            let whole = strsim::jaro_winkler(&lower, &name.to_lowercase());
            let last = strsim::jaro_winkler(&lower, &names::last_field(name).to_lowercase());
            (whole.max(last), name)
        })
        .filter(|(likeness, _)| *likeness > 0.84)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}

/// The variable `name`, if the file has it and it is one.
pub(crate) fn find<'a>(file: &str, bindings: &'a [Binding], name: &str) -> Result<&'a Candidate, ImageError> {
    let Some(binding) = bindings.iter().find(|b| b.name == name) else {
        return Err(missing(file, bindings, name));
    };
    match binding.candidates.as_slice() {
        [one] => Ok(one),
        several => {
            let message = format!("`{file}` has {} groups of channels that could be `{name}`", several.len());
            let mut error = ImageError::new(ErrorKind::Ambiguous, message);
            for candidate in several {
                error = error.hint(format!("This one: --map {}", argument(name, &candidate.group)));
            }
            Err(error)
        }
    }
}

/// What to say of a variable that a file does not have: what it has, and the `--map` that may help.
pub(crate) fn missing(file: &str, bindings: &[Binding], name: &str) -> ImageError {
    let mut error = ImageError::new(ErrorKind::Missing, format!("`{file}` has no variable `{name}`"));
    let near = nearest(name, bindings.iter().map(|b| b.name.as_str()));
    if let Some(near) = near {
        error = error.hint(format!("Did you mean `{near}`?"));
    }
    let own: Vec<&Binding> = bindings.iter().filter(|b| !b.alias).collect();
    if own.is_empty() {
        return error.hint("It has no variables at all.");
    }
    let known = |name: &str| names::KNOWN.iter().any(|(k, _)| *k == name);
    if known(name) {
        let fits = |shape: &Shape| match name {
            "surface" | "depth" | "alpha" => shape.is_scalar(),
            "uv" => matches!(shape, Shape::Vector(2..=3)),
            "motion" => matches!(shape, Shape::Vector(2..=4)),
            _ => matches!(shape, Shape::Vector(3..=4)),
        };
        // Only what has no known meaning yet can have this one.
        let free = own.iter().filter(|b| !known(&b.name) && b.name != "uv_coverage");
        let candidates: Vec<&&Binding> = free.filter(|b| fits(&b.candidates[0].shape)).collect();
        for candidate in candidates.iter().take(3) {
            error = error.hint(format!(
                "If `{}` is it: --map {}",
                candidate.name,
                argument(name, &candidate.candidates[0].group)
            ));
        }
        if candidates.is_empty() && near.is_none() {
            error =
                error.hint(format!("None of its channels can be `{name}`: render the image with that pass."));
        }
    }
    error.hint(format!("It has {}.", list(own.iter().map(|b| b.name.as_str()))))
}
