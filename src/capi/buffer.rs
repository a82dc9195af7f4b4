//! Buffers of C: floats, halves and bytes with strides.

use super::text;
use crate::image::color;
use crate::program::Strides;
use crate::shape::Shape;
use half::f16;
use std::ffi::{c_char, c_int, c_void};

/// `pse_buffer`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PseBuffer {
    pub(super) name: *const c_char,
    pub(super) data: *mut c_void,
    pub(super) length: usize,
    pub(super) kind: c_int,
    pub(super) components: u32,
    pub(super) start: usize,
    pub(super) component: usize,
    pub(super) pixel: usize,
    pub(super) row: isize,
}

pub(super) const F32: c_int = 0;
const F16: c_int = 1;
const U8: c_int = 2;
const U8_SRGB: c_int = 3;

/// A buffer that was looked at: its name, shape and strides.
pub(super) struct Checked<'a> {
    pub buffer: PseBuffer,
    pub name: &'a str,
    pub strides: Strides,
}

impl<'a> Checked<'a> {
    /// # Safety
    /// The name ends with 0.
    pub unsafe fn new(buffer: PseBuffer) -> Result<Checked<'a>, String> {
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

    pub fn shape(&self) -> Shape {
        if self.buffer.components == 1 { Shape::Scalar } else { Shape::Vector(self.buffer.components) }
    }

    /// The number at an index, as a float. `alpha`: it is stored without a curve.
    ///
    /// # Safety
    /// The buffer holds that many numbers.
    pub unsafe fn get(&self, index: usize, alpha: bool) -> f32 {
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
    pub unsafe fn put(&self, index: usize, alpha: bool, x: f32) {
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

    pub fn check(&self, size: [usize; 2]) -> Result<(), String> {
        match self.strides.fits(size, self.buffer.components as usize, self.buffer.length) {
            true => Ok(()),
            false => Err(format!(
                "the buffer of `{}` has {} numbers, too few for its strides at {} x {} pixels",
                self.name, self.buffer.length, size[0], size[1]
            )),
        }
    }
}
