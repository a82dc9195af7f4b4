//! The workload `waves`: a sine for each of twenty centres.

use super::frame::{Hits, LANES, Row, Workload, each, lit, norm, over, part, plane, planes, run};
use pse::Image;
use pse::internal::lanes::Isa;
use pse::internal::math;
use std::ops::Range;

/// `waves.pse`
pub fn waves(isa: Isa, image: &Image<'_>) -> Vec<Vec<f32>> {
    let waves = Waves {
        surface: plane(image, "surface"),
        point: planes(image, "point"),
        normal: planes(image, "normal"),
        hits: Hits::new(),
        p: [[0.0; LANES]; 3],
        n: [[0.0; LANES]; 3],
        length: [0.0; LANES],
        angle: [0.0; LANES],
        sine: [0.0; LANES],
    };
    run(isa, image, waves)
}

struct Waves<'a> {
    surface: &'a [f32],
    point: [&'a [f32]; 3],
    normal: [&'a [f32]; 3],
    hits: Hits,
    p: [Row; 3],
    n: [Row; 3],
    length: Row,
    angle: Row,
    sine: Row,
}

/// What is beside the torus.
const BLUE: [f32; 3] = [0.0, 0.0, 0.1];

const CENTERS: [[f32; 3]; 20] = [
    [0.003033931, 0.7367971, -0.6761071],
    [-0.6323985, -0.3228562, -0.7041562],
    [0.04208769, 0.9378646, -0.3444395],
    [-0.7153654, 0.5647546, 0.4114664],
    [0.1125166, -0.9931592, -0.03122269],
    [0.4397685, -0.8501948, -0.2894349],
    [-0.6457061, -0.4379615, -0.6255025],
    [-0.1784647, -0.9621566, 0.2059249],
    [0.06199234, -0.07392795, -0.9953349],
    [-0.9748101, -0.08776654, 0.2050421],
    [-0.814748, -0.2543882, -0.5210299],
    [-0.5186734, 0.6803098, -0.5178382],
    [-0.03067823, 0.8342586, -0.5505193],
    [-0.6588078, 0.6515073, 0.376179],
    [-0.669024, 0.04158149, 0.7420768],
    [-0.8722102, 0.4844811, 0.0672864],
    [-0.2870411, 0.8951337, 0.3410911],
    [-0.899811, 0.05590857, 0.4326828],
    [-0.265278, 0.9596305, -0.09347063],
    [0.3871055, 0.8345629, -0.3919874],
];

impl Workload<3> for Waves<'_> {
    #[inline(always)]
    fn block(&mut self, isa: Isa, at: Range<usize>, mut out: [&mut [f32]; 3]) {
        self.hits.find(&self.surface[at.clone()]);
        let lanes = self.hits.count;
        if lanes == 0 {
            out.iter_mut().zip(BLUE).for_each(|(out, x)| out.fill(x));
            return;
        }
        for (to, from) in self
            .p
            .iter_mut()
            .chain(&mut self.n)
            .zip(part(self.point, &at).into_iter().chain(part(self.normal, &at)))
        {
            self.hits.pick(from, to);
        }
        let Waves { p, n, length, angle, sine, .. } = self;
        for c in CENTERS {
            for i in 0..lanes {
                length[i] = norm([p[0][i] - c[0], p[1][i] - c[1], p[2][i] - c[2]]);
                angle[i] = 40.0 * length[i];
            }
            math::sin_lanes(isa, &angle[..lanes], &mut sine[..lanes]);
            for i in 0..lanes {
                let v = over([p[0][i] - c[0], p[1][i] - c[1], p[2][i] - c[2]], length[i]);
                for k in 0..3 {
                    n[k][i] += 0.05 * v[k] * sine[i];
                }
            }
        }
        let color = p.each_mut().map(|row| &mut row[..lanes]);
        each(n.each_ref().map(|row| &row[..lanes]), color, |n| {
            let light = lit(over(n, norm(n)));
            [light, 0.0 * light, 0.0 * light]
        });
        self.hits.put(&self.p, out, BLUE);
    }
}
