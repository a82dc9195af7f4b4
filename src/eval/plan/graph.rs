//! The operations of a plan as they are found: each once, however often its value is used.

use super::op::{Arith, Op};
use super::strip::{BLOCK, Block};
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
    /// The statement that first wanted it.
    pub of: Span,
}

/// The operations, in an order in which they can be done.
pub struct Graph {
    isa: Isa,
    pub nodes: Vec<Node>,
    /// The results so far.
    pub results: u32,
    seen: HashMap<(super::op::Key, Cells), u32>,
    /// The statement that is followed.
    pub at: Span,
}

impl Graph {
    pub fn new(isa: Isa) -> Graph {
        Graph { isa, nodes: Vec::new(), results: 0, seen: HashMap::new(), at: Span::default() }
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
        let key = op.key().map(|key| (key, args.clone()));
        if let Some(first) = key.as_ref().and_then(|key| self.seen.get(key)) {
            return *first;
        }
        let first = self.results;
        self.results += results as u32;
        if let Some(key) = key {
            self.seen.insert(key, first);
        }
        self.nodes.push(Node { op, args, first, results, of: self.at });
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

/// Which nodes the results that are wanted need.
fn needed(nodes: &[Node], results: u32, wanted: &[Cell]) -> (Vec<bool>, Vec<u32>) {
    let mut uses = vec![0_u32; results as usize];
    let mut needed = vec![false; nodes.len()];
    let mut count = |cell: &Cell| {
        if let Cell::Result(id) = cell {
            uses[*id as usize] += 1;
        }
    };
    wanted.iter().for_each(&mut count);
    for (node, needed) in nodes.iter().zip(&mut needed).rev() {
        let ids = node.first as usize..node.first as usize + node.results;
        *needed = uses[ids].iter().any(|&n| n > 0);
        if *needed {
            for arg in &node.args {
                if let Cell::Result(id) = arg {
                    uses[*id as usize] += 1;
                }
            }
        }
    }
    (needed, uses)
}

/// Drops what is not wanted, and joins operators whose result one other alone takes.
pub fn reduce(mut nodes: Vec<Node>, results: u32, wanted: &[Cell]) -> Vec<Node> {
    let (mut keep, uses) = needed(&nodes, results, wanted);
    let mut maker = vec![usize::MAX; results as usize];
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
    nodes
}
