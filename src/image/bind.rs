//! Which channels are which variable, decided once from the names; and what to say when none is.
//!
//! Of a file with several views each has variables of its own: those of the hero, the first, have plain names, and
//! those of the others the view's before them, `left.color`. A group whose name is known becomes a canonical variable (`point`, `normal`, …); every group can
//! also be read by its own last name. If several groups could be the same canonical variable, the
//! spelling that comes first in the table of `names` wins; with the same spelling, one
//! without a prefix wins over one with, and any over Blender's `Composite`; otherwise the variable is
//! ambiguous, which is an error only for a program that reads it.

use super::error::{ErrorKind, ImageError};
use super::mapping::{self, Mapping};
use super::names::{self, Family, Group};
use crate::shape::Shape;
use crate::spelling;
use std::collections::{HashMap, HashSet};

/// The channels that a variable is read from.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// The group's name, as for `--map`.
    pub group: String,
    /// The indices in [`File::channels`](super::File::channels), one for each cell of the shape.
    pub channels: Vec<usize>,
    /// The shape.
    pub shape: Shape,
    /// Whether they are luminance and chroma, `Y`, `RY` and `BY`, which are converted to red, green and blue when
    /// read.
    pub luminance_chroma: bool,
}

impl Candidate {
    pub(super) fn plain(group: String, channels: Vec<usize>) -> Candidate {
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
    /// The index of its part in the file.
    pub part: usize,
    /// The index in that part.
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
    /// What the user should know of the mappings.
    pub notes: Vec<String>,
}

/// A variable that can be read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Binding {
    /// Its name in programs.
    pub name: String,
    /// Whether it is a second name for the channels of another variable.
    pub alias: bool,
    /// The candidates: one, or several if the variable is ambiguous; never none.
    pub candidates: Vec<Candidate>,
}

/// Less is better: the spelling's place in the table, then how deep the name is.
type Rank = (usize, usize);

/// The rank of what only a part's name says, below every known spelling.
const BY_PART: usize = 500;

/// The rank of a group's own name, below that.
const OWN: usize = 1_000_000;

/// A group of channels of one view.
pub(super) struct Viewed {
    /// Its channels are those of the file.
    pub group: Group,
    /// As `--map` takes it, and nothing else by it: a name, or its channels.
    pub shown: String,
    /// Names by which it can be called, which others may have too.
    pub names: Vec<String>,
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

/// The channels of a file by the names that `--map` takes.
pub(super) struct Channels<'c> {
    pub list: &'c [ChannelName],
    /// The channels that each name stands for.
    by_name: HashMap<String, Vec<usize>>,
}

impl<'c> Channels<'c> {
    fn new(list: &'c [ChannelName]) -> Channels<'c> {
        let mut by_name: HashMap<String, Vec<usize>> = HashMap::new();
        for (index, channel) in list.iter().enumerate() {
            for name in names_of(channel) {
                by_name.entry(name).or_default().push(index);
            }
        }
        Channels { list, by_name }
    }

    /// A name that stands for this channel alone, if it has one.
    pub fn argument(&self, channel: usize) -> &str {
        let names = names_of(&self.list[channel]);
        let single = names.iter().filter_map(|name| self.by_name.get_key_value(name));
        let single = single.filter(|(_, channels)| channels.len() == 1).map(|(name, _)| name.as_str()).next();
        single.unwrap_or(&self.list[channel].full)
    }
}

/// A channel's full name, and the one that it has beside its view.
pub(super) fn names_of(channel: &ChannelName) -> Vec<String> {
    let beside = with_view(channel);
    let other = (beside != channel.full).then_some(beside);
    std::iter::once(channel.full.clone()).chain(other).collect()
}

/// The groups of all views, the hero's first.
fn viewed(channels: &Channels<'_>) -> Vec<Viewed> {
    let Channels { list: all, .. } = channels;
    let mut views: Vec<(&Option<String>, Vec<usize>)> = vec![(&None, Vec::new())];
    let mut places: HashMap<&Option<String>, usize> = HashMap::from([(&None, 0)]);
    for (index, channel) in all.iter().enumerate() {
        let place = *places.entry(&channel.view).or_insert_with(|| {
            views.push((&channel.view, Vec::new()));
            views.len() - 1
        });
        views[place].1.push(index);
    }
    let mut list = Vec::new();
    for (view, places) in views {
        let names: Vec<String> = places.iter().map(|&c| all[c].short.clone()).collect();
        for mut group in names::groups(&names) {
            group.channels.iter_mut().for_each(|c| *c = places[*c]);
            let first = &all[group.channels[0]];
            let same = |c: &&usize| all[**c].layerless && all[**c].part == first.part;
            let layerless = group.channels.iter().all(|c| same(&c)).then_some(first.part);
            let own = match (view, group.path.is_empty()) {
                (None, true) => None,
                (None, false) => Some(group.path.clone()),
                (Some(view), true) => Some(view.clone()),
                (Some(view), false) => Some(format!("{view}.{}", group.path)),
            };
            // The name that the channels have in the file without their last field.
            let stored = first.full.rsplit_once('.').map(|(layer, _)| layer.to_string());
            let stored = stored.filter(|name| own.as_ref() != Some(name));
            let names = own.into_iter().chain(stored).collect();
            list.push(Viewed { group, shown: String::new(), names, view: view.clone(), layerless });
        }
    }
    let mut counts: HashMap<String, usize> = HashMap::new();
    list.iter().flat_map(|v| &v.names).for_each(|name| *counts.entry(name.clone()).or_default() += 1);
    for viewed in &mut list {
        let single = viewed.names.iter().find(|name| counts[*name] == 1 && !name.contains(','));
        let channels = || {
            let names = viewed.group.channels.iter().map(|&c| channels.argument(c));
            names.collect::<Vec<_>>().join(",")
        };
        viewed.shown = single.cloned().unwrap_or_else(channels);
    }
    list
}

/// What a group may be, with the names that variables have in its view.
fn offers(index: usize, viewed: &Viewed, channels: &Channels<'_>, list: &mut Vec<Offer>) {
    let Viewed { group, shown, view, layerless, .. } = viewed;
    let Channels { list: all, .. } = channels;
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
            let own = names::identifier(&all[channel].short);
            offer(&own, OWN, Candidate::plain(channels.argument(channel).to_string(), vec![channel]));
        }
    }
}

/// Can all channels of it be read?
pub(super) fn is_read(candidate: &Candidate, channels: &[ChannelName]) -> bool {
    let first = candidate.channels.first().map(|&c| channels[c].part);
    candidate.channels.iter().enumerate().all(|(i, &c)| {
        // Chroma is interpolated where it is subsampled; it lies where the luminance does.
        let chroma = candidate.luminance_chroma && i > 0 && Some(channels[c].part) == first;
        !channels[c].unread && (!channels[c].subsampled || chroma)
    })
}

/// The variables of a file with such channels, after the user's mappings.
pub(crate) fn bind(file: &str, channels: &[ChannelName], maps: &[Mapping]) -> Result<Bound, ImageError> {
    let named = Channels::new(channels);
    let groups = viewed(&named);
    let mut list = Vec::new();
    for (index, viewed) in groups.iter().enumerate() {
        offers(index, viewed, &named, &mut list);
    }
    // Keep the best offers for each name. What cannot be read is no worse for it: another group in its place would be
    // something else than the file says.
    let mut best: Vec<(Binding, Rank, usize)> = Vec::new();
    let mut places: HashMap<String, usize> = HashMap::new();
    for Offer { name, rank, candidate, group } in list {
        let place = *places.entry(name.clone()).or_insert(best.len());
        match best.get_mut(place) {
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
    let canonical: HashSet<usize> = best.iter().filter(|(_, r, _)| r.0 < OWN).map(|(_, _, i)| *i).collect();
    let mut bound = Bound { bindings: Vec::new(), unread: Vec::new(), notes: Vec::new() };
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
        mapping::apply(map, file, &named, &groups, &mut bound)?;
    }
    Ok(bound)
}

/// A channel's short name behind its view.
fn with_view(channel: &ChannelName) -> String {
    match &channel.view {
        Some(view) => format!("{view}.{}", channel.short),
        None => channel.short.clone(),
    }
}

/// `name=group`, quoted where the shell would want it.
pub(super) fn argument(name: &str, group: &str) -> String {
    match group.chars().all(|c| c.is_ascii_alphanumeric() || "._-,:".contains(c)) {
        true => format!("{name}={group}"),
        false => format!("'{name}={group}'"),
    }
}

/// Names in a row, in quotes; a very long row is cut.
pub(super) fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.collect();
    let mut text: Vec<String> = names.iter().take(40).map(|n| format!("`{n}`")).collect();
    if names.len() > 40 {
        text.push(format!("{} more", names.len() - 40));
    }
    text.join(", ")
}

/// The name that `wanted` may be a slip or the beginning of, compared whole and by its last field.
pub(super) fn nearest<'a>(wanted: &str, names: impl Iterator<Item = &'a str> + Clone) -> Option<&'a str> {
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
