//! Images that are read, run and written in bands of rows: the same as in one piece.

use super::{Folder, load};

/// Several bands high.
const SIZE: &str = "--size 900x800";

#[test]
fn bands_equal_the_whole() {
    let f = Folder::new();
    f.write("p.pse", "color = [point.x pixelsize pixel.y] + filterwidth(point)\ndepth = Dv(depth)\n");
    f.good(&format!("scene donut -o g.exr {SIZE}"));
    f.good("run p.pse -i g.exr -o bands.exr --vars color,depth,normal");
    // What is repeated runs in one piece.
    f.good("run p.pse -i g.exr -o whole.exr --vars color,depth,normal --repeat 1");
    assert!(f.read("bands.exr") == f.read("whole.exr"), "of a file");
    f.good(&format!("run p.pse --scene donut {SIZE} -o scene.exr --vars color,depth,normal"));
    assert!(f.read("bands.exr") == f.read("scene.exr"), "of a scene");
    f.good("run p.pse -i g.exr -i b=g.exr -o kept.##.exr --vars color,depth,normal --frames 1-2");
    assert!(f.read("bands.exr") == f.read("kept.02.exr"), "kept in memory");
    f.good("run p.pse -i g.exr -o bands.png -o also.exr");
    f.good("run p.pse -i g.exr -o whole.png --repeat 1");
    assert!(f.read("bands.png") == f.read("whole.png"), "a picture");
    f.good("run p.pse -i g.exr --region 100,20,800,790 -o part.exr");
    f.good("run p.pse -i g.exr --region 100,20,800,790 -o same.exr --repeat 1");
    assert!(f.read("part.exr") == f.read("same.exr"), "a region");
    let piped = f.pse_with(&["run", "p.pse", "-i", "-", "-o", "-"], &f.read("g.exr"));
    assert!(piped.code == 0 && piped.out == f.read("also.exr"), "pipes");
}

/// Where one part of a surface hides another, a pixel is compared with several neighbours to each side.
#[test]
fn bands_and_regions_agree_at_silhouettes() {
    let f = Folder::new();
    f.write("p.pse", "color = [pixelsize Du(uv.x) turbulence(4 * point)] + filterwidth(point)\n");
    let view = "--scene donut --eye 0,-5,1 --size 900x800";
    f.good(&format!("run p.pse {view} -o bands.exr"));
    f.good(&format!("run p.pse {view} -o whole.exr --repeat 1"));
    assert!(f.read("bands.exr") == f.read("whole.exr"));
    let whole = f.planes("whole.exr", "color");
    for top in [190, 203, 217, 288] {
        f.good(&format!("run p.pse {view} --region 150,{top},751,{} -o part.exr", top + 2));
        for (part, whole) in f.planes("part.exr", "color").iter().zip(&whole) {
            for row in 0..2 {
                let of = &whole[(top + row) * 900 + 150..][..601];
                assert!(of == &part[row * 601..][..601], "row {row} of the region at {top}");
            }
        }
    }
}

#[test]
fn an_output_that_becomes_wider_on_the_way() {
    let f = Folder::new();
    // The samples of the first band do not show it; the last row has it.
    f.write("w.pse", "if pixel.y > resolution.y - 1\n    v = [1 2]\nelse\n    v = 7\n");
    f.good(&format!("run w.pse {SIZE} -o v.exr"));
    let planes = f.planes("v.exr", "v");
    assert_eq!(planes.len(), 2);
    assert_eq!((planes[1][0], planes[1][900 * 800 - 1]), (7.0, 2.0));
    f.write("n.pse", "if pixel.y > 700\n    v = [1 2]\nelse\n    v = [1 2 3]\n");
    f.bad(1, &format!("run n.pse {SIZE} -o n.exr"), &["at pixel [0 0]", "at pixel [0 700]"]);
    assert!(!f.path("n.exr").exists());
}

#[test]
fn the_first_error_in_reading_order_is_told() {
    let f = Folder::new();
    f.good(&format!("scene donut -o g.exr {SIZE}"));
    f.write("e.pse", "v = [1 2]\ncolor = white * v[pixel.y > 650.6 ? 3 : 1]\n");
    f.bad(1, "run e.pse -i g.exr -o e.exr", &["[0 651]"]);
    // The file ends in the middle: what is before is read, and the error at its place told.
    let bytes = f.read("g.exr");
    std::fs::write(f.path("cut.exr"), &bytes[..bytes.len() / 2]).expect("a file");
    f.write("ok.pse", "color = point\n");
    f.bad(1, "run ok.pse -i cut.exr -o e.exr", &["cut.exr"]);
    assert_eq!(load(&f.path("g.exr")).width, 900);
    let files: Vec<_> = std::fs::read_dir(f.path("")).expect("a folder").collect();
    assert_eq!(files.len(), 4, "nothing is left behind: {files:?}");
}

/// An interrupted run leaves nothing behind: no output, and no temporary file.
#[cfg(unix)]
#[test]
fn an_interrupt_cleans_up() {
    let f = Folder::new();
    let slow = "i = 0\nwhile i < 900\n    i += 1 + 0 * Noise(i * point)\ncolor = white * i\n";
    f.write("slow.pse", slow);
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_pse"))
        .current_dir(f.path(""))
        .args(["run", "slow.pse", "--size", "2000x2000", "-o", "out.exr"])
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the command");
    // Until the first band is written: only then is there something to clean up.
    let begun = std::time::Instant::now();
    let files = || std::fs::read_dir(f.path("")).expect("a folder").count();
    while files() < 2 && begun.elapsed().as_secs() < 120 {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    assert_eq!(files(), 2, "the output has begun");
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.expect("kill").success());
    let ended = child.wait().expect("an end");
    assert_eq!(ended.code(), Some(130));
    assert_eq!(files(), 1, "nothing is left behind");
}
