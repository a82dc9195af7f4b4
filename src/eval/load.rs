//! The outer variables of a batch: filled from the image when they are first looked at.

use super::bind::Source;
use super::input::InputVariable;
use super::machine::{Machine, Slot};
use super::pixels::{Batch, Pixels};
use crate::resolve::tree::Place;

impl<'r> Machine<'r> {
    /// Begins with the variables of these pixels: fills those that the program may change. Those that differ from
    /// pixel to pixel are filled when they are first looked at.
    pub fn load(&mut self, pixels: Pixels<'_>) {
        self.pixels = match pixels {
            Pixels::Run(start, n) => Batch::Run(start, n),
            Pixels::List(list) => Batch::List(list.into()),
        };
        self.places.clear();
        if let Some(sample) = self.sample {
            let place = |lane| sample.offset(self.bound.position(pixels.at(lane)));
            self.places.extend((0..pixels.len()).map(place));
        }
        for (i, global) in self.program.globals.iter().enumerate() {
            let source = &self.bound.sources[i];
            self.pending[i] = source.varies();
            // What nobody changes stays from batch to batch.
            if self.pending[i] {
                self.globals[i] = Slot::EMPTY;
            } else if global.assigned.is_some() || self.globals[i].value.is_none() {
                self.globals[i] = source.slot(pixels, self.bound, &self.places);
            }
        }
    }

    /// Fills an outer variable if it was not looked at yet.
    #[inline]
    pub(super) fn settle(&mut self, i: usize) {
        if self.pending[i] {
            self.fill(i);
        }
    }

    #[cold]
    fn fill(&mut self, i: usize) {
        self.pending[i] = false;
        let pixels = match &self.pixels {
            Batch::Run(start, n) => Pixels::Run(*start, *n),
            Batch::List(list) => Pixels::List(list),
        };
        // A statement that shadows do not run may be the first that looks at it.
        self.globals[i] = match self.program.derivatives && self.bound.neighbours.is_some() {
            false => self.bound.sources[i].slot(pixels, self.bound, &self.places),
            true => self.bound.sources[i].shadowed_slot(pixels, self.bound, &self.places),
        };
    }

    /// Fills what is wanted when the batch is done.
    pub fn settle_outputs(&mut self) {
        for i in 0..self.globals.len() {
            if self.wanted(Place::Global(i as u32)) {
                self.settle(i);
            }
        }
    }

    /// Forgets what an outer variable holds, which no lane wants any more.
    pub fn forget(&mut self, place: Place) {
        if let Place::Global(i) = place {
            self.pending[i as usize] = false;
        }
    }

    /// The image's variable that an outer variable still is, untouched, and the first pixel of the batch, if its
    /// pixels follow each other.
    pub fn untouched(&self, place: Place) -> Option<(InputVariable<'r>, usize)> {
        match (place, &self.pixels) {
            // With shadows there is more than the image holds.
            (Place::Global(i), Batch::Run(start, n))
                if self.pending[i as usize] && *n == self.n && !self.shadowed() =>
            {
                match &self.bound.sources[i as usize] {
                    Source::Input(variable) => {
                        let variable = self.bound.inputs.get(*variable);
                        variable.is_contiguous().then_some((variable, *start))
                    }
                    _ => None,
                }
            }
            _ => None,
        }
    }
}
