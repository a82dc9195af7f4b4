//! The operations of a plan as they are found: each once, however often its value is used.

use super::op::{Arith, Cost, Op};
use super::strip::{BLOCK, Block, zip};
use crate::diagnostic::Span;
use crate::lanes::Isa;
use smallvec::SmallVec;
use std::collections::HashMap;

/// One number a lane: known, or the result of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cell {
    /// The same in all lanes; its bits.
    Known(u32),
    /// By the number of the result.
    Result(u32),
}

impl Cell {
    pub fn number(x: f32) -> Cell {
        Cell::Known(x.to_bits())
    }

    pub fn known(self) -> Option<f32> {
        match self {
            Cell::Known(bits) => Some(f32::from_bits(bits)),
            Cell::Result(_) => None,
        }
    }
}

pub type Cells = SmallVec<[Cell; 4]>;

/// An operation.
pub struct Node {
    pub op: Op,
    pub args: Cells,
    /// The number of its first result; the others follow.
    pub first: u32,
    /// How many results it has.
    pub results: usize,
    /// The guard under which it is wanted.
    pub guard: Option<u32>,
    /// The statement that first wanted it.
    pub of: Span,
}

/// Lanes that alone want some operations: those of a branch. In the others these may be left undone, or done with
/// whatever numbers there are; what comes of it is not looked at.
#[derive(Clone, Copy, PartialEq)]
pub struct Guard {
    /// The result that is not 0 in them. It is computed under the guard around.
    pub cell: Cell,
    /// The guard around, whose lanes have all of its own.
    pub around: Option<u32>,
}

/// The operations, in an order in which they can be done.
pub struct Graph {
    isa: Isa,
    pub nodes: Vec<Node>,
    /// The results so far.
    pub results: u32,
    pub guards: Vec<Guard>,
    /// The guard of what is followed.
    pub guard: Option<u32>,
    /// Light operations under guards, which are computed in lanes that don't want them.
    pub spare: u32,
    seen: HashMap<(super::op::Key, Option<u32>, Cells), u32>,
    /// The statement that is followed.
    pub at: Span,
}

impl Graph {
    pub fn new(isa: Isa) -> Graph {
        Graph {
            isa,
            nodes: Vec::new(),
            results: 0,
            guards: Vec::new(),
            guard: None,
            spare: 0,
            seen: HashMap::new(),
            at: Span::default(),
        }
    }

    /// What follows is wanted only where the condition has this truth, until [`Graph::guard`] is put back.
    pub fn enter(&mut self, condition: Cell, truth: bool) {
        let around = self.guard;
        let cell = match (around.map(|g| self.guards[g as usize].cell), truth) {
            (None, true) => condition,
            (None, false) => self.not(condition),
            (Some(g), true) => self.one(
                Op::Zip(|isa, args, out| {
                    zip(isa, args, out, |[g, c]| f32::from(u8::from((g != 0.0) & (c != 0.0))))
                }),
                &[g, condition],
            ),
            (Some(g), false) => self.one(
                Op::Zip(|isa, args, out| {
                    zip(isa, args, out, |[g, c]| f32::from(u8::from((g != 0.0) & (c == 0.0))))
                }),
                &[g, condition],
            ),
        };
        let guard = Guard { cell, around };
        let at = self.guards.iter().position(|g| *g == guard).unwrap_or_else(|| {
            self.guards.push(guard);
            self.guards.len() - 1
        });
        self.guard = Some(at as u32);
    }

    /// `!a`
    pub fn not(&mut self, a: Cell) -> Cell {
        self.one(
            Op::Zip(|isa, args, out| {
                zip(isa, args, out, |[a]: [f32; 1]| if a == 0.0 { 1.0 } else { 0.0 });
            }),
            &[a],
        )
    }

    /// A new operation, or an old one of the same arguments: its first result.
    pub fn add(&mut self, op: Op, args: &[Cell], results: usize) -> u32 {
        let mut args: Cells = args.into();
        if !op.takes_blocks() {
            for arg in &mut args {
                if let Cell::Known(_) = arg {
                    *arg = Cell::Result(self.add(Op::Fill, &[*arg], 1));
                }
            }
        }
        let mut guard = self.guard;
        let mut key = op.key().map(|key| (key, guard, args.clone()));
        if let Some(key) = &mut key {
            // What the guards around want has been done in these lanes too.
            loop {
                if let Some(first) = self.seen.get(key) {
                    return *first;
                }
                let Some(g) = key.1 else { break };
                key.1 = self.guards[g as usize].around;
            }
            key.1 = guard;
        } else {
            // An input is there for all.
            guard = None;
        }
        let first = self.results;
        self.results += results as u32;
        if let Some(key) = key {
            self.seen.insert(key, first);
        }
        if guard.is_some() && op.cost() == Cost::Light {
            self.spare += 1;
        }
        self.nodes.push(Node { op, args, first, results, guard, of: self.at });
        first
    }

    /// What an operation with one result makes of cells; of known numbers at once.
    pub fn one(&mut self, op: Op, args: &[Cell]) -> Cell {
        self.several(op, args, 1)[0]
    }

    /// The like with several results.
    pub fn several(&mut self, op: Op, args: &[Cell], results: usize) -> Cells {
        let known: Option<SmallVec<[Block; 6]>> =
            args.iter().map(|a| a.known().map(|x| [x; BLOCK])).collect();
        if let Some(blocks) = known {
            let args: SmallVec<[&[Block]; 6]> = blocks.iter().map(std::slice::from_ref).collect();
            let mut out = [[[0.0; BLOCK]]; 4];
            let mut rows: SmallVec<[&mut [Block]; 4]> =
                out.iter_mut().take(results).map(|o| &mut o[..]).collect();
            // Eight lanes of the same number.
            op.run(self.isa, 8, &args, &mut rows);
            drop(rows);
            return out[..results].iter().map(|o| Cell::number(o[0][0])).collect();
        }
        let first = self.add(op, args, results);
        (first..first + results as u32).map(Cell::Result).collect()
    }

    pub fn arith(&mut self, a: Arith, x: Cell, y: Cell) -> Cell {
        self.one(Op::Arith(a), &[x, y])
    }
}

/// Which nodes the results that are wanted need, and how often each result is used. With `guards`, what tells their lanes
/// is wanted too.
fn needed(graph: &Graph, wanted: &[Cell], guards: bool) -> (Vec<bool>, Vec<u32>) {
    let mut uses = vec![0_u32; graph.results as usize];
    let mut needed = vec![false; graph.nodes.len()];
    let count = |cell: &Cell, uses: &mut [u32]| {
        if let Cell::Result(id) = cell {
            uses[*id as usize] += 1;
        }
    };
    wanted.iter().for_each(|cell| count(cell, &mut uses));
    for (node, needed) in graph.nodes.iter().zip(&mut needed).rev() {
        let ids = node.first as usize..node.first as usize + node.results;
        *needed = uses[ids].iter().any(|&n| n > 0);
        if *needed {
            node.args.iter().for_each(|cell| count(cell, &mut uses));
            if guards {
                around(&graph.guards, node.guard).for_each(|g| count(&graph.guards[g].cell, &mut uses));
            }
        }
    }
    (needed, uses)
}

/// A guard, and those around it.
pub fn around(guards: &[Guard], guard: Option<u32>) -> impl Iterator<Item = usize> {
    std::iter::successors(guard, |&g| guards[g as usize].around).map(|g| g as usize)
}

/// What there must be to compute under a guard for it to be looked at, in light operations.
const WORTH: u32 = 4;
/// What a heavy operation counts.
const HEAVY: u32 = 8;

/// Takes the guards away under which there is too little to compute.
fn weigh(graph: &mut Graph, wanted: &[Cell]) {
    let (keep, _) = needed(graph, wanted, false);
    let mut costs = vec![0; graph.guards.len()];
    for (node, _) in graph.nodes.iter().zip(keep).filter(|(_, keep)| *keep) {
        let cost = if node.op.cost() == Cost::Heavy { HEAVY } else { 1 };
        around(&graph.guards, node.guard).for_each(|g| costs[g] += cost);
    }
    // What a guard has, those around it have too.
    let worth =
        |guard: Option<u32>| around(&graph.guards, guard).find(|&g| costs[g] >= WORTH).map(|g| g as u32);
    for node in &mut graph.nodes {
        node.guard = worth(node.guard);
    }
}

/// Drops what is not wanted, and joins operators whose result one other alone takes.
pub fn reduce(graph: &mut Graph, wanted: &[Cell]) {
    weigh(graph, wanted);
    let (mut keep, uses) = needed(graph, wanted, true);
    let nodes = &mut graph.nodes;
    let mut maker = vec![usize::MAX; graph.results as usize];
    for (i, node) in nodes.iter().enumerate() {
        maker[node.first as usize..][..node.results].fill(i);
    }
    for i in (0..nodes.len()).rev() {
        let Op::Arith(outer) = nodes[i].op else { continue };
        if !keep[i] {
            continue;
        }
        let joinable = |cell: Cell| match cell {
            Cell::Result(id) if uses[id as usize] == 1 => {
                let made = &nodes[maker[id as usize]];
                if let Op::Arith(inner) = made.op { Some((maker[id as usize], inner)) } else { None }
            }
            _ => None,
        };
        let [a, b] = [nodes[i].args[0], nodes[i].args[1]];
        if let Some((at, inner)) = joinable(b) {
            let args = [a, nodes[at].args[0], nodes[at].args[1]];
            (nodes[i].op, nodes[i].args) = (Op::Right(outer, inner), args.into_iter().collect());
            keep[at] = false;
        } else if let Some((at, inner)) = joinable(a) {
            let args = [nodes[at].args[0], nodes[at].args[1], b];
            (nodes[i].op, nodes[i].args) = (Op::Left(outer, inner), args.into_iter().collect());
            keep[at] = false;
        }
    }
    let mut keep = keep.into_iter();
    nodes.retain(|_| keep.next().unwrap_or(false));
}
