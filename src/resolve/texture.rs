//! Calls that name images: found, looked into, and numbered, before any pixel.

use super::lower::Resolver;
use super::names;
use super::tree::{Expr, ExprKind};
use crate::builtin::{Asked, Builtin};
use crate::diagnostic::{Diagnostic, Span};
use crate::image::{ErrorKind, ImageError};
use crate::texture::{Filter, Layout, Source};

/// An image that cannot be looked up, as an error of the place that names it.
pub(crate) fn unreadable(error: ImageError, span: Span) -> Diagnostic {
    error.hints.into_iter().fold(Diagnostic::error("texture", error.message, span), Diagnostic::hint)
}

fn is_empty(e: &Expr) -> bool {
    matches!(&e.kind, ExprKind::Vector(elements) if elements.is_empty())
}

/// Does the look-up in an image take the mean over the width of the pixel, because none is given?
pub(super) fn takes_pixels_width(builtin: &Builtin, args: &[Expr]) -> bool {
    let number = |i: usize| match args[i].kind {
        ExprKind::Number(x) => x as usize,
        _ => 0,
    };
    let width = Asked::of(builtin, number).and_then(|asked| asked.width);
    let given = |e: &Expr| match &e.kind {
        // What is the same at all pixels has been wrapped already, when this is asked again.
        ExprKind::Kept(_, inner, _) => !is_empty(inner),
        _ => !is_empty(e),
    };
    width.is_some_and(|i| !given(&args[i]))
}

impl Resolver<'_> {
    /// Finds the image that a call names, and gives the call its number. `None` after an error; a call of another
    /// function is left alone.
    pub fn texture(&mut self, builtin: &Builtin, args: &mut [Expr]) -> Option<()> {
        let number = |i: usize| match args[i].kind {
            ExprKind::Number(x) => x,
            _ => f32::NAN,
        };
        let Some(asked) = Asked::of(builtin, |i| number(i) as usize) else { return Some(()) };
        self.out.derivatives |= takes_pixels_width(builtin, args);
        let (name, span) = self.texts.get(number(0) as usize)?.clone();
        let channel = Some(number(asked.channel)).filter(|n| !n.is_nan()).map(|n| &self.texts[n as usize]);
        let channel = channel.filter(|(text, _)| !text.is_empty()).cloned();
        if asked.layout == Layout::Cube && asked.filter == Filter::Sums {
            let error = Diagnostic::error("texture", "a cube has no summed-area table", span);
            self.errors.push(error.hint("Use `filter = \"mip\"`."));
            return None;
        }
        let width = builtin.params.iter().position(|p| p.name == "width");
        if let Some(width) = width.filter(|&i| asked.width.is_none() && !is_empty(&args[i])) {
            let error =
                Diagnostic::error("texture", "`width` has no effect with this filter", args[width].span);
            self.errors.push(error.hint("Remove it, or use `filter = \"mip\"` or `filter = \"sat\"`."));
            return None;
        }
        let program = self.sources.get(span.source).name.clone();
        let origin = match self.host.image(&program, &name) {
            Ok(origin) => origin,
            Err(why) => {
                let error = Diagnostic::error("texture", format!("cannot find the image \"{name}\""), span)
                    .label(span, why.message());
                let known = if self.is_shown() { self.host.images(&program, &name) } else { Vec::new() };
                let near = names::nearest(&name, known.iter().map(String::as_str));
                let near = near.map(|near| format!("Did you mean \"{near}\"?"));
                self.errors
                    .push(near.into_iter().chain(self.host.image_hint()).fold(error, Diagnostic::hint));
                return None;
            }
        };
        let named = channel.as_ref().map(|(text, _)| text.as_str());
        let source = Source::new(&name, origin, named, asked.raw, asked.layout);
        let place = match self.out.textures.iter().position(|(known, _)| known.same(&source)) {
            Some(place) => place,
            None => {
                if let Err(error) = source.check() {
                    let of_channel = matches!(
                        error.kind,
                        ErrorKind::Missing | ErrorKind::Ambiguous | ErrorKind::Unsupported
                    );
                    let place = channel.filter(|_| of_channel).map_or(span, |(_, span)| span);
                    self.errors.push(unreadable(error, place));
                    return None;
                }
                self.out.textures.push((source, span));
                self.out.textures.len() - 1
            }
        };
        let needs = &mut self.out.textures[place].0.needs;
        needs.levels |= asked.filter == Filter::Mip;
        needs.sums |= asked.filter == Filter::Sums;
        args[0].kind = ExprKind::Number(place as f32);
        Some(())
    }
}
