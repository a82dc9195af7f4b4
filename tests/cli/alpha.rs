//! The alpha of an image goes with the colour that a program makes of it.

use super::{Folder, load};
use pse::{Image, Program, RunOptions, Shape, Variable};

/// A folder with `a.exr` and `a.png`, whose alpha grows from the left, and `b.exr`, the same without alpha.
fn folder() -> Folder {
    let f = Folder::new();
    f.write("make.pse", "alpha = pixel.x / 9\ncolor = alpha * [0.2 0.4 pixel.y / 40]\n");
    f.good("run make.pse --scene card --size 9x40 -q -o a.exr -o a.png");
    f.good("run make.pse --scene card --size 9x40 -q -o b.exr --vars color");
    f
}

fn has_alpha(f: &Folder, name: &str) -> bool {
    load(&f.path(name)).variable("alpha").is_some()
}

#[test]
fn it_is_passed_on_unless_the_program_has_its_own() {
    let f = folder();
    let alpha = f.planes("a.exr", "alpha");
    f.write("p.pse", "color = 2 * color\n");
    for options in ["", "--batch 7 --threads 1", "--samples 5", "--no-optimize"] {
        f.good(&format!("run p.pse -q -i a.exr -o o.exr {options}"));
        assert_eq!(f.planes("o.exr", "alpha"), alpha, "{options}");
    }
    // Of a picture with whole numbers it comes back with the same ones.
    f.good("run p.pse -q -i a.png -o o.png");
    assert_eq!(f.planes("o.png", "alpha"), f.planes("a.png", "alpha"));
    f.good("run -q -e point -i b.exr -i a.exr --map point=R,G,B -o o.exr");
    assert_eq!(f.planes("o.exr", "alpha"), alpha, "the second image has the alpha");
    f.good("run p.pse -q -i a.exr -o o.exr --region 2,3,7,30");
    assert_eq!(f.planes("o.exr", "alpha")[0][..5], alpha[0][3 * 9 + 2..3 * 9 + 7]);
    f.good("run p.pse -q -i a.exr -o t.{tile}.exr --tile 1/2x2");
    assert!(has_alpha(&f, "t.1.exr"));
    // The program's own, in one of two ways.
    for (text, expected) in [("color = color\nalpha = 1", 1.0), ("color = [0.5 0 0 0.5]", 0.5)] {
        f.write("own.pse", text);
        f.good("run own.pse -q -i a.exr -o o.exr");
        assert!(f.planes("o.exr", "alpha")[0].iter().all(|a| *a == expected), "{text}");
    }
    // Four components that come late.
    f.write("late.pse", "color = pixel.y > 30 ? [0.5 0 0 0.5] : [1 0 0]\n");
    f.good("run late.pse -q -i a.exr -o o.exr");
    let late = &f.planes("o.exr", "alpha")[0];
    assert_eq!((late[0], late[9 * 39]), (1.0, 0.5));
}

#[test]
fn it_is_not_invented() {
    let f = folder();
    f.write("p.pse", "color = 2 * color\n");
    f.good("run p.pse -q -i a.exr -o o.exr --vars color");
    assert!(!has_alpha(&f, "o.exr"));
    f.good("run p.pse -q -i b.exr -o o.exr");
    assert!(!has_alpha(&f, "o.exr"));
    f.good("run -q -e white --scene card --size 4x4 -o o.exr");
    assert!(!has_alpha(&f, "o.exr"));
    // The alpha of an image with a name is that image's.
    f.good("run -q -e fg.color -i fg=a.exr -o o.exr");
    assert!(!has_alpha(&f, "o.exr"));
    // A program that makes no colour writes what it makes.
    f.good("run -q -e twice=color -i a.exr -o o.exr");
    assert!(!has_alpha(&f, "o.exr"));
}

#[test]
fn a_trace_and_a_host_see_it_too() {
    let f = folder();
    f.write("p.pse", "color = 2 * color\n");
    let trace = f.good("trace p.pse --pixel 4,1 -i a.exr");
    assert!(trace.text.contains("alpha = 0.5"), "{}", trace.text);
    let variable = |name: &str, shape, planes: Vec<Vec<f32>>| Variable::new(name, shape, planes).unwrap();
    let image = Image::new(
        2,
        1,
        [
            variable("color", Shape::Vector(3), vec![vec![0.5, 0.25]; 3]),
            variable("alpha", Shape::Scalar, vec![vec![1.0, 0.25]]),
        ],
    )
    .unwrap();
    let program = Program::compile("color = 2 * color").unwrap();
    assert!(program.keeps_alpha());
    let run = |options: &RunOptions<'_>| program.run(&image, options).unwrap().image;
    assert_eq!(run(&RunOptions::default()).variable("alpha").unwrap().planes[0][..], [1.0, 0.25]);
    let outputs = Some(vec!["color".to_string()]);
    assert!(
        run(&RunOptions { outputs: outputs.clone(), ..RunOptions::default() }).variable("alpha").is_none()
    );
    let kept = run(&RunOptions { outputs, keep_alpha: true, ..RunOptions::default() });
    assert!(kept.variable("alpha").is_some());
}
