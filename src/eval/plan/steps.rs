//! A plan: steps on numbered strips, and how they are run.

use super::graph::{Cell, Graph, Node, reduce};
use super::op::{ARGUMENTS, Op};
use super::strip::{BLOCK, Block, STRIP, Strip};
use crate::diagnostic::Span;
use crate::lanes::Isa;
use smallvec::SmallVec;

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
    /// The statement that it is of.
    of: Span,
}

/// The most results of a step.
const RESULTS: usize = 4;

impl Step {
    /// # Panics
    /// If a strip is written that is also read, or written twice: running the step relies on it.
    fn new(op: Op, args: SmallVec<[Operand; 6]>, out: SmallVec<[u16; 4]>, of: Span, strips: u16) -> Step {
        assert!(args.len() <= ARGUMENTS && out.len() <= RESULTS);
        for (k, &strip) in out.iter().enumerate() {
            assert!(strip < strips && !out[..k].contains(&strip) && !args.contains(&Operand::Strip(strip)));
        }
        assert!(args.iter().all(|arg| !matches!(arg, Operand::Strip(i) if *i >= strips)));
        Step { op, args, out, of }
    }
}

/// Steps, one after another.
pub struct Steps {
    steps: Vec<Step>,
    known: Vec<Block>,
    strips: usize,
    /// Where the results are that were asked for; [`Operand::Known`] where they are numbers.
    pub results: Vec<Operand>,
    /// The numbers of the inputs that are read.
    pub inputs: Vec<usize>,
}

/// Strips for what is between, kept from run to run.
#[derive(Default)]
pub struct Scratch(Vec<Strip>);

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
    pub fn new(graph: Graph, wanted: &[Cell]) -> Steps {
        let results = graph.results;
        let nodes = reduce(graph.nodes, results, wanted);
        let mut last = vec![0; results as usize];
        for (i, node) in nodes.iter().enumerate() {
            let ids =
                node.args.iter().filter_map(|a| if let Cell::Result(id) = a { Some(*id) } else { None });
            ids.for_each(|id| last[id as usize] = i);
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
        let mut steps = Vec::new();
        for (i, node) in nodes.into_iter().enumerate() {
            let Node { op, args: cells, first, results, of } = node;
            if let Op::Input(number) = op {
                to.places[first as usize] = Some(Operand::Input(to.inputs.len() as u16));
                to.inputs.push(number);
                continue;
            }
            let args = cells.iter().map(|&cell| to.operand(cell)).collect();
            // Before its arguments are given back: no kernel writes where it reads.
            let ids = first..first + results as u32;
            let out: SmallVec<[u16; 4]> = ids.clone().map(|_| to.strip()).collect();
            for (id, &strip) in ids.clone().zip(&out) {
                to.places[id as usize] = Some(Operand::Strip(strip));
            }
            let mut done: SmallVec<[u32; 6]> = cells
                .iter()
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
            steps.push(Step::new(op, args, out, of, to.strips));
        }
        let results = wanted.iter().map(|&cell| to.operand(cell)).collect();
        Steps { steps, known: to.known, strips: usize::from(to.strips), results, inputs: to.inputs }
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
        scratch.0.resize(scratch.0.len().max(self.strips), Strip::ZERO);
        let blocks = lanes.div_ceil(BLOCK);
        let lanes = lanes.next_multiple_of(8);
        for step in &self.steps {
            let strips = scratch.0.as_mut_ptr();
            let mut args: [&[Block]; ARGUMENTS] = [&[]; ARGUMENTS];
            for (arg, &operand) in args.iter_mut().zip(&step.args) {
                *arg = match operand {
                    Operand::Known(i) => std::slice::from_ref(&self.known[usize::from(i)]),
                    Operand::Input(i) => &inputs[usize::from(i)][..blocks],
                    // SAFETY: there are `self.strips` strips, and it is none of those that are written below.
                    Operand::Strip(i) => unsafe { &(&(*strips.add(usize::from(i))).0)[..blocks] },
                };
            }
            let mut out: [&mut [Block]; RESULTS] = [&mut [], &mut [], &mut [], &mut []];
            for (out, &i) in out.iter_mut().zip(&step.out) {
                // SAFETY: likewise, and no other output of the step, as `Step::new` saw to.
                *out = unsafe { &mut (&mut (*strips.add(usize::from(i))).0)[..blocks] };
            }
            step.op.run(isa, lanes, &args[..step.args.len()], &mut out[..step.out.len()]);
            after(step.of);
        }
        for (k, &result) in self.results.iter().enumerate() {
            match result {
                Operand::Known(_) => {}
                Operand::Input(i) => take(k, &inputs[usize::from(i)][..blocks]),
                Operand::Strip(i) => take(k, &scratch.0[usize::from(i)].0[..blocks]),
            }
        }
    }
}
