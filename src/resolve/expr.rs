//! Expressions: from names to slots.

use super::lower::Resolver;
use super::names;
use super::scope::Scope;
use super::tree::*;
use super::unknown::{is_swizzle, no_component, no_swizzle, no_variable};
use crate::diagnostic::{Diagnostic, Span};
use crate::stack;
use crate::syntax::{MAX_DEPTH, ast};
use crate::vocabulary;

/// Expressions and blocks inside of others, with the defaults of calls. Later walks over the tree have no other bound.
pub(super) const MAX_LEVELS: u32 = 2 * MAX_DEPTH;

impl Resolver<'_> {
    /// A variable that is read.
    pub fn variable(&mut self, name: &str, span: Span, scope: &Scope) -> Place {
        if let Some(&slot) = scope.locals.as_ref().and_then(|l| l.get(name)) {
            return Place::Local(slot);
        }
        let slot = self.global(name, scope.library);
        let known = self.out.globals[slot as usize].assigned.is_some()
            || self.out.globals[slot as usize].framed.is_some()
            || names::constant(name).is_some()
            || names::is_system(name);
        if !known && self.is_function(name) {
            let behind = self.sources.get(span.source).text.get(span.end as usize..).unwrap_or("");
            let gap =
                behind.starts_with([' ', '\t']) && behind.trim_start_matches([' ', '\t']).starts_with('(');
            // Of a built-in function's name an image may yet have a variable: binding to one will tell.
            if gap || !super::is_standard_function(name) {
                self.errors.push(no_variable(name, span, gap));
                return Place::Global(slot);
            }
        }
        let frame_value = self.out.globals[slot as usize].framed.is_some() || names::is_frame_constant(name);
        if scope.frame && !frame_value {
            self.errors.push(self.pixel_in_frame(name, span, None, scope.param));
        }
        self.out.globals[slot as usize].read.get_or_insert(span);
        if let Some(current) = self.current {
            self.out.functions[current as usize].reads.insert(slot);
        }
        Place::Global(slot)
    }

    /// The error of a pixel's variable in the frame's program.
    pub fn pixel_in_frame(&self, name: &str, span: Span, read: Option<Span>, param: bool) -> Diagnostic {
        let usual = names::USUAL_INPUTS.contains(&name) || names::is_system(name);
        let assigned =
            self.ids.get(&(false, name.to_string())).and_then(|&i| self.out.globals[i as usize].assigned);
        let mut error = match self.instead_of_frame_variable(name) {
            hints if !usual && assigned.is_none() && !hints.is_empty() => hints.into_iter().fold(
                Diagnostic::error("name", format!("there is no frame variable `{name}`"), span),
                Diagnostic::hint,
            ),
            _ => Diagnostic::error("frame", format!("`{name}` has no value before the pixels run run"), span)
                .label(span, "runs once a frame, before any pixel")
                .hint(if param {
                    format!(
                        "A param has one value for the whole frame, and `{name}` differs from pixel to pixel. Use an \
                         assignment instead of `param`."
                    )
                } else {
                    format!(
                        "`{name}` differs from pixel to pixel. Move the lines that read it out of the block of `if begin_frame`."
                    )
                }),
        };
        if matches!(name, "pixelsize" | "pixel_freq") && !self.sources.text(span).contains(name) {
            error = error.hint("A default value of the function reads it. Give that argument, as in `turbulence(p, high = 64)`.");
        }
        if let Some(read) = read {
            error = error.label(read, format!("`{name}` is read here"));
        }
        error
    }

    /// What may be meant by a variable that no frame has.
    fn instead_of_frame_variable(&self, name: &str) -> Vec<String> {
        if !self.is_shown() {
            return Vec::new();
        }
        let own = self.out.globals.iter().filter(|g| g.is_frame()).map(|g| g.name.as_str());
        let constants = names::CONSTANTS.iter().map(|c| c.name).chain(names::FRAME.iter().copied());
        vocabulary::instead_of_variable(name, own, constants.chain(names::USUAL_INPUTS.iter().copied()))
    }

    pub fn expr(&mut self, e: &ast::Expr, scope: &mut Scope) -> Expr {
        if stack::is_low() {
            return stack::grow(|| self.expr(e, scope));
        }
        if !self.nesting.enter(MAX_LEVELS) {
            self.too_deep(e.span);
            return Expr { kind: ExprKind::Number(0.0), span: e.span };
        }
        let resolved = self.expr_here(e, scope);
        self.nesting.leave();
        resolved
    }

    /// Reports the first part of the program that is nested too deep.
    pub fn too_deep(&mut self, span: Span) {
        const CODE: &str = "nesting";
        if self.errors.iter().any(|error| error.code == CODE) {
            return;
        }
        let mut error = Diagnostic::error(CODE, "this is nested too deep", span)
            .hint("Assign a part of it to a variable, or move a block into a function.");
        if !self.defaults.is_empty() {
            error = error.hint("It is in the default of a parameter, which counts in each call that leaves the argument out.");
        }
        self.errors.push(error);
    }

    fn expr_here(&mut self, e: &ast::Expr, scope: &mut Scope) -> Expr {
        use ast::ExprKind as Written;
        let kind = match &*e.kind {
            Written::Number(x) => ExprKind::Number(*x),
            Written::Text(text) => {
                let message = format!("a value is expected here, and the string \"{text}\" was found");
                let error = Diagnostic::error("string", message, e.span).hint(
                    "Values are numbers and vectors. Use a string only as a function's argument that takes a name, as in \
                     `Noise(p, kind = \"gradient\")`.",
                );
                self.errors.push(error);
                ExprKind::Number(0.0)
            }
            Written::Name(name) => ExprKind::Variable(self.variable(name, e.span, scope)),
            Written::Member(base, member) => self.member(base, member, e.span, scope),
            Written::Index(base, index) => {
                let base = self.expr(base, scope);
                ExprKind::Index(Box::new(base), Box::new(self.expr(index, scope)))
            }
            Written::Call(name, args) => return self.call(name, args, e.span, scope),
            Written::Unary(op, a) => ExprKind::Unary(*op, Box::new(self.expr(a, scope))),
            Written::Binary(op, a, b) => {
                let a = self.expr(a, scope);
                ExprKind::Binary(*op, Box::new(a), Box::new(self.expr(b, scope)))
            }
            Written::Conditional(c, a, b) => {
                let c = self.expr(c, scope);
                let a = self.expr(a, scope);
                ExprKind::Conditional(Box::new([c, a, self.expr(b, scope)]))
            }
            Written::Vector(elements) => {
                let elements = elements.iter().map(|element| self.element(element, scope)).collect();
                ExprKind::Vector(elements)
            }
            Written::Range(..) => {
                let error = Diagnostic::error("place", "a range is only allowed inside [ ]", e.span)
                    .hint("Put it in brackets: `[1 .. 10]`.");
                self.errors.push(error);
                ExprKind::Number(0.0)
            }
            Written::Group(inner) => return self.expr(inner, scope),
            Written::Error => ExprKind::Number(0.0),
        };
        Expr { kind, span: e.span }
    }

    fn element(&mut self, element: &ast::Expr, scope: &mut Scope) -> Element {
        match &*element.kind {
            ast::ExprKind::Range(a, b) => {
                let a = self.expr(a, scope);
                Element::Range(a, self.expr(b, scope))
            }
            _ => Element::Item(self.expr(element, scope)),
        }
    }

    /// `a.b`: a component of the vector `a`, or the variable `b` of the image `a`.
    fn member(&mut self, base: &ast::Expr, member: &ast::Name, span: Span, scope: &mut Scope) -> ExprKind {
        if let Some(i) = names::component(&member.text) {
            let base = self.expr(base, scope);
            return ExprKind::Component(Box::new(base), i);
        }
        if is_swizzle(&member.text) {
            self.expr(base, scope);
            self.errors.push(no_swizzle(base, member));
            return ExprKind::Number(0.0);
        }
        match self.image_name(base, scope) {
            Some(image) => {
                let full = format!("{image}.{}", member.text);
                ExprKind::Variable(self.variable(&full, span, scope))
            }
            None => {
                self.expr(base, scope);
                let written = match &*base.kind {
                    ast::ExprKind::Name(name) => name,
                    _ => "v",
                };
                self.errors.push(no_component(written, &member.text, member.span));
                ExprKind::Number(0.0)
            }
        }
    }

    /// The name of an image before a member: `bg`, or with a view of that image `bg.left`.
    fn image_name(&self, base: &ast::Expr, scope: &Scope) -> Option<String> {
        match &*base.kind {
            ast::ExprKind::Name(image) => {
                let is_local = scope.locals.as_ref().is_some_and(|l| l.contains_key(image));
                (!is_local && !self.is_assigned(image)).then(|| image.clone())
            }
            ast::ExprKind::Member(image, view) => {
                let ast::ExprKind::Name(_) = &*image.kind else { return None };
                let is_component = names::component(&view.text).is_some() || is_swizzle(&view.text);
                let image = self.image_name(image, scope).filter(|_| !is_component)?;
                Some(format!("{image}.{}", view.text))
            }
            _ => None,
        }
    }

    /// Does the program give a variable of that name a value?
    pub fn is_assigned(&self, name: &str) -> bool {
        self.ids.get(&(false, name.to_string())).is_some_and(|&i| {
            let global = &self.out.globals[i as usize];
            global.assigned.is_some() || global.framed.is_some()
        })
    }
}
