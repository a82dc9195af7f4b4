//! The C interface, `include/pse.h`: every function of it, with the types that it names.
//!
//! Pointers come from C, so each function checks for null what may be null, and says under *Safety* what it trusts. A panic
//! never leaves: it becomes an error.

mod buffer;
mod error;
mod run;

pub use buffer::PseBuffer;
pub use error::{PseDiagnostic, PseError, pse_error_at, pse_error_count, pse_error_free, pse_error_message};
pub use run::pse_run;

use crate::program::{Program, Session};
use crate::value::PixelValue;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
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
/// The session is null or of [`pse_session_new`]; `name` ends with 0; `values` points to `components` numbers; `error` is null or a place
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
        // SAFETY: the caller promises `components` numbers.
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
