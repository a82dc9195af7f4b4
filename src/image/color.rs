//! The sRGB transfer function (IEC 61966-2-1), by tables that are the same on every machine.
//!
//! Decoding looks a code up; encoding finds the code whose interval holds the value. The intervals
//! meet half way between codes, so that a decoded code always encodes to itself.

use std::sync::OnceLock;

/// An encoded component 0..1 as a linear one.
pub fn srgb_to_linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// A linear component as an encoded one; below 0 as its opposite.
pub fn linear_to_srgb(linear: f64) -> f64 {
    let size = linear.abs();
    let encoded = if size <= 0.003_130_8 { size * 12.92 } else { 1.055 * libm::pow(size, 1.0 / 2.4) - 0.055 };
    encoded.copysign(linear)
}

/// The linear value of an encoded number of any size; below 0 as its opposite.
pub fn decode(encoded: f32) -> f32 {
    (srgb_to_linear(f64::from(encoded.abs())) as f32).copysign(encoded)
}

/// Linear values of the codes `0..=max`, and the least linear value that encodes to each code above 0.
struct Table {
    linear: Vec<f32>,
    thresholds: Vec<f32>,
}

fn table(max: u16) -> &'static Table {
    static EIGHT: OnceLock<Table> = OnceLock::new();
    static SIXTEEN: OnceLock<Table> = OnceLock::new();
    let cell = if max == 255 { &EIGHT } else { &SIXTEEN };
    cell.get_or_init(|| {
        let scale = f64::from(max);
        Table {
            linear: (0..=max).map(|code| srgb_to_linear(f64::from(code) / scale) as f32).collect(),
            thresholds: (1..=max)
                .map(|code| srgb_to_linear((f64::from(code) - 0.5) / scale) as f32)
                .collect(),
        }
    })
}

/// The linear value of an 8-bit sRGB code.
pub fn decode8(code: u8) -> f32 {
    table(255).linear[usize::from(code)]
}

/// The linear value of a 16-bit sRGB code.
pub fn decode16(code: u16) -> f32 {
    table(65535).linear[usize::from(code)]
}

/// The nearest 8-bit sRGB code; below 0 and NaN give 0, above 1 gives 255.
pub fn encode8(linear: f32) -> u8 {
    table(255).thresholds.partition_point(|&t| t <= linear) as u8
}

/// The nearest 16-bit sRGB code; below 0 and NaN give 0, above 1 gives 65535.
pub fn encode16(linear: f32) -> u16 {
    table(65535).thresholds.partition_point(|&t| t <= linear) as u16
}

/// A number 0..1 as a code of `max` steps, with no transfer function; NaN gives 0.
pub fn quantize(value: f32, max: u16) -> u16 {
    // Rust's casts saturate and take NaN to 0.
    (value.clamp(0.0, 1.0) * f32::from(max) + 0.5) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_returns_to_itself() {
        for code in 0..=255 {
            assert_eq!(encode8(decode8(code)), code);
            assert_eq!(quantize(f32::from(code) / 255.0, 255), u16::from(code));
        }
        for code in 0..=65535 {
            assert_eq!(encode16(decode16(code)), code);
            assert_eq!(quantize(f32::from(code) / 65535.0, 65535), code);
        }
    }

    #[test]
    fn known_values_and_clipping() {
        assert_eq!(decode8(0), 0.0);
        assert_eq!(decode8(255), 1.0);
        assert!((decode8(188) - 0.502_886_5).abs() < 1e-6);
        assert_eq!(encode8(0.5), 188);
        assert_eq!(encode8(0.18), 118);
        for (value, code) in
            [(f32::NAN, 0), (-1.0, 0), (-0.0, 0), (2.0, 255), (f32::INFINITY, 255), (f32::NEG_INFINITY, 0)]
        {
            assert_eq!(encode8(value), code, "{value}");
            assert_eq!(quantize(value, 255), u16::from(code), "{value}");
        }
    }
}
