//! Finding the plan of statements, and running it.

use super::active::Active;
use super::build::{Builder, Read, Val};
use super::graph::Cell;
use super::steps::{Scratch, Steps};
use super::strip::{BLOCK, Block, STRIP, Strip};
use super::wanted::Reads;
use crate::diagnostic::Span;
use crate::eval::fault::Result;
use crate::eval::machine::{Machine, Slot};
use crate::resolve::tree::*;
use crate::shape::Shape;
use crate::value::{Lanes, Mask, Plane, Planes, Value};
use smallvec::SmallVec;
use std::collections::HashMap;
use std::sync::Arc;

/// Lanes of a batch that is worth a plan.
const LEAST: usize = 32;
/// Plans of the same statements, for different numbers that are known. Where there are more, the evaluator goes on.
const VERSIONS: usize = 8;
/// How often statements may have no plan before they are no more looked at.
const FAILURES: u32 = 3;

/// What statements do to a batch.
pub struct Plan {
    /// How many statements it stands for.
    pub count: usize,
    /// What must be as it was.
    reads: Vec<Read>,
    steps: Steps,
    /// The variable and the plane of each input of the steps.
    inputs: Vec<(Place, usize)>,
    writes: Vec<Write>,
    /// Rounds of loops and calls.
    rounds: u32,
    /// How deep calls go.
    calls: usize,
}

struct Write {
    place: Place,
    shape: Shape,
    /// The first of its cells among the results of the steps.
    first: usize,
}

#[derive(Default)]
struct Versions {
    plans: Vec<Arc<Plan>>,
    failures: u32,
}

/// The plans that were found so far, and what running them needs.
#[derive(Default)]
pub struct Plans {
    /// By the address of the first statement.
    found: HashMap<usize, Versions>,
    reads: Option<Arc<Reads>>,
    scratch: Scratch,
    gathered: Vec<Strip>,
    /// Room for the lanes of a batch.
    list: Vec<u32>,
}

impl<'r> Machine<'r> {
    /// The plan for the first of these statements on, for the lanes of the mask.
    pub(in crate::eval) fn plan(&mut self, stmts: &'r [Stmt], mask: &Mask) -> Option<Arc<Plan>> {
        if !self.plans_allowed() || self.n < LEAST || stmts.is_empty() {
            return None;
        }
        let key = stmts.as_ptr().addr();
        if let Some(versions) = self.plans.found.get(&key) {
            let (failures, plans) = (versions.failures, versions.plans.len());
            for i in 0..plans {
                let plan = self.plans.found.get(&key)?.plans[i].clone();
                if self.fits(&plan, mask) {
                    return Some(plan);
                }
            }
            if failures >= FAILURES || plans >= VERSIONS {
                return None;
            }
        }
        let plan = self.make_plan(stmts, mask).map(Arc::new);
        let versions = self.plans.found.entry(key).or_default();
        match &plan {
            Some(plan) => versions.plans.push(plan.clone()),
            None => versions.failures += 1,
        }
        let plan = plan?;
        self.fits(&plan, mask).then_some(plan)
    }

    /// Is all as it was when the plan was made?
    fn fits(&mut self, plan: &Plan, mask: &Mask) -> bool {
        let width = self.width();
        let same = |plane: &Plane, cell: &Cell| match (plane, cell.known()) {
            (Plane::Uniform(x), Some(known)) => x.to_bits() == known.to_bits(),
            (Plane::Varying(_), None) => true,
            _ => false,
        };
        self.room_for_calls(plan.calls)
            && plan.reads.iter().all(|read| {
                if let Some((variable, _)) = self.untouched(read.place) {
                    return *variable.shape == read.value.shape
                        && read.value.cells.iter().all(|c| c.known().is_none());
                }
                let slot = self.slot(read.place);
                slot.value.as_ref().is_some_and(|value| {
                    value.shape == read.value.shape
                        && value.planes.iter().zip(&read.value.cells).all(|(p, c)| same(p, c))
                }) && mask.is_subset(&slot.defined, width)
            })
            && plan.writes.iter().all(|write| {
                if let Mask::All = mask {
                    return true;
                }
                let slot = self.slot(write.place);
                // Where other lanes keep a value its shape must be theirs.
                slot.value
                    .as_ref()
                    .is_none_or(|v| v.shape == write.shape || slot.defined.is_subset(mask, width))
            })
    }

    fn make_plan(&mut self, stmts: &'r [Stmt], mask: &Mask) -> Option<Plan> {
        let reads = match &self.plans.reads {
            Some(reads) => reads.clone(),
            None => self.plans.reads.insert(Arc::new(Reads::of_program(self.program))).clone(),
        };
        let mut builder = Builder::new(self, mask, &reads);
        let count = builder.follow(stmts);
        if count == 0 {
            return None;
        }
        let Builder { graph, reads: needed, inputs, outer, assigned, steps: rounds, calls, .. } = builder;
        let mut cells: Vec<Cell> = Vec::new();
        let mut writes = Vec::new();
        for place in assigned {
            let Some(Val { shape, cells: of }) = outer.get(&place) else { continue };
            if self.wanted(place)
                || needed.iter().any(|read| read.place == place)
                || !reads.temporary(&stmts[..count], place)
            {
                writes.push(Write { place, shape: shape.clone(), first: cells.len() });
                cells.extend(of);
            }
        }
        let steps = Steps::new(graph, &cells);
        let inputs = steps
            .inputs
            .iter()
            .map(|&i| {
                let (variable, plane) = inputs[i];
                (needed[variable].place, plane)
            })
            .collect();
        Some(Plan { count, reads: needed, steps, inputs, writes, rounds, calls })
    }

    /// Runs a plan that fits, on the lanes of the mask. `first` is the first of its statements.
    pub(in crate::eval) fn run_plan(&mut self, plan: &Plan, first: Span, mask: &Mask) -> Result<()> {
        if self.clock.is_none() {
            return self.carry_out(plan, mask);
        }
        let (n, width) = (self.n, self.width());
        let before = self.begin(first, mask);
        if let Some(clock) = &mut self.clock {
            for statement in plan.steps.statements().into_iter().filter(|s| *s != first) {
                clock.visit(statement, mask.count(width), n);
            }
        }
        let outcome = self.carry_out(plan, mask);
        self.done(before);
        outcome
    }

    fn carry_out(&mut self, plan: &Plan, mask: &Mask) -> Result<()> {
        self.check_memory()?;
        if plan.rounds > 0 {
            self.charge(plan.rounds, mask, self.at)?;
        }
        let (n, width) = (self.n, self.width());
        let active = Active::of(mask, width, std::mem::take(&mut self.plans.list));
        let inputs: SmallVec<[Input<'r>; 8]> =
            plan.inputs.iter().filter_map(|&(place, plane)| self.input(place, plane)).collect();
        // What stays of the old values, and the planes that are to be filled.
        let mut targets: SmallVec<[Option<Lanes>; 8]> = plan.steps.results.iter().map(|_| None).collect();
        for write in &plan.writes {
            if let Mask::All = mask {
                self.forget(write.place);
            }
            let old = std::mem::replace(self.slot(write.place), Slot::EMPTY);
            let keep = old.value.is_some() && !old.defined.is_subset(mask, width);
            let defined = if keep { old.defined.or(mask, width) } else { mask.clone() };
            let mut planes = Planes::new();
            let old = old.value.filter(|_| keep).map(|value| value.planes).unwrap_or_default();
            let mut old = old.into_iter();
            for k in write.first..write.first + write.shape.cells() {
                let old = old.next();
                planes.push(match (plan.steps.known(k), old) {
                    (Some(x), None) => Plane::Uniform(x),
                    (Some(x), Some(Plane::Uniform(before))) if x.to_bits() == before.to_bits() => {
                        Plane::Uniform(x)
                    }
                    (Some(x), Some(before)) => {
                        let mut lanes = owned(before, n);
                        active.fill(x, lanes.get_mut(n));
                        Plane::Varying(lanes)
                    }
                    (None, before) => {
                        targets[k] = Some(before.map_or_else(|| Lanes::new(n), |before| owned(before, n)));
                        // Its place is taken by the target below.
                        Plane::Uniform(0.0)
                    }
                });
            }
            let value = Value { shape: write.shape.clone(), planes };
            *self.slot(write.place) = Slot { value: Some(value), defined };
        }
        if targets.iter().any(Option::is_some) {
            self.strips(plan, &active, &inputs, &mut targets);
        }
        for write in &plan.writes {
            let slot = self.slot(write.place);
            if let Some(value) = &mut slot.value {
                for (plane, target) in value.planes.iter_mut().zip(&mut targets[write.first..]) {
                    if let Some(lanes) = target.take() {
                        *plane = Plane::Varying(lanes);
                    }
                }
            }
        }
        if let Some(list) = active.room() {
            self.plans.list = list;
        }
        Ok(())
    }

    fn strips(&mut self, plan: &Plan, active: &Active, inputs: &[Input<'_>], targets: &mut [Option<Lanes>]) {
        let (n, isa) = (self.n, self.isa);
        let Machine { plans: Plans { scratch, gathered, .. }, clock, .. } = self;
        gathered.resize_with(gathered.len().max(inputs.len()), || Strip::ZERO);
        let count = active.count();
        for start in (0..count).step_by(STRIP) {
            let lanes = STRIP.min(count - start);
            let blocks: SmallVec<[&[Block]; 8]> = if let Active::All(_) = active {
                for (input, strip) in inputs.iter().zip(gathered.iter_mut()) {
                    if input.in_place(start, lanes).is_none() {
                        active.gather(input.get(n), start, lanes, strip);
                    }
                }
                let both = inputs.iter().zip(gathered.iter());
                both.map(|(input, strip)| input.in_place(start, lanes).unwrap_or(&strip.0)).collect()
            } else {
                for (input, strip) in inputs.iter().zip(gathered.iter_mut()) {
                    active.gather(input.get(n), start, lanes, strip);
                }
                gathered.iter().map(|strip| &strip.0[..]).take(inputs.len()).collect()
            };
            let take = |k: usize, result: &[Block]| {
                if let Some(target) = &mut targets[k] {
                    active.scatter(result.as_flattened(), start, lanes, target.get_mut(n));
                }
            };
            match clock {
                None => plan.steps.run(isa, lanes, &blocks, scratch, |_| {}, take),
                Some(clock) => {
                    // What was done until here is the first statement's; then each has its turn.
                    let first = clock.turn(Span::default());
                    let after = |statement| {
                        clock.become_of(statement);
                    };
                    plan.steps.run(isa, lanes, &blocks, scratch, after, take);
                    clock.become_of(first);
                    clock.turn(first);
                }
            }
        }
    }

    fn input(&self, place: Place, plane: usize) -> Option<Input<'r>> {
        if let Some((variable, start)) = self.untouched(place) {
            let plane = variable.plane(plane).contiguous()?;
            return Some(Input::Image(&plane[start..start + self.n]));
        }
        match self.slot_of(place).value.as_ref()?.planes.get(plane)? {
            Plane::Varying(lanes) => Some(Input::Lanes(lanes.clone())),
            Plane::Uniform(_) => None,
        }
    }
}

/// A plane that is read, of all lanes of the batch.
enum Input<'r> {
    Lanes(Lanes),
    Image(&'r [f32]),
}

impl Input<'_> {
    fn get(&self, n: usize) -> &[f32] {
        match self {
            Input::Lanes(lanes) => lanes.get(n),
            Input::Image(lanes) => lanes,
        }
    }

    /// The blocks of so many lanes, where they are as they should be.
    fn in_place(&self, start: usize, lanes: usize) -> Option<&[Block]> {
        match self {
            Input::Lanes(all) => Some(&all.blocks()[start / BLOCK..]),
            Input::Image(all) => {
                Some(all[start..].as_chunks().0).filter(|blocks| blocks.len() * BLOCK >= lanes)
            }
        }
    }
}

/// The plane's numbers, one a lane, to be changed.
fn owned(plane: Plane, n: usize) -> Lanes {
    match plane {
        Plane::Uniform(x) => Lanes::filled(n, |out| out.fill(x)),
        Plane::Varying(lanes) => lanes,
    }
}
