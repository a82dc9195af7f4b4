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
use crate::lanes::Isa;
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
            let p: [&[f32]; MOST] = std::array::from_fn(|k| p.get(k).map_or(&[][..], |x| &x[start..end]));
            block.run(isa, &self.cut(start, end), &p, &mut out[start..end]);
        }
    }

    /// The same of some lanes.
    fn cut(&self, start: usize, end: usize) -> Self {
        Sum {
            form: self.form,
            fields: self.fields,
            low: &self.low[start..end],
            high: &self.high[start..end],
            size: &self.size[start..end],
            octaves: &self.octaves[start..end],
            lacunarity: &self.lacunarity[start..end],
            gain: &self.gain[start..end],
            fade: &self.fade[start..end],
            offset: &self.offset[start..end],
        }
    }

    /// How much of an octave of this frequency enters in a lane.
    #[inline(always)]
    fn share(&self, lane: usize, octave: usize, frequency: f32) -> f32 {
        let counted = (self.octaves[lane] - octave as f32).clamp(0.0, 1.0);
        let left = (2.0 * (1.0 - frequency / self.high[lane]) / self.fade[lane]).clamp(0.0, 1.0);
        let open = self.low[lane] > 0.0 && frequency < self.high[lane];
        if open { counted * left } else { 0.0 }
    }
}

/// What is known of some lanes between octaves.
struct Block {
    /// The lanes that still have octaves, and the numbers of those, without gaps.
    lanes: [usize; BLOCK],
    frequency: [f32; BLOCK],
    size: [f32; BLOCK],
    share: [f32; BLOCK],
    /// What the octave before lets through.
    weight: [f32; BLOCK],
    sum: [f32; BLOCK],
    scaled: [[f32; BLOCK]; MOST],
    noise: [f32; BLOCK],
}

impl Block {
    fn new() -> Block {
        Block {
            lanes: [0; BLOCK],
            frequency: [0.0; BLOCK],
            size: [0.0; BLOCK],
            share: [0.0; BLOCK],
            weight: [0.0; BLOCK],
            sum: [0.0; BLOCK],
            scaled: [[0.0; BLOCK]; MOST],
            noise: [0.0; BLOCK],
        }
    }

    fn run(&mut self, isa: Isa, sum: &Sum<'_>, p: &[&[f32]; MOST], out: &mut [f32]) {
        let n = out.len();
        for lane in 0..n {
            self.lanes[lane] = lane;
            (self.frequency[lane], self.size[lane]) = (sum.low[lane], sum.size[lane]);
            (self.weight[lane], self.sum[lane]) = (1.0, 0.0);
        }
        let mut active = n;
        for octave in 0..OCTAVES {
            active = self.keep_open(sum, octave, active, out);
            if active == 0 {
                return;
            }
            let dimensions = p.iter().filter(|x| !x.is_empty()).count();
            for (scaled, p) in self.scaled[..dimensions].iter_mut().zip(p) {
                for ((scaled, lane), f) in scaled.iter_mut().zip(&self.lanes[..active]).zip(&self.frequency) {
                    *scaled = p[*lane] * f;
                }
            }
            let scaled: [&[f32]; MOST] = self.scaled.each_ref().map(|s| &s[..active]);
            let field = &sum.fields[octave.min(sum.fields.len() - 1)];
            field.noise(isa, &scaled[..dimensions], &mut self.noise[..active]);
            self.add(isa, sum, octave, active);
        }
        for (lane, sum) in self.lanes[..active].iter().zip(&self.sum) {
            out[*lane] = *sum;
        }
    }

    /// Closes the gaps that lanes leave for which there is no such octave, and gives out their sums; tells how
    /// many are left.
    fn keep_open(&mut self, sum: &Sum<'_>, octave: usize, active: usize, out: &mut [f32]) -> usize {
        let mut kept = 0;
        for i in 0..active {
            let lane = self.lanes[i];
            let share = sum.share(lane, octave, self.frequency[i]);
            if share > 0.0 {
                self.share[kept] = share;
                self.lanes[kept] = lane;
                self.frequency[kept] = self.frequency[i];
                self.size[kept] = self.size[i];
                self.weight[kept] = self.weight[i];
                self.sum[kept] = self.sum[i];
                kept += 1;
            } else {
                out[lane] = self.sum[i];
            }
        }
        kept
    }

    /// Adds an octave's noise, and goes on to the next.
    fn add(&mut self, _isa: Isa, sum: &Sum<'_>, octave: usize, active: usize) {
        for i in 0..active {
            let (lane, noise, size) = (self.lanes[i], self.noise[i], self.size[i]);
            let part = match sum.form {
                Form::Turbulence => noise.abs() * size,
                Form::Fractal => noise * size,
                Form::Ridged => {
                    let ridge = sum.offset[lane] - noise.abs();
                    let signal = ridge * ridge * self.weight[i];
                    // Musgrave's gain of 2: ridges half as high as could be still carry all of the next octave.
                    self.weight[i] = (2.0 * signal).clamp(0.0, 1.0);
                    signal * size
                }
                Form::Hybrid => {
                    let signal = (noise + sum.offset[lane]) * size;
                    let part = signal * self.weight[i];
                    self.weight[i] = if octave == 0 { part } else { part.min(1.0) * signal };
                    self.weight[i] = self.weight[i].min(1.0);
                    part
                }
            };
            self.sum[i] += part * self.share[i];
            self.frequency[i] *= sum.lacunarity[lane];
            self.size[i] = size * sum.gain[lane];
        }
    }
}
