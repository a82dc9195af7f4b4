//! Batches use the same memory again: a larger image takes hardly more allocations than a small one.

use pse::{Program, RunOptions, scene};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

/// The system's allocator, which counts.
struct Counting;

static COUNT: AtomicUsize = AtomicUsize::new(0);

// SAFETY: all is done by the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.fetch_add(1, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn batches_allocate_nothing() {
    let options = RunOptions { threads: Some(1), ..RunOptions::default() };
    let frame = |height: usize| {
        let options = scene::Options { width: 1024, height, ..scene::Options::default() };
        scene::render("donut", &options).expect("the donut is a scene")
    };
    let (small, large) = (frame(64), frame(256));
    for name in ["diffuse", "spotted", "marble", "wrinkled", "waves", "straight", "branchy"] {
        let path = format!("{}/benches/workloads/{name}.pse", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).expect("a workload");
        let program = Program::compile(&text).expect("the workloads are programs");
        let count = |image| {
            let before = COUNT.load(Ordering::Relaxed);
            program.run(image, &options).expect("the workloads run");
            COUNT.load(Ordering::Relaxed) - before
        };
        count(&small);
        let (few, many) = (count(&small), count(&large));
        // 32 batches against 128. Each four have two lists of the planes they write; and some buffers grow in the
        // first batch that needs them.
        assert!(many < few + 2 * 24 + 20, "{name}: {few} allocations for 32 batches, {many} for 128");
    }
}
