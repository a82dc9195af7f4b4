//! Which channels are which variable, decided once from the names; and what to say when none is.
//!
//! Of a file with several views each has variables of its own: those of the hero, the first, have plain names, and
//! those of the others the view's before them, `left.color`. A group whose name is known becomes a canonical variable (`point`, `normal`, …); every group can
//! also be read by its own last name. If several groups could be the same canonical variable, the
//! spelling that comes first in the table of `names` wins; with the same spelling, one
//! without a prefix wins over one with, and any over Blender's `Composite`; otherwise the variable is
//! ambiguous, which is an error only for a program that reads it.

use super::error::{ErrorKind, ImageError};
use super::names::{self, Family, Group};
use crate::shape::Shape;
use crate::spelling;
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
    /// Are they luminance and chroma, `Y`, `RY` and `BY`, which become red, green and blue when they are read?
    pub luminance_chroma: bool,
}

impl Candidate {
    fn plain(group: String, channels: Vec<usize>) -> Candidate {
        let shape = match channels.len() {
            1 => Shape::Scalar,
            n => Shape::Vector(n as u32),
        };
        Candidate { group, channels, shape, luminance_chroma: false }
    }
}

/// A channel as variables are found by it.
#[derive(Clone, Debug, Default)]
pub(crate) struct ChannelName {
    /// With the layer in the part's name.
    pub full: String,
    /// Without the view, and without a part's name that says nothing.
    pub short: String,
    /// The view, if it is another than the hero.
    pub view: Option<String>,
    /// Has it no layer but the name of its part?
    pub layerless: bool,
    /// Which part of the file holds it.
    pub part: usize,
    /// Its place in that part.
    pub index: usize,
    /// Is its part not read?
    pub unread: bool,
    /// Has it fewer samples than pixels?
    pub subsampled: bool,
}

impl ChannelName {
    /// A channel of a file with neither parts nor views.
    pub fn plain(name: &str) -> ChannelName {
        ChannelName { full: name.to_string(), short: name.to_string(), ..ChannelName::default() }
    }
}

/// The variables of a file.
pub(crate) struct Bound {
    /// Those that can be read.
    pub bindings: Vec<Binding>,
    /// Those that are in the file, but not read.
    pub unread: Vec<Binding>,
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

/// The rank of what only a part's name says, below every known spelling.
const BY_PART: usize = 500;

/// The rank of a group's own name, below that.
const OWN: usize = 1_000_000;

/// A group of channels of one view.
struct Viewed {
    /// Its channels are those of the file.
    group: Group,
    /// Its name as `--map` takes it, with the view.
    shown: String,
    /// Names by which it can be called too.
    others: Vec<String>,
    view: Option<String>,
    /// Its part, if its channels have no layer but the part's name.
    layerless: Option<usize>,
}

/// A group that may be a variable.
struct Offer {
    name: String,
    rank: Rank,
    candidate: Candidate,
    /// Which group.
    group: usize,
}

/// The groups of all views, the hero's first.
fn viewed(channels: &[ChannelName]) -> Vec<Viewed> {
    let mut views: Vec<&Option<String>> = vec![&None];
    for channel in channels {
        if !views.contains(&&channel.view) {
            views.push(&channel.view);
        }
    }
    let mut list = Vec::new();
    for view in views {
        let places: Vec<usize> = (0..channels.len()).filter(|&c| channels[c].view == *view).collect();
        let names: Vec<String> = places.iter().map(|&c| channels[c].short.clone()).collect();
        for mut group in names::groups(&names) {
            group.channels.iter_mut().for_each(|c| *c = places[*c]);
            let first = &channels[group.channels[0]];
            let same = |c: &&usize| channels[**c].layerless && channels[**c].part == first.part;
            let layerless = group.channels.iter().all(|c| same(&c)).then_some(first.part);
            // The name that the channels have in the file without their last field.
            let stored = first.full.rsplit_once('.').map(|(layer, _)| layer.to_string());
            let (shown, short) = match (view, group.path.is_empty()) {
                (None, false) => (group.path.clone(), None),
                (None, true) => {
                    let names = group.channels.iter().map(|&c| channels[c].full.as_str());
                    (names.collect::<Vec<_>>().join(","), None)
                }
                (Some(view), true) => (view.clone(), None),
                (Some(view), false) => (format!("{view}.{}", group.path), None),
            };
            let others = stored.into_iter().chain(short).filter(|name: &String| *name != shown).collect();
            list.push(Viewed { group, shown, others, view: view.clone(), layerless });
        }
    }
    list
}

/// What a group may be, with the names that variables have in its view.
fn offers(index: usize, viewed: &Viewed, channels: &[ChannelName], list: &mut Vec<Offer>) {
    let Viewed { group, shown, view, layerless, .. } = viewed;
    let depth = match group.path.split('.').next() {
        Some(first) if first.eq_ignore_ascii_case("composite") => 2,
        _ => usize::from(group.path.contains('.')),
    };
    let mut offer = |name: &str, rank: usize, candidate: Candidate| {
        let name = match view {
            Some(view) => format!("{}.{name}", names::identifier(view)),
            None => name.to_string(),
        };
        list.push(Offer { name, rank: (rank, depth), candidate, group: index });
    };
    let converted = group.family == Family::LuminanceChroma;
    let mut known = names::canonical(group);
    if let (Some(part), true) = (layerless, known.is_empty()) {
        known = names::of_part(group).into_iter().map(|(name, used)| (name, BY_PART + part, used)).collect();
    }
    for (name, rank, used) in known {
        let from = used.iter().map(|&i| group.channels[i]).collect();
        let candidate = Candidate::plain(shown.clone(), from);
        let luminance_chroma = converted && name == "color";
        offer(name, rank, Candidate { luminance_chroma, ..candidate });
    }
    let whole = Candidate {
        group: shown.clone(),
        channels: group.channels.iter().copied().take(if converted { 3 } else { usize::MAX }).collect(),
        shape: group.shape.clone(),
        luminance_chroma: converted,
    };
    offer(&group.own, OWN, whole);
    if group.path.is_empty() {
        // The beauty's channels, which have no group name, can be read one by one.
        for &channel in &group.channels {
            let ChannelName { full, short, .. } = &channels[channel];
            let own = names::identifier(short);
            offer(&own, OWN, Candidate::plain(full.clone(), vec![channel]));
        }
    }
}

/// Can all channels of it be read?
fn is_read(candidate: &Candidate, channels: &[ChannelName]) -> bool {
    let first = candidate.channels.first().map(|&c| channels[c].part);
    candidate.channels.iter().enumerate().all(|(i, &c)| {
        // Chroma is interpolated where it is subsampled; it lies where the luminance does.
        let chroma = candidate.luminance_chroma && i > 0 && Some(channels[c].part) == first;
        !channels[c].unread && (!channels[c].subsampled || chroma)
    })
}

/// The variables of a file with such channels, after the user's mappings.
pub(crate) fn bind(file: &str, channels: &[ChannelName], maps: &[Mapping]) -> Result<Bound, ImageError> {
    let groups = viewed(channels);
    let mut list = Vec::new();
    for (index, viewed) in groups.iter().enumerate() {
        offers(index, viewed, channels, &mut list);
    }
    // Keep the best offers for each name. What cannot be read is no worse for it: another group in its place would be
    // something else than the file says.
    let mut best: Vec<(Binding, Rank, usize)> = Vec::new();
    for Offer { name, rank, candidate, group } in list {
        match best.iter_mut().find(|(b, _, _)| b.name == name) {
            None => best.push((Binding { name, alias: false, candidates: vec![candidate] }, rank, group)),
            Some((binding, least, at)) if rank < *least => {
                binding.candidates = vec![candidate];
                (*least, *at) = (rank, group);
            }
            Some((binding, least, at)) if rank == *least && *at != group => {
                binding.candidates.push(candidate)
            }
            Some(_) => {}
        }
    }
    let canonical: Vec<usize> = best.iter().filter(|(_, r, _)| r.0 < OWN).map(|(_, _, i)| *i).collect();
    let mut bound = Bound { bindings: Vec::new(), unread: Vec::new() };
    for (mut binding, rank, group) in best {
        binding.alias = rank.0 == OWN && canonical.contains(&group);
        let (read, unread): (Vec<_>, Vec<_>) =
            binding.candidates.into_iter().partition(|c| is_read(c, channels));
        match read.is_empty() {
            true => bound.unread.push(Binding { candidates: unread, ..binding }),
            false => bound.bindings.push(Binding { candidates: read, ..binding }),
        }
    }
    for map in maps {
        apply(map, file, channels, &groups, &mut bound.bindings)?;
    }
    Ok(bound)
}

/// Sets a variable to a candidate, whatever it was.
fn put(bindings: &mut Vec<Binding>, name: &str, candidate: Candidate) {
    let binding = Binding { name: name.to_string(), alias: false, candidates: vec![candidate] };
    match bindings.iter_mut().find(|b| b.name == name) {
        Some(old) => *old = binding,
        None => bindings.push(binding),
    }
}

fn apply(
    map: &Mapping,
    file: &str,
    channels: &[ChannelName],
    groups: &[Viewed],
    bindings: &mut Vec<Binding>,
) -> Result<(), ImageError> {
    let checked = |candidate: Candidate| match is_read(&candidate, channels) {
        true => Ok(candidate),
        false => Err(unread(map, &candidate, file, channels)),
    };
    // A channel by its full name, or by the one that it has beside its view.
    let one = |wanted: &str| {
        let names = |c: &ChannelName| [Some(c.full.clone()), Some(with_view(c)).filter(|n| *n != c.full)];
        let list = channels
            .iter()
            .enumerate()
            .flat_map(|(i, c)| names(c).into_iter().flatten().map(move |n| (i, n)));
        pick(wanted, &list.collect::<Vec<_>>())
    };
    if map.channels.contains(',') {
        let picked = map.channels.split(',').map(|part| match one(part.trim()).as_slice() {
            [one] => Ok(*one),
            found => Err(unmapped(map, part.trim(), found, file, channels, groups)),
        });
        let from = picked.collect::<Result<Vec<usize>, _>>()?;
        let shape = Shape::Vector(from.len() as u32);
        let candidate = Candidate { shape, ..Candidate::plain(map.channels.clone(), from) };
        put(bindings, &map.name, checked(candidate)?);
        return Ok(());
    }
    let named = groups.iter().enumerate().flat_map(|(i, g)| {
        let own = Some(&g.shown).filter(|_| !g.group.path.is_empty() || g.view.is_some());
        own.into_iter().chain(&g.others).map(move |name| (i, name.clone()))
    });
    match pick(&map.channels, &named.collect::<Vec<_>>()).as_slice() {
        [] => {}
        [one] => {
            let Viewed { group, shown, .. } = &groups[*one];
            let converted = group.family == Family::LuminanceChroma;
            let all = if converted { 3 } else { group.channels.len() };
            // A known variable takes as many components as it has: a point three, an id one.
            let wanted = match map.name.as_str() {
                "point" | "normal" | "color" | "albedo" => 3,
                "uv" => 2,
                "surface" | "depth" | "alpha" => 1,
                _ => all,
            };
            let whole = wanted >= all || converted;
            let from = group.channels.iter().copied().take(if whole { all } else { wanted }).collect();
            let mut candidate = Candidate::plain(shown.clone(), from);
            if whole {
                candidate.shape = group.shape.clone();
                candidate.luminance_chroma = converted;
            }
            if map.name == "color"
                && let Some(a) = group.letters.find('a')
            {
                put(bindings, "alpha", checked(Candidate::plain(shown.clone(), vec![group.channels[a]]))?);
            }
            put(bindings, &map.name, checked(candidate)?);
            return Ok(());
        }
        several => {
            let found: Vec<String> = several.iter().map(|&g| groups[g].shown.clone()).collect();
            return Err(several_match(map, &map.channels, &found, file));
        }
    }
    match one(&map.channels).as_slice() {
        [one] => {
            let candidate = Candidate::plain(channels[*one].full.clone(), vec![*one]);
            put(bindings, &map.name, checked(candidate)?);
            Ok(())
        }
        found => Err(unmapped(map, &map.channels, found, file, channels, groups)),
    }
}

/// A channel's short name behind its view.
fn with_view(channel: &ChannelName) -> String {
    match &channel.view {
        Some(view) => format!("{view}.{}", channel.short),
        None => channel.short.clone(),
    }
}

/// The error of a mapping to channels that are not read.
fn unread(map: &Mapping, candidate: &Candidate, file: &str, channels: &[ChannelName]) -> ImageError {
    let bad = candidate.channels.iter().map(|&c| &channels[c]).find(|c| c.unread || c.subsampled);
    let name = bad.map_or("", |c| c.full.as_str());
    let message = format!("--map {}={}: `{name}` of `{file}` is not read", map.name, map.channels);
    ImageError::new(ErrorKind::Mapping, message).hint(match bad.is_some_and(|c| c.unread) {
        true => "The part that holds it is not read: see `pse info`.",
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
    channels: &[ChannelName],
    groups: &[Viewed],
) -> ImageError {
    if !found.is_empty() {
        let found: Vec<String> = found.iter().map(|&c| channels[c].full.clone()).collect();
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

/// The name that `wanted` may be a slip or the beginning of, compared whole and by its last field.
fn nearest<'a>(wanted: &str, names: impl Iterator<Item = &'a str> + Clone) -> Option<&'a str> {
    let fields = || names.clone().map(|name| (names::last_field(name), name));
    let whole = spelling::nearest(wanted, names.clone());
    let field = || spelling::nearest(wanted, fields().map(|(field, _)| field));
    let by_field = |near: &str| fields().find(|(field, _)| *field == near).map(|(_, name)| name);
    let lower = wanted.to_lowercase();
    let begins = |field: &str| lower.len() > 2 && field.to_lowercase().starts_with(&lower);
    whole.or_else(|| by_field(field()?)).or_else(|| {
        let mut longer = fields().filter(|(field, _)| begins(field)).map(|(_, name)| name);
        longer.next().filter(|_| longer.next().is_none())
    })
}

/// What a variable is read from, if that is one thing.
pub(crate) fn only<'b>(file: &str, binding: &'b Binding) -> Result<&'b Candidate, ImageError> {
    match binding.candidates.as_slice() {
        [one] => Ok(one),
        several => {
            let name = &binding.name;
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
