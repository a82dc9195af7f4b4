//! `--map`: what a variable is, whatever the names of the channels say.

use super::bind::{Binding, Bound, Candidate, ChannelName, Channels, Viewed};
use super::bind::{argument, is_read, list, names_of, nearest};
use super::error::{ErrorKind, ImageError};
use super::names::{self, Family};
use crate::shape::Shape;
use std::str::FromStr;

/// A user's `name=channels`: the variable `name` is read from these channels.
///
/// The right side is a group of channels (`ViewLayer.Position`), a single channel (`ViewLayer.IndexOB.X`), or several
/// channels separated by commas (`A.R,A.G`). The end of a name is enough if it is unique, and case matters only if
/// needed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mapping {
    /// The variable; of another view than the file's first, behind the view's name: `right.color`.
    pub name: String,
    /// The channels, as written.
    pub channels: String,
}

impl FromStr for Mapping {
    type Err = ImageError;

    fn from_str(text: &str) -> Result<Mapping, ImageError> {
        let wrong = |why: &str| {
            Err(ImageError::new(ErrorKind::Mapping, format!("invalid --map `{text}`: {why}"))
                .hint("Write it as --map point=ViewLayer.Position."))
        };
        let Some((name, channels)) = text.split_once('=') else { return wrong("no `=`") };
        let (name, channels) = (name.trim(), channels.trim());
        if channels.is_empty() {
            return wrong("no channels after the `=`");
        }
        // A variable of another view than the first has its name before its own: `right.color`.
        let fields: Vec<&str> = name.split('.').collect();
        if fields.len() > 2
            || fields.iter().any(|field| field.is_empty() || names::identifier(field) != *field)
        {
            return wrong("the part before the `=` is not a variable name");
        }
        Ok(Mapping { name: name.into(), channels: channels.into() })
    }
}

/// Sets a variable to a candidate, whatever it was.
fn put(bindings: &mut Vec<Binding>, name: &str, candidate: Candidate) {
    let binding = Binding { name: name.to_string(), alias: false, candidates: vec![candidate] };
    match bindings.iter_mut().find(|b| b.name == name) {
        Some(old) => *old = binding,
        None => bindings.push(binding),
    }
}

/// The fewest channels that can be a variable, and how many it takes of a group; `None`: all.
fn size_of(name: &str) -> (usize, Option<usize>) {
    match name.rsplit('.').next().unwrap_or(name) {
        "point" | "normal" => (3, Some(3)),
        "color" | "albedo" => (1, Some(3)),
        "uv" => (2, Some(2)),
        "motion" => (2, None),
        "surface" | "depth" | "alpha" => (1, Some(1)),
        _ => (1, None),
    }
}

/// Makes a variable what the mapping says.
pub(super) fn apply(
    map: &Mapping,
    file: &str,
    named: &Channels<'_>,
    groups: &[Viewed],
    bound: &mut Bound,
) -> Result<(), ImageError> {
    let channels = named.list;
    if let Some((view, _)) = map.name.split_once('.') {
        let is_view =
            |channel: &ChannelName| channel.view.as_deref().is_some_and(|v| names::identifier(v) == view);
        if !channels.iter().any(is_view) {
            let message = format!("--map {}={}: `{file}` has no view `{view}`", map.name, map.channels);
            return Err(ImageError::new(ErrorKind::Mapping, message)
                .hint(format!("To name an image, write -i {view}=FILE.")));
        }
    }
    let (least, most) = size_of(&map.name);
    let checked = |candidate: Candidate| {
        let count = candidate.channels.len();
        if !is_read(&candidate, channels) {
            return Err(unread(map, &candidate, file, channels));
        }
        // One channel is a grey colour.
        if count < least || most == Some(3) && count == 2 {
            return Err(too_few(map, count, most.unwrap_or(least), groups));
        }
        Ok(candidate)
    };
    // A channel by its full name, or by the one that it has beside its view.
    let one = |wanted: &str| {
        let list =
            channels.iter().enumerate().flat_map(|(i, c)| names_of(c).into_iter().map(move |n| (i, n)));
        pick(wanted, &list.collect::<Vec<_>>())
    };
    if map.channels.contains(',') {
        let picked = map.channels.split(',').map(|part| match one(part.trim()).as_slice() {
            [one] => Ok(*one),
            found => Err(unmapped(map, part.trim(), found, file, named, groups)),
        });
        let from = picked.collect::<Result<Vec<usize>, _>>()?;
        let shape = Shape::Vector(from.len() as u32);
        let candidate = Candidate { shape, ..Candidate::plain(map.channels.clone(), from) };
        put(&mut bound.bindings, &map.name, checked(candidate)?);
        return Ok(());
    }
    let by_name = groups.iter().enumerate().flat_map(|(i, g)| g.names.iter().map(move |n| (i, n.clone())));
    match pick(&map.channels, &by_name.collect::<Vec<_>>()).as_slice() {
        [] => {}
        [one] => {
            let Viewed { group, shown, .. } = &groups[*one];
            let converted = group.family == Family::LuminanceChroma;
            let all = if converted { 3 } else { group.channels.len() };
            // A known variable takes as many components as it has: a point three, an id one.
            let wanted = most.unwrap_or(all);
            let whole = wanted >= all || converted;
            let from = group.channels.iter().copied().take(if whole { all } else { wanted }).collect();
            let mut candidate = Candidate::plain(shown.clone(), from);
            if whole {
                candidate.shape = group.shape.clone();
                candidate.luminance_chroma = converted;
            }
            let candidate = grey(map, checked(candidate)?, bound);
            if let (Some(prefix), Some(a)) = (map.name.strip_suffix("color"), group.letters.find('a'))
                && (prefix.is_empty() || prefix.ends_with('.'))
            {
                let alpha = Candidate::plain(shown.clone(), vec![group.channels[a]]);
                put(&mut bound.bindings, &format!("{prefix}alpha"), checked(alpha)?);
            }
            put(&mut bound.bindings, &map.name, candidate);
            return Ok(());
        }
        several => {
            let found: Vec<String> = several.iter().map(|&g| groups[g].shown.clone()).collect();
            return Err(several_match(map, &map.channels, &found, file));
        }
    }
    match one(&map.channels).as_slice() {
        [one] => {
            let candidate = Candidate::plain(named.argument(*one).to_string(), vec![*one]);
            let candidate = grey(map, checked(candidate)?, bound);
            put(&mut bound.bindings, &map.name, candidate);
            Ok(())
        }
        found => Err(unmapped(map, &map.channels, found, file, named, groups)),
    }
}

/// One channel that is to be a colour: it is used three times, as a lone `Y` is, and a note says so.
fn grey(map: &Mapping, candidate: Candidate, bound: &mut Bound) -> Candidate {
    let is_color = size_of(&map.name) == (1, Some(3));
    match candidate.channels[..] {
        [one] if is_color => {
            bound.notes.push(format!(
                "--map {}={}: using one channel for red, green and blue",
                map.name, map.channels
            ));
            Candidate::plain(candidate.group, vec![one; 3])
        }
        _ => candidate,
    }
}

/// The error of a mapping to fewer channels than the variable has.
fn too_few(map: &Mapping, count: usize, wanted: usize, groups: &[Viewed]) -> ImageError {
    let s = if count == 1 { "" } else { "s" };
    let message = format!(
        "--map {}={}: `{}` has {wanted} components, found {count} channel{s}",
        map.name, map.channels, map.name
    );
    let error = ImageError::new(ErrorKind::Mapping, message);
    // The group that the channel is of.
    let layer = map.channels.rsplit_once('.').map(|(layer, _)| layer);
    let group = layer.and_then(|layer| {
        let own = |g: &&Viewed| g.group.channels.len() >= wanted && !g.group.path.is_empty();
        let found: Vec<&Viewed> =
            groups.iter().filter(own).filter(|g| g.names.iter().any(|n| ends_with(n, layer))).collect();
        if let [one] = found[..] { Some(&one.shown) } else { None }
    });
    error.hint(match group {
        Some(group) => format!("Give the whole group: --map {}.", argument(&map.name, group)),
        None => format!("Give a group, or {wanted} channels separated by commas."),
    })
}

/// Is it the name, or the end of the name?
fn ends_with(name: &str, end: &str) -> bool {
    name == end || name.strip_suffix(end).is_some_and(|rest| rest.ends_with('.'))
}

/// The error of a mapping to channels that are not read.
fn unread(map: &Mapping, candidate: &Candidate, file: &str, channels: &[ChannelName]) -> ImageError {
    let bad = candidate.channels.iter().map(|&c| &channels[c]).find(|c| c.unread || c.subsampled);
    let name = bad.map_or("", |c| c.full.as_str());
    let message = format!("--map {}={}: `{name}` of `{file}` is not read", map.name, map.channels);
    ImageError::new(ErrorKind::Mapping, message).hint(match bad.is_some_and(|c| c.unread) {
        true => "Its part cannot be read: see `pse info`.",
        false => "It is subsampled: convert it to full resolution first.",
    })
}

/// What `wanted` means of things and their names: the name itself, else in another case, else as the end of a name.
fn pick(wanted: &str, names: &[(usize, String)]) -> Vec<usize> {
    let lower = wanted.to_lowercase();
    let tail = format!(".{lower}");
    let tests: [&dyn Fn(&str) -> bool; 4] =
        [&|n| n == wanted, &|n| n.to_lowercase() == lower, &|n| n.ends_with(&format!(".{wanted}")), &|n| {
            n.to_lowercase().ends_with(&tail)
        }];
    for test in tests {
        let mut found: Vec<usize> =
            names.iter().filter(|(_, name)| test(name)).map(|(thing, _)| *thing).collect();
        found.dedup();
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
    channels: &Channels<'_>,
    groups: &[Viewed],
) -> ImageError {
    if !found.is_empty() {
        let found: Vec<String> = found.iter().map(|&c| channels.argument(c).to_string()).collect();
        return several_match(map, wanted, &found, file);
    }
    let message = format!("--map {}={}: `{file}` has no channels `{wanted}`", map.name, map.channels);
    let mut error = ImageError::new(ErrorKind::Mapping, message);
    let shown = || groups.iter().map(|g| g.shown.as_str());
    if let Some(near) = nearest(wanted, shown()) {
        error = error.hint(format!("Did you mean --map {}?", argument(&map.name, near)));
    }
    error.hint(format!("It has {}.", list(shown())))
}
