//! Which lanes of a batch are active.

use super::plane::{Lanes, Plane};
use crate::lanes::Isa;
use std::fmt;

/// How wide a batch is, and with which instructions its lanes are worked on.
#[derive(Clone, Copy, Debug)]
pub struct Width {
    /// The number of lanes.
    pub n: usize,
    /// The instruction set.
    pub isa: Isa,
}

/// A set of lanes. Its common states, all and none, hold no buffer.
#[derive(Clone)]
pub enum Mask {
    /// Every lane.
    All,
    /// No lane.
    None,
    /// Some: all bits set in a lane that is on, none in one that is off.
    Some(Lanes),
}

impl fmt::Debug for Mask {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Mask::All => "All",
            Mask::None => "None",
            Mask::Some(_) => "Some",
        })
    }
}

impl Mask {
    /// Is no lane on?
    pub fn is_none(&self) -> bool {
        matches!(self, Mask::None)
    }

    /// The mask that `bit` gives for each lane: all ones or all zeros.
    fn build(Width { n, isa }: Width, bit: impl Fn(usize) -> u32) -> Mask {
        let mut on = 0;
        let lanes = Lanes::filled(n, |out| {
            let out: &mut [u32] = bytemuck::cast_slice_mut(out);
            on = isa.run(|| fill_bits(out, bit));
        });
        let on = on as usize;
        if on == 0 {
            Mask::None
        } else if on == n {
            Mask::All
        } else {
            Mask::Some(lanes)
        }
    }

    /// The lanes for which `on` holds.
    pub fn from_fn(n: usize, on: impl Fn(usize) -> bool) -> Mask {
        Mask::build(Width { n, isa: Isa::baseline() }, |i| if on(i) { !0 } else { 0 })
    }

    /// One lane alone.
    pub fn only(lane: usize, n: usize) -> Mask {
        Mask::from_fn(n, |i| i == lane)
    }

    /// Splits by a condition: the lanes of this mask where it is true (any number but 0), and the rest.
    /// A side that keeps every lane is this mask itself, so that later subset tests are cheap.
    pub fn split(&self, condition: &Plane, width: Width) -> (Mask, Mask) {
        let lanes = match condition {
            Plane::Uniform(x) if *x != 0.0 => return (self.clone(), Mask::None),
            Plane::Uniform(_) => return (Mask::None, self.clone()),
            Plane::Varying(lanes) => lanes.get(width.n),
        };
        let truth = |i: usize| if lanes[i] != 0.0 { !0u32 } else { 0 };
        let (yes, no) = match self {
            Mask::None => (Mask::None, Mask::None),
            Mask::All => {
                let yes = Mask::build(width, truth);
                let no = yes.complement(width);
                (yes, no)
            }
            Mask::Some(on) => {
                let on = on.bits(width.n);
                (Mask::build(width, |i| on[i] & truth(i)), Mask::build(width, |i| on[i] & !truth(i)))
            }
        };
        match (yes, no) {
            (_, Mask::None) => (self.clone(), Mask::None),
            (Mask::None, _) => (Mask::None, self.clone()),
            sides => sides,
        }
    }

    /// The lanes that are off here.
    pub fn complement(&self, width: Width) -> Mask {
        match self {
            Mask::All => Mask::None,
            Mask::None => Mask::All,
            Mask::Some(on) => {
                let on = on.bits(width.n);
                Mask::build(width, |i| !on[i])
            }
        }
    }

    /// The lanes of either.
    pub fn or(&self, other: &Mask, width: Width) -> Mask {
        match (self, other) {
            (Mask::All, _) | (_, Mask::All) => Mask::All,
            (Mask::None, m) | (m, Mask::None) => m.clone(),
            (Mask::Some(a), Mask::Some(b)) if a.same(b) => self.clone(),
            (Mask::Some(a), Mask::Some(b)) => {
                let (a, b) = (a.bits(width.n), b.bits(width.n));
                Mask::build(width, |i| a[i] | b[i])
            }
        }
    }

    /// The lanes of this mask that are not in the other.
    pub fn minus(&self, other: &Mask, width: Width) -> Mask {
        match (self, other) {
            (Mask::None, _) | (_, Mask::All) => Mask::None,
            (m, Mask::None) => m.clone(),
            (Mask::All, m) => m.complement(width),
            (Mask::Some(a), Mask::Some(b)) if a.same(b) => Mask::None,
            (Mask::Some(a), Mask::Some(b)) => {
                let (a, b) = (a.bits(width.n), b.bits(width.n));
                Mask::build(width, |i| a[i] & !b[i])
            }
        }
    }

    /// Is every lane of this mask in the other?
    pub fn is_subset(&self, other: &Mask, width: Width) -> bool {
        match (self, other) {
            (Mask::None, _) | (_, Mask::All) => true,
            (_, Mask::None) | (Mask::All, Mask::Some(_)) => false,
            (Mask::Some(a), Mask::Some(b)) if a.same(b) => true,
            (Mask::Some(a), Mask::Some(b)) => {
                a.bits(width.n).iter().zip(b.bits(width.n)).fold(0, |outside, (a, b)| outside | (a & !b)) == 0
            }
        }
    }

    /// How many lanes are on.
    pub fn count(&self, width: Width) -> usize {
        match self {
            Mask::All => width.n,
            Mask::None => 0,
            // All bits of a lane are alike: as a number it is 0 or -1.
            Mask::Some(on) => {
                on.bits(width.n).iter().fold(0_u32, |count, bits| count.wrapping_sub(*bits)) as usize
            }
        }
    }

    /// Is the lane on?
    pub fn has(&self, lane: usize) -> bool {
        match self {
            Mask::All => true,
            Mask::None => false,
            Mask::Some(on) => on.bits(lane + 1)[lane] != 0,
        }
    }

    /// The lanes that are on, in order.
    pub fn lanes(&self, n: usize) -> impl Iterator<Item = usize> + '_ {
        (0..n).filter(|&i| self.has(i))
    }

    /// The first lane that is on.
    pub fn first(&self, n: usize) -> Option<usize> {
        self.lanes(n).next()
    }

    /// Takes `new` where the mask is on and `old` where it is off.
    pub fn select(&self, new: &Plane, old: &Plane, width: Width) -> Plane {
        match (self, new, old) {
            (Mask::All, _, _) => new.clone(),
            (Mask::None, _, _) => old.clone(),
            (_, Plane::Uniform(a), Plane::Uniform(b)) if a.to_bits() == b.to_bits() => new.clone(),
            (_, Plane::Varying(a), Plane::Varying(b)) if a.same(b) => new.clone(),
            (Mask::Some(on), _, _) => {
                let on = on.bits(width.n);
                let pick = |on: u32, a: f32, b: f32| f32::from_bits((a.to_bits() & on) | (b.to_bits() & !on));
                let Width { n, isa } = width;
                Plane::filled(n, |out| match (new, old) {
                    (Plane::Varying(a), Plane::Varying(b)) => {
                        let (a, b) = (a.get(n), b.get(n));
                        isa.run(|| {
                            for (((out, on), a), b) in out.iter_mut().zip(on).zip(a).zip(b) {
                                *out = pick(*on, *a, *b);
                            }
                        });
                    }
                    (Plane::Varying(a), Plane::Uniform(b)) => {
                        let a = a.get(n);
                        isa.run(|| {
                            for ((out, on), a) in out.iter_mut().zip(on).zip(a) {
                                *out = pick(*on, *a, *b);
                            }
                        });
                    }
                    (Plane::Uniform(a), Plane::Varying(b)) => {
                        let b = b.get(n);
                        isa.run(|| {
                            for ((out, on), b) in out.iter_mut().zip(on).zip(b) {
                                *out = pick(*on, *a, *b);
                            }
                        });
                    }
                    (Plane::Uniform(a), Plane::Uniform(b)) => {
                        for (out, on) in out.iter_mut().zip(on) {
                            *out = pick(*on, *a, *b);
                        }
                    }
                })
            }
        }
    }
}

/// Writes each lane's bits and counts those that are on.
#[inline(always)]
fn fill_bits(out: &mut [u32], bit: impl Fn(usize) -> u32) -> u32 {
    let mut on = 0u32;
    for (i, out) in out.iter_mut().enumerate() {
        let b = bit(i);
        *out = b;
        on += b & 1;
    }
    on
}

#[cfg(test)]
mod tests {
    use super::*;

    fn width(n: usize) -> Width {
        Width { n, isa: Isa::detect() }
    }

    #[test]
    fn split_keeps_the_mask_itself_when_all_lanes_agree() {
        let mask = Mask::from_fn(10, |i| i > 3);
        let condition = Plane::filled(10, |c| c.iter_mut().enumerate().for_each(|(i, c)| *c = i as f32));
        let (yes, no) = mask.split(&condition, width(10));
        assert!(no.is_none());
        assert!(matches!((&yes, &mask), (Mask::Some(a), Mask::Some(b)) if a.same(b)));
    }

    #[test]
    fn set_algebra() {
        let n = 37;
        let a = Mask::from_fn(n, |i| i % 2 == 0);
        let b = Mask::from_fn(n, |i| i % 3 == 0);
        assert_eq!(a.or(&b, width(n)).lanes(n).count(), 25);
        assert_eq!(a.minus(&b, width(n)).first(n), Some(2));
        assert!(a.minus(&b, width(n)).is_subset(&a, width(n)));
        assert!(!a.is_subset(&b, width(n)));
        assert!(matches!(a.or(&a.complement(width(n)), width(n)), Mask::All));
        assert!(matches!(a.minus(&a, width(n)), Mask::None));
    }

    #[test]
    fn select_picks_bits() {
        let mask = Mask::only(1, 3);
        let plane = mask.select(&Plane::Uniform(-0.0), &Plane::Uniform(0.0), width(3));
        assert_eq!((0..3).map(|i| plane.lane(i).to_bits() >> 31).collect::<Vec<_>>(), [0, 1, 0]);
    }
}
