//! The tree in a readable form, one node a line, without places.

use super::ast::*;
use std::fmt::Write;

/// The tree of a program as indented lines, as `pse ast` prints it.
pub fn tree(module: &Module) -> String {
    let mut dump = Dump { out: String::new(), depth: 0 };
    dump.body(&module.body);
    dump.out
}

struct Dump {
    out: String,
    depth: usize,
}

impl Dump {
    fn line(&mut self, text: impl std::fmt::Display) {
        // Writing to a String cannot fail.
        let _ = writeln!(self.out, "{:width$}{text}", "", width = 2 * self.depth);
    }

    fn inside(&mut self, head: impl std::fmt::Display, children: impl FnOnce(&mut Dump)) {
        self.line(head);
        self.depth += 1;
        children(self);
        self.depth -= 1;
    }

    fn body(&mut self, body: &[Stmt]) {
        for stmt in body {
            self.stmt(stmt);
        }
    }

    fn stmt(&mut self, stmt: &Stmt) {
        match &stmt.kind {
            StmtKind::Assign { target, op, value } => {
                let op = op.map_or("", BinaryOp::symbol);
                self.inside(format!("assign {op}="), |d| {
                    d.inside(format!("target {}", target.name.text), |d| {
                        for access in &target.path {
                            match access {
                                Access::Index(i) => d.inside("index", |d| d.expr(i)),
                                Access::Member(n) => d.line(format!("member {}", n.text)),
                            }
                        }
                    });
                    d.expr(value);
                });
            }
            StmtKind::Expr(e) => self.inside("expression", |d| d.expr(e)),
            StmtKind::If { arms, otherwise } => {
                for (i, (condition, block)) in arms.iter().enumerate() {
                    self.inside(if i == 0 { "if" } else { "else if" }, |d| {
                        d.expr(condition);
                        d.inside("then", |d| d.body(block));
                    });
                }
                if let Some(block) = otherwise {
                    self.inside("else", |d| d.body(block));
                }
            }
            StmtKind::While(condition, block) => self.inside("while", |d| {
                d.expr(condition);
                d.inside("do", |d| d.body(block));
            }),
            StmtKind::For(name, vector, block) => self.inside(format!("for {}", name.text), |d| {
                d.inside("in", |d| d.expr(vector));
                d.inside("do", |d| d.body(block));
            }),
            StmtKind::Break => self.line("break"),
            StmtKind::Continue => self.line("continue"),
            StmtKind::Return(e) => self.inside("return", |d| d.expr(e)),
            StmtKind::Function(f) => self.inside(format!("function {}", f.name.text), |d| {
                for (name, default) in &f.params {
                    d.inside(format!("parameter {}", name.text), |d| {
                        if let Some(default) = default {
                            d.expr(default);
                        }
                    });
                }
                d.inside("do", |d| d.body(&f.body));
            }),
            StmtKind::Param { name, value, range } => self.inside(format!("param {}", name.text), |d| {
                d.expr(value);
                if let Some(range) = range {
                    d.inside("in", |d| d.expr(range));
                }
            }),
            StmtKind::Import(path, _) => self.line(format!("import {path:?}")),
        }
    }

    fn expr(&mut self, e: &Expr) {
        match &*e.kind {
            ExprKind::Number(n) => self.line(n),
            ExprKind::Text(t) => self.line(format!("{t:?}")),
            ExprKind::Name(n) => self.line(n),
            ExprKind::Member(e, n) => self.inside(format!("member {}", n.text), |d| d.expr(e)),
            ExprKind::Index(e, i) => self.inside("index", |d| {
                d.expr(e);
                d.expr(i);
            }),
            ExprKind::Call(name, arguments) => self.inside(format!("call {}", name.text), |d| {
                for argument in arguments {
                    match &argument.name {
                        Some(name) => d.inside(format!("{} =", name.text), |d| d.expr(&argument.value)),
                        None => d.expr(&argument.value),
                    }
                }
            }),
            ExprKind::Unary(op, e) => self.inside(op.symbol(), |d| d.expr(e)),
            ExprKind::Binary(op, a, b) => self.inside(op.symbol(), |d| {
                d.expr(a);
                d.expr(b);
            }),
            ExprKind::Conditional(c, a, b) => self.inside("? :", |d| {
                d.expr(c);
                d.expr(a);
                d.expr(b);
            }),
            ExprKind::Vector(elements) => self.inside("[ ]", |d| {
                for e in elements {
                    d.expr(e);
                }
            }),
            ExprKind::Range(a, b) => self.inside("..", |d| {
                d.expr(a);
                d.expr(b);
            }),
            ExprKind::Group(e) => self.inside("( )", |d| d.expr(e)),
            ExprKind::Error => self.line("error"),
        }
    }
}
