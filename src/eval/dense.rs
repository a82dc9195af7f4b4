//! Running part of a program on the active lanes alone: they are gathered into a batch of their own, without the
//! lanes that are off, and what they assign is scattered back.
//!
//! A lane's result does not depend on its batch, so nothing changes but the time.

use super::fault::{Fault, Result};
use super::machine::{Machine, Slot};
use crate::resolve::tree::{Effects, Place};
use crate::value::{Lanes, Mask, Plane, Value};

/// What it costs to move a number of a lane to the dense batch or back, in the unit of [`Effects::work`].
const MOVE: u32 = 2;
/// What setting up a dense batch costs.
const SET_UP: u64 = 6000;

/// The lanes of a mask, in runs of neighbours.
pub(super) struct Gathered {
    /// The first lane of a run, and how many follow each other.
    runs: Vec<(u32, u32)>,
    /// How many lanes there are.
    count: usize,
}

impl Gathered {
    fn of(mask: &Mask, n: usize) -> Option<Gathered> {
        let Mask::Some(on) = mask else { return None };
        let mut runs: Vec<(u32, u32)> = Vec::new();
        let mut count = 0;
        let mut before = 0;
        for (lane, &bits) in on.bits(n).iter().enumerate() {
            if bits != 0 {
                if before == 0 {
                    runs.push((lane as u32, 0));
                }
                if let Some(run) = runs.last_mut() {
                    run.1 += 1;
                }
                count += 1;
            }
            before = bits;
        }
        Some(Gathered { runs, count })
    }

    /// Where each run lies in the whole batch, and where in the dense one.
    fn pieces(&self) -> impl Iterator<Item = (std::ops::Range<usize>, std::ops::Range<usize>)> {
        let mut dense = 0;
        self.runs.iter().map(move |&(start, length)| {
            let (start, length, at) = (start as usize, length as usize, dense);
            dense += length;
            (start..start + length, at..at + length)
        })
    }

    /// The lane of the whole batch that a lane of the dense one is.
    fn lane(&self, dense: usize) -> usize {
        self.pieces().find(|(_, d)| d.contains(&dense)).map_or(0, |(whole, d)| whole.start + dense - d.start)
    }

    fn gather_lanes(&self, lanes: &Lanes, n: usize) -> Lanes {
        let from = lanes.get(n);
        Lanes::filled(self.count, |to| {
            for (whole, dense) in self.pieces() {
                to[dense].copy_from_slice(&from[whole]);
            }
        })
    }

    fn gather(&self, plane: &Plane, n: usize) -> Plane {
        match plane {
            Plane::Uniform(x) => Plane::Uniform(*x),
            Plane::Varying(lanes) => Plane::Varying(self.gather_lanes(lanes, n)),
        }
    }

    fn gather_mask(&self, mask: &Mask, n: usize) -> Mask {
        match mask {
            Mask::All => Mask::All,
            Mask::None => Mask::None,
            Mask::Some(lanes) => {
                let bits = self.gather_lanes(lanes, n);
                Mask::from_fn(self.count, |i| bits.bits(self.count)[i] != 0)
            }
        }
    }

    /// The plane with the numbers of the dense batch in its lanes; in the others those of `old`, if they matter.
    fn scatter(&self, dense: &Plane, old: Option<Plane>, n: usize) -> Plane {
        let mut lanes = match (dense, old) {
            (Plane::Uniform(new), None) => return Plane::Uniform(*new),
            (Plane::Uniform(new), Some(Plane::Uniform(old))) if new.to_bits() == old.to_bits() => {
                return Plane::Uniform(old);
            }
            (_, Some(old)) => match old {
                Plane::Uniform(x) => Lanes::filled(n, |out| out.fill(x)),
                Plane::Varying(lanes) => lanes,
            },
            (_, None) => Lanes::filled(n, |out| out.fill(0.0)),
        };
        let to = lanes.get_mut(n);
        for (whole, at) in self.pieces() {
            match dense {
                Plane::Uniform(x) => to[whole].fill(*x),
                Plane::Varying(from) => to[whole].copy_from_slice(&from.get(self.count)[at]),
            }
        }
        Plane::Varying(lanes)
    }

    /// The lanes of the whole batch that a mask of the dense one has.
    fn scatter_mask(&self, dense: &Mask, n: usize) -> Mask {
        let mut on = vec![false; n];
        for (whole, at) in self.pieces() {
            for (lane, dense_lane) in whole.zip(at) {
                on[lane] = dense.has(dense_lane);
            }
        }
        Mask::from_fn(n, |lane| on[lane])
    }

    /// The fault with its lanes counted in the whole batch.
    fn fault(&self, fault: Fault, n: usize) -> Fault {
        match fault {
            Fault::Error(error, lane) => Fault::Error(error, self.lane(lane)),
            Fault::Count(lane) => Fault::Count(self.lane(lane)),
            Fault::Split(mask) => Fault::Split(self.scatter_mask(&mask, n)),
            Fault::Cancelled => Fault::Cancelled,
        }
    }
}

impl<'r> Machine<'r> {
    /// The lanes of the mask, if it saves work to run these alone.
    pub(super) fn gathered(&self, effects: &Effects, mask: &Mask) -> Option<Gathered> {
        let Mask::Some(_) = mask else { return None };
        // Not worth the count of lanes if even a batch without any would not pay.
        if effects.leaves || effects.prints || u64::from(effects.work) * self.n as u64 <= SET_UP {
            return None;
        }
        let lanes = Gathered::of(mask, self.n)?;
        let planes = |places: &[Place]| -> usize { places.iter().map(|&place| self.varying(place)).sum() };
        let moved = planes(&effects.reads) + 2 * planes(&effects.writes);
        let saved = (self.n - lanes.count) as u64 * u64::from(effects.work);
        let spent = SET_UP + lanes.count as u64 * moved as u64 * u64::from(MOVE);
        (saved > spent).then_some(lanes)
    }

    /// How many of a variable's planes differ from lane to lane.
    fn varying(&self, place: Place) -> usize {
        if let Some((variable, _)) = self.untouched(place) {
            return variable.shape.cells();
        }
        let slot = match place {
            Place::Global(i) => &self.globals[i as usize],
            Place::Local(i) => &self.locals[self.base + i as usize],
        };
        slot.value.iter().flat_map(|v| &v.planes).filter(|p| matches!(p, Plane::Varying(_))).count()
    }

    /// Runs `part`, which has these effects and does not leave them, on the lanes alone.
    pub(super) fn dense(
        &mut self,
        lanes: &Gathered,
        effects: &Effects,
        part: impl FnOnce(&mut Machine<'r>) -> Result<()>,
    ) -> Result<()> {
        let n = self.n;
        let touched = || effects.reads.iter().chain(&effects.writes);
        let before: Vec<Slot> =
            touched().map(|&place| std::mem::replace(self.slot(place), Slot::EMPTY)).collect();
        for (&place, old) in touched().zip(&before) {
            *self.slot(place) = Slot {
                value: old.value.as_ref().map(|value| Value {
                    shape: value.shape.clone(),
                    planes: value.planes.iter().map(|plane| lanes.gather(plane, n)).collect(),
                }),
                defined: lanes.gather_mask(&old.defined, n),
            };
        }
        let counts = self.set_width(lanes.count, |counts| {
            lanes.pieces().flat_map(|(whole, _)| counts[whole].to_vec()).collect()
        });
        // The slots below are those of the call that runs now.
        let outcome = self.guarded(part);
        let dense_counts = self.restore_width(n, counts);
        if let (Some(all), Some(dense)) = (self.counts_mut(), dense_counts) {
            for (whole, at) in lanes.pieces() {
                all[whole].copy_from_slice(&dense[at]);
            }
        }
        let mut before = before.into_iter();
        for &place in &effects.reads {
            *self.slot(place) = before.next().unwrap_or(Slot::EMPTY);
        }
        let mut outcome = outcome.map_err(|fault| lanes.fault(fault, n));
        for (&place, old) in effects.writes.iter().zip(before) {
            let new = std::mem::replace(self.slot(place), Slot::EMPTY);
            *self.slot(place) = match &outcome {
                Ok(()) => match self.scattered(lanes, new, old) {
                    Ok(slot) => slot,
                    Err(fault) => {
                        outcome = Err(fault);
                        Slot::EMPTY
                    }
                },
                // The batch begins again; what it began with must be there.
                Err(_) => old,
            };
        }
        outcome
    }

    /// A variable of the dense batch, back among the lanes where it was `old`.
    fn scattered(&self, lanes: &Gathered, new: Slot, old: Slot) -> Result<Slot> {
        let (n, width) = (self.n, self.width());
        let Some(value) = new.value else { return Ok(old) };
        let assigned = lanes.scatter_mask(&new.defined, n);
        let keep = !old.defined.minus(&assigned, width).is_none();
        let defined = old.defined.or(&assigned, width);
        let planes = match old.value {
            Some(old) if keep => {
                if old.shape != value.shape {
                    return Err(Fault::Split(assigned));
                }
                value
                    .planes
                    .iter()
                    .zip(old.planes)
                    .map(|(new, old)| lanes.scatter(new, Some(old), n))
                    .collect()
            }
            _ => value.planes.iter().map(|new| lanes.scatter(new, None, n)).collect(),
        };
        Ok(Slot { value: Some(Value { shape: value.shape, planes }), defined })
    }
}
