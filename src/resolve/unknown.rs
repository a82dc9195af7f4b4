//! What to say of names that nothing in a program explains.

use super::names;
use super::tree::{Global, Resolved};
use crate::diagnostic::{Diagnostic, Span};
use crate::syntax::ast;
use crate::vocabulary;

/// What is to be said of a variable that a program reads and nothing in it assigns, by whoever knows the image that it
/// is to run on: the program, the name, and where it is read. `None`: the image has it.
pub type Doubt<'d> = dyn Fn(&Resolved, &str, Span) -> Option<Diagnostic> + 'd;

/// The names that a program gives itself.
pub fn own(program: &Resolved) -> impl Iterator<Item = &str> {
    let given = |g: &&Global| !g.library && (g.assigned.is_some() || g.framed.is_some());
    program.globals.iter().filter(given).map(|g| g.name.as_str())
}

/// The variables that the program reads and does not give itself, with the places where they are read.
pub fn unassigned(program: &Resolved) -> impl Iterator<Item = (&str, Span)> {
    let open = |g: &&Global| !g.library && g.assigned.is_none() && g.framed.is_none();
    let read = program.globals.iter().filter(open).filter_map(|g| Some((g.name.as_str(), g.read?)));
    read.filter(|(name, _)| super::space_of(name).is_none())
}

/// The doubt of one who knows no image: the usual variables of G-buffers are taken for granted.
pub fn usual(program: &Resolved, name: &str, span: Span) -> Option<Diagnostic> {
    if names::constant(name).is_some() || names::is_system(name) || names::USUAL_INPUTS.contains(&name) {
        return None;
    }
    if let Some((base, member)) = name.split_once('.') {
        // An image may be called as a variable usually is, but has no variable of one foreign letter.
        let foreign = component_meant(member).is_some() && names::USUAL_INPUTS.contains(&base);
        return foreign.then(|| no_component(base, member, span).warning());
    }
    if super::is_standard_function(name) {
        return Some(no_variable(name, span, false));
    }
    let usual = names::USUAL_INPUTS.iter().copied();
    let foreign = vocabulary::variable(name);
    if foreign.is_none()
        && let Some(near) = names::nearest(name, own(program).chain(usual))
    {
        let error = Diagnostic::error("name", format!("there is no variable `{name}`"), span);
        return Some(error.hint(format!("Did you mean `{near}`?")));
    }
    // An image may well have a `flame`, however much it looks like `frame`.
    let warning = Diagnostic::error("name", format!("the program does not assign `{name}`"), span)
        .hint("It needs an input image with this variable.")
        .warning();
    let fixed = names::CONSTANTS.iter().map(|c| c.name).chain(names::SYSTEM.iter().map(|s| s.0));
    Some(match foreign {
        Some(_) => vocabulary::instead_of_variable(name, own(program), [].into_iter())
            .into_iter()
            .fold(warning, Diagnostic::hint),
        None => match names::nearest(name, fixed) {
            Some(near) => warning.hint(format!("Or did you mean `{near}`?")),
            None => warning,
        },
    })
}

/// Adds what `#include` means here, if the text has such a line: what it would include may be what is missing.
pub fn about_includes(text: &str, error: Diagnostic) -> Diagnostic {
    let mut lines = text.lines().filter_map(|line| line.strip_prefix("#include"));
    let Some(line) = lines.find(|rest| rest.trim_start().starts_with(['"', '<'])) else { return error };
    let file = line.trim().trim_start_matches(['"', '<']);
    let file = file.split(['"', '>']).next().unwrap_or(file);
    error.hint(format!(
        "`#include` starts a comment here. To use another file's functions, write `import \"{file}\"`."
    ))
}

/// The error of a function's name where a variable is read; `gap`: with its `(` a blank away, inside `[ ]`.
pub fn no_variable(name: &str, span: Span, gap: bool) -> Diagnostic {
    let error = Diagnostic::error("name", format!("`{name}` is a function, not a variable"), span);
    error.hint(if gap {
        format!("Inside `[ ]` a space separates elements. Remove the space between `{name}` and its `(`.")
    } else {
        format!("To call it, put its arguments in brackets directly after the name: `{name}(…)`.")
    })
}

/// The component that is meant by a member which is none here: by the letters of texture coordinates, by capital
/// letters, or by its whole name.
pub fn component_meant(member: &str) -> Option<&'static str> {
    Some(match member {
        "u" | "s" | "U" | "S" | "X" => "x",
        "v" | "t" | "V" | "T" | "Y" => "y",
        "p" | "P" | "Z" => "z",
        "q" | "Q" | "W" => "w",
        "R" | "red" | "Red" => "r",
        "G" | "green" | "Green" => "g",
        "B" | "blue" | "Blue" => "b",
        "A" | "alpha" | "Alpha" => "a",
        _ => return None,
    })
}

/// The error of a member that names no component of the vector `base`.
pub fn no_component(base: &str, member: &str, span: Span) -> Diagnostic {
    if matches!(base, "depth" | "surface" | "alpha") && component_meant(member).is_some() {
        return Diagnostic::error("name", format!("`{base}` is a number and has no components"), span)
            .hint(format!("Remove `.{member}`: `{base}`."));
    }
    let error = Diagnostic::error("name", format!("a vector has no component called `{member}`"), span);
    let error = match component_meant(member) {
        Some(component) => error.hint(format!("Write `{base}.{component}`.")),
        None => error,
    };
    error.hint("Components are `.x .y .z .w`, which are the same as `.r .g .b .a`. Any can be counted from 1: `v[3]`.")
}

/// Several components at once, as shading languages write them: `xyz`, `rg`.
pub fn is_swizzle(member: &str) -> bool {
    let of = |set: &str| member.chars().all(|c| set.contains(c));
    (2..=4).contains(&member.len()) && (of("xyzw") || of("rgba"))
}

pub(super) fn no_swizzle(base: &ast::Expr, member: &ast::Name) -> Diagnostic {
    let indices: Vec<String> = member
        .text
        .chars()
        .filter_map(|c| names::component(&c.to_string()))
        .map(|i| (i + 1).to_string())
        .collect();
    let indices = indices.join(" ");
    let v = match &*base.kind {
        ast::ExprKind::Name(name) => name,
        _ => "v",
    };
    Diagnostic::error("name", format!("`.{}` names several components", member.text), member.span)
        .hint(format!("Pick them by their numbers: `{v}[[{indices}]]`."))
}
