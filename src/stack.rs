//! Room on the stack for walks that call themselves: over trees, and through calls inside of calls.
//!
//! With the feature `deep` the stack grows. Without it a walk ends with an error before the stack does, whatever the
//! size of the build's stack frames: it takes no more than a part of a small stack.

/// Stack that a walk may take where it can't grow. A thread's whole stack may be no more than one megabyte.
#[cfg(not(any(feature = "deep", target_family = "wasm")))]
const MAX_BYTES: usize = 640 << 10;

/// The same for WebAssembly, where a part of each frame lies on the engine's own stack, whose size is unknown.
#[cfg(all(not(feature = "deep"), target_family = "wasm"))]
const MAX_BYTES: usize = 256 << 10;

/// Stack that must be left for a level of a walk to begin.
#[cfg(feature = "deep")]
const RED_ZONE: usize = 256 << 10;

/// Stack that is added where less is left.
#[cfg(feature = "deep")]
const GROWTH: usize = 4 << 20;

/// How deep a walk is.
#[derive(Default)]
pub(crate) struct Nesting {
    levels: u32,
    /// An address in the frame of the first level.
    #[cfg(not(feature = "deep"))]
    base: usize,
}

impl Nesting {
    /// Begins one more level if there is room, and if there are fewer than `most`. [`Nesting::leave`] ends it.
    #[must_use]
    pub fn enter(&mut self, most: u32) -> bool {
        #[cfg(not(feature = "deep"))]
        {
            let here = 0_u8;
            let here = std::ptr::from_ref(&here).addr();
            if self.levels == 0 {
                self.base = here;
            }
            if self.base.abs_diff(here) > MAX_BYTES {
                return false;
            }
        }
        let room = self.levels < most;
        self.levels += u32::from(room);
        room
    }

    /// Ends a level.
    pub fn leave(&mut self) {
        self.levels -= 1;
    }
}

/// Whether the next level of a walk needs [`grow`].
pub(crate) fn is_low() -> bool {
    #[cfg(feature = "deep")]
    return stacker::remaining_stack().is_some_and(|left| left < RED_ZONE);
    #[cfg(not(feature = "deep"))]
    false
}

/// Runs a level of a walk on more stack, if the stack grows.
pub(crate) fn grow<T>(level: impl FnOnce() -> T) -> T {
    #[cfg(feature = "deep")]
    return stacker::grow(GROWTH, level);
    #[cfg(not(feature = "deep"))]
    level()
}
