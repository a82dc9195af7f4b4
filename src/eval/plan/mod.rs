//! Plans: statements as straight lines of operations on short strips of lanes.
//!
//! The walk over the tree ([`super`]) says what a program means. Each of its visits costs as much as some hundred
//! lanes of an addition, so a batch has to be wide, and then what is between does not fit into the nearest cache.
//! Where statements cannot fail, there is a shorter way: they are followed once with the
//! values that are the same in all lanes known (Perlin's "quantities that vary slowly", 1985), loops and calls gone
//! through, constants folded, equal operations done once, and those that nobody wants dropped. What remains is a
//! plan: it is run strip by strip, for the active lanes alone, and kept for all batches in which the same is known.
//!
//! A lane's result is the same bits either way: each operation is the one that the evaluator does.

mod active;
mod branch;
mod build;
mod builtins;
mod expr;
mod graph;
mod op;
mod run;
mod steps;
mod strip;
mod wanted;

pub(super) use run::Plans;
