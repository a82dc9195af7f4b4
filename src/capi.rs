//! The C interface, `include/pse.h`: every function of it, with the types that it names.
//!
//! Pointers come from C, so each function checks for null what may be null, and says under *Safety* what it trusts. A panic
//! never leaves: it becomes an error.

use crate::diagnostic::Style;
use crate::image::color;
use crate::program::{
    BufferView, BufferViewMut, Error, Program, Progress, RunOptions, Session, Strides, Window,
};
use crate::shape::Shape;
use crate::value::PixelValue;
use half::f16;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;
use std::sync::Arc;

/// A compiled program.
pub struct PseProgram {
    program: Arc<Program>,
    required: Vec<CString>,
    assigned: Vec<CString>,
}

/// Runs of a program, with the params that are set.
pub struct PseSession {
    session: Session,
    set: Vec<(String, PixelValue)>,
    /// Buffers of other types than `f32`, converted.
    inputs: Vec<Vec<f32>>,
    outputs: Vec<Vec<f32>>,
}

/// What went wrong.
pub struct PseError {
    message: CString,
    faults: Vec<Fault>,
}

struct Fault {
    code: CString,
    message: CString,
    file: CString,
    line: u32,
    column: u32,
    bytes: [usize; 2],
    pixel: Option<[i32; 2]>,
}

/// `pse_diagnostic`.
#[repr(C)]
pub struct PseDiagnostic {
    code: *const c_char,
    message: *const c_char,
    file: *const c_char,
    line: u32,
    column: u32,
    start: usize,
    end: usize,
    pixel: [i32; 2],
    has_pixel: c_int,
}

/// `pse_buffer`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PseBuffer {
    name: *const c_char,
    data: *mut c_void,
    length: usize,
    kind: c_int,
    components: u32,
    start: usize,
    component: usize,
    pixel: usize,
    row: isize,
}

/// `pse_options`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PseOptions {
    size: usize,
    frame: f32,
    threads: u32,
    origin: [i32; 2],
    resolution: [usize; 2],
    window: [usize; 4],
    abort: Option<unsafe extern "C" fn(*mut c_void) -> c_int>,
    user: *mut c_void,
}

const F32: c_int = 0;
const F16: c_int = 1;
const U8: c_int = 2;
const U8_SRGB: c_int = 3;

/// The host's pointer, which its callback gets on whichever thread calls it.
#[derive(Clone, Copy)]
struct User(*mut c_void);
// SAFETY: the header says that `abort` is called from any of the threads.
unsafe impl Send for User {}
// SAFETY: as above.
unsafe impl Sync for User {}

/// A string for C; bytes of 0 inside of it end it there.
fn c_string(text: &str) -> CString {
    let end = text.bytes().position(|b| b == 0).unwrap_or(text.len());
    CString::new(&text[..end]).unwrap_or_default()
}

/// # Safety
/// The pointer is null or a string that ends with 0.
unsafe fn text<'a>(pointer: *const c_char, what: &str) -> Result<&'a str, String> {
    if pointer.is_null() {
        return Err(format!("{what} is NULL"));
    }
    // SAFETY: it is not null, and the caller says that it ends.
    unsafe { CStr::from_ptr(pointer) }.to_str().map_err(|_| format!("{what} is not UTF-8"))
}

impl From<Error> for PseError {
    fn from(error: Error) -> PseError {
        let fault = |d: &crate::Diagnostic| {
            let place = d.span().map(|span| (error.sources.line_column(span), span));
            let file = place.map_or("", |(_, span)| error.sources.get(span.source).name.as_str());
            Fault {
                code: c_string(d.code),
                message: c_string(&d.message),
                file: c_string(file),
                line: place.map_or(0, |((line, _), _)| line as u32),
                column: place.map_or(0, |((_, column), _)| column as u32),
                bytes: place.map_or([0, 0], |(_, span)| [span.start as usize, span.end as usize]),
                pixel: d.pixel,
            }
        };
        PseError {
            message: c_string(&error.render(Style::PLAIN)),
            faults: error.diagnostics.iter().map(fault).collect(),
        }
    }
}

impl From<String> for PseError {
    fn from(message: String) -> PseError {
        let fault = Fault {
            code: c_string("argument"),
            message: c_string(&message),
            file: CString::default(),
            line: 0,
            column: 0,
            bytes: [0, 0],
            pixel: None,
        };
        PseError { message: c_string(&format!("{message}\n")), faults: vec![fault] }
    }
}

/// Does the work, and stores what goes wrong.
///
/// # Safety
/// `error` is null or points to a place for a pointer.
unsafe fn attempt<T>(error: *mut *mut PseError, work: impl FnOnce() -> Result<T, PseError>) -> Option<T> {
    let outcome = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        let message = "internal error: the library panicked; please report the program and its input";
        Err(message.to_string().into())
    });
    match outcome {
        Ok(value) => Some(value),
        Err(fault) => {
            if !error.is_null() {
                // SAFETY: the caller says that it is a place for a pointer.
                unsafe { *error = Box::into_raw(Box::new(fault)) };
            }
            None
        }
    }
}

/// The version.
#[unsafe(no_mangle)]
pub extern "C" fn pse_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// Compiles a program.
///
/// # Safety
/// Both strings end with 0; `error` is null or a place for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pse_compile(
    name: *const c_char,
    program: *const c_char,
    error: *mut *mut PseError,
) -> *mut PseProgram {
    let compile = || -> Result<*mut PseProgram, PseError> {
        // SAFETY: the caller's promise.
        let (name, program) = unsafe { (text(name, "the name")?, text(program, "the text")?) };
        let program = crate::Compiler::new().compile(name, program)?;
        let required = program.required_inputs().into_iter().map(c_string).collect();
        let assigned = program.assigned().map(c_string).collect();
        Ok(Box::into_raw(Box::new(PseProgram { program: Arc::new(program), required, assigned })))
    };
    // SAFETY: the caller's promise.
    unsafe { attempt(error, compile) }.unwrap_or(ptr::null_mut())
}

/// Frees a program.
///
/// # Safety
/// It comes from [`pse_compile`] and is not used any more; or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pse_program_free(program: *mut PseProgram) {
    if !program.is_null() {
        // SAFETY: it was made by `Box::into_raw`.
        drop(unsafe { Box::from_raw(program) });
    }
}

/// The name of a number in a list of the program.
///
/// # Safety
/// The program is null or of [`pse_compile`].
unsafe fn listed(
    program: *const PseProgram,
    list: impl Fn(&PseProgram) -> &[CString],
    index: usize,
) -> *const c_char {
    // SAFETY: the caller's promise.
    let program = unsafe { program.as_ref() };
    program.and_then(|p| list(p).get(index)).map_or(ptr::null(), |name| name.as_ptr())
}

/// How many variables the inputs have to hold.
///
/// # Safety
/// The program is null or of [`pse_compile`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pse_required_count(program: *const PseProgram) -> usize {
    // SAFETY: the caller's promise.
    unsafe { program.as_ref() }.map_or(0, |p| p.required.len())
}

/// The name of one of them.
///
/// # Safety
/// The program is null or of [`pse_compile`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pse_required(program: *const PseProgram, index: usize) -> *const c_char {
    // SAFETY: the caller's promise.
    unsafe { listed(program, |p| &p.required, index) }
}

/// How many variables the program assigns.
///
/// # Safety
/// The program is null or of [`pse_compile`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pse_assigned_count(program: *const PseProgram) -> usize {
    // SAFETY: the caller's promise.
    unsafe { program.as_ref() }.map_or(0, |p| p.assigned.len())
}

/// The name of one of them.
///
/// # Safety
/// The program is null or of [`pse_compile`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pse_assigned(program: *const PseProgram, index: usize) -> *const c_char {
    // SAFETY: the caller's promise.
    unsafe { listed(program, |p| &p.assigned, index) }
}

/// Begins a session; null for null.
///
/// # Safety
/// The program is null or of [`pse_compile`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pse_session_new(program: *const PseProgram) -> *mut PseSession {
    // SAFETY: the caller's promise.
    let Some(program) = (unsafe { program.as_ref() }) else { return ptr::null_mut() };
    let session = Session::new(Arc::clone(&program.program));
    Box::into_raw(Box::new(PseSession { session, set: Vec::new(), inputs: Vec::new(), outputs: Vec::new() }))
}

/// Frees a session.
///
/// # Safety
/// It comes from [`pse_session_new`] and is not used any more; or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pse_session_free(session: *mut PseSession) {
    if !session.is_null() {
        // SAFETY: it was made by `Box::into_raw`.
        drop(unsafe { Box::from_raw(session) });
    }
}

/// Sets a param.
///
/// # Safety
/// The session is null or of [`pse_session_new`]; `name` ends with 0; there are so many values; `error` is null or a place
/// for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pse_set(
    session: *mut PseSession,
    name: *const c_char,
    values: *const f32,
    components: u32,
    error: *mut *mut PseError,
) -> c_int {
    let set = || -> Result<(), PseError> {
        // SAFETY: the caller's promise.
        let session = unsafe { session.as_mut() }.ok_or_else(|| "the session is NULL".to_string())?;
        // SAFETY: the caller's promise.
        let name = unsafe { text(name, "the name")? };
        if values.is_null() || components == 0 {
            return Err(format!("`{name}` has no values to set").into());
        }
        // SAFETY: the caller says that there are so many.
        let values = unsafe { std::slice::from_raw_parts(values, components as usize) };
        let value: PixelValue = match values {
            [x] => (*x).into(),
            list => list.into(),
        };
        session.set.retain(|(known, _)| known != name);
        session.set.push((name.to_string(), value));
        Ok(())
    };
    // SAFETY: the caller's promise.
    if unsafe { attempt(error, set) }.is_some() { 0 } else { -1 }
}

/// Options with every field at its default.
#[unsafe(no_mangle)]
pub extern "C" fn pse_options_default() -> PseOptions {
    PseOptions {
        size: size_of::<PseOptions>(),
        frame: 0.0,
        threads: 0,
        origin: [0, 0],
        resolution: [0, 0],
        window: [0; 4],
        abort: None,
        user: ptr::null_mut(),
    }
}

/// A buffer that was looked at: its name, shape and strides.
struct Checked<'a> {
    buffer: PseBuffer,
    name: &'a str,
    strides: Strides,
}

impl<'a> Checked<'a> {
    /// # Safety
    /// The name ends with 0.
    unsafe fn new(buffer: PseBuffer) -> Result<Checked<'a>, String> {
        // SAFETY: the caller's promise.
        let name = unsafe { text(buffer.name, "the name of a buffer")? };
        if buffer.data.is_null() {
            return Err(format!("the buffer of `{name}` is NULL"));
        }
        let aligned = match buffer.kind {
            F32 => buffer.data.cast::<f32>().is_aligned(),
            F16 => buffer.data.cast::<u16>().is_aligned(),
            U8 | U8_SRGB => true,
            other => return Err(format!("the buffer of `{name}` is of the unknown type {other}")),
        };
        if !aligned {
            return Err(format!("the buffer of `{name}` is not aligned for its type"));
        }
        if buffer.components == 0 {
            return Err(format!("the buffer of `{name}` has no components"));
        }
        let PseBuffer { start, component, pixel, row, .. } = buffer;
        Ok(Checked { buffer, name, strides: Strides { start, component, pixel, row } })
    }

    fn shape(&self) -> Shape {
        if self.buffer.components == 1 { Shape::Scalar } else { Shape::Vector(self.buffer.components) }
    }

    /// The number at an index, as a float. `alpha`: it is stored without a curve.
    ///
    /// # Safety
    /// The buffer holds that many numbers.
    unsafe fn get(&self, index: usize, alpha: bool) -> f32 {
        let data = self.buffer.data;
        // SAFETY: the caller's promise.
        unsafe {
            match self.buffer.kind {
                F32 => *data.cast::<f32>().add(index),
                F16 => f16::from_bits(*data.cast::<u16>().add(index)).to_f32(),
                kind => {
                    let x = f32::from(*data.cast::<u8>().add(index)) / 255.0;
                    if kind == U8 || alpha { x } else { color::decode(x) }
                }
            }
        }
    }

    /// Stores a number.
    ///
    /// # Safety
    /// The buffer holds that many numbers, and nobody else uses it.
    unsafe fn put(&self, index: usize, alpha: bool, x: f32) {
        let data = self.buffer.data;
        // SAFETY: the caller's promise.
        unsafe {
            match self.buffer.kind {
                F32 => *data.cast::<f32>().add(index) = x,
                F16 => *data.cast::<u16>().add(index) = f16::from_f32(x).to_bits(),
                kind => {
                    let code =
                        if kind == U8 || alpha { color::quantize(x, 255) as u8 } else { color::encode8(x) };
                    *data.cast::<u8>().add(index) = code;
                }
            }
        }
    }

    fn check(&self, size: [usize; 2]) -> Result<(), String> {
        match self.strides.fits(size, self.buffer.components as usize, self.buffer.length) {
            true => Ok(()),
            false => Err(format!(
                "the buffer of `{}` has {} numbers, too few for its strides at {} x {} pixels",
                self.name, self.buffer.length, size[0], size[1]
            )),
        }
    }
}

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
    // SAFETY: the caller says that there are so many.
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
            // SAFETY: it is aligned, and the caller says that it holds so many.
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
            // SAFETY: it is aligned, the caller says that it holds so many, and nobody else uses it.
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

/// The whole message; empty for null.
///
/// # Safety
/// The error is null or of this library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pse_error_message(error: *const PseError) -> *const c_char {
    // SAFETY: the caller's promise.
    unsafe { error.as_ref() }.map_or(c"".as_ptr(), |error| error.message.as_ptr())
}

/// How many faults it has.
///
/// # Safety
/// The error is null or of this library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pse_error_count(error: *const PseError) -> usize {
    // SAFETY: the caller's promise.
    unsafe { error.as_ref() }.map_or(0, |error| error.faults.len())
}

/// One fault: 0, or -1 if there is none of that number.
///
/// # Safety
/// The error is null or of this library; `diagnostic` is null or a place for one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pse_error_at(
    error: *const PseError,
    index: usize,
    diagnostic: *mut PseDiagnostic,
) -> c_int {
    // SAFETY: the caller's promise.
    let fault = unsafe { error.as_ref() }.and_then(|error| error.faults.get(index));
    let Some(fault) = fault.filter(|_| !diagnostic.is_null()) else { return -1 };
    let found = PseDiagnostic {
        code: fault.code.as_ptr(),
        message: fault.message.as_ptr(),
        file: fault.file.as_ptr(),
        line: fault.line,
        column: fault.column,
        start: fault.bytes[0],
        end: fault.bytes[1],
        pixel: fault.pixel.unwrap_or_default(),
        has_pixel: c_int::from(fault.pixel.is_some()),
    };
    // SAFETY: the caller says that it is a place for one.
    unsafe { diagnostic.write(found) };
    0
}

/// Frees an error.
///
/// # Safety
/// It comes from this library and is not used any more; or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pse_error_free(error: *mut PseError) {
    if !error.is_null() {
        // SAFETY: it was made by `Box::into_raw`.
        drop(unsafe { Box::from_raw(error) });
    }
}
