//! Errors for C: the whole message, and each fault with its place.

use super::c_string;
use crate::diagnostic::{Diagnostic, Style};
use crate::program::Error;
use std::ffi::{CString, c_char, c_int};

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

impl From<Error> for PseError {
    fn from(error: Error) -> PseError {
        let fault = |d: &Diagnostic| {
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
