use super::*;
use crate::gbuffer::Projection;
use crate::host::NoFiles;
use crate::image::{Image, Variable};
use crate::scene;
use crate::shape::Shape;

fn flow(text: &str) -> Flow {
    Flow::compile(&NoFiles, "flow", text).unwrap_or_else(|e| panic!("{e}"))
}

fn run(text: &str, seeds: &[Vector], step: f64, steps: usize) -> Trajectories {
    flow(text).trajectories(seeds, step, steps, &RunOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// A camera at the built-in scene's place.
fn view(size: [usize; 2]) -> Projection {
    let options = scene::Options { width: size[0], height: size[1], ..scene::Options::default() };
    let image = scene::render("sphere", &options).expect("a scene");
    Projection::of(&image).expect("a camera")
}

#[test]
fn the_error_falls_with_the_fourth_power_of_the_step() {
    let text = "function velocity(p)\n    return [p.y -p.x p.z / 2]";
    let error = |steps: usize| {
        let round = run(text, &[[1.0, 0.0, 0.25]], 4.0 / steps as f64, steps);
        let end = round.line(0)[steps].map(f64::from);
        let exact = [libm::cos(4.0), -libm::sin(4.0), 0.25 * libm::exp(2.0)];
        glam::DVec3::from(end).distance(exact.into())
    };
    let (coarse, fine) = (error(8), error(16));
    let ratio = coarse / fine;
    assert!((12.0..24.0).contains(&ratio), "{coarse} and {fine}: {ratio}");
}

#[test]
fn backwards_leads_to_the_seed() {
    let text = "function velocity(p)\n    return curl(p)";
    let seeds = ball(50, 1.0);
    let there = run(text, &seeds, 0.01, 200);
    let ends: Vec<Vector> = (0..50).map(|i| there.line(i)[200]).collect();
    let back = run(text, &ends, -0.01, 200);
    for (i, seed) in seeds.iter().enumerate() {
        let end = back.line(i)[200];
        assert!((0..3).all(|k| (end[k] - seed[k]).abs() < 1e-4), "{seed:?} {end:?}");
    }
}

#[test]
fn threads_and_batches_change_nothing() {
    let text = "function velocity(p)\n    return Vnoise(3 * p) * turbulence(p)\nfunction color(p, age, along)\n    \
                return [age abs(along.x) 1 - age]";
    let flow = flow(text);
    let seeds = ball(3000, 1.0);
    let with = |threads, batch| {
        let options = RunOptions {
            threads: Some(threads),
            batch: Some(batch),
            pixelsize: Some(0.01),
            ..RunOptions::default()
        };
        let lines = flow.trajectories(&seeds, 0.05, 20, &options).expect("lines");
        let colors = flow.colors(&lines, &options).expect("colours").expect("some");
        let image = draw(&lines, Some(&colors), &view([64, 48]), &Pen::default(), None);
        let bits: Vec<u32> = image
            .variables
            .iter()
            .flat_map(|v| &v.planes)
            .flat_map(|p| p.iter())
            .map(|x| x.to_bits())
            .collect();
        (lines, bits)
    };
    let first = with(1, 2048);
    assert!(first.1.iter().any(|&b| b != 0));
    assert!(first == with(2, 2048) && first == with(2, 100));
}

#[test]
fn outer_variables_params_and_the_frame_are_there() {
    let text = "param speed = 2\nif begin_frame\n    up = [0 0 frame]\nwide = 3 * speed\nfunction velocity(p)\n    \
                return [speed wide 0] + up\ncolor = white * missing";
    let options = RunOptions { frame: 5.0, ..RunOptions::default() };
    let lines = flow(text).trajectories(&[[0.0; 3]], 1.0, 1, &options).expect("a line");
    assert_eq!(lines.line(0), [[0.0; 3], [2.0, 6.0, 5.0]]);
}

#[test]
fn the_divergence_of_curl_is_that_of_rounding() {
    let seeds = ball(1000, 2.3);
    let options = RunOptions::default();
    let share = |text: &str| {
        let measured = flow(text).divergence(&seeds, 1e-3, &options).expect("numbers");
        assert!(measured.gradient > 0.1 && measured.points == 1000);
        measured.share()
    };
    let curl = share("function velocity(p)\n    return curl(p)");
    assert!(curl < 2e-3, "{curl}");
    let plain = share("function velocity(p)\n    return Vnoise(p)");
    assert!((0.3..1.0).contains(&plain), "{plain}");
}

#[test]
fn what_is_no_flow_says_so() {
    let compiled = |text: &str| Flow::compile(&NoFiles, "flow", text).err().map(|e| e.to_string());
    let text = compiled("color = white").expect("an error");
    assert!(text.contains("no function `velocity(point)`"), "{text}");
    let text = compiled("function velocity(p, q)\n    return p").expect("an error");
    assert!(text.contains("takes 2"), "{text}");
    let text = compiled("function velocity(p)\n    return Du(p)").expect("an error");
    assert!(text.contains("neighbouring pixels"), "{text}");
    let followed = |text: &str| {
        let error = flow(text).trajectories(&[[1.0, 2.0, 3.0]], 1.0, 3, &RunOptions::default());
        error.expect_err("an error").to_string()
    };
    assert!(followed("function velocity(p)\n    return 1").contains("gives a scalar"));
    assert!(followed("function velocity(p)\n    return p / 0").contains("velocity([1 2 3])"));
    let many = flow("function velocity(p)\n    return p");
    let error = many.trajectories(&[[0.0; 3]; 2], 1.0, MAX_POINTS, &RunOptions::default());
    assert!(error.expect_err("an error").to_string().contains("too many points"));
}

#[test]
fn a_line_covers_what_it_is_wide() {
    // From the left to the right through the middle of the sphere's view, 2.3 units wide at least.
    let lines = Trajectories { steps: 1, points: vec![[-10.0, 0.0, 0.0], [10.0, 0.0, 0.0]] };
    for width in [0.25, 1.0, 2.5] {
        let image = draw(&lines, None, &view([40, 30]), &Pen { width }, None);
        let alpha = &image.variable("alpha").expect("alpha").planes[0];
        for column in 0..40 {
            let sum: f32 = (0..30).map(|row| alpha[row * 40 + column]).sum();
            assert!((f64::from(sum) - width).abs() < 0.02, "{width} at {column}: {sum}");
        }
    }
}

#[test]
fn the_nearer_line_is_before_the_other() {
    let lines = Trajectories {
        steps: 1,
        points: vec![[-9.0, 0.5, 0.0], [9.0, 0.5, 0.0], [0.0, -0.5, -9.0], [0.0, -0.5, 9.0]],
    };
    let colors = [[1.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]];
    let projection = view([41, 41]);
    let pen = Pen { width: 3.0 };
    let image = draw(&lines, Some(&colors), &projection, &pen, None);
    let middle = 20 * 41 + 20;
    let at = |name: &str| {
        image.variable(name).expect("a variable").planes.iter().map(|p| p[middle]).collect::<Vec<_>>()
    };
    assert_eq!((at("color"), at("alpha"), at("line")), (vec![0.0, 1.0, 0.0], vec![1.0], vec![1.0]));
    assert!((at("depth")[0] - 5.5).abs() < 1e-4 && (at("point")[1] + 0.5).abs() < 1e-5);
    // A wall between the two, and one before both.
    let wall = |depth: f32| {
        let depth = Variable::new("depth", Shape::Scalar, [vec![depth; 41 * 41]]).expect("a variable");
        let image = Image::new(41, 41, [depth]).expect("an image");
        draw(&lines, Some(&colors), &projection, &pen, Some(&image))
    };
    let line = |image: &Image<'_>, at: usize| image.variable("color").expect("color").planes[0][at];
    assert_eq!((line(&image, 20 * 41), line(&wall(6.0), 20 * 41)), (1.0, 0.0));
    assert_eq!(wall(6.0).variable("alpha").expect("alpha").planes[0][middle], 1.0);
    assert!(wall(5.0).variable("alpha").expect("alpha").planes[0].iter().all(|a| *a == 0.0));
}

#[test]
fn points_go_to_ply() {
    let lines = run("function velocity(p)\n    return [1 0 0]", &[[0.0; 3], [0.0, 1.0, 0.0]], 0.5, 2);
    let mut bytes = Vec::new();
    to_ply(&lines, None, &mut bytes).expect("bytes");
    let text = String::from_utf8_lossy(&bytes);
    assert!(text.starts_with("ply\nformat binary_little_endian 1.0\nelement vertex 6\n"), "{text}");
    assert!(text.contains("element edge 4\n"));
    let body = bytes.len() - 6 * 32 - 4 * 8;
    assert!(bytes[..body].ends_with(b"end_header\n"));
    let number = |at: usize| f32::from_le_bytes(bytes[body + at..][..4].try_into().expect("four bytes"));
    // The third point of the first line.
    assert_eq!([number(64), number(76), number(88)], [1.0, 1.0, 1.0]);
}

#[test]
fn seeds_lie_where_they_should() {
    let seeds = grid([2, 1, 3], [-1.0, 0.0, 0.0], [1.0, 4.0, 3.0]);
    assert_eq!((seeds.len(), seeds[0], seeds[5]), (6, [-0.5, 2.0, 0.5], [0.5, 2.0, 2.5]));
    let ball = ball(400, 2.0);
    let radius = |p: &Vector| p.iter().map(|x| x * x).sum::<f32>().sqrt();
    assert!(ball.iter().all(|p| (radius(p) - 2.0).abs() < 1e-5));
    // Evenly: each has its nearest neighbour at about the same distance.
    let nearest = |p: &Vector| {
        let apart = |q: &&Vector| radius(&[p[0] - q[0], p[1] - q[1], p[2] - q[2]]);
        ball.iter().filter(|q| *q != p).map(|q| apart(&q)).fold(f32::MAX, f32::min)
    };
    let near: Vec<f32> = ball.iter().map(nearest).collect();
    let (low, high) =
        (near.iter().copied().fold(f32::MAX, f32::min), near.iter().copied().fold(0.0, f32::max));
    assert!(low > 0.15 && high < 0.4, "{low} {high}");
    let options = scene::Options { width: 32, height: 32, ..scene::Options::default() };
    let image = scene::render("sphere", &options).expect("a scene");
    let seen = visible(&image, 4);
    assert!((30..64).contains(&seen.len()), "{}", seen.len());
    assert!(seen.iter().all(|p| (radius(p) - 1.0).abs() < 1e-5));
}
