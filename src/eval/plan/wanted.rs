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

    /// Is an outer variable, of these counts, only read in this block, and each time assigned there before? In a loop
    /// another round could read it otherwise.
    pub fn temporary(&self, block: &[Stmt], place: Place) -> bool {
        let Place::Global(i) = place else { return false };
        Reads::of(block).count(i) == self.count(i) && first(block, i) != Some(First::Read)
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
                StmtKind::Print(parts) => {
                    for part in parts {
                        if let PrintPart::Value(e) = part {
                            self.expr(e);
                        }
                    }
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

/// What happens to a variable first.
#[derive(PartialEq)]
enum First {
    /// It is assigned, whatever way is taken.
    Assigned,
    /// On some way it is read.
    Read,
}

/// What happens first to an outer variable; `None` if it may be that nothing does, and it is not read before that.
fn first(stmts: &[Stmt], global: u32) -> Option<First> {
    let reads = |e: &Expr| {
        let mut reads = Reads::default();
        reads.expr(e);
        reads.count(global) > 0
    };
    let this = Place::Global(global);
    stmts.iter().find_map(|stmt| match &stmt.kind {
        StmtKind::Assign { place, path, op: None, value, .. } if *place == this && path.is_empty() => {
            Some(if reads(value) { First::Read } else { First::Assigned })
        }
        StmtKind::If(arms, otherwise) => {
            let mut always = true;
            for block in arms.iter().map(|(_, block)| block).chain([otherwise]) {
                match first(&block.stmts, global) {
                    Some(First::Read) => return Some(First::Read),
                    Some(First::Assigned) => {}
                    None => always = false,
                }
            }
            if arms.iter().any(|(condition, _)| reads(condition)) {
                Some(First::Read)
            } else {
                always.then_some(First::Assigned)
            }
        }
        // Maybe there is no round; each begins with an element.
        StmtKind::For(place, vector, _) if *place == this => reads(vector).then_some(First::Read),
        StmtKind::While(head, body, _) | StmtKind::For(_, head, body) => {
            let read = reads(head) || first(body, global) == Some(First::Read);
            read.then_some(First::Read)
        }
        _ => (Reads::of(std::slice::from_ref(stmt)).count(global) > 0).then_some(First::Read),
    })
}
