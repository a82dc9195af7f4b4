//! Work shared by threads: rayon's iterators with the feature `threads`, the same methods on one thread without it.

#[cfg(feature = "threads")]
#[allow(unused_imports, reason = "only `scene` joins")]
pub use rayon::{current_num_threads, join, prelude::*};

#[cfg(not(feature = "threads"))]
pub use serial::*;

/// Runs `work` on this many threads at once and returns when all have ended. One thread is the caller's own, and no other
/// is started.
///
/// # Errors
/// If the operating system cannot start the threads: why.
#[cfg(feature = "threads")]
pub fn on_threads(threads: usize, work: &(impl Fn() + Sync)) -> Result<(), String> {
    let all = || rayon::scope(|scope| (0..threads).for_each(|_| scope.spawn(|_| work())));
    if threads == 1 {
        work();
    } else if threads <= current_num_threads() {
        all();
    } else {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.map_err(|e| e.to_string())?.install(all);
    }
    Ok(())
}

/// Gives each row of `width` numbers to `work`, with its number: on the threads of the current pool, or one after
/// another on the caller's.
pub fn for_rows<T: Send>(threads: bool, data: &mut [T], width: usize, work: impl Fn(usize, &mut [T]) + Sync) {
    let width = width.max(1);
    if threads {
        data.par_chunks_mut(width).enumerate().for_each(|(row, part)| work(row, part));
    } else {
        data.chunks_mut(width).enumerate().for_each(|(row, part)| work(row, part));
    }
}

#[cfg(not(feature = "threads"))]
#[allow(dead_code, reason = "each feature uses some of it")]
mod serial {
    /// How many threads share the work.
    pub fn current_num_threads() -> usize {
        1
    }

    /// Runs `work` on the caller's thread.
    pub fn on_threads(_: usize, work: &(impl Fn() + Sync)) -> Result<(), String> {
        work();
        Ok(())
    }

    /// Does both.
    pub fn join<A, B>(a: impl FnOnce() -> A, b: impl FnOnce() -> B) -> (A, B) {
        (a(), b())
    }

    /// Rayon's methods of slices.
    pub trait ParallelSlice<T> {
        fn par_iter(&self) -> std::slice::Iter<'_, T>;
        fn par_iter_mut(&mut self) -> std::slice::IterMut<'_, T>;
        fn par_chunks_mut(&mut self, size: usize) -> std::slice::ChunksMut<'_, T>;
        fn par_chunks_exact(&self, size: usize) -> std::slice::ChunksExact<'_, T>;
        fn par_chunks_exact_mut(&mut self, size: usize) -> std::slice::ChunksExactMut<'_, T>;
    }

    impl<T> ParallelSlice<T> for [T] {
        fn par_iter(&self) -> std::slice::Iter<'_, T> {
            self.iter()
        }
        fn par_iter_mut(&mut self) -> std::slice::IterMut<'_, T> {
            self.iter_mut()
        }
        fn par_chunks_mut(&mut self, size: usize) -> std::slice::ChunksMut<'_, T> {
            self.chunks_mut(size)
        }
        fn par_chunks_exact(&self, size: usize) -> std::slice::ChunksExact<'_, T> {
            self.chunks_exact(size)
        }
        fn par_chunks_exact_mut(&mut self, size: usize) -> std::slice::ChunksExactMut<'_, T> {
            self.chunks_exact_mut(size)
        }
    }

    /// Rayon's methods of what makes an iterator, and of iterators.
    pub trait ParallelIterator: IntoIterator + Sized {
        fn into_par_iter(self) -> Self::IntoIter {
            self.into_iter()
        }
        fn with_min_len(self, _: usize) -> Self {
            self
        }
    }

    impl<I: IntoIterator> ParallelIterator for I {}
}
