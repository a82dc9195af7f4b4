//! What renderers call things: channels gathered into groups, and groups known by their names.
//!
//! A channel is `layer.layer.group.component`: the last field is a component if it is one of
//! `X Y Z W`, `R G B A`, `U V`, their lower case, `red green blue alpha`, or a number (our own vectors
//! of any length, `v.1`, `m.2.1`). Files hold channels alphabetically (A B G R); a group has them in
//! natural order. A group is known by its last field alone, in any case and with any prefix.

use crate::shape::Shape;
use std::collections::HashMap;

/// How a group's components are named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Family {
    /// R G B A.
    Rgb,
    /// X Y Z W.
    Xyz,
    /// U V W.
    Uv,
    /// Y, RY and BY, which are luminance and chroma, and A.
    LuminanceChroma,
    /// Numbers: a vector of any length, or nested.
    Numbered,
    /// One channel that is no component.
    Single,
}

/// Channels that belong together.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    /// The name without the component: `ViewLayer.Position`; empty at the root.
    pub path: String,
    /// Its last field, made into an identifier: the variable's own name.
    pub own: String,
    /// Indices of its channels, in natural order.
    pub channels: Vec<usize>,
    /// The letters of the components, lower case; empty for `Numbered` and `Single`.
    pub letters: String,
    /// How they are named.
    pub family: Family,
    /// The shape.
    pub shape: Shape,
    /// Is it one component of several, and so nothing by itself?
    pub sibling: bool,
}

/// The canonical variables, and the names under which renderers write them, best first, as
/// [`key`] spells them. Where a file has several, the first in the list is the variable.
pub(crate) const KNOWN: [(&str, &[&str]); 9] = [
    (
        "surface",
        &[
            "surface",
            "indexob",      // Blender to 4.5
            "objectindex",  // Blender 5
            "objectid",     // Karma's ray:objectid is rayobjectid
            "id",           // Arnold, RenderMan, Redshift
            "rawid",        // RenderMan
            "vrayobjectid", // V-Ray
            "vrayrenderid",
            "opid", // Mantra's Op_Id
            "rayobjectid",
            "actorhitproxymask", // Unreal
        ],
    ),
    (
        "point",
        &[
            "point",
            "position",
            "pworld", // RenderMan: before P, which is in camera space there
            "worldposition",
            "rayhitp",
            "p",
            "vraysamplerinfo",
        ],
    ),
    (
        "normal",
        &[
            "normal",
            "nworld",
            "worldnormal",
            "rayhitn",
            "n",
            "nn",
            "normals",
            "vraynormals",
            "bumpnormals",
            "vraybumpnormals",
        ],
    ),
    ("uv", &["uv", "st", "rayhituv", "vraysamplerinfo", "texcoord"]),
    ("depth", &["depth", "z", "vrayzdepth", "zdepth", "pz", "rayhitpz", "worlddepth"]),
    ("color", &["", "color", "combined", "rgba", "rgb", "beauty", "ci", "c", "finalimage", "y"]),
    ("alpha", &["alpha", "a"]),
    (
        "albedo",
        &[
            "albedo",
            "diffcol",
            "diffusecolor",
            "diffusealbedo",
            "diffusefilter",
            "vraydiffusefilter",
            "basecolor",
            "diffuse",
        ],
    ),
    ("motion", &["motion", "vector", "motionvector", "motionvectors", "velocity"]),
];

/// A name as the table has it: lower-case letters and digits only.
pub(crate) fn key(name: &str) -> String {
    let key: String = name.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_lowercase();
    // Unreal prefixes the passes of its post-process materials, and numbers the layers of its ids.
    let key = key.strip_prefix("finalimagemovierenderqueue").filter(|rest| !rest.is_empty()).unwrap_or(&key);
    match key.strip_prefix("actorhitproxymask") {
        Some("00") => "actorhitproxymask".into(),
        _ => key.to_string(),
    }
}

/// A name as an identifier of the language: `Object Index` is `Object_Index`.
pub(crate) fn identifier(name: &str) -> String {
    let mut text: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '_' }).collect();
    if text.is_empty() || text.starts_with(|c: char| c.is_ascii_digit()) {
        text.insert(0, '_');
    }
    text
}

/// The last field of a dotted name.
pub(crate) fn last_field(path: &str) -> &str {
    path.rsplit('.').next().unwrap_or(path)
}

/// The canonical variables that a group can be: name, place in the list of spellings, and the
/// positions of the components that it uses.
pub(crate) fn canonical(group: &Group) -> Vec<(&'static str, usize, Vec<usize>)> {
    let count = group.channels.len();
    let tail = key(last_field(&group.path));
    let at_root = !group.path.contains('.');
    let plain = !matches!(group.family, Family::Numbered);
    let first = |n: usize| (0..n).collect::<Vec<usize>>();
    let mut found = Vec::new();
    // A component of something is not all of another thing.
    if group.sibling {
        return found;
    }
    for (name, spellings) in KNOWN {
        let Some(rank) = spellings.iter().position(|s| *s == tail) else { continue };
        // Spelt exactly as ours, with no alpha mixed in, it is as long as it is: our own files come back.
        let ours = at_root && group.own == name && plain && !group.letters.contains('a');
        // We write vectors as x y z; red, green and blue of what is one number are the same number three times.
        let thrice = group.family == Family::Rgb && matches!(name, "surface" | "depth" | "alpha");
        let used = match name {
            _ if ours && !thrice && !matches!(name, "color" | "uv") => Some(first(count)),
            // The root's channels are colour only if they are R G B; a lone `Y` is luminance.
            "color" if tail.is_empty() && !matches!(group.family, Family::Rgb | Family::LuminanceChroma) => {
                None
            }
            "color" if tail == "y" => {
                (at_root && group.path == "Y" && group.family == Family::Single).then(|| vec![0, 0, 0])
            }
            "color" | "albedo" | "normal" => {
                (count >= 3 && plain && group.family != Family::Uv).then(|| first(3))
            }
            "point" => (count >= 3 && plain && group.family != Family::Uv).then(|| first(3)),
            // V-Ray's sampler info is a point as X Y Z and texture coordinates as U V W.
            "uv" if tail == "vraysamplerinfo" && group.family != Family::Uv => None,
            "uv" => (count >= 2 && plain).then(|| first(2)),
            "motion" => (count >= 2 && plain).then(|| first(count)),
            // The A of a layer that is not the beauty says nothing of the whole pixel.
            "alpha" if tail == "a" && !at_root => None,
            "alpha" => (count == 1 || thrice).then(|| first(1)),
            _ => plain.then(|| first(1)),
        };
        // A small `a` may be any program's own variable: `A` comes before it.
        let rank = if group.path == "a" { spellings.len() } else { rank };
        if let Some(used) = used {
            found.push((name, rank, used));
        }
        if let Some(a) = group.letters.find('a')
            && matches!(name, "color" | "uv")
            && (found.last().is_some_and(|f| f.0 == name) || name == "color" && group.letters == "a")
        {
            let name = if name == "uv" { "uv_coverage" } else { "alpha" };
            // Coverage that stands beside the beauty belongs to it: it ranks with it. So does one that has the beauty's
            // name and a part of its own.
            found.push((name, rank, vec![a]));
        }
    }
    // A lone Z beside R G B, as in `main.Z`, was made a group of its own and is found by its name `Z`.
    found
}

/// What a group can be whose channels have no layer but the name of their part, where that name is none that is known.
pub(crate) fn of_part(group: &Group) -> Vec<(&'static str, Vec<usize>)> {
    match (group.family, group.letters.as_str()) {
        (Family::Rgb, "rgb") | (Family::LuminanceChroma, "") => vec![("color", vec![0, 1, 2])],
        (Family::Rgb, "rgba") | (Family::LuminanceChroma, _) => {
            vec![("color", vec![0, 1, 2]), ("alpha", vec![3])]
        }
        (Family::Xyz, "z") => vec![("depth", vec![0])],
        (Family::Xyz, "y") => vec![("color", vec![0, 0, 0])],
        _ => Vec::new(),
    }
}

/// Gathers channels, given by their full names, into groups; in the order of their first channels.
pub(crate) fn groups(names: &[String]) -> Vec<Group> {
    let mut groups = Vec::new();
    let mut taken = vec![false; names.len()];
    luminance_chroma(names, &mut taken, &mut groups);
    // Gather by layer, noting each channel's component.
    let mut layers: Vec<(String, Vec<(Component, usize)>)> = Vec::new();
    let mut places: HashMap<String, usize> = HashMap::new();
    // At the root a small letter is a program's own name, as `a` and `y` are, but where r g b make a colour.
    let small_color = ["r", "g", "b"].iter().all(|c| names.iter().any(|n| n == c));
    for (index, name) in names.iter().enumerate().filter(|(i, _)| !taken[*i]) {
        let own = name.len() == 1 && name.starts_with(|c: char| c.is_ascii_lowercase()) && !small_color;
        let (layer, component) = if own { (name.clone(), Component::Other) } else { split(name) };
        let place = *places.entry(layer).or_insert_with_key(|layer| {
            layers.push((layer.clone(), Vec::new()));
            layers.len() - 1
        });
        layers[place].1.push((component, index));
    }
    for (layer, members) in layers {
        groups_of_layer(&layer, members, names, &mut groups);
    }
    by_last_letter(names, &mut groups);
    // Beside `b` or `x` a small `a` is a program's own variable, alone it is alpha.
    let is_own =
        |name: &String| name.len() == 1 && name.starts_with(|c: char| c.is_ascii_lowercase() && c != 'a');
    if !small_color && names.iter().any(is_own) {
        groups.iter_mut().filter(|g| g.path == "a").for_each(|g| g.sibling = true);
    }
    groups.sort_by_key(|g: &Group| g.channels.iter().copied().min());
    groups
}

/// Finds layers with `Y`, `RY` and `BY`, which OpenEXR's colours of luminance and chroma are called.
fn luminance_chroma(names: &[String], taken: &mut [bool], groups: &mut Vec<Group>) {
    let mut places: HashMap<&str, usize> = HashMap::new();
    for (index, name) in names.iter().enumerate() {
        places.entry(name).or_insert(index);
    }
    for (index, name) in names.iter().enumerate() {
        let Some(prefix) = name.strip_suffix("RY").filter(|p| p.is_empty() || p.ends_with('.')) else {
            continue;
        };
        let place = |letters: &str| places.get(format!("{prefix}{letters}").as_str()).copied();
        let (Some(y), Some(by)) = (place("Y"), place("BY")) else { continue };
        let mut channels = vec![y, index, by];
        channels.extend(place("A"));
        channels.iter().for_each(|&c| taken[c] = true);
        let path = prefix.trim_end_matches('.').to_string();
        let own = if path.is_empty() { "color".into() } else { identifier(last_field(&path)) };
        // Beside the three there may be an `a`, in the fourth place.
        let letters = if channels.len() == 4 { "yrba".into() } else { String::new() };
        let (family, shape) = (Family::LuminanceChroma, Shape::Vector(3));
        groups.push(Group { path, own, channels, letters, family, shape, sibling: false });
    }
}

/// Finds components that are told by the last letter of a name: `Px`, `Py`, `Pz`. Where what stands before the letters
/// is a known vector's name, they are one; in any case none of them is all there is of something.
fn by_last_letter(names: &[String], groups: &mut Vec<Group>) {
    let mut stems: Vec<(String, Vec<(char, usize)>)> = Vec::new();
    let mut places: HashMap<String, usize> = HashMap::new();
    for (index, name) in names.iter().enumerate() {
        let Some(letter) = name.chars().next_back().filter(|c| "xyzwXYZW".contains(*c)) else { continue };
        // `P.x` is gathered already; of letters alone at the root, small ones are not.
        let stem = &name[..name.len() - 1];
        if stem.ends_with('.') {
            continue;
        }
        // Capitals and small letters do not mix.
        let stem = format!("{stem}{}", if letter.is_ascii_uppercase() { 'X' } else { 'x' });
        let place = *places.entry(stem).or_insert_with_key(|stem| {
            stems.push((stem.clone(), Vec::new()));
            stems.len() - 1
        });
        stems[place].1.push((letter.to_ascii_lowercase(), index));
    }
    // The group of each channel that is one by itself.
    let singles = groups.iter().enumerate().filter(|(_, g)| g.family == Family::Single);
    let singles: HashMap<usize, usize> = singles.map(|(place, g)| (g.channels[0], place)).collect();
    for (stem, mut letters) in stems.into_iter().filter(|(_, letters)| letters.len() > 1) {
        for group in letters.iter().filter_map(|(_, index)| singles.get(index)) {
            groups[*group].sibling = true;
        }
        let stem = stem[..stem.len() - 1].trim_end_matches(['_', '-', ':', ' ']);
        let known = |(_, spellings): &(&str, &[&str])| spellings.contains(&key(last_field(stem)).as_str());
        let is_vector =
            |(name, _): &(&str, &[&str])| matches!(*name, "point" | "normal" | "motion" | "albedo");
        letters.sort_by_key(|(letter, _)| "xyzw".find(*letter));
        let order: String = letters.iter().map(|(letter, _)| *letter).collect();
        if stem.is_empty() || !"xyzw".starts_with(&order) || !KNOWN.iter().filter(|k| is_vector(k)).any(known)
        {
            continue;
        }
        groups.push(Group {
            path: stem.to_string(),
            own: identifier(last_field(stem)),
            channels: letters.iter().map(|(_, index)| *index).collect(),
            shape: Shape::Vector(letters.len() as u32),
            letters: order,
            family: Family::Xyz,
            sibling: false,
        });
    }
}

enum Component {
    Letter(char),
    Numbers(Vec<usize>),
    Other,
}

/// A channel's layer and component. A channel with no component is a layer by itself.
fn split(name: &str) -> (String, Component) {
    let fields: Vec<&str> = name.split('.').collect();
    let is_index = |f: &&&str| f.parse::<usize>().is_ok_and(|n| n > 0) && !f.starts_with(['0', '+']);
    let numbers = fields.iter().rev().take_while(is_index).count();
    if numbers > 0 && numbers < fields.len() {
        let (base, indices) = fields.split_at(fields.len() - numbers);
        return (base.join("."), Component::Numbers(indices.iter().filter_map(|f| f.parse().ok()).collect()));
    }
    let (layer, suffix) = name.rsplit_once('.').unwrap_or(("", name));
    let letter = match suffix {
        "red" | "Red" | "RED" => 'r',
        "green" | "Green" | "GREEN" => 'g',
        "blue" | "Blue" | "BLUE" => 'b',
        "alpha" | "Alpha" | "ALPHA" => 'a',
        _ => match suffix.as_bytes() {
            [c] if b"xyzwrgbauv".contains(&c.to_ascii_lowercase()) => char::from(c.to_ascii_lowercase()),
            _ => return (name.to_string(), Component::Other),
        },
    };
    (layer.to_string(), Component::Letter(letter))
}

fn groups_of_layer(layer: &str, members: Vec<(Component, usize)>, names: &[String], out: &mut Vec<Group>) {
    let single = |index: usize| Group {
        path: names[index].clone(),
        own: identifier(last_field(&names[index])),
        channels: vec![index],
        letters: String::new(),
        family: Family::Single,
        shape: Shape::Scalar,
        sibling: false,
    };
    let mut letters: Vec<(char, usize)> = Vec::new();
    let mut numbered: Vec<(Vec<usize>, usize)> = Vec::new();
    for (component, index) in members {
        match component {
            Component::Letter(c) if letters.iter().all(|(l, _)| *l != c) => letters.push((c, index)),
            Component::Numbers(path) => numbered.push((path, index)),
            _ => out.push(single(index)),
        }
    }
    if !numbered.is_empty() {
        numbered.sort();
        let mut channels = Vec::new();
        match nest(&numbered, 0, &mut channels) {
            Some(shape) => out.push(Group {
                path: layer.to_string(),
                own: identifier(last_field(layer)),
                channels,
                letters: String::new(),
                family: Family::Numbered,
                shape,
                sibling: false,
            }),
            // Not a whole vector, `v.2` without `v.1`: each is a scalar, named with its number.
            None => out.extend(numbered.iter().map(|(path, index)| {
                let digits: Vec<String> = path.iter().map(usize::to_string).collect();
                let own = identifier(&format!("{}_{}", last_field(layer), digits.join("_")));
                Group { own, ..single(*index) }
            })),
        }
    }
    // Sort the letters into families. A goes with R G B, else with U V, else with X Y Z.
    let has = |set: &str| letters.iter().any(|(l, _)| set.contains(*l));
    let (rgb, uv, xyz) = (has("rgb"), has("uv"), has("xyz"));
    let family_of = |c: char| match c {
        'r' | 'g' | 'b' => Family::Rgb,
        'u' | 'v' => Family::Uv,
        'x' | 'y' | 'z' => Family::Xyz,
        'w' if xyz || !uv => Family::Xyz,
        'w' => Family::Uv,
        _ if rgb => Family::Rgb,
        _ if uv => Family::Uv,
        _ => Family::Xyz,
    };
    let several = [rgb, uv, xyz].iter().filter(|&&f| f).count() > 1;
    for (family, order) in [(Family::Rgb, "rgba"), (Family::Xyz, "xyzwa"), (Family::Uv, "uvwa")] {
        let mut list: Vec<(usize, char, usize)> = letters
            .iter()
            .filter(|(c, _)| family_of(*c) == family)
            .filter_map(|&(c, index)| Some((order.find(c)?, c, index)))
            .collect();
        list.sort();
        match list.as_slice() {
            [] => {}
            // At the root a letter is a name, but for R G B: Z, A, and any program's own x or u. So is a
            // letter beside another family (main.Z). X Y Z together are a vector of which nobody knows what it is.
            _ if layer.is_empty() && family != Family::Rgb => {
                let (vector, others): (Vec<_>, Vec<_>) =
                    list.iter().partition(|(_, c, _)| family == Family::Xyz && *c != 'a');
                let mut alone = others;
                match vector.len() {
                    0 | 1 => alone.extend(vector),
                    n => out.push(Group {
                        path: String::new(),
                        own: vector.iter().map(|(_, c, _)| *c).collect(),
                        channels: vector.iter().map(|(_, _, index)| *index).collect(),
                        letters: vector.iter().map(|(_, c, _)| *c).collect(),
                        family,
                        shape: Shape::Vector(n as u32),
                        sibling: false,
                    }),
                }
                out.extend(alone.iter().map(|(_, _, index)| single(*index)));
            }
            [(_, _, index)] if layer.is_empty() || several => out.push(single(*index)),
            _ => {
                let letters: String = list.iter().map(|(_, c, _)| *c).collect();
                let own = match last_field(layer) {
                    "" => letters.clone(),
                    last if several && family != Family::Rgb => identifier(&format!("{last}_{letters}")),
                    last => identifier(last),
                };
                let shape = match list.len() {
                    1 => Shape::Scalar,
                    n => Shape::Vector(n as u32),
                };
                let channels = list.iter().map(|(_, _, index)| *index).collect();
                let path = layer.to_string();
                out.push(Group { path, own, channels, letters, family, shape, sibling: false });
            }
        }
    }
}

/// The shape that sorted numbers `1`, `2.1`, `2.2`, … spell, appending the channels in reading order;
/// `None` if one is missing or doubled.
fn nest(sorted: &[(Vec<usize>, usize)], depth: usize, channels: &mut Vec<usize>) -> Option<Shape> {
    if let [(path, index)] = sorted
        && path.len() == depth
    {
        channels.push(*index);
        return Some(Shape::Scalar);
    }
    let mut elements = Vec::new();
    let mut rest = sorted;
    while !rest.is_empty() {
        let number = *rest[0].0.get(depth)?;
        let end = rest.iter().position(|(p, _)| p.get(depth) != Some(&number)).unwrap_or(rest.len());
        if number != elements.len() + 1 {
            return None;
        }
        elements.push(nest(&rest[..end], depth + 1, channels)?);
        rest = &rest[end..];
    }
    Some(Shape::vector_of(&elements))
}
