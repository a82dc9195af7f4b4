//! Colours: linear light with the primaries of Rec. 709 (those of sRGB), unless said otherwise. An alpha in a
//! fourth component is carried along.

use super::apply::{each, each_scalar, vector_of};
use super::arithmetic::{clamp, max, min};
use super::call::{Call, Fault};
use super::{Builtin, Kernel, Param, ex};
use crate::lanes::map1;
use crate::math;
use crate::value::{Planes, Value};

/// The curve of IEC 61966-2-1 that sRGB files are written with, mirrored below zero.
#[inline(always)]
fn encode(x: f32) -> f32 {
    let a = x.abs();
    let curve = 1.055 * math::pow(a, 1.0 / 2.4) - 0.055;
    let encoded = if a <= 0.0031308 { 12.92 * a } else { curve };
    encoded.copysign(x)
}

/// The inverse of [`encode`].
#[inline(always)]
fn decode(x: f32) -> f32 {
    let a = x.abs();
    let curve = math::pow((a + 0.055) / 1.055, 2.4);
    let linear = if a <= 0.04045 { a / 12.92 } else { curve };
    linear.copysign(x)
}

/// One round of the hexagon of hues, in sixths, from 0 up to 6.
#[inline(always)]
fn sixths(x: f32) -> f32 {
    x - 6.0 * math::floor(x / 6.0)
}

#[inline(always)]
fn hsv_to_rgb([h, s, v]: [f32; 3]) -> [f32; 3] {
    [5.0, 3.0, 1.0].map(|n| {
        let k = sixths(n + 6.0 * h);
        v - v * s * clamp(min(k, 4.0 - k), 0.0, 1.0)
    })
}

#[inline(always)]
fn hsl_to_rgb([h, s, l]: [f32; 3]) -> [f32; 3] {
    let a = s * min(l, 1.0 - l);
    [0.0, 4.0, 2.0].map(|n| {
        let k = sixths(n + 6.0 * h);
        l - a * clamp(min(2.0 * k - 3.0, 9.0 - 2.0 * k), -1.0, 1.0)
    })
}

/// Hue in turns, the largest and the smallest component.
#[inline(always)]
fn hue([r, g, b]: [f32; 3]) -> [f32; 3] {
    let (top, low) = (max(max(r, g), b), min(min(r, g), b));
    let c = top - low;
    let from_red = (g - b) / c;
    let from_green = (b - r) / c + 2.0;
    let from_blue = (r - g) / c + 4.0;
    let h = if top == r {
        from_red
    } else if top == g {
        from_green
    } else {
        from_blue
    };
    let turns = sixths(h) / 6.0;
    [if c == 0.0 { 0.0 } else { turns }, top, low]
}

#[inline(always)]
fn rgb_to_hsv(rgb: [f32; 3]) -> [f32; 3] {
    let [h, top, low] = hue(rgb);
    let s = (top - low) / top;
    [h, if top == low { 0.0 } else { s }, top]
}

#[inline(always)]
fn rgb_to_hsl(rgb: [f32; 3]) -> [f32; 3] {
    let [h, top, low] = hue(rgb);
    let l = 0.5 * (top + low);
    let s = (top - l) / min(l, 1.0 - l);
    [h, if top == low { 0.0 } else { s }, l]
}

/// The colour of a black body. Krystek's rational approximation (1985) of the Planckian locus in the CIE 1960
/// chart, right to 0.0001 from 1000 K to 15000 K; then by way of XYZ to Rec. 709.
#[inline(always)]
fn blackbody([kelvin]: [f32; 1]) -> [f32; 3] {
    let t = clamp(kelvin, 1000.0, 1e6);
    let u = (0.86011773 + t * (0.00015411824 + t * 1.286412e-07))
        / (1.0 + t * (0.00084242027 + t * 7.0814514e-07));
    let v = (0.31739873 + t * (4.2280626e-05 + t * 4.2048168e-08))
        / (1.0 + t * (-2.8974182e-05 + t * 1.6145604e-07));
    // X = 3u, Y = 2v, Z = 4 - u - 10v, but for a common factor.
    let (x, y, z) = (3.0 * u, 2.0 * v, 4.0 - u - 10.0 * v);
    let rgb = [
        3.240_454_2 * x - 1.537_138_5 * y - 0.498_531_4 * z,
        -0.969_266 * x + 1.876_010_8 * y + 0.041_556 * z,
        0.055_643_4 * x - 0.204_025_9 * y + 1.057_225_2 * z,
    ];
    let top = max(max(rgb[0], rgb[1]), rgb[2]);
    rgb.map(|c| clamp(c / top, 0.0, 1.0))
}

/// A function of three components on each colour of the first argument.
fn on_colors(call: &Call<'_>, name: &str, f: impl Fn([f32; 3]) -> [f32; 3] + Copy) -> Result<Value, Fault> {
    each([&call.args[0]], &mut |[color]| {
        let planes = vector_of(name, 0, color, &[3, 4])?;
        let out = call.lanes([&planes[0], &planes[1], &planes[2]], f);
        Ok(Value::vector(out.into_iter().chain(planes[3..].iter().cloned()).collect::<Planes>()))
    })
}

fn luminance(call: &Call<'_>) -> Result<Value, Fault> {
    each([&call.args[0]], &mut |[color]| {
        if color.shape.is_scalar() {
            return Ok(color.clone());
        }
        let planes = vector_of("luminance", 0, color, &[3, 4])?;
        let light = |[r, g, b]: [f32; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
        Ok(Value::scalar(call.lane([&planes[0], &planes[1], &planes[2]], light)))
    })
}

fn blackbodies(call: &Call<'_>) -> Result<Value, Fault> {
    call.room(3 * call.args[0].planes.len())?;
    each_scalar(&call.args[0], &mut |kelvin| {
        Ok(Value::vector(call.lanes([kelvin], blackbody).into_iter().collect()))
    })
}

/// Colour.
pub static FUNCTIONS: &[Builtin] = &[
    Builtin {
        name: "luminance",
        params: &[Param::new("color")],
        brief: "The luminance of a colour in linear light.",
        doc: "`0.2126 R + 0.7152 G + 0.0722 B` (Rec. 709). A scalar is a grey and is returned unchanged; an alpha is \
              ignored.",
        examples: &[ex("luminance([1 1 1])", "1"), ex("luminance([0 1 0])", "0.7152")],
        kernel: Kernel::Whole(luminance),
    },
    Builtin {
        name: "hsv_to_rgb",
        params: &[Param::new("hsv")],
        brief: "The colour with this hue, saturation and value.",
        doc: "The hue counts turns: 0 red, 1/3 green, 2/3 blue, 1 red again, and so on in both directions. \
              Saturation and value are between 0 and 1; a value above 1 is a brighter light (Smith, *Color Gamut \
              Transform Pairs*, 1978).",
        examples: &[ex("hsv_to_rgb([1/3 1 1])", "[0 1 0]"), ex("hsv_to_rgb([0.5 0.5 0.8])", "[0.4 0.8 0.8]")],
        kernel: Kernel::Whole(|call| on_colors(call, "hsv_to_rgb", hsv_to_rgb)),
    },
    Builtin {
        name: "rgb_to_hsv",
        params: &[Param::new("rgb")],
        brief: "The hue, saturation and value of a colour.",
        doc: "The inverse of [hsv_to_rgb](#hsv_to_rgb), with a hue from 0 up to 1; a grey's hue and saturation are 0.",
        examples: &[ex("rgb_to_hsv([0 0 1])", "[2/3 1 1]"), ex("rgb_to_hsv([0.4 0.8 0.8])", "[0.5 0.5 0.8]")],
        kernel: Kernel::Whole(|call| on_colors(call, "rgb_to_hsv", rgb_to_hsv)),
    },
    Builtin {
        name: "hsl_to_rgb",
        params: &[Param::new("hsl")],
        brief: "The colour with this hue, saturation and lightness.",
        doc: "The hue counts turns, as in [hsv_to_rgb](#hsv_to_rgb); lightness is from 0, black, to 1, white.",
        examples: &[ex("hsl_to_rgb([1/3 1 0.5])", "[0 1 0]"), ex("hsl_to_rgb([0 1 0.75])", "[1 0.5 0.5]")],
        kernel: Kernel::Whole(|call| on_colors(call, "hsl_to_rgb", hsl_to_rgb)),
    },
    Builtin {
        name: "rgb_to_hsl",
        params: &[Param::new("rgb")],
        brief: "The hue, saturation and lightness of a colour.",
        doc: "The inverse of [hsl_to_rgb](#hsl_to_rgb), with a hue from 0 up to 1; a grey's hue and saturation are 0.",
        examples: &[ex("rgb_to_hsl([1 0.5 0.5])", "[0 1 0.75]")],
        kernel: Kernel::Whole(|call| on_colors(call, "rgb_to_hsl", rgb_to_hsl)),
    },
    Builtin {
        name: "srgb_to_linear",
        params: &[Param::new("x")],
        brief: "Decodes sRGB values, 0 to 1, to linear light.",
        doc: "Component by component, an alpha too (which sRGB does not encode: apply it to the first three). Below \
              zero the curve is mirrored (IEC 61966-2-1). Pictures are converted automatically when read and \
              written; use this for colours picked in other programs.",
        examples: &[ex("srgb_to_linear([0 0.5 1])", "[0 0.21404114 1]")],
        kernel: Kernel::Map1(|isa, a, out| map1(isa, a, out, decode)),
    },
    Builtin {
        name: "linear_to_srgb",
        params: &[Param::new("x")],
        brief: "Encodes linear light as sRGB values.",
        doc: "The inverse of [srgb_to_linear](#srgb_to_linear).",
        examples: &[ex("linear_to_srgb([0 0.21404114 1])", "[0 0.5 1]")],
        kernel: Kernel::Map1(|isa, a, out| map1(isa, a, out, encode)),
    },
    Builtin {
        name: "blackbody",
        params: &[Param::new("kelvin")],
        brief: "The colour of a body that glows at this temperature, in kelvins.",
        doc: "In linear light, scaled so that its largest component is 1: multiply it by a brightness (that of a \
              black body grows with the fourth power of its temperature). Candle flame 1900, light bulb 2800, noon \
              sun 5800, blue sky 12000. Below 1000 the colour is that at 1000; red outside Rec. 709 is clipped. From \
              Krystek's approximation of the Planckian locus, 1985, good to 15000 and plausible beyond.",
        examples: &[ex("blackbody(1000)[1]", "1"), ex("blackbody(20000)[3]", "1")],
        kernel: Kernel::Whole(blackbodies),
    },
];
