//! What to say of a variable that a program reads and its image does not have.

use super::bind::Missing;
use super::spaces;
use crate::diagnostic::{Diagnostic, Span};
use crate::resolve::tree::Resolved;
use crate::resolve::{is_standard_function, names, unknown};
use crate::vocabulary;

/// The error of a variable that neither the program nor the image has. `has` are the variables of the image that are
/// known by name; `missing` says more about those that are not. `camera`: why the position of the eye is unknown.
pub fn absent(
    program: &Resolved,
    name: &str,
    span: Span,
    has: &[String],
    missing: Option<&Missing<'_>>,
    camera: Option<&str>,
) -> Diagnostic {
    let add = |error: Diagnostic, hints: Vec<String>| hints.into_iter().fold(error, Diagnostic::hint);
    if let Some((base, member)) = name.split_once('.') {
        let error = Diagnostic::error("input", format!("the input has no variable `{name}`"), span);
        // With the component behind it, so that the answer can be copied.
        let hints = of_image(&format!("{name}{}", component_behind(program, span)), has, missing);
        let is_variable = names::USUAL_INPUTS.contains(&base) || has.iter().any(|v| v == base);
        let is_image = missing.is_some() && !hints.iter().any(|hint| hint.starts_with(NO_IMAGE))
            || has.iter().any(|v| v.split_once('.').is_some_and(|(image, _)| image == base));
        // Of an image that is not there a component of its variable may be meant, too.
        return match is_variable && !is_image {
            true => unknown::no_component(base, member, span),
            false => add(error, hints),
        };
    }
    if names::USUAL_INPUTS.contains(&name) {
        let error = Diagnostic::error("input", format!("the input has no variable `{name}`"), span);
        let error = match name {
            "I" => error.hint(
                "`I` is the direction from the eye to the point. Renderers do not write it. If you \
                 know the eye, write `param eye = [0 -5 5]` and `I = direction(point - eye)`.",
            ),
            _ => error,
        };
        let camera = camera.into_iter().chain([spaces::CAMERA]).filter(|_| name == "I");
        let error = camera.fold(error, |error, hint| error.hint(hint));
        return add(error, of_image(name, has, missing));
    }
    if is_standard_function(name) {
        return unknown::no_variable(name, span, false);
    }
    if name == "eye" {
        return spaces::no_eye(span, camera);
    }
    let error = Diagnostic::error("name", format!("there is no variable `{name}`"), span)
        .label(span, "not assigned, and not in the input");
    let error = unknown::about_includes(&program.sources.get(span.source).text, error);
    if matches!(name, "camera" | "world" | "screen" | "object") {
        return error.hint(format!("Write the name of a space in quotes: `transform(\"{name}\", point)`."));
    }
    let others = has.iter().map(String::as_str);
    let fixed = names::CONSTANTS.iter().map(|c| c.name).chain(names::SYSTEM.iter().map(|(n, _)| *n));
    let mut likely = vocabulary::instead_of_variable(name, unknown::own(program), others.chain(fixed));
    // The host may know of variables that it did not load.
    let mut hints =
        if missing.is_some() || !has.is_empty() { of_image(name, has, missing) } else { Vec::new() };
    let guess = |hint: &String| hint.starts_with("Did you mean");
    if !likely.is_empty() {
        hints.retain(|hint| !guess(hint));
    } else if !hints.iter().any(guess) {
        likely.push(format!("Give it a value in a line above: `{name} = 1`."));
    }
    add(error, likely.into_iter().chain(hints).collect())
}

/// How a hint begins that says that no image of that name was given.
pub const NO_IMAGE: &str = "No input is called";

/// What is known of a variable that the image does not have.
pub(super) fn of_image(name: &str, has: &[String], missing: Option<&Missing<'_>>) -> Vec<String> {
    match missing {
        Some(missing) => missing(name),
        None if has.is_empty() => vec!["There is no input image.".into()],
        None => vec![format!("The input has {}.", has.join(", "))],
    }
}

/// The component that is written behind a variable: `.g`.
fn component_behind(program: &Resolved, span: Span) -> &str {
    let behind = program.sources.get(span.source).text.get(span.end as usize..).unwrap_or("");
    let end = behind.get(1..).and_then(|rest| rest.find(|c: char| !(c.is_alphanumeric() || c == '_')));
    let member = &behind[..end.map_or(behind.len(), |end| end + 1)];
    let is_component = member.strip_prefix('.').is_some_and(|member| names::component(member).is_some());
    if is_component { member } else { "" }
}
