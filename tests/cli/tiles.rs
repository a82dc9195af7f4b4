//! Tiles, and what is joined of them: the same bytes as one run.

use super::{Folder, gbuffer};
use std::fs;

/// It looks at neighbours, so that the edges of tiles matter.
const PROGRAM: &str = "\
color = [point.x filterwidth(point).x pixel.y / resolution.y] * (0.5 + Noise(8 * point))
alpha = surface > 0 ? 1 : 0.5
N = normal
m = rotation(point.x)
long = [1 2 3 4 5] * Du(point.x)
";

impl Folder {
    /// Runs it whole and in tiles, joins them, and compares all files. `late`: what is given to the join and not to the
    /// tiles.
    fn same_in_tiles(&self, tiles: [usize; 2], arguments: &str, late: &str, outputs: &[&str]) {
        let [columns, rows] = tiles;
        let names =
            |stem: &str| -> String { outputs.iter().map(|ending| format!(" -o {stem}{ending}")).collect() };
        self.good(&format!("run {arguments} {late}{}", names("whole")));
        for n in 1..=columns * rows {
            self.good(&format!("run {arguments} --tile {n}/{columns}x{rows} -o t.{{tile}}.exr"));
        }
        self.good(&format!("join t.{{tile}}.exr --tiles {columns}x{rows} {late}{}", names("joined")));
        for ending in outputs {
            let same = self.read(&format!("whole{ending}")) == self.read(&format!("joined{ending}"));
            assert!(same, "{arguments} {late} {ending}");
        }
    }
}

#[test]
fn what_is_joined_has_the_bytes_of_one_run() {
    let f = Folder::new();
    f.write("p.pse", PROGRAM);
    let all = "p.pse --scene donut --size 101x67 --vars color,alpha,N,m,long,point,surface";
    f.same_in_tiles([3, 4], all, "", &[".exr", ".png", ".jpg"]);
    f.same_in_tiles([2, 1], all, "--half --bits 16", &[".exr", ".tif"]);
    f.same_in_tiles([1, 5], "p.pse --size 64x48 --samples 3 --filter mitchell", "", &[".exr", ".png"]);
    // Where one part of the surface hides another, several pixels to each side are compared.
    f.same_in_tiles([3, 7], "p.pse --scene donut --eye 0,-5,1 --size 101x67 --vars color,N,m", "", &[".exr"]);
    // Pictures of a variable that is no colour, and plain numbers.
    f.same_in_tiles([2, 2], "p.pse --size 64x48 --vars N", "", &[".png", ".exr"]);
    f.same_in_tiles([2, 2], "-e n=1-depth/9 --size 64x48 --vars n", "", &[".png", ".hdr"]);
    f.same_in_tiles([2, 2], "-e Noise(9*point)*white --size 64x48", "--raw", &[".png"]);
    // Several bands high.
    f.same_in_tiles([2, 2], "p.pse --scene floor --size 700x900", "", &[".exr"]);
}

#[test]
fn data_windows_and_headers_stay() {
    let f = Folder::new();
    f.write("p.pse", "color = normal + [0.1 0.2 0.3]\nz = point[3]\n");
    for name in ["plain_datawindow_crop", "plain_datawindow_overscan", "plain_nonfinite", "multipart_named"] {
        let path = gbuffer(&format!("donut_320x180_{name}.exr"));
        f.same_in_tiles([3, 2], &format!("p.pse -i {path} --vars color,z"), "", &[".exr", ".png"]);
    }
    f.good("run -e point --size 90x60 -o g.exr --vars color,depth,point --region 10,5,80,50");
    f.same_in_tiles([3, 2], "-e point*Du(depth) -i g.exr --vars color,point,depth", "", &[".exr"]);
}

#[test]
fn cryptomattes_stay() {
    let f = Folder::new();
    let path = gbuffer("donut_320x180_blender50_antialiased.exr");
    let run = format!("-e white -i {path} --vars color,surface,CryptoObject00");
    f.same_in_tiles([2, 2], &run, "--half", &[".exr"]);
}

#[test]
fn what_does_not_go_together_is_said() {
    let f = Folder::new();
    let run = |tile: &str, more: &str| f.good(&format!("run -e point --size 40x30 --tile {tile} {more}"));
    (1..=4).for_each(|n| drop(run(&format!("{n}/2x2"), "-o t.{tile}.exr")));
    fs::remove_file(f.path("t.3.exr")).expect("a file");
    f.bad(
        1,
        "join t.{tile}.exr --tiles 2x2 -o a.exr",
        &["t.3.exr", "there is no such file", "Render the missing tile first."],
    );
    f.bad(1, "join t.1.exr t.2.exr t.4.exr -o a.exr", &["300 of the pixels 0,0,40,30 are in no tile"]);
    f.bad(2, "join t.1.exr t.2.exr --tiles 2x2 -o a.exr", &["2x2 are 4 tiles, and 2 are given"]);
    f.bad(2, "join t.{tile}.exr -o a.exr", &["matches several tiles", "--tiles"]);
    f.bad(1, "join t.1.exr t.2.exr -o part.exr", &["of a picture of 40x30", "--tiles", "--partial"]);
    let part = f.good("join t.1.exr t.2.exr --partial -o part.exr");
    assert!(part.err.contains("the tiles hold 0,0,40,15 of a picture of 40x30"), "{}", part.err);
    run("1/1x2", "-o u.{tile}.exr");
    f.bad(1, "join t.1.exr u.1.exr -o a.exr", &["both hold the pixels 0,0,20,15"]);
    run("2/1x2", "-o n.{tile}.exr --vars normal");
    f.bad(1, "join u.1.exr n.2.exr -o a.exr", &["different pictures", "different variables"]);
    f.good("run -e point --size 40x40 --tile 2/1x2 -o s.{tile}.exr");
    f.bad(1, "join u.1.exr s.2.exr -o a.exr", &["different pictures", "display windows"]);
    f.good("run -e point --size 40x30 -o w.png");
    f.bad(1, "join w.png -o a.exr", &["is not a tile", ".exr"]);
    f.bad(1, "join part.exr --partial -o part.exr", &["the output `part.exr` is the input", "--force"]);
    f.bad(1, "run -e point --size 3x3 --tile 1/4x1 -o v.{tile}.exr", &["3x3 pixels cannot be cut into 4x1"]);
    f.bad(2, "run -e point --tile 5/2x2 -o v.{tile}.exr", &["no tile `5` of 2x2"]);
    f.bad(2, "run -e point --tile 1/2x2 -o v.exr", &["would all be written", "{tile}"]);
    f.bad(2, "join t.1.exr -o a.####.png", &["--frames"]);
    f.bad(2, "join t.1.exr --frames 1-2 -o a.png", &["would all be written"]);
    f.bad(1, "join t.1.exr -o a.gif", &["unknown format"]);
    assert!(!f.path("a.exr").exists());
    // Without names the tiles are called by the program, each with its number.
    f.write("p.pse", "color = point\n");
    f.good("run p.pse --size 40x30 --tile 2/2x2");
    assert!(f.path("p.2.exr").exists());
}
