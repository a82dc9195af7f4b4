//! Which variables of an image a program can see: those that it reads before it gives them a value on every way there,
//! and those that keep the image's value where it gives them none.
//!
//! A variable that is always assigned first is never the image's. So it need not be read from a file, and it does not
//! matter whether several of the file's channels could be it.

use super::tree::*;
use std::collections::HashSet;

/// For each global: whether the pixel's program may see the value that it has at the beginning.
pub(super) fn exposed(program: &Resolved) -> Vec<bool> {
    let count = program.globals.len();
    let mut walk = Walk { program, assigned: vec![false; count], exposed: vec![false; count] };
    walk.block(&program.body);
    if let Some(block) = &program.by_normal {
        walk.block(block);
    }
    for (i, global) in program.globals.iter().enumerate() {
        walk.exposed[i] |= match global.assigned {
            // What is not assigned everywhere keeps its value elsewhere.
            Some(_) => !walk.assigned[i],
            None => global.read.is_some(),
        };
    }
    walk.exposed
}

struct Walk<'p> {
    program: &'p Resolved,
    /// Which globals have a value of the program's on every way to where the walk is.
    assigned: Vec<bool>,
    exposed: Vec<bool>,
}

impl Walk<'_> {
    /// Walks through statements; gives the globals that they assign on every way through them.
    fn block(&mut self, stmts: &[Stmt]) -> Vec<u32> {
        let mut new = Vec::new();
        for stmt in stmts {
            self.stmt(stmt, &mut new);
        }
        new
    }

    fn stmt(&mut self, stmt: &Stmt, new: &mut Vec<u32>) {
        match &stmt.kind {
            StmtKind::Assign { place, path, op, value, .. } => {
                self.expr(value);
                for step in path {
                    if let Step::Index(e) = step {
                        self.expr(e);
                    }
                }
                if let Place::Global(i) = *place {
                    if op.is_some() || !path.is_empty() {
                        self.read(i);
                    }
                    self.assign(i, new);
                }
            }
            StmtKind::Expr(e) | StmtKind::Return(e) => self.expr(e),
            StmtKind::If(arms, otherwise) => {
                let mut common: Option<HashSet<u32>> = None;
                let mut meet = |assigned: Vec<u32>| {
                    let assigned: HashSet<u32> = assigned.into_iter().collect();
                    common = Some(match common.take() {
                        Some(common) => common.intersection(&assigned).copied().collect(),
                        None => assigned,
                    });
                };
                for (condition, block) in arms {
                    self.expr(condition);
                    meet(self.branch(&block.stmts));
                }
                meet(self.branch(&otherwise.stmts));
                common.into_iter().flatten().for_each(|i| self.assign(i, new));
            }
            StmtKind::While(condition, block, _) => {
                self.expr(condition);
                self.branch(block);
            }
            StmtKind::For(place, vector, block) => {
                self.expr(vector);
                let mut of_loop = Vec::new();
                if let Place::Global(i) = *place {
                    self.assign(i, &mut of_loop);
                }
                self.branch(block);
                self.forget(&of_loop);
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

    /// Statements that may not run: what they assign counts inside of them alone.
    fn branch(&mut self, stmts: &[Stmt]) -> Vec<u32> {
        let new = self.block(stmts);
        self.forget(&new);
        new
    }

    fn assign(&mut self, i: u32, new: &mut Vec<u32>) {
        if !std::mem::replace(&mut self.assigned[i as usize], true) {
            new.push(i);
        }
    }

    fn forget(&mut self, assigned: &[u32]) {
        for &i in assigned {
            self.assigned[i as usize] = false;
        }
    }

    fn read(&mut self, i: u32) {
        self.exposed[i as usize] |= !self.assigned[i as usize];
    }

    fn expr(&mut self, e: &Expr) {
        match &e.kind {
            ExprKind::Number(_) | ExprKind::Variable(Place::Local(_)) => {}
            ExprKind::Variable(Place::Global(i)) => self.read(*i),
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
            ExprKind::Call(function, args) => {
                args.iter().for_each(|e| self.expr(e));
                for &i in &self.program.functions[*function as usize].reads {
                    self.read(i);
                }
            }
            ExprKind::Builtin(_, args) | ExprKind::Host(_, args) => args.iter().for_each(|e| self.expr(e)),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::program::Program;

    /// The names that the program may see of an image, in order.
    fn seen(text: &str) -> String {
        let program = Program::compile(text).unwrap();
        let exposed = program.resolved().exposed();
        let globals = program.resolved().globals.iter().zip(exposed).filter(|(g, e)| *e && !g.library);
        let mut names: Vec<&str> = globals.map(|(g, _)| g.name.as_str()).collect();
        names.sort_unstable();
        names.join(" ")
    }

    #[test]
    fn what_is_assigned_first_is_not_the_images() {
        assert_eq!(seen("color = point"), "point");
        assert_eq!(seen("color = point\ncolor *= 2\nalpha = color.x"), "point");
        assert_eq!(seen("point"), "point");
        assert_eq!(seen("color = color * 2"), "color");
        assert_eq!(seen("color += 1"), "color");
        assert_eq!(seen("color[1] = 0"), "color");
        assert_eq!(seen("normal += point"), "normal point");
    }

    #[test]
    fn what_is_assigned_on_some_ways_keeps_its_value_on_others() {
        assert_eq!(seen("if surface\n    color = point"), "color point surface");
        assert_eq!(seen("if surface\n    color = point\nelse\n    color = normal"), "normal point surface");
        assert_eq!(
            seen("if surface == 1\n    color = white\nelse if surface\n    color = black"),
            "black color surface white"
        );
        assert_eq!(seen("for i in [1 .. 3]\n    color = i * white"), "color i white");
        assert_eq!(seen("i = 0\nwhile i < 3\n    i += 1\n    color = white"), "color white");
    }

    #[test]
    fn functions_read_what_is_there_when_they_are_called() {
        let function = "function f(x)\n    return x * color\n";
        assert_eq!(seen(&format!("{function}color = white\ncolor = f(2)")), "white");
        assert_eq!(seen(&format!("{function}alpha = f(2)\ncolor = white")), "color white");
    }
}
