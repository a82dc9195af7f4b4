//! What a block touches: which variables it reads and assigns, whether it can be left halfway, and how much work it
//! is. By that the evaluator decides whether to gather the active lanes of a batch before it runs the block.

use super::texture;
use super::tree::*;
use crate::builtin::{Kernel, ParamKind};
use std::collections::BTreeSet;
use std::sync::Arc;

/// A loop is counted as so many rounds.
const ROUNDS: u32 = 8;
/// The work of a function whose own is not known yet, as in recursion.
const UNKNOWN: u32 = 64;
/// No work is counted higher than this.
const MOST: u32 = 1 << 20;

/// Notes the effects of every block of an `if`, and of every `while` loop. Gives what each statement of the outer level
/// touches.
pub(super) fn mark(program: &mut Resolved) -> Vec<Seen> {
    let reads: Vec<Vec<u32>> = program.functions.iter().map(|f| f.reads.iter().copied().collect()).collect();
    let count = program.functions.len();
    let prints = program.functions.iter().map(|f| f.prints).collect();
    let no = vec![false; count];
    let mut marker = Marker { reads, prints, work: vec![UNKNOWN; count], shadows: no.clone(), derives: no };
    // At least twice, so that most functions are known when a call of them is weighed.
    let mut passes = 0;
    let mut grew = true;
    while passes < 2 || grew {
        (passes, grew) = (passes + 1, false);
        for i in 0..program.functions.len() {
            let mut seen = Seen::default();
            let mut body = std::mem::take(&mut program.functions[i].body);
            marker.block(&mut body, &mut seen);
            program.functions[i].body = body;
            marker.work[i] = seen.work;
            grew |= seen.shadows && !marker.shadows[i] || seen.derives && !marker.derives[i];
            marker.shadows[i] |= seen.shadows;
            marker.derives[i] |= seen.derives;
        }
    }
    let seen: Vec<Seen> = program
        .body
        .iter_mut()
        .map(|stmt| {
            let mut seen = Seen::default();
            marker.block(std::slice::from_mut(stmt), &mut seen);
            seen
        })
        .collect();
    if program.derivatives {
        program.shadowed = shadowed(&seen);
    }
    if let Some(block) = &mut program.by_normal {
        marker.block(block, &mut Seen::default());
    }
    seen
}

/// Which of the outer statements shadows have to run: those that ask for derivatives, and those that assign what such
/// statements read or assign.
fn shadowed(body: &[Seen]) -> Vec<bool> {
    needed(body, BTreeSet::new(), |seen| seen.shadows)
}

/// Which of the outer statements are `wanted` or assign what is `touched`, and those that assign what such statements read
/// or assign.
pub(super) fn needed(
    body: &[Seen],
    mut touched: BTreeSet<Place>,
    wanted: impl Fn(&Seen) -> bool,
) -> Vec<bool> {
    let mut needed = vec![false; body.len()];
    loop {
        let before = touched.len();
        for (seen, needed) in body.iter().zip(&mut needed) {
            if *needed || wanted(seen) || seen.writes.iter().any(|place| touched.contains(place)) {
                *needed = true;
                touched.extend(seen.reads.iter().chain(&seen.writes));
            }
        }
        if touched.len() == before {
            return needed;
        }
    }
}

struct Marker {
    /// The globals that each function reads.
    reads: Vec<Vec<u32>>,
    /// Whether a call of each prints.
    prints: Vec<bool>,
    /// The work of a call of each.
    work: Vec<u32>,
    /// Whether a call of each looks at shadows.
    shadows: Vec<bool>,
    /// Whether a call of each cannot do without them.
    derives: Vec<bool>,
}

/// What has been seen of a block so far.
#[derive(Default)]
pub(super) struct Seen {
    pub reads: Vec<Place>,
    pub writes: Vec<Place>,
    /// `break` and `continue` of a loop around.
    breaks: bool,
    returns: bool,
    /// Derivatives, or look-ups that may take their width from them.
    pub shadows: bool,
    /// Derivatives, or look-ups that do take their width from them.
    pub derives: bool,
    prints: bool,
    work: u32,
}

impl Seen {
    fn read(&mut self, place: Place) {
        if !self.reads.contains(&place) {
            self.reads.push(place);
        }
    }

    fn write(&mut self, place: Place) {
        if !self.writes.contains(&place) {
            self.writes.push(place);
        }
    }

    fn add(&mut self, work: u32) {
        self.work = self.work.saturating_add(work).min(MOST);
    }

    /// Adds what a part does, which is run so many times.
    fn include(&mut self, part: &Seen, times: u32) {
        part.reads.iter().for_each(|&place| self.read(place));
        part.writes.iter().for_each(|&place| self.write(place));
        self.breaks |= part.breaks;
        self.returns |= part.returns;
        self.shadows |= part.shadows;
        self.derives |= part.derives;
        self.prints |= part.prints;
        self.add(part.work.saturating_mul(times));
    }

    fn effects(&self) -> Arc<Effects> {
        Arc::new(Effects {
            reads: self.reads.iter().filter(|place| !self.writes.contains(place)).copied().collect(),
            writes: self.writes.iter().copied().collect(),
            leaves: self.breaks || self.returns,
            prints: self.prints,
            work: self.work,
        })
    }
}

impl Marker {
    fn block(&self, block: &mut [Stmt], seen: &mut Seen) {
        for stmt in block {
            match &mut stmt.kind {
                StmtKind::Assign { place, path, value, .. } => {
                    seen.write(*place);
                    for step in path {
                        if let Step::Index(e) = step {
                            self.expr(e, seen);
                        }
                    }
                    self.expr(value, seen);
                }
                StmtKind::Expr(e) => self.expr(e, seen),
                StmtKind::Return(e) => {
                    seen.returns = true;
                    self.expr(e, seen);
                }
                StmtKind::If(arms, otherwise) => {
                    for (condition, block) in arms {
                        self.expr(condition, seen);
                        self.part(block, seen);
                    }
                    self.part(otherwise, seen);
                }
                StmtKind::While(condition, body, effects) => {
                    let mut part = Seen::default();
                    self.expr(condition, &mut part);
                    self.block(body, &mut part);
                    // It is the loop itself that they leave.
                    part.breaks = false;
                    *effects = part.effects();
                    seen.include(&part, ROUNDS);
                }
                StmtKind::For(place, vector, body) => {
                    self.expr(vector, seen);
                    let mut part = Seen::default();
                    part.write(*place);
                    self.block(body, &mut part);
                    part.breaks = false;
                    seen.include(&part, ROUNDS);
                }
                StmtKind::Print(parts) => {
                    seen.prints = true;
                    for part in parts {
                        if let PrintPart::Value(e) = part {
                            self.expr(e, seen);
                        }
                    }
                }
                StmtKind::Break | StmtKind::Continue => seen.breaks = true,
            }
        }
    }

    fn part(&self, block: &mut Block, seen: &mut Seen) {
        let mut part = Seen::default();
        self.block(&mut block.stmts, &mut part);
        block.effects = part.effects();
        seen.include(&part, 1);
    }

    fn expr(&self, e: &mut Expr, seen: &mut Seen) {
        match &e.kind {
            ExprKind::Variable(place) => seen.read(*place),
            ExprKind::Number(_) => {}
            // It is computed once; but an image may have what it reads.
            ExprKind::Kept(_, _, reads) => reads.iter().for_each(|&i| seen.read(Place::Global(i))),
            ExprKind::Call(f, _) => {
                self.reads[*f as usize].iter().for_each(|&i| seen.read(Place::Global(i)));
                seen.shadows |= self.shadows[*f as usize];
                seen.derives |= self.derives[*f as usize];
                seen.prints |= self.prints[*f as usize];
                seen.add(self.work[*f as usize]);
            }
            ExprKind::Builtin(builtin, args) => {
                let looks_up = builtin.params.iter().any(|p| p.kind == ParamKind::Text);
                let shadowed = matches!(builtin.kernel, Kernel::Shadowed(_));
                seen.shadows |= looks_up || shadowed;
                seen.derives |= shadowed || looks_up && texture::takes_pixels_width(builtin, args);
                seen.add(builtin.work());
            }
            ExprKind::Host(..) => seen.add(UNKNOWN),
            _ => seen.add(1),
        }
        if !matches!(e.kind, ExprKind::Kept(..)) {
            children(e).into_iter().for_each(|child| self.expr(child, seen));
        }
    }
}
