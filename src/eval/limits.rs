//! What a program may use up at one pixel.

/// Bounds that end a runaway program with an error at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Rounds of loops and calls of functions, all told.
    pub steps: u32,
    /// Calls inside of calls.
    pub depth: u32,
    /// Scalars in one vector, at any depth.
    pub cells: usize,
    /// Bytes of the values that a thread holds. A batch that needs more is cut into smaller ones first.
    pub memory: usize,
}

/// Vectors inside of vectors. What walks over a value takes stack for each level.
pub(super) const NESTING: usize = 64;

impl Default for Limits {
    fn default() -> Limits {
        Limits { steps: 100_000, depth: 256, cells: 65_536, memory: 512 << 20 }
    }
}
