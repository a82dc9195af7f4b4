//! Branches of a plan: both ways are followed, each under a guard, and of what they assign and return each lane takes that
//! of its own.

use super::build::{Builder, Flow, GiveUp, Val};
use super::graph::Cell;
use super::op::Op;
use super::strip::zip;
use crate::resolve::tree::*;
use std::collections::HashMap;

/// The most light operations in branches, which are computed in other lanes too: more is left to their lanes alone.
const SPARE: u32 = 128;

/// `condition ? a : b`
const SELECT: Op = Op::Zip(|isa, args, out| zip(isa, args, out, |[c, a, b]| if c != 0.0 { a } else { b }));

impl<'r> Builder<'_, 'r> {
    /// An `if`: where its condition differs from lane to lane both ways, and of each number the one that its lane wants.
    pub fn branch(&mut self, arms: &'r [(Expr, Block)], otherwise: &'r Block) -> Result<Flow, GiveUp> {
        let Some(((condition, block), rest)) = arms.split_first() else {
            return self.block(&otherwise.stmts);
        };
        let cell = self.expr(condition)?.as_scalar()?;
        match cell.known() {
            Some(0.0) => self.branch(rest, otherwise),
            Some(_) => self.block(&block.stmts),
            None => {
                let before = self.variables().clone();
                let flow = self.under(cell, true, |builder| builder.block(&block.stmts))?;
                self.drop_temporary(&block.stmts, &before);
                let returned = self.returned();
                let yes = std::mem::replace(self.variables(), before.clone());
                let other = self.under(cell, false, |builder| builder.branch(rest, otherwise))?;
                if rest.is_empty() {
                    self.drop_temporary(&otherwise.stmts, &before);
                }
                let returned = self.either_returned(cell, returned)?;
                if let Some(frame) = self.frames.last_mut() {
                    frame.returned = returned;
                }
                match (flow, other) {
                    (Flow::On, Flow::On) => {
                        let no = self.variables().clone();
                        *self.variables() = self.either(cell, yes, no)?;
                        Ok(Flow::On)
                    }
                    // Those who go on are of one way.
                    (Flow::On, Flow::Return) => {
                        *self.variables() = yes;
                        Ok(Flow::On)
                    }
                    (Flow::Return, Flow::On) => Ok(Flow::On),
                    (Flow::Return, Flow::Return) => Ok(Flow::Return),
                    _ => Err(GiveUp),
                }
            }
        }
    }

    /// Forgets variables of which nobody outside of the block knows: they need no value on another way.
    fn drop_temporary(&mut self, block: &'r [Stmt], before: &HashMap<Place, Val>) {
        if !self.frames.is_empty() {
            return;
        }
        let new: Vec<Place> =
            self.outer.keys().filter(|place| !before.contains_key(place)).copied().collect();
        for place in new {
            if !self.machine.wanted(place) && self.all.temporary(block, place) {
                self.outer.remove(&place);
            }
        }
    }

    /// What was returned on two ways: that of one way, and the frame's.
    fn either_returned(
        &mut self,
        condition: Cell,
        yes: Option<(Cell, Val)>,
    ) -> Result<Option<(Cell, Val)>, GiveUp> {
        let zero = Cell::number(0.0);
        Ok(match (yes, self.returned()) {
            (None, None) => None,
            (Some((a, value)), None) => Some((self.choose(condition, a, zero), value)),
            (None, Some((b, value))) => Some((self.choose(condition, zero, b), value)),
            (Some((a, value)), Some((b, other))) => {
                let value = self.select(condition, &value, &other)?;
                Some((self.choose(condition, a, b), value))
            }
        })
    }

    /// The truth of `condition ? a : b`.
    fn choose(&mut self, condition: Cell, a: Cell, b: Cell) -> Cell {
        match (a.known(), b.known()) {
            _ if a == b => a,
            (Some(1.0), Some(0.0)) => condition,
            (Some(0.0), Some(1.0)) => self.graph.not(condition),
            _ => self.graph.one(SELECT, &[condition, a, b]),
        }
    }

    /// Of the variables that are assigned on two ways, the value of the way that each lane took.
    fn either(
        &mut self,
        condition: Cell,
        yes: HashMap<Place, Val>,
        no: HashMap<Place, Val>,
    ) -> Result<HashMap<Place, Val>, GiveUp> {
        // In a fixed order: what is met first is computed first.
        let mut places: Vec<Place> = yes.keys().chain(no.keys()).copied().collect();
        places.sort_unstable();
        places.dedup();
        let mut both = HashMap::with_capacity(places.len());
        for place in places {
            // Assigned on one way alone, it is on the other what it was before.
            let mut of = |way: &HashMap<Place, Val>| match way.get(&place) {
                Some(value) => Ok(value.clone()),
                None => self.find(place),
            };
            let (a, b) = match (of(&yes), of(&no)) {
                (Ok(a), Ok(b)) => (a, b),
                // A call's own variable that has no value on one way. If it is read later it is found missing.
                _ if !self.frames.is_empty() => continue,
                _ => return Err(GiveUp),
            };
            let value = if a == b { a } else { self.select(condition, &a, &b)? };
            both.insert(place, value);
        }
        Ok(both)
    }

    /// `condition ? a : b`.
    pub fn select(&mut self, condition: Cell, a: &Val, b: &Val) -> Result<Val, GiveUp> {
        if a.shape != b.shape {
            return Err(GiveUp);
        }
        let cells = a.cells.iter().zip(&b.cells).map(|(&a, &b)| {
            if a == b {
                return a;
            }
            self.graph.one(SELECT, &[condition, a, b])
        });
        Ok(Val { shape: a.shape.clone(), cells: cells.collect() })
    }

    /// Where the call has returned, and what; it is forgotten.
    pub fn returned(&mut self) -> Option<(Cell, Val)> {
        self.frames.last_mut()?.returned.take()
    }

    /// Follows statements in the lanes that have not returned, where others have.
    pub fn others(&mut self, stmts: &'r [Stmt], where_: Cell, value: Val) -> Result<Flow, GiveUp> {
        let flow = self.under(where_, false, |builder| builder.block(stmts))?;
        let later = self.returned();
        let returned = match (&flow, later) {
            (Flow::On, None) => (where_, value),
            (Flow::On | Flow::Return, Some((later, other))) => {
                let value = self.select(where_, &value, &other)?;
                (self.choose(where_, Cell::number(1.0), later), value)
            }
            _ => return Err(GiveUp),
        };
        if let Some(frame) = self.frames.last_mut() {
            frame.returned = Some(returned);
        }
        Ok(flow)
    }

    /// Follows what is wanted only where a condition has this truth.
    pub fn under<T>(
        &mut self,
        condition: Cell,
        truth: bool,
        f: impl FnOnce(&mut Self) -> Result<T, GiveUp>,
    ) -> Result<T, GiveUp> {
        // A pixel decides for its shadows, which a plan knows nothing of.
        if self.machine.shadowed() {
            return Err(GiveUp);
        }
        let around = self.graph.guard;
        if around.is_none() {
            self.graph.spare = 0;
        }
        self.graph.enter(condition, truth);
        let outcome = f(self)?;
        self.graph.guard = around;
        if self.graph.spare > SPARE { Err(GiveUp) } else { Ok(outcome) }
    }

    /// Gives up if a round of a loop has left the call in some lanes.
    pub fn all_on(&self) -> Result<(), GiveUp> {
        if self.frames.last().is_some_and(|frame| frame.returned.is_some()) { Err(GiveUp) } else { Ok(()) }
    }
}
