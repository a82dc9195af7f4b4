//! Which variables are still wanted after statements.

use crate::resolve::tree::*;
use std::collections::HashMap;

/// How often each outer variable is read, as the program is written.
#[derive(Default)]
pub struct Reads(HashMap<u32, u32>);

impl Reads {
    /// By the whole program.
    pub fn of_program(program: &Resolved) -> Reads {
        let mut reads = Reads::default();
        reads.stmts(&program.body);
        reads.stmts(program.by_normal.as_deref().unwrap_or_default());
        for function in &program.functions {
            reads.stmts(&function.body);
        }
        reads
    }

    /// By some statements.
    pub fn of(stmts: &[Stmt]) -> Reads {
        let mut reads = Reads::default();
        reads.stmts(stmts);
        reads
    }

    /// How often a variable is read.
    pub fn count(&self, global: u32) -> u32 {
        self.0.get(&global).copied().unwrap_or(0)
    }

    /// Is an outer variable, of these counts, only read in this block, and each time assigned there before?
    pub fn temporary(&self, block: &[Stmt], place: Place) -> bool {
        let Place::Global(i) = place else { return false };
        if Reads::of(block).count(i) < self.count(i) {
            return false;
        }
        for stmt in block {
            match &stmt.kind {
                StmtKind::Assign { place: to, path, op: None, value, .. }
                    if *to == place && path.is_empty() =>
                {
                    let mut reads = Reads::default();
                    reads.expr(value);
                    return reads.count(i) == 0;
                }
                _ if Reads::of(std::slice::from_ref(stmt)).count(i) > 0 => return false,
                _ => {}
            }
        }
        true
    }

    fn add(&mut self, place: Place) {
        if let Place::Global(i) = place {
            *self.0.entry(i).or_default() += 1;
        }
    }

    fn stmts(&mut self, stmts: &[Stmt]) {
        for stmt in stmts {
            match &stmt.kind {
                StmtKind::Assign { place, path, op, value, .. } => {
                    if op.is_some() || !path.is_empty() {
                        self.add(*place);
                    }
                    for step in path {
                        if let Step::Index(e) = step {
                            self.expr(e);
                        }
                    }
                    self.expr(value);
                }
                StmtKind::Expr(e) | StmtKind::Return(e) => self.expr(e),
                StmtKind::If(arms, otherwise) => {
                    for (condition, block) in arms {
                        self.expr(condition);
                        self.stmts(&block.stmts);
                    }
                    self.stmts(&otherwise.stmts);
                }
                StmtKind::While(condition, body, _) => {
                    self.expr(condition);
                    self.stmts(body);
                }
                StmtKind::For(_, vector, body) => {
                    self.expr(vector);
                    self.stmts(body);
                }
                StmtKind::Break | StmtKind::Continue => {}
            }
        }
    }

    fn expr(&mut self, e: &Expr) {
        match &e.kind {
            ExprKind::Number(_) => {}
            ExprKind::Variable(place) => self.add(*place),
            ExprKind::Kept(_, a, _) | ExprKind::Unary(_, a) | ExprKind::Component(a, _) => self.expr(a),
            ExprKind::Binary(_, a, b) | ExprKind::Index(a, b) => {
                self.expr(a);
                self.expr(b);
            }
            ExprKind::Conditional(parts) => parts.iter().for_each(|e| self.expr(e)),
            ExprKind::Vector(elements) => {
                for element in elements {
                    match element {
                        Element::Item(e) => self.expr(e),
                        Element::Range(a, b) => {
                            self.expr(a);
                            self.expr(b);
                        }
                    }
                }
            }
            ExprKind::Call(_, args) | ExprKind::Builtin(_, args) | ExprKind::Host(_, args) => {
                args.iter().for_each(|e| self.expr(e));
            }
        }
    }
}
