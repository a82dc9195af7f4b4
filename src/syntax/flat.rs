//! Prints an expression on one line.

use super::ast::*;

/// Where an expression stands.
#[derive(Clone, Copy, PartialEq)]
pub enum Inside {
    /// Outside all brackets: the line cannot break at an operator.
    Line,
    /// The innermost bracket is `(`.
    Round,
    /// The innermost bracket is `[`, where blanks separate.
    Square,
}

/// `e` on one line, as it stands in `inside`; numbers and strings as `text` has them.
pub fn flat(text: &str, e: &Expr, inside: Inside) -> String {
    let mut out = String::new();
    print(text, e, inside, &mut out);
    out
}

fn print(text: &str, e: &Expr, inside: Inside, out: &mut String) {
    match &*e.kind {
        ExprKind::Number(_) | ExprKind::Text(_) => {
            out.push_str(text.get(e.span.start as usize..e.span.end as usize).unwrap_or(""))
        }
        ExprKind::Name(name) => out.push_str(name),
        ExprKind::Member(v, name) => {
            print(text, v, inside, out);
            out.push('.');
            out.push_str(&name.text);
        }
        ExprKind::Index(v, i) => {
            print(text, v, inside, out);
            out.push('[');
            print(text, i, Inside::Square, out);
            out.push(']');
        }
        ExprKind::Call(name, arguments) => {
            out.push_str(&name.text);
            out.push('(');
            for (i, argument) in arguments.iter().enumerate() {
                if i > 0 {
                    out.push_str(", ");
                }
                if let Some(name) = &argument.name {
                    out.push_str(&name.text);
                    out.push_str(" = ");
                }
                print(text, &argument.value, Inside::Round, out);
            }
            out.push(')');
        }
        ExprKind::Unary(op, e) => {
            out.push_str(op.symbol());
            print(text, e, inside, out);
        }
        ExprKind::Binary(op, a, b) => {
            print(text, a, inside, out);
            let blank = if inside == Inside::Square { "" } else { " " };
            out.push_str(blank);
            out.push_str(op.symbol());
            out.push_str(blank);
            print(text, b, inside, out);
        }
        ExprKind::Conditional(c, a, b) => {
            print(text, c, inside, out);
            out.push_str(" ? ");
            print(text, a, inside, out);
            out.push_str(" : ");
            print(text, b, inside, out);
        }
        ExprKind::Vector(elements) => {
            out.push('[');
            for (i, e) in elements.iter().enumerate() {
                if i > 0 {
                    out.push(' ');
                }
                print(text, e, Inside::Square, out);
            }
            out.push(']');
        }
        ExprKind::Range(a, b) => {
            print(text, a, inside, out);
            out.push_str(" .. ");
            print(text, b, inside, out);
        }
        ExprKind::Group(e) => {
            out.push('(');
            print(text, e, Inside::Round, out);
            out.push(')');
        }
        ExprKind::Error => {}
    }
}
