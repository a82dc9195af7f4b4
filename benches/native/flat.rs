//! The workloads that are one loop over the planes: diffuse, over, recursive.

use super::frame::{Formula, Workload, each, each_of, hits, lit, max, min, norm, part, plane, planes, run};
use pse::Image;
use pse::internal::lanes::Isa;
use std::ops::Range;

/// `diffuse.pse`
pub fn diffuse(isa: Isa, image: &Image<'_>) -> Vec<Vec<f32>> {
    run(isa, image, Diffuse { surface: plane(image, "surface"), normal: planes(image, "normal") })
}

struct Diffuse<'a> {
    surface: &'a [f32],
    normal: [&'a [f32]; 3],
}

/// What is beside the torus.
const BLUE: [f32; 3] = [0.0, 0.0, 0.1];

impl Workload<3> for Diffuse<'_> {
    #[inline(always)]
    fn block(&mut self, _: Isa, at: Range<usize>, out: [&mut [f32]; 3]) {
        let surface = &self.surface[at.clone()];
        if hits(surface) == 0 {
            out.into_iter().zip(BLUE).for_each(|(out, x)| out.fill(x));
            return;
        }
        let [x, y, z] = part(self.normal, &at);
        each([surface, x, y, z], out, |[surface, x, y, z]| {
            let light = lit([x, y, z]);
            let red = [light, 0.0 * light, 0.0 * light];
            if surface == 1.0 { red } else { BLUE }
        });
    }
}

/// `over.pse`
pub fn over(isa: Isa, image: &Image<'_>) -> Vec<Vec<f32>> {
    let of = |name| (planes(image, &format!("{name}.color")), plane(image, &format!("{name}.alpha")));
    run(isa, image, Over { fg: of("fg"), bg: of("bg") })
}

struct Over<'a> {
    fg: ([&'a [f32]; 3], &'a [f32]),
    bg: ([&'a [f32]; 3], &'a [f32]),
}

impl Workload<4> for Over<'_> {
    #[inline(always)]
    fn block(&mut self, _: Isa, at: Range<usize>, out: [&mut [f32]; 4]) {
        let ([a, b, c], alpha) = self.fg;
        let ([d, e, f], below) = self.bg;
        each(part([a, b, c, alpha, d, e, f, below], &at), out, |p| {
            let through = 1.0 - p[3];
            std::array::from_fn(|k| p[k] + through * p[k + 4])
        });
    }
}

/// `recursive.pse`
pub fn recursive(isa: Isa, image: &Image<'_>) -> Vec<Vec<f32>> {
    run(isa, image, Recursive { surface: plane(image, "surface"), point: planes(image, "point") })
}

struct Recursive<'a> {
    surface: &'a [f32],
    point: [&'a [f32]; 3],
}

const FOLDS: usize = 5;

struct Folded;

impl Formula<4, 3> for Folded {
    #[inline(always)]
    fn of(&self, [surface, x, y, z]: [f32; 4]) -> [f32; 3] {
        // All folds there may be, in every lane, and then which of them count.
        let mut p = [2.0 * x, 2.0 * y, 2.0 * z];
        let distances: [f32; FOLDS] = std::array::from_fn(|_| {
            let q = p.map(|x| x.abs() - 0.4);
            p = [1.5 * q[1], 1.5 * q[2], 1.5 * q[0]];
            norm(q) - 0.2
        });
        let mut nearest = distances[FOLDS - 1];
        for k in (0..FOLDS - 1).rev() {
            let with = min(distances[k], nearest / 1.5);
            nearest = if distances[k] > 1.0 { distances[k] } else { with };
        }
        let near = max(0.0, 1.0 - 3.0 * nearest.abs());
        let color = [near, 0.9 * near, 0.8 * near];
        if surface == 1.0 { color } else { [0.0; 3] }
    }
}

impl Workload<3> for Recursive<'_> {
    #[inline(always)]
    fn block(&mut self, _: Isa, at: Range<usize>, out: [&mut [f32]; 3]) {
        let surface = &self.surface[at.clone()];
        if hits(surface) == 0 {
            out.into_iter().for_each(|out| out.fill(0.0));
            return;
        }
        let [x, y, z] = part(self.point, &at);
        each_of([surface, x, y, z], out, Folded);
    }
}
