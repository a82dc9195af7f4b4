//! Statements: each takes the lanes that reach it and gives the lanes that fall through.
//!
//! `break`, `continue` and `return` let none through; they note their lanes with the loop or the call that
//! they leave. So there is no stack of masks to keep in balance.

use super::fault::Result;
use super::machine::{Loop, Machine, Slot, blend};
use crate::diagnostic::Diagnostic;
use crate::resolve::tree::*;
use crate::stack;
use crate::value::{Mask, Value};

impl<'r> Machine<'r> {
    /// Runs statements in order, as long as a lane is left.
    pub fn block(&mut self, block: &'r [Stmt], mask: &Mask) -> Result<Mask> {
        if stack::is_low() {
            return stack::grow(|| self.block(block, mask));
        }
        if !self.nesting.enter(u32::MAX) {
            return Err(self.too_deep(self.at, mask));
        }
        let through = self.block_here(block, mask);
        self.nesting.leave();
        through
    }

    fn block_here(&mut self, block: &'r [Stmt], mask: &Mask) -> Result<Mask> {
        let mut mask = mask.clone();
        let mut rest = block;
        while let Some((stmt, after)) = rest.split_first() {
            if mask.is_none() {
                break;
            }
            self.at = stmt.span;
            if let Some(plan) = self.plan(rest, &mask) {
                self.run_plan(&plan, stmt.span, &mask)?;
                rest = &rest[plan.count..];
                continue;
            }
            mask = if self.watched { self.watched(stmt, &mask)? } else { self.exec(stmt, &mask)? };
            rest = after;
        }
        Ok(mask)
    }

    #[cold]
    fn watched(&mut self, stmt: &'r Stmt, mask: &Mask) -> Result<Mask> {
        if self.tracer.is_some() {
            return self.traced(stmt, mask);
        }
        let before = self.begin(stmt.span, mask);
        let through = self.exec(stmt, mask);
        self.done(before);
        through
    }

    pub(super) fn exec(&mut self, stmt: &'r Stmt, mask: &Mask) -> Result<Mask> {
        self.at = stmt.span;
        match &stmt.kind {
            StmtKind::Assign { place, name, path, op, value } => {
                self.assign(*place, *name, path, *op, value, mask)?;
                Ok(mask.clone())
            }
            StmtKind::Expr(e) => {
                match &e.kind {
                    // A call whose value nobody wants need not return one.
                    ExprKind::Call(f, args) => drop(self.invoke(*f, args, e.span, mask)?),
                    _ => drop(self.eval(e, mask)?),
                }
                Ok(mask.clone())
            }
            StmtKind::If(arms, otherwise) => self.branch(arms, otherwise, mask),
            StmtKind::While(condition, body, effects) => self.while_loop(condition, body, effects, mask),
            StmtKind::For(place, vector, body) => self.for_loop(*place, vector, body, mask),
            StmtKind::Print(parts) => {
                self.print(stmt.span, parts, mask)?;
                Ok(mask.clone())
            }
            StmtKind::Break => {
                let width = self.width();
                if let Some(innermost) = self.loops.last_mut() {
                    innermost.broken = innermost.broken.or(mask, width);
                }
                Ok(Mask::None)
            }
            StmtKind::Continue => {
                let width = self.width();
                if let Some(innermost) = self.loops.last_mut() {
                    innermost.continued = innermost.continued.or(mask, width);
                }
                Ok(Mask::None)
            }
            StmtKind::Return(e) => {
                let value = self.eval(e, mask)?;
                let width = self.width();
                if let Some(frame) = self.frames.last_mut() {
                    frame.returned = Some(match frame.returned.take() {
                        Some(old) => blend(mask, &value, &old, width)?,
                        None => value,
                    });
                    frame.lanes = frame.lanes.or(mask, width);
                }
                Ok(Mask::None)
            }
        }
    }

    fn branch(&mut self, arms: &'r [(Expr, Block)], otherwise: &'r Block, mask: &Mask) -> Result<Mask> {
        let width = self.width();
        let mut through = Mask::None;
        let mut open = mask.clone();
        for (condition, block) in arms {
            let value = self.eval(condition, &open)?;
            let (yes, no) = self.split(&value, condition.span, &open)?;
            if self.tracer.is_some() {
                self.trace_branch(condition.span, &value, !yes.is_none());
            }
            if !yes.is_none() {
                through = through.or(&self.part(block, &yes)?, width);
            }
            open = no;
            if open.is_none() {
                return Ok(self.rejoin(through, mask));
            }
        }
        let rest = self.part(otherwise, &open)?;
        Ok(self.rejoin(through.or(&rest, width), mask))
    }

    /// Runs the block of a branch, on its lanes alone if that saves work.
    fn part(&mut self, block: &'r Block, mask: &Mask) -> Result<Mask> {
        if mask.is_none() {
            return Ok(Mask::None);
        }
        if let Some(plan) = self.plan(&block.stmts, mask).filter(|plan| plan.count == block.stmts.len()) {
            let first = block.stmts.first().map_or(self.at, |stmt| stmt.span);
            self.run_plan(&plan, first, mask)?;
            return Ok(mask.clone());
        }
        match self.gathered(&block.effects, mask) {
            Some(lanes) => {
                self.dense(&lanes, &block.effects, |machine| {
                    machine.block(&block.stmts, &Mask::All).map(drop)
                })?;
                Ok(mask.clone())
            }
            None => self.block(&block.stmts, mask),
        }
    }

    /// A mask that has all the lanes of another again is that one: later subset tests then cost nothing.
    fn rejoin(&self, joined: Mask, whole: &Mask) -> Mask {
        if whole.is_subset(&joined, self.width()) { whole.clone() } else { joined }
    }

    fn while_loop(
        &mut self,
        condition: &'r Expr,
        body: &'r [Stmt],
        effects: &'r Effects,
        mask: &Mask,
    ) -> Result<Mask> {
        let width = self.width();
        let mut left = Mask::None;
        let mut active = mask.clone();
        while !active.is_none() {
            // As lanes leave, the others go on without them.
            if let Some(lanes) = self.gathered(effects, &active) {
                self.dense(&lanes, effects, |machine| {
                    machine.while_loop(condition, body, effects, &Mask::All).map(drop)
                })?;
                left = left.or(&active, width);
                break;
            }
            self.step(&active, condition.span)?;
            let value = self.eval(condition, &active)?;
            let (yes, no) = self.split(&value, condition.span, &active)?;
            left = left.or(&no, width);
            if yes.is_none() {
                break;
            }
            if self.tracer.is_some() {
                self.trace_round(condition.span, None);
            }
            (active, left) = self.round(body, &yes, left)?;
        }
        Ok(self.rejoin(left, mask))
    }

    /// One round of a loop's block: the lanes that go on, and those that have left the loop.
    fn round(&mut self, body: &'r [Stmt], mask: &Mask, left: Mask) -> Result<(Mask, Mask)> {
        let width = self.width();
        self.loops.push(Loop { broken: Mask::None, continued: Mask::None });
        let fell = self.block(body, mask)?;
        let Some(round) = self.loops.pop() else { return Ok((Mask::None, left)) };
        Ok((fell.or(&round.continued, width), left.or(&round.broken, width)))
    }

    fn for_loop(&mut self, place: Place, vector: &'r Expr, body: &'r [Stmt], mask: &Mask) -> Result<Mask> {
        let width = self.width();
        // The loop goes over the vector as it was, whatever its block assigns.
        let elements = self.eval(vector, mask)?;
        let Some(count) = elements.shape.len() else {
            let lane = self.first(mask);
            let error = Diagnostic::error("shape", "`for` needs a vector to go through", vector.span)
                .label(vector.span, format!("a scalar: {}", elements.show(lane)))
                .hint("To count, write a range: `for i in [1 .. 10]`.");
            return Err(self.fault(error, lane));
        };
        let mut left = Mask::None;
        let mut active = mask.clone();
        for i in 0..count {
            if active.is_none() {
                break;
            }
            self.step(&active, vector.span)?;
            self.store(place, elements.element(i), &active)?;
            if self.tracer.is_some() {
                self.trace_round(vector.span, Some(place));
            }
            (active, left) = self.round(body, &active, left)?;
        }
        let through = left.or(&active, width);
        Ok(self.rejoin(through, mask))
    }

    /// Room for a call's locals, the arguments in the first of them.
    pub fn enter(&mut self, args: impl IntoIterator<Item = Value>, locals: usize, mask: &Mask) -> usize {
        let base = self.locals.len();
        self.locals.extend(args.into_iter().map(|v| Slot { value: Some(v), defined: mask.clone() }));
        self.locals.resize(base + locals, Slot::EMPTY);
        base
    }
}
