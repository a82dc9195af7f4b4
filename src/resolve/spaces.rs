//! Named spaces: `transform("camera", p)` is `transform` with the matrix from the world to that space, which the frame
//! knows; `transform("object", "camera", p)` goes from the one to the other.

use super::lower::Resolver;
use super::scope::Scope;
use super::tree::{Expr, ExprKind};
use crate::builtin::{self, Builtin};
use crate::diagnostic::{Diagnostic, Span};
use crate::syntax::ast;

/// The functions that take the name of a space for a matrix.
const FUNCTIONS: [&str; 3] = ["transform", "vtransform", "ntransform"];

/// What the outer variable with a space's matrix is called: as no variable of a program can be.
const PREFIX: &str = "space ";

/// May the first arguments of this function name spaces?
pub fn names_space(function: &str) -> bool {
    FUNCTIONS.contains(&function)
}

/// The space of which this outer variable holds the matrix.
pub fn space_of(variable: &str) -> Option<&str> {
    variable.strip_prefix(PREFIX)
}

impl Resolver<'_> {
    /// A call that names spaces; `None` if it is not such a one.
    pub fn space_call(
        &mut self,
        builtin: &'static Builtin,
        args: &[ast::Argument],
        span: Span,
        scope: &mut Scope,
    ) -> Option<Expr> {
        let name = |arg: &ast::Argument| match &*arg.value.kind {
            ast::ExprKind::Text(text) => Some((text.clone(), arg.value.span)),
            _ => None,
        };
        if !FUNCTIONS.contains(&builtin.name) || !args.iter().any(|arg| name(arg).is_some()) {
            return None;
        }
        let named: Vec<(String, Span)> = args.iter().map_while(name).collect();
        let plain = args.iter().all(|arg| arg.name.is_none());
        let ([_] | [_, _], [value]) = (&named[..], &args[named.len()..]) else {
            return Some(self.no_space_call(builtin, span));
        };
        if !plain || name(value).is_some() {
            return Some(self.no_space_call(builtin, span));
        }
        let value = self.expr(&value.value, scope);
        // From a space to itself is no way at all.
        let named: Vec<(String, Span)> = match &named[..] {
            [(from, span), (to, _)] if from == to => vec![("world".to_string(), *span)],
            _ => named,
        };
        let mut matrices = named.iter().map(|(space, span)| {
            let kind = ExprKind::Variable(self.variable(&format!("{PREFIX}{space}"), *span, scope));
            Expr { kind, span: *span }
        });
        let first = matrices.next()?;
        let matrix = match matrices.next() {
            None => first,
            Some(to) => {
                let back = call("inverse", vec![first], span)?;
                call("multiply", vec![to, back], span)?
            }
        };
        let args = vec![matrix, value];
        Some(Expr { kind: ExprKind::Builtin(builtin, args), span })
    }

    fn no_space_call(&mut self, builtin: &Builtin, span: Span) -> Expr {
        let name = builtin.name;
        let what = &builtin.params[1].name;
        let error = Diagnostic::error(
            "string",
            format!("`{name}()` takes one or two spaces, and then `{what}`"),
            span,
        )
        .hint(format!("To a space: `{name}(\"camera\", {what})`."))
        .hint(format!("From one to another: `{name}(\"object\", \"world\", {what})`."));
        self.errors.push(error);
        Expr { kind: ExprKind::Number(0.0), span }
    }
}

fn call(name: &str, args: Vec<Expr>, span: Span) -> Option<Expr> {
    Some(Expr { kind: ExprKind::Builtin(builtin::find(name)?, args), span })
}
