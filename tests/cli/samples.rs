//! `pse run --samples`: several samples of each pixel.

use super::{Folder, load};

#[test]
fn bands_regions_and_threads_change_nothing() {
    let f = Folder::new();
    f.write("p.pse", "color = white * (mod(4 * point.x + 3 * point.y, 1) < 0.5)\n");
    f.write(
        "d.pse",
        "color = white * pulsetrain(4 * point.x, width = filterwidth(4 * point.x)) + pixelsize\n",
    );
    f.good("scene donut -o g.exr --size 900x400 -q");
    for input in ["-i g.exr", "--scene donut --size 900x400"] {
        for program in ["p.pse", "d.pse"] {
            let run = format!("run {program} {input} --samples 3 --seed 4");
            f.good(&format!("{run} -o bands.exr"));
            f.good(&format!("{run} -o whole.exr --repeat 1 --batch 100 --threads 1"));
            assert!(f.read("bands.exr") == f.read("whole.exr"), "{run}");
            f.good(&format!("{run} -o part.exr --region 200,310,420,340"));
            let (whole, part) = (f.planes("whole.exr", "color"), f.planes("part.exr", "color"));
            for row in 0..30 {
                let of = &whole[0][(310 + row) * 900 + 200..][..220];
                assert!(of == &part[0][row * 220..][..220], "{run}: row {row} of the region");
            }
        }
    }
    f.good("run p.pse -i g.exr --samples 1 -o one.exr");
    f.good("run p.pse -i g.exr -o none.exr");
    assert!(f.read("one.exr") == f.read("none.exr"));
}

#[test]
fn edges_of_a_scene_are_antialiased() {
    let f = Folder::new();
    let run = "run -e color=white*(surface==1) --scene sphere --size 60x60";
    f.good(&format!("{run} -o sharp.exr"));
    f.good(&format!("{run} -o smooth.exr --samples 16"));
    let between = |name: &str| {
        let planes = f.planes(name, "color");
        planes[0].iter().filter(|&&x| x > 0.0 && x < 1.0).count()
    };
    assert_eq!(between("sharp.exr"), 0);
    assert!(between("smooth.exr") > 100, "{}", between("smooth.exr"));
    // The area of the disk, pi r², of a picture 2.3 across at the centre; the eye is 6 away.
    let area: f32 = f.planes("smooth.exr", "color")[0].iter().sum();
    let sine = 1.0f32 / 6.0;
    let radius = 6.0 * sine / (1.0 - sine * sine).sqrt() / 2.3 * 60.0;
    assert!((area / (std::f32::consts::PI * radius * radius) - 1.0).abs() < 2e-3, "{area}");
}

#[test]
fn statistics_count_pixels_and_not_samples() {
    let f = Folder::new();
    let ended = f.good("run -e 0/0 --size 8x8 --samples 5 --stats -o a.exr");
    assert!(ended.err.contains("64 pixels hold NaN"), "{}", ended.err);
    assert!(ended.err.contains("samples              5"), "{}", ended.err);
    assert_eq!(load(&f.path("a.exr")).width, 8);
    let again = f.good("run -e white*pixel.x --size 8x8 --samples 5 --filter mitchell --profile -o b.exr");
    assert!(again.err.contains("100 %"), "{}", again.err);
}

#[test]
fn what_cannot_be_is_said() {
    let f = Folder::new();
    f.bad(2, "run -e white --samples -3", &["-3", "whole number from 1 to 65536"]);
    f.bad(2, "run -e white --samples 0", &["--samples", "whole number from 1"]);
    f.bad(2, "run -e white --samples 4 --filter gauss", &["catmull-rom", "mitchell"]);
    f.bad(2, "run -e white --filter box", &["--samples"]);
    f.bad(2, "run -e white --seed 3", &["--samples"]);
}
