//! `pse flow`: seeds, pictures, G-buffers, points, frames, and what is wrong with arguments.

use super::{Folder, load};

const SWIRL: &str = "param speed = 1\nfunction velocity(p)\n    return speed * [-p.y p.x 0.2]\n";

fn folder() -> Folder {
    let f = Folder::new();
    f.write("swirl.pse", SWIRL);
    f
}

#[test]
fn a_picture_and_a_g_buffer() {
    let f = folder();
    let ended = f.good("flow swirl.pse --ball 40 --size 64x48");
    assert!(ended.err.contains("wrote swirl.png (40 lines)"), "{}", ended.err);
    let image = load(&f.path("swirl.png"));
    assert_eq!((image.width, image.height), (64, 48));
    let color = &image.variable("color").expect("a colour").planes[0];
    assert!(color.contains(&0.0) && color.iter().any(|&c| c > 0.3), "lines on black");

    f.good("flow swirl.pse --ball 40 --size 64x48 -o lines.exr -q");
    let image = load(&f.path("lines.exr"));
    let plane = |name: &str, i: usize| image.variable(name).expect(name).planes[i].to_vec();
    let (surface, alpha, depth, age) =
        (plane("surface", 0), plane("alpha", 0), plane("depth", 0), plane("age", 0));
    for i in 0..64 * 48 {
        assert_eq!(surface[i] == 1.0, alpha[i] > 0.0);
        assert_eq!(surface[i] == 0.0, depth[i] == 1e10);
        assert!((0.0..=1.0).contains(&age[i]));
    }
    // What is drawn is where its point is seen.
    f.write(
        "where.pse",
        "s = transform(\"screen\", point)\nwhere = surface ? length([s.x * 64 48 - s.y * 48] - pixel) : 0\n",
    );
    f.good("run where.pse -i lines.exr -o where.exr -q");
    let off = load(&f.path("where.exr"));
    let off = off.variable("where").expect("where").planes[0].iter().fold(0f32, |a, b| a.max(*b));
    assert!(off < 1.1, "{off} pixels off");
}

#[test]
fn lines_grow_from_what_a_scene_shows_and_stay_behind_it() {
    let f = Folder::new();
    // Inwards: all of each line but its root is hidden.
    f.write("in.pse", "function velocity(p)\n    return -direction(p)\n");
    f.write("out.pse", "function velocity(p)\n    return direction(p)\n");
    let lit = |program: &str| {
        f.good(&format!("flow {program} --scene sphere --every 4 --size 48x48 --step 0.01 -o o.exr -q"));
        load(&f.path("o.exr")).variable("alpha").expect("alpha").planes[0].iter().sum::<f32>()
    };
    let (inwards, outwards) = (lit("in.pse"), lit("out.pse"));
    assert!(inwards > 0.0 && outwards > 3.0 * inwards, "{inwards} {outwards}");
    // A file without depth has its points.
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/gbuffers/donut_320x180_plain_tiled64.exr");
    let lit = |program: &str| {
        f.good(&format!("flow {program} -i {file} --every 4 --step 0.01 -o o.exr -q"));
        load(&f.path("o.exr")).variable("alpha").expect("alpha").planes[0].iter().sum::<f32>()
    };
    f.write("away.pse", "function velocity(p)\n    return [0 0 -0.5]\n");
    f.write("up.pse", "function velocity(p)\n    return [0 0 0.5]\n");
    let (under, over) = (lit("away.pse"), lit("up.pse"));
    assert!(over > 1.3 * under, "{over} {under}");
    // The same from a file, whose header knows the camera.
    f.good("scene sphere --size 48x48 -o g.exr");
    f.good("flow out.pse -i g.exr --every 4 --step 0.01 -o p.exr -q");
    f.good("flow out.pse --scene sphere --size 48x48 --every 4 --step 0.01 -o o.exr -q");
    let plane = |name: &str| load(&f.path(name)).variable("alpha").expect("alpha").planes[0].to_vec();
    assert_eq!(plane("o.exr"), plane("p.exr"));
}

#[test]
fn points_frames_and_params() {
    let f = folder();
    f.good("flow swirl.pse --grid 2x3x1 --box 0,0,0,1,1,1 --steps 4 --set speed=2 -o a.ply");
    let text = String::from_utf8_lossy(&f.read("a.ply")).into_owned();
    assert!(text.contains("element vertex 30\n") && text.contains("element edge 24\n"), "{text:.300}");
    f.good("flow swirl.pse --ball 5 --frames 2-3 -o a.##.ply -q");
    assert_eq!(f.read("a.02.ply"), f.read("a.03.ply"));
    f.write("moving.pse", "function velocity(p)\n    return [frame 0 0]\n");
    f.good("flow moving.pse --ball 5 --frames 2-3 -o b.##.ply -q");
    assert!(f.read("b.02.ply") != f.read("b.03.ply"));
    let told = f.good("flow swirl.pse --ball 5 --stats -q").err;
    assert!(told.contains("5 lines of 50 steps: 255 points") && told.contains("divergence"), "{told}");
}

#[test]
fn what_is_wrong_is_told() {
    let f = folder();
    f.write("still.pse", "color = white\n");
    f.bad(1, "flow still.pse", &["no function `velocity(point)`", "Write one"]);
    f.write("flat.pse", "function velocity(p)\n    return 3\n");
    f.bad(1, "flow flat.pse", &["gives a scalar", "[x y z]", "flat.pse:1:1"]);
    f.write("hole.pse", "function velocity(p)\n    return p / (p.x > 2 ? 0 : 1)\n");
    f.bad(1, "flow hole.pse --step 0.5", &["velocity([2.", "is ["]);
    f.bad(1, "run swirl.pse", &["has no output", "`pse flow`"]);
    f.bad(2, "flow swirl.pse --step 0", &["is not possible"]);
    f.bad(2, "flow swirl.pse --grid 3x3", &["20x20x20"]);
    f.bad(2, "flow swirl.pse --grid 99999x99999x99999", &["too many points"]);
    f.bad(2, "flow swirl.pse --ball 99999999999", &["too many points"]);
    f.bad(2, "flow swirl.pse --ball 0", &["no seeds"]);
    f.bad(2, "flow swirl.pse --width nan", &["a width of NaN"]);
    f.bad(2, "flow swirl.pse --radius 1e30", &["a radius"]);
    f.bad(2, "flow swirl.pse --size 1000000x1000000", &["1000000x1000000", "in memory"]);
    f.bad(2, "flow swirl.pse -o - -o -", &["standard output"]);
    f.bad(2, "flow swirl.pse --frames 1-3 -o a.png", &["a.png", "####"]);
    f.bad(1, "flow swirl.pse -o a.obj", &[".obj"]);
    assert!(!f.path("still.png").exists() && !f.path("hole.png").exists());
}

#[test]
fn no_input_is_harmed() {
    let f = folder();
    f.good("scene sphere --size 32x32 -o g.exr -q");
    let before = f.read("g.exr");
    f.bad(1, "flow swirl.pse -i g.exr -o g.exr", &["the output `g.exr` is the input `g.exr`"]);
    f.bad(1, "flow swirl.pse -i g.exr -o ./g.exr", &["is the input"]);
    assert_eq!(f.read("g.exr"), before);
}

#[test]
fn a_camera_that_no_header_tells_is_found_from_the_points() {
    let f = Folder::new();
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/gbuffers");
    let file = std::path::Path::new(folder).join("donut_320x180_plain_tiled64.exr");
    f.write("up.pse", "function velocity(p)\n    return [0 0 0.001]\n");
    f.good(&format!("flow up.pse -i {} --every 3 --steps 1 -o o.exr -q", file.display()));
    // Lines of next to no length lie where their seeds were seen; the image is a part of its picture.
    let (lines, seen) = (load(&f.path("o.exr")), load(&file));
    assert_eq!([lines.width, lines.height], seen.resolution());
    let [left, top] = seen.metadata.origin;
    let point = |image: &pse::Image<'_>, at: usize| -> Vec<f32> {
        image.variable("point").expect("points").planes.iter().map(|p| p[at]).collect()
    };
    let mut found = 0;
    for row in (1..seen.height).step_by(3) {
        for column in (1..seen.width).step_by(3) {
            let (x, y) = (column as i32 + left, row as i32 + top);
            let at = y as usize * lines.width + x as usize;
            if lines.variable("surface").expect("surface").planes[0][at] == 1.0 {
                let (a, b) = (point(&lines, at), point(&seen, row * seen.width + column));
                let apart: f32 = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).sum();
                assert!(apart < 0.01, "{apart} at {x} {y}");
                found += 1;
            }
        }
    }
    assert!(found > 50, "{found}");
}

#[test]
fn images_are_looked_up_with_a_width() {
    let f = folder();
    f.good("run -e white*pixel.x/40 --size 40x30 -o t.png -q");
    f.write("w.pse", "function velocity(p)\n    return [texture(\"t.png\", p.x, p.y, width = 0.1).r 0 1]\n");
    f.good("flow w.pse --ball 9 -q");
    f.write("n.pse", "function velocity(p)\n    return [texture(\"t.png\", p.x, p.y).r 0 1]\n");
    f.bad(1, "flow n.pse --ball 9 -q", &["neighbouring pixels", "width"]);
    // Where it goes wrong is a point, not a pixel.
    f.write("i.pse", "function velocity(p)\n    v = [1 2 3]\n    return v * v[p.x > 0.5 ? 7 : 0]\n");
    let said = f.pse("flow i.pse --ball 50").err;
    assert!(said.contains("This happens at the point [0.") && !said.contains("pixel"), "{said}");
}
