//! Planes of numbers, and the buffers they reuse.

use bytemuck::{Pod, Zeroable};
use std::cell::RefCell;
use std::fmt;
use std::sync::Arc;

/// Lanes that are taken together; four cache lines.
const LINE: usize = 64;

/// Lanes on cache lines of their own, so that vector loads never straddle two.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Line([f32; LINE]);

// SAFETY: 64 floats fill the 256 bytes exactly; every bit pattern is a float.
unsafe impl Zeroable for Line {}
// SAFETY: as above; `Line` is `Copy`, has no padding and no references.
unsafe impl Pod for Line {}

/// How many free buffers a thread keeps for reuse, in bytes.
const KEPT: usize = 64 << 20;

/// How many times as large as it must be a buffer may be.
const ROOMY: usize = 4;

/// A thin pointer: planes are moved about a lot, and by it one is 16 bytes.
type Buffer = Arc<Box<[Line]>>;

/// The buffers that a thread's batches have done with, and the count of those that are in use.
struct Pool {
    /// Last in, first out: what was used last is still in the cache.
    free: Vec<Buffer>,
    /// Bytes in `free`.
    kept: usize,
    /// Bytes in use.
    live: usize,
}

thread_local! {
    static POOL: RefCell<Pool> = const { RefCell::new(Pool { free: Vec::new(), kept: 0, live: 0 }) };
}

/// Bytes in the buffers that this thread holds at the moment, without those kept for reuse.
pub fn live_bytes() -> usize {
    POOL.with_borrow(|pool| pool.live)
}

/// A shared buffer of one number a lane. It returns to its thread's pool when the last owner drops it.
pub struct Lanes {
    // Only `drop` takes it out.
    buffer: Option<Buffer>,
}

impl Lanes {
    /// A buffer with room for `n` lanes, holding whatever was there before.
    pub fn new(n: usize) -> Lanes {
        let lines = n.div_ceil(LINE).max(1);
        let reused = POOL.with_borrow_mut(|pool| {
            let buffer = pool.free.pop()?;
            pool.kept -= size_of_val(&**buffer);
            Some(buffer)
        });
        // Batches with and without shadows take turns: a buffer may have some room to spare.
        let buffer = match reused {
            Some(buffer) if (lines..=ROOMY * lines).contains(&buffer.len()) => buffer,
            _ => Arc::new(vec![Line::zeroed(); lines].into_boxed_slice()),
        };
        POOL.with_borrow_mut(|pool| pool.live += size_of_val(&**buffer));
        Lanes { buffer: Some(buffer) }
    }

    /// A buffer that `fill` writes: it must write all `n` lanes.
    #[inline]
    pub fn filled(n: usize, fill: impl FnOnce(&mut [f32])) -> Lanes {
        let mut lanes = Lanes::new(n);
        // Nobody else has seen it yet.
        if let Some(lines) = lanes.buffer.as_mut().and_then(Arc::get_mut) {
            fill(&mut bytemuck::cast_slice_mut(lines)[..n]);
        }
        lanes
    }

    /// The first `n` lanes. A buffer may have room for more.
    pub fn get(&self, n: usize) -> &[f32] {
        match &self.buffer {
            Some(buffer) => &bytemuck::cast_slice(buffer)[..n],
            None => &[],
        }
    }

    /// All lanes that there is room for, in blocks. Those beyond the first `n` mean nothing.
    pub fn blocks(&self) -> &[[f32; LINE]] {
        match &self.buffer {
            Some(buffer) => bytemuck::cast_slice(buffer),
            None => &[],
        }
    }

    /// The first `n` lanes, as bits.
    pub fn bits(&self, n: usize) -> &[u32] {
        bytemuck::cast_slice(self.get(n))
    }

    /// The first `n` lanes for writing; a buffer with other owners is copied first.
    pub fn get_mut(&mut self, n: usize) -> &mut [f32] {
        let shared = self.buffer.as_mut().is_none_or(|b| Arc::get_mut(b).is_none());
        if shared {
            let mut copy = Lanes::new(n);
            if let Some(Some(lines)) = copy.buffer.as_mut().map(Arc::get_mut) {
                bytemuck::cast_slice_mut::<Line, f32>(lines)[..n].copy_from_slice(self.get(n));
            }
            *self = copy;
        }
        match self.buffer.as_mut().and_then(Arc::get_mut) {
            Some(lines) => &mut bytemuck::cast_slice_mut(lines)[..n],
            None => &mut [],
        }
    }

    /// Are both the very same buffer?
    pub fn same(&self, other: &Lanes) -> bool {
        match (&self.buffer, &other.buffer) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}

impl Clone for Lanes {
    fn clone(&self) -> Lanes {
        Lanes { buffer: self.buffer.clone() }
    }
}

impl Drop for Lanes {
    fn drop(&mut self) {
        if let Some(buffer) = self.buffer.take()
            && Arc::strong_count(&buffer) == 1
        {
            let bytes = size_of_val(&**buffer);
            // A thread that ends may drop a value after its pool is gone.
            let _ = POOL.try_with(|pool| {
                let mut pool = pool.borrow_mut();
                // A value may be dropped on another thread than that which made it.
                pool.live = pool.live.saturating_sub(bytes);
                if pool.kept + bytes <= KEPT {
                    pool.kept += bytes;
                    pool.free.push(buffer);
                }
            });
        }
    }
}

impl fmt::Debug for Lanes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let n = self.buffer.as_ref().map_or(0, |b| b.len() * LINE);
        f.debug_list().entries(self.get(n)).finish()
    }
}

/// One number a lane, or one for all.
#[derive(Clone, Debug)]
pub enum Plane {
    /// The same in every lane.
    Uniform(f32),
    /// One a lane.
    Varying(Lanes),
}

impl Plane {
    /// A varying plane that `fill` writes: it must write all `n` lanes.
    pub fn filled(n: usize, fill: impl FnOnce(&mut [f32])) -> Plane {
        Plane::Varying(Lanes::filled(n, fill))
    }

    /// What one lane holds.
    pub fn lane(&self, lane: usize) -> f32 {
        match self {
            Plane::Uniform(x) => *x,
            Plane::Varying(lanes) => lanes.get(lane + 1)[lane],
        }
    }

    /// The same numbers, one a lane.
    pub fn spread(&self, n: usize) -> Lanes {
        match self {
            Plane::Uniform(x) => Lanes::filled(n, |out| out.fill(*x)),
            Plane::Varying(lanes) => lanes.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shared_buffer_is_copied_before_it_is_written() {
        let mut a = Lanes::filled(20, |x| x.fill(1.0));
        let b = a.clone();
        a.get_mut(20)[3] = 2.0;
        assert_eq!((a.get(20)[3], b.get(20)[3]), (2.0, 1.0));
        assert!(!a.same(&b));
    }

    #[test]
    fn buffers_are_reused_and_counted() {
        let before = live_bytes();
        let address = {
            let a = Lanes::new(100);
            assert_eq!(live_bytes() - before, 2 * 256);
            a.get(1).as_ptr()
        };
        assert_eq!(live_bytes(), before);
        assert_eq!(Lanes::new(100).get(1).as_ptr(), address);
    }
}
