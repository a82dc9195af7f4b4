//! The workload `straight`: two hundred assignments.

use super::frame::{Workload, part, planes, run};
use pse::Image;
use pse::internal::lanes::Isa;
use std::ops::Range;

/// `straight.pse`
pub fn straight(isa: Isa, image: &Image<'_>) -> Vec<Vec<f32>> {
    let [.., z] = planes::<3>(image, "normal");
    let [a, b, c] = planes(image, "point");
    run(isa, image, Straight([a, b, c, z]))
}

struct Straight<'a>([&'a [f32]; 4]);

/// So many lanes at a time: each assignment waits for the one before, so that the processor needs those of several
/// vectors to be busy, and as many as keep their four variables in registers.
const TOGETHER: usize = 24;

/// The program has the four lines of a round so many times.
const ROUNDS: usize = 49;

impl Workload<3> for Straight<'_> {
    #[inline(always)]
    fn block(&mut self, _: Isa, at: Range<usize>, mut out: [&mut [f32]; 3]) {
        let planes = part(self.0, &at);
        let n = at.len();
        for start in (0..n).step_by(TOGETHER) {
            let end = (start + TOGETHER).min(n);
            let mut lanes = [[0.0; TOGETHER]; 4];
            for (lanes, plane) in lanes.iter_mut().zip(planes) {
                match plane[start..end].try_into() {
                    Ok(whole) => *lanes = whole,
                    Err(_) => lanes[..end - start].copy_from_slice(&plane[start..end]),
                }
            }
            let [mut a, mut b, mut c, mut d] = lanes;
            for _ in 0..ROUNDS {
                for i in 0..TOGETHER {
                    a[i] = a[i] * 0.99 + b[i];
                    b[i] = b[i] * 0.99 - a[i];
                    c[i] = c[i] * 0.95 + a[i];
                    d[i] = b[i] - d[i] * 0.95;
                }
            }
            for (out, mut color) in out.iter_mut().zip([a, b, c]) {
                for i in 0..TOGETHER {
                    color[i] = 0.1 * (color[i] + d[i]);
                }
                match out[start..end].first_chunk_mut() {
                    Some(out) => *out = color,
                    None => out[start..end].copy_from_slice(&color[..end - start]),
                }
            }
        }
    }
}
