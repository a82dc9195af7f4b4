//! What channels are called, given the parts and the views that they are in.
//!
//! The layer may stand in a part's name, in a channel's, or in both. A part's name may end with its view (`rgba.left`,
//! `depth_left`), and a channel's may have a view in it (`left.R`, `left.depth.Z`, `depth.left.Z`). The first view of
//! a file is its hero: its channels are called as if there were no views.

use super::bind::ChannelName;
use super::names;
use std::collections::{HashMap, HashSet};

/// A part's names, as the file has them.
pub(super) struct PartNames {
    /// The part's; empty if it has none.
    pub name: String,
    /// The view that it belongs to, if it says so.
    pub view: Option<String>,
    /// All views, in the part that lists them.
    pub views: Vec<String>,
    /// Its channels'.
    pub channels: Vec<String>,
}

/// The view that Nuke puts into the names of parts where there is only one.
const ONLY_VIEW: &str = "main";

/// Names the channels of all parts, in the file's order.
pub(super) fn name(parts: &[PartNames]) -> Vec<ChannelName> {
    let several = parts.len() > 1;
    let mut views: Vec<&str> = Vec::new();
    let mut known: HashSet<&str> = HashSet::new();
    let listed =
        parts.iter().flat_map(|part| &part.views).chain(parts.iter().filter_map(|p| p.view.as_ref()));
    for view in listed.filter(|view| !view.is_empty()) {
        if known.insert(view) {
            views.push(view);
        }
    }
    let split: Vec<Split<'_>> = parts.iter().map(|part| Split::new(part, &known)).collect();
    let hero = hero(parts, &split, &views);
    let mut list: Vec<ChannelName> = Vec::new();
    // In which part a name stood first.
    let mut first: HashMap<(String, Option<String>), usize> = HashMap::new();
    for (index, (part, Split { base, channels })) in parts.iter().zip(split).enumerate() {
        let numbered = is_numbered(base);
        let alone = part.channels.len() == 1;
        for (place, (channel, (own, view))) in part.channels.iter().zip(channels).enumerate() {
            let full = if several { full_name(&part.name, channel, alone) } else { channel.clone() };
            // The hero's names are plain.
            let view = view.filter(|view| hero != Some(*view)).map(String::from);
            let is_taken = first.get(&(own.clone(), view.clone())).is_some_and(|other| *other != index);
            let plain = !several || base.is_empty() || numbered && !is_taken;
            let short = if plain { own.clone() } else { full_name(base, &own, alone) };
            let layerless = !plain && !own.contains('.');
            first.entry((short.clone(), view.clone())).or_insert(index);
            list.push(ChannelName {
                full,
                short,
                view,
                layerless,
                part: index,
                index: place,
                ..ChannelName::default()
            });
        }
    }
    distinguish(&mut list, parts);
    list
}

/// The names of a part without its view.
struct Split<'p> {
    /// The part's.
    base: &'p str,
    /// Its channels', with the views that they belong to.
    channels: Vec<(String, Option<&'p str>)>,
}

impl<'p> Split<'p> {
    fn new(part: &'p PartNames, views: &HashSet<&'p str>) -> Split<'p> {
        let (base, view) = split_view(part, views);
        let channel = |channel: &String| match view {
            Some(view) => (without_prefix(channel, view).unwrap_or(channel).to_string(), Some(view)),
            None => match without_any_view(channel, views) {
                Some((own, view)) => (own, Some(view)),
                None => (channel.clone(), None),
            },
        };
        Split { base, channels: part.channels.iter().map(channel).collect() }
    }
}

/// The view whose names are plain: the first, unless channels without a view are what its channels are. Then these are the
/// picture proper, and all views stand beside it.
fn hero<'p>(parts: &[PartNames], split: &[Split<'p>], views: &[&'p str]) -> Option<&'p str> {
    let first = *views.first()?;
    // Where the views are listed, the first is the one whose channels are not marked.
    if parts.iter().any(|part| !part.views.is_empty()) {
        return Some(first);
    }
    let variables = |wanted: Option<&str>| -> HashSet<String> {
        let names = split.iter().flat_map(|Split { base, channels }| {
            let own = channels.iter().filter(move |(_, view)| *view == wanted);
            own.map(|(own, _)| full_name(base, own, channels.len() == 1))
        });
        let groups = names::groups(&names.collect::<Vec<_>>());
        let of = |group: &names::Group| {
            let known = names::canonical(group).into_iter().map(|(name, ..)| name);
            let by_part = names::of_part(group).into_iter().map(|(name, _)| name);
            let all: Vec<String> = known.chain(by_part).map(String::from).collect();
            all.into_iter().chain([group.own.clone()]).collect::<Vec<_>>()
        };
        groups.iter().flat_map(of).collect()
    };
    (variables(None).is_disjoint(&variables(Some(first)))).then_some(first)
}

/// Gives channels of the same full name others, with their part's name or number before the channel's own.
fn distinguish(list: &mut [ChannelName], parts: &[PartNames]) {
    let spellings: [&dyn Fn(&ChannelName) -> String; 2] =
        [&|c| format!("{}.{}", parts[c.part].name, parts[c.part].channels[c.index]), &|c| {
            format!("part{}.{}", c.part + 1, parts[c.part].channels[c.index])
        }];
    for spelling in spellings {
        let mut counts: HashMap<String, usize> = HashMap::new();
        list.iter().for_each(|c| *counts.entry(c.full.clone()).or_default() += 1);
        for channel in list.iter_mut().filter(|c| counts[&c.full] > 1) {
            channel.full = spelling(channel);
        }
    }
}

/// Between the words of a name.
const SEPARATORS: [char; 5] = ['.', '_', '-', ' ', ':'];

/// A part's name without its view, and the view.
fn split_view<'p>(part: &'p PartNames, views: &HashSet<&'p str>) -> (&'p str, Option<&'p str>) {
    if let Some(view) = part.view.as_deref().filter(|view| !view.is_empty()) {
        return (strip_view(&part.name, view).unwrap_or(&part.name), Some(view));
    }
    let name = part.name.as_str();
    let cuts = || name.char_indices().filter(|(_, c)| SEPARATORS.contains(c)).map(|(at, _)| at);
    let ends = cuts().map(|at| (&name[..at], &name[at + 1..]));
    let starts = cuts().map(|at| (&name[at + 1..], &name[..at]));
    let found = std::iter::once(("", name)).chain(ends).chain(starts);
    let found = found.filter_map(|(base, view)| Some((base, *views.get(view)?)));
    // Of several the longest; the last of those that are as long is the first here.
    if let Some((base, view)) = found.reduce(|a, b| if b.1.len() > a.1.len() { b } else { a }) {
        return (base, Some(view));
    }
    (strip_view(name, ONLY_VIEW).unwrap_or(name), None)
}

/// A part's name without the view at its end or at its start.
fn strip_view<'n>(name: &'n str, view: &str) -> Option<&'n str> {
    if name == view {
        return Some("");
    }
    let end = name.strip_suffix(view).and_then(|rest| rest.strip_suffix(SEPARATORS));
    end.or_else(|| name.strip_prefix(view)?.strip_prefix(SEPARATORS))
}

/// A channel's name without the view before it.
fn without_prefix<'n>(channel: &'n str, view: &str) -> Option<&'n str> {
    channel.strip_prefix(view)?.strip_prefix('.')
}

/// A channel's name without a view, which stands before it or before its last field, and the view: the longest of several.
fn without_any_view<'p>(channel: &str, views: &HashSet<&'p str>) -> Option<(String, &'p str)> {
    let dots = || channel.match_indices('.').map(|(at, _)| at);
    let before = dots().map(|at| (&channel[..at], channel[at + 1..].to_string()));
    let (layer, last) = channel.rsplit_once('.')?;
    let inside =
        layer.match_indices('.').map(|(at, _)| (&layer[at + 1..], format!("{}.{last}", &layer[..at])));
    let found = before.chain(inside).filter_map(|(view, own)| Some((own, *views.get(view)?)));
    found.reduce(|a, b| if b.1.len() > a.1.len() { b } else { a })
}

/// Is it a number with a word that says no more than that it is a part?
fn is_numbered(name: &str) -> bool {
    let word = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let word = word.trim_end_matches(['.', '_', '-', ' ']).to_lowercase();
    name.ends_with(|c: char| c.is_ascii_digit())
        && matches!(word.as_str(), "" | "part" | "subimage" | "image" | "layer")
}

/// The full name of a channel in a part that has a name of its own. `alone`: it is the part's only one, so the part's name
/// may be all of its name.
fn full_name(part: &str, channel: &str, alone: bool) -> String {
    let (p, c) = (part.to_lowercase(), channel.to_lowercase());
    let layer = c.rsplit_once('.').map_or("", |(layer, _)| layer);
    let ends_with = |long: &str, short: &str| {
        long == short || long.strip_suffix(short).is_some_and(|head| head.ends_with('.'))
    };
    // The names have as many fields in small letters, but may be of another length.
    let tail = || channel.rsplit('.').next().unwrap_or(channel);
    if part.is_empty() || c == p || c.starts_with(&format!("{p}.")) || ends_with(&c, &p) {
        // The channel says it all already.
        channel.to_string()
    } else if !layer.is_empty() && ends_with(layer, &p) {
        channel.to_string()
    } else if !layer.is_empty() && ends_with(&p, layer) {
        format!("{part}.{}", tail())
    } else if alone && ends_with(&p, &c) {
        part.to_string()
    } else {
        format!("{part}.{channel}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(name: &str, view: &str, channels: &str) -> PartNames {
        PartNames {
            name: name.into(),
            view: Some(view.to_string()).filter(|v| !v.is_empty()),
            views: Vec::new(),
            channels: channels.split(' ').map(String::from).collect(),
        }
    }

    /// The channels' short names, with `view:` before those of another view than the hero.
    fn shown(parts: &[PartNames]) -> String {
        let of = |c: ChannelName| match c.view {
            Some(view) => format!("{view}:{}", c.short),
            None => c.short,
        };
        name(parts).into_iter().map(of).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn views_are_taken_out_of_names() {
        let stereo = [part("rgba.left", "left", "R G"), part("depth_right", "right", "Z depth.Z")];
        assert_eq!(shown(&stereo), "rgba.R rgba.G right:depth.Z right:depth.Z");
        let by_view = [part("left", "left", "R P.X"), part("right", "right", "R P.X")];
        assert_eq!(shown(&by_view), "R P.X right:R right:P.X");
        assert_eq!(shown(&[part("P.main", "", "X"), part("N.main", "main", "X")]), "P.X N.X");
        // A part that names no view, but ends with one.
        assert_eq!(
            shown(&[part("a_l", "l", "R"), part("b_r", "r", "R"), part("c_r", "", "R")]),
            "a.R r:b.R r:c.R"
        );
    }

    #[test]
    fn one_part_may_hold_several_views() {
        let mut one = part("", "", "R left.eye.R left.R P.left.X left.P.Y left.P.left.Z P.Z a.b.left");
        one.views = ["right", "left", "left.eye"].map(String::from).to_vec();
        assert_eq!(shown(&[one]), "R left.eye:R left:R left:P.X left:P.Y left:P.left.Z P.Z a.b.left");
    }

    #[test]
    fn numbers_of_parts_are_no_layers() {
        let parts = [part("part0", "", "R G"), part("part1", "", "B"), part("part2", "", "R N.X")];
        assert_eq!(shown(&parts), "R G B part2.R N.X");
    }
}
