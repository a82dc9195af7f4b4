//! The workload `branchy`: four materials, mixed pixel by pixel.
//!
//! What is cheap is computed in all lanes; noise, sine and power only in those of their material.

use super::frame::{LANES, Row, Workload, dot, each, max, norm, over, part, plane, planes, run};
use pse::Image;
use pse::internal::lanes::Isa;
use pse::internal::math;
use pse::noise::{Field, Kind, Params};
use std::ops::Range;
use std::sync::Arc;

/// `branchy.pse`
pub fn branchy(isa: Isa, image: &Image<'_>) -> Vec<Vec<f32>> {
    let kind = Kind::from_name("gradient").expect("it is a kind of noise");
    let row = [0.0; LANES];
    let light = [-0.5, -0.7, 0.8];
    let branchy = Branchy {
        surface: plane(image, "surface"),
        point: planes(image, "point"),
        normal: planes(image, "normal"),
        light: over(light, norm(light)),
        noise: kind.field(3, &Params::default()).expect("it has three dimensions"),
        lists: [[0; LANES]; 4],
        shift: [0; LANES],
        p: [row; 3],
        angle: row,
        lit: row,
        value: row,
        result: row,
    };
    run(isa, image, branchy)
}

struct Branchy<'a> {
    surface: &'a [f32],
    point: [&'a [f32]; 3],
    normal: [&'a [f32]; 3],
    light: [f32; 3],
    noise: Arc<dyn Field>,
    /// The lanes of each material.
    lists: [[u16; LANES]; 4],
    /// Sixteen times each lane's material.
    shift: [u32; LANES],
    /// Numbers of one material, without gaps.
    p: [Row; 3],
    result: Row,
    /// Numbers of all lanes: the stripes' angle, the light on plastic, and what noise, sine or power gave.
    angle: Row,
    lit: Row,
    value: Row,
}

impl Branchy<'_> {
    /// Sorts the lanes by material, and tells how many each has.
    #[inline(always)]
    fn sort(&mut self, surface: &[f32]) -> [usize; 4] {
        for (shift, &s) in self.shift.iter_mut().zip(surface) {
            let upper = if s == 2.0 { 32 } else { 48 };
            let lower = if s == 1.0 { 16 } else { upper };
            *shift = if s == 0.0 { 0 } else { lower };
        }
        // Four counts in one register: no lane waits for memory to know its place.
        let mut counts = 0_u64;
        for (i, &shift) in self.shift[..surface.len()].iter().enumerate() {
            let next = (counts >> shift) as usize % LANES;
            self.lists[(shift / 16) as usize % 4][next] = i as u16;
            counts += 1 << shift;
        }
        std::array::from_fn(|k| (counts >> (16 * k)) as usize & 0xffff)
    }
}

#[inline(always)]
fn gather(list: &[u16], from: &[f32], to: &mut [f32]) {
    for (to, &lane) in to.iter_mut().zip(list) {
        *to = from[usize::from(lane)];
    }
}

#[inline(always)]
fn scatter(list: &[u16], from: &[f32], to: &mut [f32]) {
    for (from, &lane) in from.iter().zip(list) {
        to[usize::from(lane)] = *from;
    }
}

impl Workload<3> for Branchy<'_> {
    #[inline(always)]
    fn block(&mut self, isa: Isa, at: Range<usize>, out: [&mut [f32]; 3]) {
        let lanes = at.len();
        let surface = &self.surface[at.clone()];
        let [x, y, z] = part(self.point, &at);
        let [u, v, w] = part(self.normal, &at);
        let [noisy, striped, shiny, _] = self.sort(surface);
        let Branchy { light, noise, lists, p, angle, lit, value, result, .. } = self;

        each([x, z, u, v, w], [&mut angle[..lanes], &mut lit[..lanes]], |[x, z, u, v, w]| {
            [40.0 * (x + 0.5 * z), max(0.0, dot([u, v, w], *light))]
        });

        let list = &lists[0][..noisy];
        for (p, from) in p.iter_mut().zip([x, y, z]) {
            gather(list, from, &mut p[..noisy]);
            p[..noisy].iter_mut().for_each(|x| *x *= 8.0);
        }
        noise.noise(isa, &p.each_ref().map(|p| &p[..noisy]), &mut result[..noisy]);
        scatter(list, &result[..noisy], value);

        let list = &lists[1][..striped];
        gather(list, angle, &mut p[0][..striped]);
        math::sin_lanes(isa, &p[0][..striped], &mut result[..striped]);
        scatter(list, &result[..striped], value);

        let list = &lists[2][..shiny];
        gather(list, lit, &mut p[0][..shiny]);
        for (result, &x) in result[..shiny].iter_mut().zip(&p[0]) {
            *result = math::pow(x, 30.0);
        }
        scatter(list, &result[..shiny], value);

        each([surface, x, y, z, &lit[..lanes], &value[..lanes]], out, |[surface, x, y, z, lit, value]| {
            let (stone, stripe) = (0.6 + 0.4 * value, 0.5 + 0.5 * value);
            let (body, shine) = (0.2 + 0.8 * lit, 0.7 * value);
            let sum = (6.0 * x).floor() + (6.0 * y).floor() + (6.0 * z).floor();
            let even = sum - 2.0 * (0.5 * sum).floor() == 0.0;
            let color = |stones: f32, stripes: [f32; 2], plastic: f32, checks: [f32; 2]| {
                let check = if even { checks[0] } else { checks[1] };
                let upper = if surface == 2.0 { plastic * body + shine } else { check };
                let lower = if surface == 1.0 { stripes[0] + stripe * stripes[1] } else { upper };
                if surface == 0.0 { stones * stone } else { lower }
            };
            [
                color(0.9, [0.1, 0.8], 0.4, [0.9, 0.1]),
                color(0.6, [0.2, 0.5], 0.05, [0.9, 0.3]),
                color(0.3, [0.6, 0.1], 0.05, [0.8, 0.1]),
            ]
        });
    }
}
