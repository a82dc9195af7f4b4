//! Strips of lanes, and the loops that run over them.

use crate::lanes::{Isa, Kernel, array};

/// Lanes of a block, which a kernel takes at a time.
pub const BLOCK: usize = 64;
/// Blocks of a strip.
const BLOCKS: usize = 8;
/// Lanes of a strip: few enough that all strips of a plan stay in the nearest cache, enough to spread the cost of
/// a visit.
pub const STRIP: usize = BLOCK * BLOCKS;

/// Neighbouring lanes. What is the same in all lanes is a single block, taken again and again.
pub type Block = [f32; BLOCK];

/// One number for each lane of a strip, on cache lines of its own.
#[derive(Clone)]
#[repr(align(64))]
pub struct Strip(pub [Block; BLOCKS], #[expect(dead_code, reason = "room")] Gap);

/// What lies between strips. Without it the same lane of every other strip would have the same address but for multiples of
/// 4096, and the processor would take a read of one for a read of what it is about to write to another.
type Gap = [f32; 144];

impl Strip {
    pub const ZERO: Strip = Strip([[0.0; BLOCK]; BLOCKS], [0.0; 144]);
}

/// A kernel that makes one strip of several, lane by lane.
pub type Zip = fn(Isa, &[&[Block]], &mut [Block]);

/// `out = f(args)`, lane by lane. `f` should be `#[inline(always)]`, or a closure of a line or two.
///
/// # Panics
/// If there are not `N` arguments, or if one is empty.
#[inline]
pub fn zip<const N: usize>(isa: Isa, args: &[&[Block]], out: &mut [Block], f: impl Fn([f32; N]) -> f32) {
    let args: [&[Block]; N] = array(|k| args[k]);
    isa.run(Zipped { args, out, f });
}

struct Zipped<'a, const N: usize, F> {
    args: [&'a [Block]; N],
    out: &'a mut [Block],
    f: F,
}

impl<const N: usize, F: Fn([f32; N]) -> f32> Kernel for Zipped<'_, N, F> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let last: [usize; N] = array(|k| self.args[k].len() - 1);
        for (b, out) in self.out.iter_mut().enumerate() {
            let blocks: [&Block; N] = array(|k| &self.args[k][b.min(last[k])]);
            let mut result = [0.0; BLOCK];
            for i in 0..BLOCK {
                result[i] = (self.f)(array(|k| blocks[k][i]));
            }
            *out = result;
        }
    }
}

/// The like for the most frequent operators: what is the same in all lanes is kept in a register.
///
/// # Panics
/// If there are not `N` arguments, 2 or 3, or if one is neither a single block nor as long as the output.
#[inline]
pub fn zip_numbers<const N: usize>(
    isa: Isa,
    args: &[&[Block]],
    out: &mut [Block],
    f: impl Fn([f32; N]) -> f32,
) {
    const { assert!(N == 2 || N == 3) };
    let args: [&[Block]; N] = array(|k| args[k]);
    // An output of one block is as long as a number.
    let known = (0..N).fold(0, |known, k| known | usize::from(args[k].len() < out.len()) << k);
    match known {
        0 => isa.run(WithNumbers::<N, 0, _> { args, out, f }),
        1 => isa.run(WithNumbers::<N, 1, _> { args, out, f }),
        2 => isa.run(WithNumbers::<N, 2, _> { args, out, f }),
        3 => isa.run(WithNumbers::<N, 3, _> { args, out, f }),
        4 => isa.run(WithNumbers::<N, 4, _> { args, out, f }),
        5 => isa.run(WithNumbers::<N, 5, _> { args, out, f }),
        6 => isa.run(WithNumbers::<N, 6, _> { args, out, f }),
        _ => isa.run(WithNumbers::<N, 7, _> { args, out, f }),
    }
}

/// The arguments whose bit is set in `KNOWN` are numbers.
struct WithNumbers<'a, const N: usize, const KNOWN: usize, F> {
    args: [&'a [Block]; N],
    out: &'a mut [Block],
    f: F,
}

impl<const N: usize, const KNOWN: usize, F: Fn([f32; N]) -> f32> Kernel for WithNumbers<'_, N, KNOWN, F> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let n = self.out.len();
        let numbers: [f32; N] = array(|k| self.args[k][0][0]);
        let args: [&[Block]; N] =
            array(|k| if KNOWN >> k & 1 == 1 { self.args[k] } else { &self.args[k][..n] });
        for (b, out) in self.out.iter_mut().enumerate() {
            let mut result = [0.0; BLOCK];
            for i in 0..BLOCK {
                result[i] = (self.f)(array(|k| if KNOWN >> k & 1 == 1 { numbers[k] } else { args[k][b][i] }));
            }
            *out = result;
        }
    }
}
