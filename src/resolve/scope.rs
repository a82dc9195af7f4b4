//! Which names are whose: the locals of a function, the variables of the outer level.

use crate::syntax::ast::{Stmt, StmtKind};
use std::collections::HashMap;

/// What surrounds the statements that are being resolved.
#[derive(Default)]
pub(super) struct Scope {
    /// In a function: its local slots by name.
    pub locals: Option<HashMap<String, u32>>,
    /// In the library: outer names are the system's, never the program's.
    pub library: bool,
    /// In what runs once a frame.
    pub frame: bool,
    /// In what runs once a frame: in a `param` line?
    pub param: bool,
    /// In how many loops.
    pub loops: usize,
    /// In how many blocks of any kind.
    pub blocks: usize,
}

/// Calls `f` with every name that the statements assign, in order, with its span; functions' blocks are left out.
pub fn assigned<'a>(body: &'a [Stmt], f: &mut impl FnMut(&'a crate::syntax::ast::Name)) {
    for stmt in body {
        match &stmt.kind {
            StmtKind::Assign { target, .. } => f(&target.name),
            StmtKind::If { arms, otherwise } => {
                arms.iter().for_each(|(_, block)| assigned(block, f));
                otherwise.iter().for_each(|block| assigned(block, f));
            }
            StmtKind::While(_, block) => assigned(block, f),
            StmtKind::For(name, _, block) => {
                f(name);
                assigned(block, f);
            }
            _ => {}
        }
    }
}
