//! Finds the plan of statements: follows them once, with the values that are the same in all lanes known.
//!
//! Loops and conditions that depend on such values alone are gone through here, so that what remains is one
//! straight line of operations on lanes. What can go wrong at a pixel, or takes another way from pixel to pixel than
//! a choice between two numbers, is left to the evaluator.

use super::graph::{Cell, Cells, Graph};
use super::op::Op;
use super::wanted::Reads;
use crate::eval::machine::Machine;
use crate::resolve::tree::*;
use crate::shape::Shape;
use crate::value::{Mask, Plane, Value, broadcast_shape};
use std::collections::HashMap;

/// The most operations of a plan.
pub const MOST: usize = 4096;
/// The most rounds and calls that are followed.
const ROUNDS: u32 = 8192;
/// The most numbers of a variable: plans are for small vectors.
const CELLS: usize = 1024;
/// How deep calls are followed.
const DEPTH: usize = 16;
/// It is left to the evaluator.
pub struct GiveUp;

/// Numbers under a shape, as [`Value`] has planes.
#[derive(Clone, Debug, PartialEq)]
pub struct Val {
    pub shape: Shape,
    pub cells: Cells,
}

impl Val {
    pub fn scalar(cell: Cell) -> Val {
        Val { shape: Shape::Scalar, cells: Cells::from_elem(cell, 1) }
    }

    pub fn vector(cells: Cells) -> Val {
        Val { shape: Shape::Vector(cells.len() as u32), cells }
    }

    pub fn number(x: f32) -> Val {
        Val::scalar(Cell::number(x))
    }

    pub fn element(&self, i: usize) -> Val {
        Val { shape: self.shape.element(i), cells: self.cells[self.shape.cells_of(i)].into() }
    }

    pub fn as_scalar(&self) -> Result<Cell, GiveUp> {
        if self.shape.is_scalar() { Ok(self.cells[0]) } else { Err(GiveUp) }
    }

    /// The value, if it is the same in all lanes.
    pub fn known(&self) -> Option<Value> {
        let planes = self.cells.iter().map(|c| c.known().map(Plane::Uniform)).collect::<Option<_>>()?;
        Some(Value { shape: self.shape.clone(), planes })
    }
}

impl From<&Value> for Val {
    /// A value of which every plane is the same in all lanes; a varying plane would be 0.
    fn from(value: &Value) -> Val {
        let cell = |p: &Plane| Cell::number(if let Plane::Uniform(x) = p { *x } else { 0.0 });
        Val { shape: value.shape.clone(), cells: value.planes.iter().map(cell).collect() }
    }
}

/// A variable that is read before it is assigned, as it must be for the plan to hold.
pub struct Read {
    pub place: Place,
    /// Its shape, and the numbers of planes that are the same in all lanes.
    pub value: Val,
}

/// How a statement ends, in all lanes that reach it but those of which [`Frame::returned`] tells.
#[derive(PartialEq)]
pub enum Flow {
    On,
    Break,
    Continue,
    Return,
}

/// A call that is followed.
#[derive(Default)]
pub struct Frame {
    pub variables: HashMap<Place, Val>,
    /// Where the call has returned, in the lanes of the statements that are followed: not 0 in those that have; and what.
    pub returned: Option<(Cell, Val)>,
}

pub struct Builder<'m, 'r> {
    pub machine: &'m mut Machine<'r>,
    pub mask: &'m Mask,
    /// What the whole program reads.
    pub all: &'m Reads,
    pub graph: Graph,
    /// What is read from outside.
    pub reads: Vec<Read>,
    /// The planes among it that differ from lane to lane: which variable and plane.
    pub inputs: Vec<(usize, usize)>,
    /// The variables of the statements' own level.
    pub outer: HashMap<Place, Val>,
    /// The calls that are followed.
    pub frames: Vec<Frame>,
    /// What is assigned, in order.
    pub assigned: Vec<Place>,
    /// Rounds of loops and calls, as the evaluator counts them.
    pub steps: u32,
    /// How deep expressions nest.
    pub depth: usize,
    /// How deep calls were followed.
    pub calls: usize,
}

impl<'m, 'r> Builder<'m, 'r> {
    pub fn new(machine: &'m mut Machine<'r>, mask: &'m Mask, all: &'m Reads) -> Builder<'m, 'r> {
        let graph = Graph::new(machine.isa);
        Builder {
            machine,
            mask,
            all,
            graph,
            reads: Vec::new(),
            inputs: Vec::new(),
            outer: HashMap::new(),
            frames: Vec::new(),
            assigned: Vec::new(),
            steps: 0,
            depth: 0,
            calls: 0,
        }
    }

    /// Follows statements as far as it can: how many.
    pub fn follow(&mut self, stmts: &'r [Stmt]) -> usize {
        for (i, stmt) in stmts.iter().enumerate() {
            let outer = self.outer.clone();
            let (reads, inputs, assigned) = (self.reads.len(), self.inputs.len(), self.assigned.len());
            let steps = self.steps;
            if !matches!(self.stmt(stmt), Ok(Flow::On)) {
                self.outer = outer;
                self.reads.truncate(reads);
                self.inputs.truncate(inputs);
                self.assigned.truncate(assigned);
                self.frames.clear();
                self.graph.guard = None;
                self.steps = steps;
                return i;
            }
        }
        stmts.len()
    }

    pub fn block(&mut self, stmts: &'r [Stmt]) -> Result<Flow, GiveUp> {
        for (i, stmt) in stmts.iter().enumerate() {
            match self.stmt(stmt)? {
                Flow::On => {}
                left => return Ok(left),
            }
            if let Some((where_, value)) = self.returned() {
                return self.others(&stmts[i + 1..], where_, value);
            }
        }
        Ok(Flow::On)
    }

    fn round(&mut self) -> Result<(), GiveUp> {
        self.steps += 1;
        if self.steps > ROUNDS || self.graph.nodes.len() > MOST { Err(GiveUp) } else { Ok(()) }
    }

    fn stmt(&mut self, stmt: &'r Stmt) -> Result<Flow, GiveUp> {
        let before = std::mem::replace(&mut self.graph.at, stmt.span);
        let flow = self.stmt_here(stmt);
        self.graph.at = before;
        flow
    }

    fn stmt_here(&mut self, stmt: &'r Stmt) -> Result<Flow, GiveUp> {
        if self.graph.nodes.len() > MOST {
            return Err(GiveUp);
        }
        match &stmt.kind {
            StmtKind::Assign { place, path, op, value, .. } => {
                self.assign(*place, path, *op, value)?;
                Ok(Flow::On)
            }
            StmtKind::If(arms, otherwise) => self.branch(arms, otherwise),
            StmtKind::While(condition, body, _) => loop {
                self.round()?;
                if !self.decided(condition)? {
                    return Ok(Flow::On);
                }
                match self.block(body)? {
                    Flow::On | Flow::Continue => {}
                    Flow::Break => return Ok(Flow::On),
                    Flow::Return => return Ok(Flow::Return),
                }
                self.all_on()?;
            },
            StmtKind::For(place, vector, body) => {
                let vector = self.expr(vector)?;
                for i in 0..vector.shape.len().ok_or(GiveUp)? {
                    self.round()?;
                    self.set(*place, vector.element(i))?;
                    match self.block(body)? {
                        Flow::On | Flow::Continue => {}
                        Flow::Break => break,
                        Flow::Return => return Ok(Flow::Return),
                    }
                    self.all_on()?;
                }
                Ok(Flow::On)
            }
            StmtKind::Break => Ok(Flow::Break),
            StmtKind::Continue => Ok(Flow::Continue),
            // The statements' own function is the evaluator's to leave.
            StmtKind::Return(e) => {
                let value = self.expr(e)?;
                // The statements' own function is the evaluator's to leave.
                let frame = self.frames.last_mut().ok_or(GiveUp)?;
                frame.returned = Some((Cell::number(1.0), value));
                Ok(Flow::Return)
            }
            // A plan has no pixels to tell about.
            StmtKind::Expr(_) | StmtKind::Print(_) => Err(GiveUp),
        }
    }

    /// The truth of a condition that is the same in all lanes.
    fn decided(&mut self, condition: &'r Expr) -> Result<bool, GiveUp> {
        let cell = self.expr(condition)?.as_scalar()?;
        Ok(cell.known().ok_or(GiveUp)? != 0.0)
    }

    fn assign(
        &mut self,
        place: Place,
        path: &'r [Step],
        op: Option<BinaryOp>,
        value: &'r Expr,
    ) -> Result<(), GiveUp> {
        if path.is_empty() {
            let value = match op {
                None => self.expr(value)?,
                Some(op) => {
                    let old = self.get(place)?;
                    let right = self.expr(value)?;
                    self.binary(op, &old, &right)?
                }
            };
            return self.set(place, value);
        }
        let [step] = path else { return Err(GiveUp) };
        let i = match step {
            Step::Component(i, _) => *i as usize,
            Step::Index(e) => self.known_index(e)?,
        };
        let mut vector = self.get(place)?;
        if !matches!(vector.shape, Shape::Vector(n) if i < n as usize) {
            return Err(GiveUp);
        }
        let value = match op {
            None => self.expr(value)?,
            Some(op) => {
                let old = vector.element(i);
                let right = self.expr(value)?;
                self.binary(op, &old, &right)?
            }
        };
        vector.cells[i] = value.as_scalar()?;
        self.set(place, vector)
    }

    /// An index that is the same in all lanes, counted from 0.
    pub fn known_index(&mut self, e: &'r Expr) -> Result<usize, GiveUp> {
        let x = self.expr(e)?.as_scalar()?.known().ok_or(GiveUp)?;
        let i = crate::math::round(x);
        if (1.0..1e6).contains(&i) { Ok(i as usize - 1) } else { Err(GiveUp) }
    }

    /// The variables of the innermost call that is followed, or of the statements' own level.
    pub fn variables(&mut self) -> &mut HashMap<Place, Val> {
        self.frames.last_mut().map_or(&mut self.outer, |frame| &mut frame.variables)
    }

    fn set(&mut self, place: Place, value: Val) -> Result<(), GiveUp> {
        if value.cells.len() > CELLS {
            return Err(GiveUp);
        }
        if self.frames.is_empty() && !self.assigned.contains(&place) {
            self.assigned.push(place);
        }
        self.variables().insert(place, value);
        Ok(())
    }

    /// A variable's value.
    pub fn get(&mut self, place: Place) -> Result<Val, GiveUp> {
        match self.variables().get(&place) {
            Some(value) => Ok(value.clone()),
            None => self.find(place),
        }
    }

    /// The value of a variable that the calls and statements that are followed have not assigned.
    pub fn find(&mut self, place: Place) -> Result<Val, GiveUp> {
        if !self.frames.is_empty() {
            // Calls read outer variables, and have no other locals than their own.
            let Place::Global(_) = place else { return Err(GiveUp) };
            if let Some(value) = self.outer.get(&place) {
                return Ok(value.clone());
            }
        }
        if let Some(read) = self.reads.iter().find(|read| read.place == place) {
            return Ok(read.value.clone());
        }
        let untouched = self.machine.untouched(place);
        if let Some((variable, _)) = untouched.filter(|(variable, _)| variable.shape.cells() <= CELLS) {
            let (first, planes) = (self.inputs.len(), variable.shape.cells());
            let variables = self.reads.len();
            self.inputs.extend((0..planes).map(|k| (variables, k)));
            let cells = (first..first + planes).map(|i| Cell::Result(self.graph.add(Op::Input(i), &[], 1)));
            let value = Val { shape: variable.shape.clone(), cells: cells.collect() };
            self.reads.push(Read { place, value: value.clone() });
            return Ok(value);
        }
        let width = self.machine.width();
        let slot = self.machine.slot(place);
        if !self.mask.is_subset(&slot.defined, width) {
            return Err(GiveUp);
        }
        let value = slot.value.as_ref().filter(|value| value.planes.len() <= CELLS).ok_or(GiveUp)?;
        let mut cells = Cells::new();
        for (k, plane) in value.planes.iter().enumerate() {
            cells.push(match plane {
                Plane::Uniform(x) => Cell::number(*x),
                Plane::Varying(_) => {
                    self.inputs.push((self.reads.len(), k));
                    Cell::Result(self.graph.add(Op::Input(self.inputs.len() - 1), &[], 1))
                }
            });
        }
        let value = Val { shape: value.shape.clone(), cells };
        self.reads.push(Read { place, value: value.clone() });
        Ok(value)
    }

    /// A call of a function of the language.
    pub fn call(&mut self, f: u32, args: &'r [Expr]) -> Result<Val, GiveUp> {
        let function = &self.machine.program.functions[f as usize];
        let mut frame = Frame::default();
        for (i, arg) in args.iter().enumerate() {
            frame.variables.insert(Place::Local(i as u32), self.expr(arg)?);
        }
        self.round()?;
        if self.frames.len() >= DEPTH || !self.machine.room_for_calls(self.frames.len() + 1) {
            return Err(GiveUp);
        }
        self.frames.push(frame);
        self.calls = self.calls.max(self.frames.len());
        let flow = self.block(&function.body)?;
        let returned = self.frames.pop().and_then(|frame| frame.returned);
        match returned {
            Some((_, value)) if flow == Flow::Return => Ok(value),
            _ => Err(GiveUp),
        }
    }

    /// The cells of several values that are to meet: a scalar with each component of a vector.
    pub fn meet<const K: usize>(
        &mut self,
        values: [&Val; K],
        mut f: impl FnMut(&mut Graph, [Cell; K]) -> Cell,
    ) -> Result<Val, GiveUp> {
        let mut shape = values[0].shape.clone();
        for value in &values[1..] {
            shape = broadcast_shape(&shape, &value.shape).map_err(|_| GiveUp)?;
        }
        if !values.iter().all(|v| v.shape == shape || v.shape.is_scalar()) || shape.cells() > 64 {
            return Err(GiveUp);
        }
        let step = values.map(|v| usize::from(!v.shape.is_scalar()));
        let cells = (0..shape.cells())
            .map(|c| f(&mut self.graph, std::array::from_fn(|k| values[k].cells[c * step[k]])))
            .collect();
        Ok(Val { shape, cells })
    }
}
