//! What channels are called, given the parts and the views that they are in.
//!
//! The layer may stand in a part's name, in a channel's, or in both. A part's name may end with its view (`rgba.left`,
//! `depth_left`), and a channel's may have a view in it (`left.R`, `left.depth.Z`, `depth.left.Z`). The first view of
//! a file is its hero: its channels are called as if there were no views.

use super::bind::ChannelName;

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
    let listed =
        parts.iter().flat_map(|part| &part.views).chain(parts.iter().filter_map(|p| p.view.as_ref()));
    for view in listed.filter(|view| !view.is_empty()) {
        if !views.contains(&view.as_str()) {
            views.push(view);
        }
    }
    let mut longest = views.clone();
    longest.sort_by_key(|view| std::cmp::Reverse(view.len()));
    let mut list: Vec<ChannelName> = Vec::new();
    for (index, part) in parts.iter().enumerate() {
        let (base, view) = split_view(part, &longest);
        let numbered = is_numbered(base);
        for (place, channel) in part.channels.iter().enumerate() {
            let full = if several { full_name(&part.name, channel) } else { channel.clone() };
            let (own, view) = match view {
                Some(view) => (without_prefix(channel, view).unwrap_or(channel).to_string(), Some(view)),
                None => match longest.iter().find_map(|view| Some((without_view(channel, view)?, *view))) {
                    Some((own, view)) => (own, Some(view)),
                    None => (channel.clone(), None),
                },
            };
            // The hero's names are plain.
            let view = view.filter(|view| views.first() != Some(view)).map(String::from);
            let taken =
                |name: &str| list.iter().any(|c| c.short == name && c.view == view && c.part != index);
            let plain = !several || base.is_empty() || numbered && !taken(&own);
            let short = if plain { own.clone() } else { full_name(base, &own) };
            let layerless = !plain && !own.contains('.');
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
    list
}

/// A part's name without its view, and the view.
fn split_view<'p>(part: &'p PartNames, views: &[&'p str]) -> (&'p str, Option<&'p str>) {
    if let Some(view) = part.view.as_deref().filter(|view| !view.is_empty()) {
        return (strip_view(&part.name, view).unwrap_or(&part.name), Some(view));
    }
    if let Some((base, view)) = views.iter().find_map(|view| Some((strip_view(&part.name, view)?, *view))) {
        return (base, Some(view));
    }
    (strip_view(&part.name, ONLY_VIEW).unwrap_or(&part.name), None)
}

/// A part's name without the view at its end or at its start.
fn strip_view<'n>(name: &'n str, view: &str) -> Option<&'n str> {
    if name == view {
        return Some("");
    }
    let separator = ['.', '_', '-', ' ', ':'];
    let end = name.strip_suffix(view).and_then(|rest| rest.strip_suffix(separator));
    end.or_else(|| name.strip_prefix(view)?.strip_prefix(separator))
}

/// A channel's name without the view before it.
fn without_prefix<'n>(channel: &'n str, view: &str) -> Option<&'n str> {
    channel.strip_prefix(view)?.strip_prefix('.')
}

/// A channel's name without the view, which stands before it or before its last field.
fn without_view(channel: &str, view: &str) -> Option<String> {
    if let Some(rest) = without_prefix(channel, view) {
        return Some(rest.to_string());
    }
    let (rest, last) = channel.rsplit_once('.')?;
    let layer = rest.strip_suffix(view)?.strip_suffix('.')?;
    Some(format!("{layer}.{last}"))
}

/// Is it a number with a word that says no more than that it is a part?
fn is_numbered(name: &str) -> bool {
    let word = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let word = word.trim_end_matches(['.', '_', '-', ' ']).to_lowercase();
    name.ends_with(|c: char| c.is_ascii_digit())
        && matches!(word.as_str(), "" | "part" | "subimage" | "image" | "layer")
}

/// The full name of a channel in a part that has a name of its own.
fn full_name(part: &str, channel: &str) -> String {
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
    } else if ends_with(&p, &c) {
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
    fn names(parts: &[PartNames]) -> String {
        let of = |c: ChannelName| match c.view {
            Some(view) => format!("{view}:{}", c.short),
            None => c.short,
        };
        name(parts).into_iter().map(of).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn views_are_taken_out_of_names() {
        let stereo = [part("rgba.left", "left", "R G"), part("depth_right", "right", "Z depth.Z")];
        assert_eq!(names(&stereo), "rgba.R rgba.G right:depth.Z right:depth.Z");
        let by_view = [part("left", "left", "R P.X"), part("right", "right", "R P.X")];
        assert_eq!(names(&by_view), "R P.X right:R right:P.X");
        assert_eq!(names(&[part("P.main", "", "X"), part("N.main", "main", "X")]), "P.X N.X");
        // A part that names no view, but ends with one.
        assert_eq!(
            names(&[part("a_l", "l", "R"), part("b_r", "r", "R"), part("c_r", "", "R")]),
            "a.R r:b.R r:c.R"
        );
    }

    #[test]
    fn one_part_may_hold_several_views() {
        let mut one = part("", "", "R left.eye.R left.R P.left.X left.P.Y left.P.left.Z P.Z a.b.left");
        one.views = ["right", "left", "left.eye"].map(String::from).to_vec();
        assert_eq!(names(&[one]), "R left.eye:R left:R left:P.X left:P.Y left:P.left.Z P.Z a.b.left");
    }

    #[test]
    fn numbers_of_parts_are_no_layers() {
        let parts = [part("part0", "", "R G"), part("part1", "", "B"), part("part2", "", "R N.X")];
        assert_eq!(names(&parts), "R G B part2.R N.X");
    }
}
