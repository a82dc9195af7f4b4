//! `print(…)`: a statement that is written as a call.

use super::lower::Resolver;
use super::scope::Scope;
use super::tree::{ExprKind, PrintPart, StmtKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::syntax::ast;

/// What it is called. A program's own function of that name hides it.
pub const NAME: &str = "print";

/// As a call is written.
pub const SIGNATURE: &str = "print(e, …)";

/// What it does, in one line.
pub const BRIEF: &str = "Prints values and texts of the current pixel, as a line on standard error.";

/// More of it, in Markdown.
pub const DOC: &str = "`print` is a statement: put it alone on its line; it has no value. It takes any number of values, and \
    texts in quotes. A run prints the lines of the first pixels, row by row, 10 lines by default; `--print N` changes \
    the number. `pse trace` prints the lines of any pixel, and `pse repl` those of the current pixel.";

impl Resolver<'_> {
    /// What is printed, if that is what the expression does.
    pub fn print_arguments<'e>(&self, e: &'e ast::Expr) -> Option<&'e [ast::Argument]> {
        match &*e.kind {
            ast::ExprKind::Call(name, args) if name.text == NAME => {
                let own = self.own.contains_key(NAME) || self.hosts.contains_key(NAME);
                (!own).then_some(args)
            }
            _ => None,
        }
    }

    /// The statement.
    pub fn print(&mut self, args: &[ast::Argument], scope: &mut Scope) -> StmtKind {
        if let Some(current) = self.current {
            self.out.functions[current as usize].prints = true;
        }
        let mut parts = Vec::with_capacity(args.len());
        for ast::Argument { name, value } in args {
            if let Some(name) = name {
                let error = Diagnostic::error(
                    "arity",
                    format!("`{NAME}()` has no parameter `{}`", name.text),
                    name.span,
                );
                let text = self.sources.text(value.span);
                let hint = format!(
                    "To print the name too, write it as a text: `{NAME}(\"{}\", {text})`.",
                    name.text
                );
                self.errors.push(error.hint(hint));
            }
            parts.push(match &*value.kind {
                ast::ExprKind::Text(text) => PrintPart::Text(text.clone()),
                _ => PrintPart::Value(self.expr(value, scope)),
            });
        }
        StmtKind::Print(parts)
    }

    /// The error of a call whose value is wanted.
    pub fn no_print(&mut self, args: &[ast::Argument], span: Span, scope: &mut Scope) -> Option<ExprKind> {
        for arg in args {
            if !matches!(&*arg.value.kind, ast::ExprKind::Text(_)) {
                self.expr(&arg.value, scope);
            }
        }
        let error = Diagnostic::error("place", format!("`{NAME}()` gives no value"), span)
            .label(span, "a value is expected here")
            .hint("It is a statement: write it on a line of its own.");
        self.errors.push(error);
        None
    }
}
