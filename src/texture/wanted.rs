//! Which of an image's variables and channels a texture is made of.

use super::COMPONENTS;
use crate::image::{ErrorKind, File, ImageError, Variable};
use crate::shape::Shape;
use crate::spelling;

/// The variables that make a texture, before they are read.
pub(super) struct Wanted {
    /// Their names.
    pub names: Vec<String>,
    /// What a look-up gives.
    pub shape: Shape,
    /// Of all their components in a row, those that are taken.
    pub components: Vec<usize>,
    /// Is there an alpha to be added, which is 1?
    pub opaque: bool,
}

/// What is known of an image's variables: name, shape, and whether all components are one channel.
pub(super) struct Known<'a> {
    name: &'a str,
    shape: Shape,
    grey: bool,
}

/// The word for colour and alpha together.
const RGBA: &str = "rgba";

/// What is known of a variable in memory.
pub(super) fn known<'a>(variable: &'a Variable<'_>) -> Known<'a> {
    Known { name: &variable.name, shape: variable.shape.clone(), grey: false }
}

/// What of a file is wanted.
///
/// # Errors
/// If it has no such thing, or several.
pub(super) fn wanted_of(file: &File, channel: Option<&str>) -> Result<Wanted, ImageError> {
    let name = file.name();
    let bindings = || file.variables().iter();
    let ambiguous = |wanted: &str| bindings().find(|b| b.name == wanted && b.candidates.len() > 1);
    if let Some(binding) = ambiguous(channel.filter(|c| *c != RGBA).unwrap_or("color")) {
        let message = format!("`{name}` has several `{}`", binding.name);
        let groups = binding.candidates.iter().map(|c| format!("This one: channel = \"{}\"", c.group));
        return Err(groups.fold(ImageError::new(ErrorKind::Ambiguous, message), ImageError::hint));
    }
    let known: Vec<Known<'_>> = bindings()
        .filter(|b| b.candidates.len() == 1 && (!b.alias || Some(b.name.as_str()) == channel))
        .map(|b| {
            let candidate = &b.candidates[0];
            let grey = candidate.channels.iter().all(|c| *c == candidate.channels[0]);
            Known { name: &b.name, shape: candidate.shape.clone(), grey }
        })
        .collect();
    wanted(&name, &known, channel)
}

/// What of an image's variables is wanted.
///
/// # Errors
/// If there is no such thing.
pub(super) fn wanted(file: &str, known: &[Known<'_>], channel: Option<&str>) -> Result<Wanted, ImageError> {
    let find = |name: &str| known.iter().find(|k| k.name == name);
    let listed = || {
        let names: Vec<&str> = known.iter().map(|k| k.name).collect();
        format!("It has {}.", names.join(", "))
    };
    let one = |found: &Known<'_>| {
        let cells = found.shape.cells();
        // The same number three times says no more than once.
        let grey = found.grey && cells > 1;
        let shape = if grey { Shape::Scalar } else { found.shape.clone() };
        let taken = if grey { 1 } else { cells };
        let fits = matches!(shape, Shape::Scalar | Shape::Vector(_)) && (1..=COMPONENTS).contains(&cells);
        if !fits {
            let message = format!("`{}` of `{file}` has {cells} components", found.name);
            return Err(ImageError::new(ErrorKind::Unsupported, message)
                .hint(format!("A texture has at most {COMPONENTS}. Name one of its channels.")));
        }
        let names = vec![found.name.to_string()];
        Ok(Wanted { names, shape, components: (0..taken).collect(), opaque: false })
    };
    match channel {
        None => match (find("color"), known) {
            (Some(color), _) | (None, [color]) => one(color),
            _ => Err(ImageError::new(ErrorKind::Missing, format!("`{file}` has no `color`"))
                .hint("Choose one of its variables: `channel = \"…\"`.")
                .hint(listed())),
        },
        Some(RGBA) if find(RGBA).is_none() => {
            let color = find("color").filter(|c| matches!(c.shape, Shape::Vector(3 | 4)) || c.grey);
            let Some(color) = color else {
                let message = format!("`{file}` has no `color`");
                return Err(ImageError::new(ErrorKind::Missing, message).hint(listed()));
            };
            let alpha = find("alpha").filter(|a| a.shape.is_scalar());
            let cells = color.shape.cells();
            let mut names = vec!["color".to_string()];
            names.extend(alpha.map(|a| a.name.to_string()));
            let mut components = vec![0, 1, 2];
            components.extend((cells == 4 || alpha.is_some()).then_some(3));
            let opaque = components.len() == 3;
            Ok(Wanted { names, shape: Shape::Vector(4), components, opaque })
        }
        Some(name) => {
            if let Some(found) = find(name) {
                return one(found);
            }
            // `point.y`, as `pse info` lists a channel.
            if let Some((variable, component)) = name.rsplit_once('.')
                && let Some(found) = find(variable)
                && let [letter] = component.as_bytes()
                && let Some(i) = b"xyzwrgba".iter().position(|l| l == letter).map(|i| i % COMPONENTS)
                && i < found.shape.cells()
            {
                let names = vec![variable.to_string()];
                return Ok(Wanted { names, shape: Shape::Scalar, components: vec![i], opaque: false });
            }
            let error = ImageError::new(ErrorKind::Missing, format!("`{file}` has no channel \"{name}\""));
            let near = spelling::nearest(name, known.iter().map(|k| k.name));
            let error = match near {
                Some(near) => error.hint(format!("Did you mean \"{near}\"?")),
                None => error,
            };
            Err(error.hint(listed()))
        }
    }
}
