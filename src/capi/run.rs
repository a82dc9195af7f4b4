//! A run on buffers of C.

use super::buffer::{Checked, F32, PseBuffer};
use super::error::PseError;
use super::{PseOptions, PseSession, attempt, pse_options_default};
use crate::program::{BufferView, BufferViewMut, Progress, RunOptions, Strides, Window};
use std::ffi::{c_int, c_void};
use std::ops::ControlFlow;

/// The host's pointer, which its callback gets on whichever thread calls it.
#[derive(Clone, Copy)]
struct User(*mut c_void);
// SAFETY: the header says that `abort` is called from any of the threads.
unsafe impl Send for User {}
// SAFETY: as above.
unsafe impl Sync for User {}

/// Runs the program.
///
/// # Safety
/// All pointers are null or as the header says; the buffers hold the numbers that they claim, outputs do not overlap
/// anything else, and nobody uses them meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pse_run(
    session: *mut PseSession,
    width: usize,
    height: usize,
    inputs: *const PseBuffer,
    input_count: usize,
    outputs: *const PseBuffer,
    output_count: usize,
    options: *const PseOptions,
    error: *mut *mut PseError,
) -> c_int {
    let run = || -> Result<bool, PseError> {
        // SAFETY: the caller's promise.
        let session = unsafe { session.as_mut() }.ok_or_else(|| "the session is NULL".to_string())?;
        // SAFETY: the caller's promise.
        unsafe {
            run(session, [width, height], (inputs, input_count), (outputs, output_count), options.as_ref())
        }
    };
    // SAFETY: the caller's promise.
    match unsafe { attempt(error, run) } {
        Some(true) => 0,
        Some(false) => 1,
        None => -1,
    }
}

/// # Safety
/// As [`pse_run`].
unsafe fn checked<'a>(
    (list, count): (*const PseBuffer, usize),
    what: &str,
) -> Result<Vec<Checked<'a>>, String> {
    if count == 0 {
        return Ok(Vec::new());
    }
    if list.is_null() {
        return Err(format!("the {what} are NULL"));
    }
    // SAFETY: the caller promises `count` buffers.
    let list = unsafe { std::slice::from_raw_parts(list, count) };
    // SAFETY: the caller's promise.
    list.iter().map(|buffer| unsafe { Checked::new(*buffer) }).collect()
}

/// Whether the run came to its end.
///
/// # Safety
/// As [`pse_run`].
unsafe fn run(
    session: &mut PseSession,
    size: [usize; 2],
    inputs: (*const PseBuffer, usize),
    outputs: (*const PseBuffer, usize),
    given: Option<&PseOptions>,
) -> Result<bool, PseError> {
    let default = pse_options_default();
    let given = given.unwrap_or(&default);
    if given.size != default.size {
        return Err(
            format!("the options have {} bytes, this library knows {}", given.size, default.size).into()
        );
    }
    // SAFETY: the caller's promise.
    let (inputs, outputs) = unsafe { (checked(inputs, "inputs")?, checked(outputs, "outputs")?) };
    let [x, y, columns, rows] = given.window;
    let window = (given.window != [0; 4])
        .then(|| Window { columns: x..x.saturating_add(columns), rows: y..y.saturating_add(rows) });
    let run_size = window.as_ref().map_or(size, |w| [w.columns.len(), w.rows.len()]);
    inputs.iter().try_for_each(|input| input.check(size))?;
    outputs.iter().try_for_each(|output| output.check(run_size))?;

    let PseSession { session, set, inputs: staged_inputs, outputs: staged_outputs } = session;
    staged_inputs.resize_with(inputs.len(), Vec::new);
    staged_outputs.resize_with(outputs.len(), Vec::new);
    let mut views = Vec::with_capacity(inputs.len());
    for (input, staged) in inputs.iter().zip(staged_inputs.iter_mut()) {
        let components = input.buffer.components as usize;
        let (data, strides) = match input.buffer.kind {
            // SAFETY: it is aligned, and the caller promises `length` numbers.
            F32 => unsafe {
                (
                    std::slice::from_raw_parts(input.buffer.data.cast::<f32>(), input.buffer.length),
                    input.strides,
                )
            },
            _ => {
                staged.clear();
                for c in 0..components {
                    for pixel in 0..size[0] * size[1] {
                        let index = input.strides.index(pixel % size[0], pixel / size[0], c);
                        // SAFETY: the strides were checked.
                        staged.push(unsafe { input.get(index, c == 3) });
                    }
                }
                (&staged[..], Strides::planar(size[0], size[1]))
            }
        };
        views.push(BufferView { name: input.name, shape: input.shape(), data, strides });
    }
    let mut written = Vec::with_capacity(outputs.len());
    for (output, staged) in outputs.iter().zip(staged_outputs.iter_mut()) {
        let components = output.buffer.components as usize;
        let (data, strides) = match output.buffer.kind {
            // SAFETY: it is aligned, the caller promises `length` numbers, and nothing else uses them.
            F32 => unsafe {
                let data =
                    std::slice::from_raw_parts_mut(output.buffer.data.cast::<f32>(), output.buffer.length);
                (data, output.strides)
            },
            _ => {
                staged.resize(components * run_size[0] * run_size[1], 0.0);
                (&mut staged[..], Strides::interleaved(components, run_size[0]))
            }
        };
        written.push(BufferViewMut { name: output.name, components, data, strides });
    }

    let metadata = session.metadata_mut();
    metadata.origin = given.origin;
    metadata.resolution = (given.resolution != [0, 0]).then_some(given.resolution);
    let (abort, user) = (given.abort, User(given.user));
    let progress = move |_: Progress| {
        let User(user) = { user };
        // SAFETY: the header says what `abort` is called with, and from where.
        match abort.is_some_and(|abort| unsafe { abort(user) } != 0) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    };
    let options = RunOptions {
        frame: given.frame,
        set: set.clone(),
        window,
        threads: (given.threads > 0).then_some(given.threads as usize),
        progress: Some(&progress),
        ..RunOptions::default()
    };
    match session.run_into(size, &views, &mut written, &options) {
        Ok(_) => {}
        Err(error) if error.cancelled => return Ok(false),
        Err(error) => return Err(error.into()),
    }
    for (output, staged) in outputs.iter().zip(staged_outputs.iter()).filter(|(o, _)| o.buffer.kind != F32) {
        let components = output.buffer.components as usize;
        for (pixel, values) in staged.chunks_exact(components).enumerate() {
            for (c, &x) in values.iter().enumerate() {
                let index = output.strides.index(pixel % run_size[0], pixel / run_size[0], c);
                // SAFETY: the strides were checked, and nobody else uses the buffer.
                unsafe { output.put(index, c == 3, x) };
            }
        }
    }
    Ok(true)
}
