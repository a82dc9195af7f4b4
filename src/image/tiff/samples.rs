//! The samples of TIFF strips and tiles: predictors, byte orders, and numbers of any size.

use half::f16;

/// What a sample is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Unsigned,
    Signed,
    Float,
}

/// How samples are stored.
#[derive(Clone, Copy, Debug)]
pub(super) struct Storage {
    pub kind: Kind,
    pub bits: usize,
    pub big_endian: bool,
    /// 1: none, 2: differences, 3: differences of the bytes of floats.
    pub predictor: u64,
}

impl Storage {
    /// The sizes that are read.
    pub fn check(&self) -> Result<(), String> {
        let fits = match self.kind {
            Kind::Float => matches!(self.bits, 16 | 24 | 32 | 64),
            Kind::Unsigned | Kind::Signed => matches!(self.bits, 1..=32 | 64),
        };
        if !fits {
            let kind = if self.kind == Kind::Float { "floats" } else { "numbers" };
            return Err(format!("{kind} of {} bits", self.bits));
        }
        match self.predictor {
            0 | 1 => Ok(()),
            2 => Ok(()),
            3 if self.kind == Kind::Float => Ok(()),
            other => Err(format!("predictor {other} for numbers of {} bits", self.bits)),
        }
    }

    /// Whether the samples are packed bit by bit, the most significant one first whatever the byte order.
    fn is_packed(&self) -> bool {
        self.kind != Kind::Float && !matches!(self.bits, 8 | 16 | 32 | 64)
    }

    /// The greatest number that is stored.
    pub fn max(&self) -> f64 {
        match self.kind {
            Kind::Float => 1.0,
            Kind::Unsigned => libm::ldexp(1.0, self.bits as i32) - 1.0,
            Kind::Signed => libm::ldexp(1.0, self.bits as i32 - 1) - 1.0,
        }
    }

    /// Undoes the predictor in a row of `count` samples for each pixel, unless they are packed; then floats of predictor 3 have the most
    /// significant byte first.
    pub fn restore(&self, row: &mut [u8], count: usize) {
        let size = self.bits / 8;
        match self.predictor {
            2 if !self.is_packed() => {
                let step = count * size;
                for at in (step..row.len() / size * size).step_by(size) {
                    // The difference is one of whole numbers, also of floats.
                    let mut carry = 0;
                    for i in 0..size {
                        let i = if self.big_endian { size - 1 - i } else { i };
                        let sum = u16::from(row[at + i]) + u16::from(row[at + i - step]) + carry;
                        row[at + i] = sum as u8;
                        carry = sum >> 8;
                    }
                }
            }
            3 => {
                for at in count..row.len() {
                    row[at] = row[at].wrapping_add(row[at - count]);
                }
                let samples = row.len() / size;
                let planes = row.to_vec();
                for (i, byte) in row.iter_mut().enumerate().take(samples * size) {
                    *byte = planes[i % size * samples + i / size];
                }
            }
            _ => {}
        }
    }

    fn big(&self) -> bool {
        self.big_endian || self.predictor == 3
    }

    /// Unpacks unsigned numbers of up to 16 bits, `count` for each pixel.
    pub fn codes(&self, row: &[u8], count: usize, mut put: impl FnMut(u16)) {
        match self.bits {
            8 => row.iter().for_each(|&b| put(u16::from(b))),
            16 => row.as_chunks::<2>().0.iter().for_each(|&pair| {
                put(if self.big_endian { u16::from_be_bytes(pair) } else { u16::from_le_bytes(pair) });
            }),
            _ => self.packed(row, count, |code| put(code as u16)),
        }
    }

    /// Unpacks numbers of any kind; whole ones are divided by the greatest that there is.
    pub fn numbers(&self, row: &[u8], count: usize, mut put: impl FnMut(f32)) {
        let max = self.max();
        let size = self.bits / 8;
        if self.is_packed() {
            return self.packed(row, count, |code| put(self.scaled(code, max)));
        }
        for bytes in row.chunks_exact(size) {
            let add = |sum: u64, &byte: &u8| sum << 8 | u64::from(byte);
            let code = if self.big() { bytes.iter().fold(0, add) } else { bytes.iter().rev().fold(0, add) };
            put(match (self.kind, self.bits) {
                (Kind::Float, 16) => f16::from_bits(code as u16).to_f32(),
                (Kind::Float, 24) => float24(code as u32),
                (Kind::Float, 32) => f32::from_bits(code as u32),
                (Kind::Float, _) => f64::from_bits(code) as f32,
                _ => self.scaled(code, max),
            });
        }
    }

    fn scaled(&self, code: u64, max: f64) -> f32 {
        match self.kind {
            Kind::Signed => {
                let unused = 64 - self.bits as u32;
                (((code << unused) as i64 >> unused) as f64 / max) as f32
            }
            _ => (code as f64 / max) as f32,
        }
    }

    fn packed(&self, row: &[u8], count: usize, mut put: impl FnMut(u64)) {
        let (mut window, mut held) = (0u64, 0);
        let mask = (1 << self.bits) - 1;
        // The codes of the pixel before, to which predictor 2 adds.
        let mut before = vec![0; if self.predictor == 2 { count } else { 0 }];
        let mut at = 0;
        for &byte in row {
            window = window << 8 | u64::from(byte);
            held += 8;
            while held >= self.bits {
                held -= self.bits;
                let mut code = window >> held & mask;
                if let Some(sum) = before.get_mut(at % count) {
                    *sum = (*sum + code) & mask;
                    code = *sum;
                }
                at += 1;
                put(code);
            }
        }
    }
}

/// A float of 24 bits: 1 of sign, 7 of exponent, 16 of fraction.
fn float24(code: u32) -> f32 {
    let (sign, exponent, fraction) = (code >> 23 & 1, code >> 16 & 0x7f, code & 0xffff);
    let size = match exponent {
        0 => f64::from(fraction) * libm::ldexp(1.0, -62 - 16),
        0x7f if fraction == 0 => f64::INFINITY,
        0x7f => f64::NAN,
        _ => (1.0 + f64::from(fraction) / 65536.0) * libm::ldexp(1.0, exponent as i32 - 63),
    };
    if sign == 1 { -size as f32 } else { size as f32 }
}
