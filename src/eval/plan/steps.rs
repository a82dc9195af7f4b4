//! A plan: steps on numbered strips, and how they are run.

use super::active::Active;
use super::graph::{Cell, Graph, Node, around, reduce};
use super::op::{ARGUMENTS, Cost, Op};
use super::strip::{BLOCK, Block, STRIP, Strip};
use crate::diagnostic::Span;
use crate::lanes::Isa;
use smallvec::SmallVec;
use std::ops::Range;

/// Where a step finds an argument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Operand {
    /// A strip of the scratch.
    Strip(u16),
    /// One of the numbers that are the same in all lanes.
    Known(u16),
    /// An input.
    Input(u16),
}

struct Step {
    op: Op,
    args: SmallVec<[Operand; 6]>,
    out: SmallVec<[u16; 4]>,
    /// The guard under which it is done.
    guard: Option<u16>,
    /// Is it done in the guard's lanes alone? Otherwise in all, if there is one.
    alone: bool,
    /// The statement that it is of.
    of: Span,
}

/// What lanes want some steps.
struct Gate {
    /// Not 0 in them.
    lanes: Operand,
    around: Option<u16>,
    /// Is any step done in them alone?
    alone: bool,
}

/// The most results of a step.
const RESULTS: usize = 4;

impl Step {
    /// # Panics
    /// If a strip is written that is also read, or written twice: running the step relies on it.
    fn new(
        op: Op,
        args: SmallVec<[Operand; 6]>,
        out: SmallVec<[u16; 4]>,
        guard: Option<u16>,
        of: Span,
        strips: u16,
    ) -> Step {
        assert!(args.len() <= ARGUMENTS && out.len() <= RESULTS);
        for (k, &strip) in out.iter().enumerate() {
            assert!(strip < strips && !out[..k].contains(&strip) && !args.contains(&Operand::Strip(strip)));
        }
        assert!(args.iter().all(|arg| !matches!(arg, Operand::Strip(i) if *i >= strips)));
        let alone = guard.is_some() && op.cost() == Cost::Heavy;
        Step { op: op.settled(), args, out, guard, alone, of }
    }
}

/// Steps, one after another.
pub struct Steps {
    steps: Vec<Step>,
    gates: Vec<Gate>,
    known: Vec<Block>,
    strips: usize,
    /// Where the results are that were asked for; [`Operand::Known`] where they are numbers.
    pub results: Vec<Operand>,
    /// The numbers of the inputs that are read.
    pub inputs: Vec<usize>,
}

/// Strips for what is between, kept from run to run.
#[derive(Default)]
pub struct Scratch {
    strips: Vec<Strip>,
    /// What is known of each gate's lanes in this strip.
    gates: Vec<Open>,
    /// Arguments and results of a step in some lanes alone.
    packed: Vec<Strip>,
    bits: Vec<u32>,
    /// Room for lists of lanes.
    lists: Vec<Vec<u32>>,
}

/// How far a gate is open.
#[expect(clippy::large_enum_variant, reason = "a few, kept from strip to strip")]
#[derive(Default)]
enum Open {
    #[default]
    Unknown,
    Shut,
    /// For the lanes between these blocks, or for so many of them that the rest is not worth leaving out.
    Wide(Range<usize>),
    /// For these lanes between the blocks; none are listed where no step is done in them alone.
    For(Range<usize>, Active),
}

struct Allocation {
    known: Vec<Block>,
    /// Where each result of the graph is.
    places: Vec<Option<Operand>>,
    inputs: Vec<usize>,
    free: Vec<u16>,
    strips: u16,
}

impl Allocation {
    fn operand(&mut self, cell: Cell) -> Operand {
        match cell {
            Cell::Known(bits) => {
                let found = self.known.iter().position(|b| b[0].to_bits() == bits);
                let at = found.unwrap_or_else(|| {
                    self.known.push([f32::from_bits(bits); BLOCK]);
                    self.known.len() - 1
                });
                Operand::Known(at as u16)
            }
            // A node comes before those that use it.
            Cell::Result(id) => self.places[id as usize].unwrap_or(Operand::Known(0)),
        }
    }

    fn strip(&mut self) -> u16 {
        self.free.pop().unwrap_or_else(|| {
            self.strips += 1;
            self.strips - 1
        })
    }
}

impl Steps {
    /// The steps that compute these cells.
    pub fn new(mut graph: Graph, wanted: &[Cell]) -> Steps {
        reduce(&mut graph, wanted);
        let Graph { nodes, results, guards, .. } = graph;
        let mut last = vec![0; results as usize];
        for (i, node) in nodes.iter().enumerate() {
            let gates = around(&guards, node.guard).map(|g| &guards[g].cell);
            for cell in node.args.iter().chain(gates) {
                if let Cell::Result(id) = cell {
                    last[*id as usize] = i;
                }
            }
        }
        for cell in wanted {
            if let Cell::Result(id) = cell {
                last[*id as usize] = usize::MAX;
            }
        }
        let mut to = Allocation {
            known: Vec::new(),
            places: vec![None; results as usize],
            inputs: Vec::new(),
            free: Vec::new(),
            strips: 0,
        };
        let mut steps: Vec<Step> = Vec::new();
        // By the graph's numbers.
        let mut gates: Vec<Option<u16>> = vec![None; guards.len()];
        let mut used: Vec<Gate> = Vec::new();
        for (i, node) in nodes.into_iter().enumerate() {
            let Node { op, args: cells, first, results, guard, of } = node;
            if let Op::Input(number) = op {
                to.places[first as usize] = Some(Operand::Input(to.inputs.len() as u16));
                to.inputs.push(number);
                continue;
            }
            let args = cells.iter().map(|&cell| to.operand(cell)).collect();
            let mut chain: SmallVec<[usize; 8]> = around(&guards, guard).collect();
            chain.reverse();
            let mut guard = None;
            for &g in &chain {
                guard = Some(*gates[g].get_or_insert_with(|| {
                    used.push(Gate { lanes: to.operand(guards[g].cell), around: guard, alone: false });
                    (used.len() - 1) as u16
                }));
            }
            // Before its arguments are given back: no kernel writes where it reads.
            let ids = first..first + results as u32;
            let out: SmallVec<[u16; 4]> = ids.clone().map(|_| to.strip()).collect();
            for (id, &strip) in ids.clone().zip(&out) {
                to.places[id as usize] = Some(Operand::Strip(strip));
            }
            let mut done: SmallVec<[u32; 6]> = cells
                .iter()
                .chain(chain.iter().map(|&g| &guards[g].cell))
                .filter_map(|cell| if let Cell::Result(id) = cell { Some(*id) } else { None })
                .chain(ids.filter(|&id| last[id as usize] == 0))
                .filter(|&id| last[id as usize] <= i)
                .collect();
            done.sort_unstable();
            done.dedup();
            for id in done {
                if let Some(Operand::Strip(strip)) = to.places[id as usize] {
                    to.free.push(strip);
                }
            }
            let step = Step::new(op, args, out, guard, of, to.strips);
            if let Some(g) = guard.filter(|_| step.alone) {
                used[usize::from(g)].alone = true;
            }
            steps.push(step);
        }
        let results = wanted.iter().map(|&cell| to.operand(cell)).collect();
        Steps {
            steps,
            gates: used,
            known: to.known,
            strips: usize::from(to.strips),
            results,
            inputs: to.inputs,
        }
    }

    /// The statements that the steps are of.
    pub fn statements(&self) -> Vec<Span> {
        let mut statements: Vec<Span> = self.steps.iter().map(|step| step.of).collect();
        statements.sort_unstable();
        statements.dedup();
        statements
    }

    /// The number of a result that is the same in all lanes.
    pub fn known(&self, result: usize) -> Option<f32> {
        match self.results[result] {
            Operand::Known(i) => Some(self.known[usize::from(i)][0]),
            _ => None,
        }
    }

    /// Runs all steps on so many lanes, [`STRIP`] at most. `after` is told of which statement each
    /// step was that is done, `take` gets each result by its number.
    ///
    /// # Panics
    /// If there are fewer inputs than [`Steps::inputs`], or if they are shorter than the lanes.
    pub fn run(
        &self,
        isa: Isa,
        lanes: usize,
        inputs: &[&[Block]],
        scratch: &mut Scratch,
        mut after: impl FnMut(Span),
        mut take: impl FnMut(usize, &[Block]),
    ) {
        assert!(lanes <= STRIP);
        let Scratch { strips, gates, packed, bits, lists } = scratch;
        strips.resize(strips.len().max(self.strips), Strip::ZERO);
        lists.extend(
            gates.drain(..).filter_map(|open| if let Open::For(_, of) = open { of.room() } else { None }),
        );
        gates.resize_with(self.gates.len(), Open::default);
        let blocks = lanes.div_ceil(BLOCK);
        let whole = lanes.next_multiple_of(8);
        for step in &self.steps {
            let strips = strips.as_mut_ptr();
            // What most steps are has a short way of its own: it is felt where a program is many light operators.
            if step.guard.is_none() && step.out.len() == 1 {
                let find = |operand: Operand| match operand {
                    Operand::Known(i) => std::slice::from_ref(&self.known[usize::from(i)]),
                    Operand::Input(i) => &inputs[usize::from(i)][..blocks],
                    // SAFETY: there are `self.strips` strips, and it is not the one that is written below.
                    Operand::Strip(i) => unsafe { &(&(*strips.add(usize::from(i))).0)[..blocks] },
                };
                // SAFETY: likewise.
                let out = unsafe { &mut (&mut (*strips.add(usize::from(step.out[0]))).0)[..blocks] };
                match step.args[..] {
                    [a] => step.op.run(isa, whole, &[find(a)], &mut [out]),
                    [a, b] => step.op.run(isa, whole, &[find(a), find(b)], &mut [out]),
                    [a, b, c] => step.op.run(isa, whole, &[find(a), find(b), find(c)], &mut [out]),
                    _ => {
                        let args: SmallVec<[&[Block]; ARGUMENTS]> =
                            step.args.iter().map(|&a| find(a)).collect();
                        step.op.run(isa, whole, &args, &mut [out]);
                    }
                }
                after(step.of);
                continue;
            }
            let find = |operand: Operand, part: &Range<usize>| match operand {
                Operand::Known(i) => std::slice::from_ref(&self.known[usize::from(i)]),
                Operand::Input(i) => &inputs[usize::from(i)][part.clone()],
                // SAFETY: there are `self.strips` strips, and it is none of those that are written below.
                Operand::Strip(i) => unsafe { &(&(*strips.add(usize::from(i))).0)[part.clone()] },
            };
            let (mut part, mut some) = (0..blocks, None);
            if let Some(g) = step.guard {
                self.open(g, isa, lanes, &|operand| find(operand, &(0..blocks)), (gates, bits, lists));
                match &gates[usize::from(g)] {
                    Open::Unknown | Open::Shut => continue,
                    Open::For(_, active) if step.alone => some = Some(active),
                    Open::For(of, _) | Open::Wide(of) => part = of.clone(),
                }
            }
            let find = |operand| find(operand, &part);
            // SAFETY: likewise, and no other output of the step, as `Step::new` saw to.
            let target = |i: u16| unsafe { &mut (&mut (*strips.add(usize::from(i))).0)[part.clone()] };
            let whole = whole.min(part.end * BLOCK) - part.start * BLOCK;
            let args: SmallVec<[&[Block]; ARGUMENTS]> = step.args.iter().map(|&arg| find(arg)).collect();
            let mut out: SmallVec<[&mut [Block]; RESULTS]> = step.out.iter().map(|&i| target(i)).collect();
            match some {
                None => step.op.run(isa, whole, &args, &mut out),
                Some(active) => run_alone(&step.op, isa, active, &args, &mut out, packed),
            }
            after(step.of);
        }
        for (k, &result) in self.results.iter().enumerate() {
            match result {
                Operand::Known(_) => {}
                Operand::Input(i) => take(k, &inputs[usize::from(i)][..blocks]),
                Operand::Strip(i) => take(k, &strips[usize::from(i)].0[..blocks]),
            }
        }
    }

    /// Looks how far a gate is open, if that is not known yet.
    fn open<'a>(
        &self,
        g: u16,
        isa: Isa,
        lanes: usize,
        find: &impl Fn(Operand) -> &'a [Block],
        (gates, bits, lists): (&mut [Open], &mut Vec<u32>, &mut Vec<Vec<u32>>),
    ) {
        let at = usize::from(g);
        if !matches!(gates[at], Open::Unknown) {
            return;
        }
        let gate = &self.gates[at];
        let mut within = 0..lanes;
        if let Some(around) = gate.around {
            self.open(around, isa, lanes, find, (gates, bits, lists));
            match &gates[usize::from(around)] {
                Open::Unknown | Open::Shut => {
                    gates[at] = Open::Shut;
                    return;
                }
                Open::Wide(part) | Open::For(part, _) => {
                    within = part.start * BLOCK..lanes.min(part.end * BLOCK);
                }
            }
        }
        bits.resize(STRIP, 0);
        let bits = &mut bits[..lanes];
        bits[..within.start].fill(0);
        bits[within.end..].fill(0);
        let truth = &find(gate.lanes).as_flattened()[within.clone()];
        let count = isa.run(|| {
            bits[within].iter_mut().zip(truth).fold(0_u32, |count, (bits, x)| {
                *bits = if *x != 0.0 { !0 } else { 0 };
                count.wrapping_sub(*bits)
            })
        });
        if count == 0 {
            gates[at] = Open::Shut;
            return;
        }
        let on = |bits: &[u32]| bits.iter().fold(0, |any, bits| any | bits) != 0;
        let first = bits.chunks(BLOCK).position(on).unwrap_or(0);
        let part = first..bits.chunks(BLOCK).rposition(on).map_or(0, |last| last + 1);
        gates[at] = if count as usize * 4 >= part.len() * BLOCK * 3 {
            Open::Wide(part)
        } else if gate.alone {
            Open::For(part, Active::of_bits(bits, isa, lists.pop().unwrap_or_default()))
        } else {
            Open::For(part, Active::All(0))
        };
    }
}

/// Does an operation in some lanes alone.
fn run_alone(
    op: &Op,
    isa: Isa,
    active: &Active,
    args: &[&[Block]],
    out: &mut [&mut [Block]],
    packed: &mut Vec<Strip>,
) {
    packed.resize(packed.len().max(ARGUMENTS + RESULTS), Strip::ZERO);
    let (of_args, of_results) = packed.split_at_mut(ARGUMENTS);
    let (all, count) = (out[0].len(), active.count());
    let blocks = count.div_ceil(BLOCK);
    let from: SmallVec<[&[Block]; ARGUMENTS]> = args
        .iter()
        .zip(of_args)
        .map(|(&arg, strip)| {
            if arg.len() < all {
                return arg;
            }
            active.gather(arg.as_flattened(), 0, count, strip);
            &strip.0[..blocks]
        })
        .collect();
    let mut to: SmallVec<[&mut [Block]; RESULTS]> =
        of_results.iter_mut().take(out.len()).map(|strip| &mut strip.0[..blocks]).collect();
    op.run(isa, count.next_multiple_of(8), &from, &mut to);
    for (result, out) in to.iter().zip(out) {
        active.scatter(result.as_flattened(), 0, count, out.as_flattened_mut());
    }
}
