//! Shadows, for derivatives: beside the lanes of a batch's pixels there are as many that run the program one column
//! further, and as many one row further.
//!
//! A shadow begins with the input variables of the neighbour, and then follows its own pixel: what a condition says,
//! which element an index picks, how long a range is, the pixel decides for its shadows. So masks and shapes are the
//! same for all three, and `Du` is the shadow's value less the pixel's. (`Du` and `Dv` are those of RenderMan's shading
//! language, as Peachey uses them in *Texturing and Modeling*, chapter 2. There a difference is one between neighbouring
//! points of a grid, each of which may have gone a way of its own.)

use super::bind::{Bound, Source, incident};
use super::fault::Result;
use super::input::{Inputs, Samples};
use super::machine::{Machine, Slot};
use super::pixels::Pixels;
use super::steps::{Along, Steps};
use crate::parallel::for_rows;
use crate::resolve::tree::Stmt;
use crate::value::{Lanes, Mask, Plane, Value};
use smallvec::smallvec;

/// Lanes of a pixel that has shadows: itself, the next column's, the next row's.
pub(super) const LANES: usize = 3;

/// For each pixel, to which of its neighbours the surface goes on.
pub(super) struct Neighbours {
    /// Bits [`AFTER`] and [`BEFORE`] of the row, then those of the column.
    bits: Vec<u8>,
    width: usize,
}

const AFTER: u8 = 1;
const BEFORE: u8 = 2;
/// The column's bits lie so much higher than the row's.
const COLUMN: u8 = 2;

impl Neighbours {
    /// Looks for the neighbours of an image's pixels.
    pub fn of(inputs: &Inputs<'_>, steps: &Steps<'_>, mut bits: Vec<u8>, threads: bool) -> Neighbours {
        let (width, height) = (inputs.width, inputs.height);
        bits.clear();
        bits.resize(width * height, 0);
        for_rows(threads, &mut bits, width, |row, bits| {
            for (column, bits) in bits.iter_mut().enumerate() {
                let look = |along| {
                    let [after, before] = steps.line(along, column, row).sides();
                    (u8::from(after) * AFTER) | (u8::from(before) * BEFORE)
                };
                *bits = look(Along::Row) | look(Along::Column) << COLUMN;
            }
        });
        Neighbours { bits, width }
    }

    /// The memory, to be used again.
    pub fn into_buffer(self) -> Vec<u8> {
        self.bits
    }

    /// What a plane of the image holds for the shadow of a pixel: what the neighbour after it has, or what goes on from
    /// the neighbour before it, or the pixel's own where neither counts.
    #[inline]
    fn shadow(&self, plane: Samples<'_>, pixel: usize, along: Along) -> f32 {
        let (bits, step) = match along {
            Along::Row => (self.bits[pixel], 1),
            Along::Column => (self.bits[pixel] >> COLUMN, self.width),
        };
        let here = plane.at(pixel);
        if bits & AFTER != 0 && plane.at(pixel + step).is_finite() {
            return plane.at(pixel + step);
        }
        if bits & BEFORE != 0 && plane.at(pixel - step).is_finite() {
            return here + (here - plane.at(pixel - step));
        }
        here
    }

    /// How far a plane goes from a pixel's middle to another place in it, by the pixel's derivatives.
    #[inline]
    fn step(&self, plane: Samples<'_>, pixel: usize, [x, y]: [f32; 2]) -> f32 {
        let here = plane.at(pixel);
        let [row, column] = [Along::Row, Along::Column].map(|along| self.shadow(plane, pixel, along) - here);
        let step = x * row + y * column;
        // Nothing is known about what lies beside an infinity.
        if step.is_finite() { step } else { 0.0 }
    }
}

impl Bound<'_> {
    /// What a plane of the image holds at places of these pixels.
    pub fn moved(&self, plane: &Samples<'_>, pixels: Pixels<'_>, places: &[[f32; 2]]) -> Plane {
        let mut out = plane.gather(pixels);
        if let (Plane::Varying(lanes), Some(neighbours)) = (&mut out, &self.neighbours) {
            let lanes = lanes.get_mut(pixels.len()).iter_mut().zip(places).enumerate();
            lanes.for_each(|(lane, (x, place))| *x += neighbours.step(*plane, pixels.at(lane), *place));
        }
        out
    }
}

impl Source {
    /// The variable at the beginning of a batch with shadows. They lie as far from the middle of their pixels as the
    /// pixel's own lane, so that a derivative is one over a pixel wherever a sample lies.
    pub fn shadowed_slot(&self, pixels: Pixels<'_>, bound: &Bound<'_>, places: &[[f32; 2]]) -> Slot {
        let count = pixels.len();
        let value = match self {
            Source::Input(variable) | Source::Moved(variable) => match &bound.neighbours {
                Some(neighbours) => {
                    let variable = bound.inputs.get(*variable);
                    let plane = |plane: Samples<'_>| {
                        Plane::filled(LANES * count, |out| {
                            let (own, rest) = out.split_at_mut(count);
                            let (row, column) = rest.split_at_mut(count);
                            for lane in 0..count {
                                let pixel = pixels.at(lane);
                                own[lane] = plane.at(pixel);
                                row[lane] = neighbours.shadow(plane, pixel, Along::Row);
                                column[lane] = neighbours.shadow(plane, pixel, Along::Column);
                                if let (Source::Moved(_), Some(place)) = (self, places.get(lane)) {
                                    let step = neighbours.step(plane, pixel, *place);
                                    for x in [&mut own[lane], &mut row[lane], &mut column[lane]] {
                                        *x += step;
                                    }
                                }
                            }
                        })
                    };
                    let planes = variable.planes().map(plane).collect();
                    Value { shape: variable.shape.clone(), planes }
                }
                None => return self.slot(pixels, bound, places),
            },
            Source::Position => {
                let place = |axis: usize| {
                    Plane::filled(LANES * count, |out| {
                        for (lane, out) in out.iter_mut().enumerate() {
                            let beside = lane / count == axis + 1;
                            let position = bound.position(pixels.at(lane % count))[axis];
                            let place = places.get(lane % count).map_or(0.0, |place| place[axis]);
                            *out = position as f32 + 0.5 + f32::from(u8::from(beside)) + place;
                        }
                    })
                };
                Value::vector(smallvec![place(0), place(1)])
            }
            Source::Incident(point, eye) => {
                let point = point.shadowed_slot(pixels, bound, places).value.unwrap_or(Value::uniform(0.0));
                incident(&point, *eye, LANES * count)
            }
            // How the sizes of pixels change is not looked at.
            Source::PixelSize | Source::PixelFreq => {
                let own = self.slot(pixels, bound, places).value.unwrap_or(Value::uniform(0.0));
                Value::scalar(decided(&own.planes[0], count, LANES * count))
            }
            Source::Nowhere | Source::Uniform(_) => return self.slot(pixels, bound, places),
        };
        Slot::full(value)
    }
}

/// The plane with the pixels' own numbers in all `n` lanes.
fn decided(plane: &Plane, pixels: usize, n: usize) -> Plane {
    let Plane::Varying(lanes) = plane else { return plane.clone() };
    Plane::Varying(Lanes::filled(n, |out| {
        let own = lanes.get(pixels);
        out.chunks_exact_mut(pixels).for_each(|out| out.copy_from_slice(own));
    }))
}

impl<'r> Machine<'r> {
    /// From now on each pixel has shadows.
    pub fn cast_shadows(&mut self) {
        self.lanes_a_pixel = LANES;
    }

    /// Runs statements for the pixels alone: what they assign, no shadow reads. The pixels' lanes come first, so that
    /// values with shadows serve as they are.
    pub fn without_shadows(&mut self, stmts: &'r [Stmt], mask: &Mask) -> Result<Mask> {
        let lanes = (self.n, self.lanes_a_pixel);
        (self.n, self.lanes_a_pixel) = (self.pixels(), 1);
        let mask = self.block(stmts, mask);
        (self.n, self.lanes_a_pixel) = lanes;
        mask
    }

    /// Have the pixels shadows?
    pub fn shadowed(&self) -> bool {
        self.lanes_a_pixel > 1
    }

    /// How many pixels the lanes are of. They come first.
    pub fn pixels(&self) -> usize {
        self.n / self.lanes_a_pixel
    }

    /// What the pixels have, for their shadows too.
    pub fn decided_plane(&self, plane: &Plane) -> Plane {
        if self.shadowed() { decided(plane, self.pixels(), self.n) } else { plane.clone() }
    }
}
