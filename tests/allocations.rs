//! Batches use the same memory again: a larger image takes hardly more allocations than a small one.

use pse::{BufferView, BufferViewMut, Program, RunOptions, Session, Strides, scene};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// The system's allocator, which counts.
struct Counting;

thread_local! {
    /// Each test counts those of its own thread.
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: all is done by the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = COUNT.try_with(|count| count.set(count.get() + 1));
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
            let before = COUNT.get();
            program.run(image, &options).expect("the workloads run");
            COUNT.get() - before
        };
        count(&small);
        let (few, many) = (count(&small), count(&large));
        // 32 batches against 128. Each four have two lists of the planes they write; and some buffers grow in the
        // first batch that needs them.
        assert!(many < few + 2 * 24 + 20, "{name}: {few} allocations for 32 batches, {many} for 128");
    }
}

#[test]
fn a_session_allocates_nothing_in_a_steady_state_and_starts_no_thread() {
    let (width, height) = (64, 64);
    let image = scene::render("donut", &scene::Options { width, height, ..scene::Options::default() })
        .expect("the donut is a scene");
    let planes: Vec<Vec<f32>> = image.variables.iter().map(|v| v.planes.concat()).collect();
    let views: Vec<BufferView<'_>> = image
        .variables
        .iter()
        .zip(&planes)
        .map(|(v, data)| BufferView {
            name: &v.name,
            shape: v.shape.clone(),
            data,
            strides: Strides::planar(width, height),
        })
        .collect();
    let options = RunOptions { threads: Some(1), ..RunOptions::default() };
    for name in ["diffuse", "spotted", "marble", "wrinkled", "waves", "straight", "branchy"] {
        let path = format!("{}/benches/workloads/{name}.pse", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).expect("a workload");
        let mut session = Session::new(Program::compile(&text).expect("the workloads are programs"));
        for strides in [Strides::interleaved(4, width), Strides::planar(width, height)] {
            let mut data = vec![0.0; 4 * width * height];
            let mut run = || {
                let before = COUNT.get();
                let outputs = &mut [BufferViewMut { name: "color", components: 4, data: &mut data, strides }];
                session.run_into([width, height], &views, outputs, &options).expect("the workloads run");
                COUNT.get() - before
            };
            run();
            run();
            assert_eq!(run(), 0, "{name}");
        }
    }
}
