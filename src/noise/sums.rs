//! Sums of octaves: noise of any kind, at frequencies that grow from one to the next, in sizes that shrink.
//!
//! Contract
//! - each lane stops at its own octave; its result depends on that lane only
//! - no octave of the frequency `high` or above enters, and the last below it fades out, so that nothing pops as
//!   `high` moves
//!
//! Sources: Perlin 1985, Appendix; Perlin 1992, section 3.6.1; Peachey, "Clamping" and "Spectral Synthesis";
//! `Ridged` and `Hybrid` are the multifractals of F. K. Musgrave in the same book as Peachey's text.

use super::field::Field;
use crate::lanes::{Isa, Kernel};
use std::sync::Arc;

/// No more octaves than this: the next would be of size 2^-24, below the last bit of a sum near 1.
pub const OCTAVES: usize = 24;

/// How an octave enters the sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Its absolute value: creases at all scales.
    Turbulence,
    /// As it is.
    Fractal,
    /// The square of offset less its absolute value, less of it where the octave before was low: sharp
    /// ridges, rough near their tops only.
    Ridged,
    /// With offset added, less of it where the sum so far is low: smooth valleys, rough heights.
    Hybrid,
}

/// A sum of octaves: in each lane Σ `form`(noise(p · f)) · a for f = `low`, `low` · `lacunarity` …, of which the
/// sizes are a = `size`, `size` · `gain` …; all slices of one length.
#[derive(Clone, Copy)]
pub struct Sum<'a> {
    /// How octaves enter.
    pub form: Form,
    /// The noise of each octave; the last is that of all that follow.
    pub fields: &'a [Arc<dyn Field>],
    /// The lowest frequency. Where it is not above 0 there are no octaves.
    pub low: &'a [f32],
    /// The octaves end where f is not below this: half a cycle a sample, say (Peachey's cutoff).
    pub high: &'a [f32],
    /// How the octaves end: 1 lets them fade out from half of `high` on, as Peachey does; 0 is a sharp end,
    /// as in Perlin's loops.
    pub fade: &'a [f32],
    /// The size of the first octave.
    pub size: &'a [f32],
    /// How many octaves; of a fraction the last enters in part. At most [`OCTAVES`].
    pub octaves: &'a [f32],
    /// By what the frequency grows from octave to octave.
    pub lacunarity: &'a [f32],
    /// By what the size shrinks.
    pub gain: &'a [f32],
    /// The offset of `Ridged` and `Hybrid`.
    pub offset: &'a [f32],
}

/// So many lanes are summed at a time: few enough that all their numbers stay in the nearest cache.
const BLOCK: usize = 256;
/// The most coordinates of a point.
const MOST: usize = 4;

impl Sum<'_> {
    /// Computes the sum at the point of each lane.
    ///
    /// # Panics
    /// If lengths differ, if there is no field, or if the fields are not for as many coordinates as p has.
    pub fn run(&self, isa: Isa, p: &[&[f32]], out: &mut [f32]) {
        assert!((1..=MOST).contains(&p.len()), "a sum for {} coordinates", p.len());
        let all = [self.low, self.high, self.size, self.octaves, self.lacunarity, self.gain];
        let all = all.iter().chain([&self.fade, &self.offset]).chain(p);
        assert!({ all }.all(|lanes| lanes.len() == out.len()), "lanes of different lengths");
        let mut block = Block::new();
        for start in (0..out.len()).step_by(BLOCK) {
            let end = (start + BLOCK).min(out.len());
            block.run(isa, self, start, p, &mut out[start..end]);
        }
    }
}

/// The numbers of some lanes that still have octaves, without gaps.
struct Block {
    /// Which lanes they are.
    lanes: [usize; BLOCK],
    /// In the order of [`Number`].
    numbers: [[f32; BLOCK]; NUMBERS],
    /// How much of the octave enters.
    share: [f32; BLOCK],
    scaled: [[f32; BLOCK]; MOST],
    noise: [f32; BLOCK],
}

/// What is known of a lane. The coordinates of its point follow the last.
#[derive(Clone, Copy)]
enum Number {
    Frequency,
    High,
    Fade,
    Size,
    /// How many octaves are left.
    Octaves,
    Lacunarity,
    Gain,
    Offset,
    /// What the octave before lets through.
    Weight,
    Sum,
    Point,
}
use Number::{Fade, Frequency, Gain, High, Lacunarity, Octaves, Offset, Point, Size, Weight};

const NUMBERS: usize = Point as usize + MOST;

impl Block {
    fn new() -> Block {
        Block {
            lanes: [0; BLOCK],
            numbers: [[0.0; BLOCK]; NUMBERS],
            share: [0.0; BLOCK],
            scaled: [[0.0; BLOCK]; MOST],
            noise: [0.0; BLOCK],
        }
    }

    fn run(&mut self, isa: Isa, sum: &Sum<'_>, start: usize, p: &[&[f32]], out: &mut [f32]) {
        let n = out.len();
        let given = [
            (Frequency, sum.low),
            (High, sum.high),
            (Fade, sum.fade),
            (Size, sum.size),
            (Octaves, sum.octaves),
            (Lacunarity, sum.lacunarity),
            (Gain, sum.gain),
            (Offset, sum.offset),
        ];
        for (number, lanes) in given {
            self.numbers[number as usize][..n].copy_from_slice(&lanes[start..start + n]);
        }
        for (k, p) in p.iter().enumerate() {
            self.numbers[Point as usize + k][..n].copy_from_slice(&p[start..start + n]);
        }
        self.numbers[Weight as usize][..n].fill(1.0);
        self.numbers[Number::Sum as usize][..n].fill(0.0);
        self.lanes = std::array::from_fn(|lane| lane);
        let mut active = n;
        for octave in 0..OCTAVES {
            if isa.run(Shares { block: self, active }) {
                active = self.close_gaps(active, out);
            }
            if active == 0 {
                return;
            }
            let scaled: [&[f32]; MOST] = self.scaled.each_ref().map(|s| &s[..active]);
            let field = &sum.fields[octave.min(sum.fields.len() - 1)];
            field.noise(isa, &scaled[..p.len()], &mut self.noise[..active]);
            isa.run(Add { block: self, form: sum.form, active });
        }
        for (lane, sum) in self.lanes[..active].iter().zip(&self.numbers[Number::Sum as usize]) {
            out[*lane] = *sum;
        }
    }

    /// Gives out the sums of lanes that have no such octave, and closes the gaps that they leave; tells how many
    /// are left.
    fn close_gaps(&mut self, active: usize, out: &mut [f32]) -> usize {
        let mut kept = 0;
        for i in 0..active {
            if self.share[i] > 0.0 {
                self.lanes[kept] = self.lanes[i];
                self.share[kept] = self.share[i];
                for numbers in self.numbers.iter_mut().chain(&mut self.scaled) {
                    numbers[kept] = numbers[i];
                }
                kept += 1;
            } else {
                out[self.lanes[i]] = self.numbers[Number::Sum as usize][i];
            }
        }
        kept
    }
}

/// Finds how much of an octave enters in each lane, and its points. Tells whether it is nothing in any.
struct Shares<'a> {
    block: &'a mut Block,
    active: usize,
}

impl Kernel for Shares<'_> {
    type Output = bool;
    #[inline(always)]
    fn run(self) -> bool {
        let Block { numbers, share, scaled, .. } = self.block;
        let of = |number: Number| &numbers[number as usize];
        let mut open = true;
        for (i, share) in share[..self.active].iter_mut().enumerate() {
            let frequency = of(Frequency)[i];
            let counted = of(Octaves)[i].clamp(0.0, 1.0);
            // Peachey's fade: 1 up to half of the cutoff frequency, then down to 0.
            let left = (2.0 * (1.0 - frequency / of(High)[i]) / of(Fade)[i]).clamp(0.0, 1.0);
            let within = frequency > 0.0 && frequency < of(High)[i];
            *share = if within { counted * left } else { 0.0 };
            open &= *share > 0.0;
        }
        for (k, scaled) in scaled.iter_mut().enumerate() {
            for i in 0..self.active {
                scaled[i] = numbers[Point as usize + k][i] * of(Frequency)[i];
            }
        }
        !open
    }
}

/// Adds an octave's noise, and goes on to the next.
struct Add<'a> {
    block: &'a mut Block,
    form: Form,
    active: usize,
}

impl Kernel for Add<'_> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        match self.form {
            Form::Turbulence => self.each(|noise, _, weight| (noise.abs(), weight)),
            Form::Fractal => self.each(|noise, _, weight| (noise, weight)),
            Form::Ridged => self.each(|noise, offset, weight| {
                let ridge = offset - noise.abs();
                let signal = ridge * ridge * weight;
                // Musgrave's gain of 2: ridges half as high as could be still carry all of the next octave.
                (signal, (2.0 * signal).clamp(0.0, 1.0))
            }),
            Form::Hybrid => self.each(|noise, offset, weight| {
                let signal = (noise + offset) * weight;
                (signal, signal)
            }),
        }
    }
}

impl Add<'_> {
    /// `signal` gives what is added of a unit's size, and the weight of the next octave, from noise, offset
    /// and weight.
    #[inline(always)]
    fn each(self, signal: impl Fn(f32, f32, f32) -> (f32, f32)) {
        let Block { numbers, share, noise, .. } = self.block;
        for i in 0..self.active {
            let of = |number: Number| numbers[number as usize][i];
            let size = of(Size);
            let (part, weight) = signal(noise[i], of(Offset), of(Weight));
            let weight = if self.form == Form::Hybrid { (weight * size).min(1.0) } else { weight };
            let sum = of(Number::Sum) + part * size * share[i];
            let (frequency, octaves) = (of(Frequency) * of(Lacunarity), of(Octaves) - 1.0);
            let size = size * of(Gain);
            numbers[Number::Sum as usize][i] = sum;
            numbers[Weight as usize][i] = weight;
            numbers[Frequency as usize][i] = frequency;
            numbers[Octaves as usize][i] = octaves;
            numbers[Size as usize][i] = size;
        }
    }
}
