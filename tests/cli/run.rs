//! `pse run`: values, options, and what goes wrong.

use super::{Folder, gbuffer, load};

const SMALL: &str = "--size 64x48";

#[test]
fn expressions_and_the_default_scene() {
    let f = Folder::new();
    let ended = f.good("run -e white*(point.x>0) --size 64x48");
    assert!(ended.err.contains("no input: using the scene donut"), "{}", ended.err);
    assert!(ended.err.contains("wrote out.png (64x48)"), "{}", ended.err);
    assert!(ended.out.is_empty());
    let image = load(&f.path("out.png"));
    assert_eq!((image.width, image.height), (64, 48));
    // Several lines are one program.
    f.good(&format!("run -e x=2 -e color=[x/4,x/2,1] -o a.exr -q {SMALL}"));
    let color = f.planes("a.exr", "color");
    assert_eq!([color[0][0], color[1][0], color[2][0]], [0.5, 1.0, 1.0]);
}

#[test]
fn programs_from_files_and_from_standard_input() {
    let f = Folder::new();
    f.write("two.pse", "color = [2 2 2]\n");
    assert!(f.good(&format!("run two.pse {SMALL}")).err.contains("wrote two.png"));
    let ended =
        f.pse_with(&["run", "-", "-o", "b.exr", "--scene", "vase", "--size", "8x8"], b"color = [3 3 3]");
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert_eq!(f.planes("b.exr", "color")[0][0], 3.0);
    let ended = f.pse_with(&["run", "-"], b"color = (1");
    assert!(ended.err.contains("<standard input>:1"), "{}", ended.err);
}

#[test]
fn quiet_says_nothing() {
    let f = Folder::new();
    assert_eq!(f.good(&format!("run -e white -q {SMALL}")).err, "");
    assert_eq!(f.good("scene card -q --size 8x8").err, "");
}

#[test]
fn several_outputs_of_one_run() {
    let f = Folder::new();
    let formats = ["exr", "png", "jpg", "tif", "hdr", "bmp", "tga", "webp"];
    let outputs: Vec<String> = formats.iter().map(|e| format!("-o a.{e}")).collect();
    let ended = f.good(&format!("run -e [1,0.5,0] {} {SMALL}", outputs.join(" ")));
    for format in formats {
        assert!(ended.err.contains(&format!("wrote a.{format} ")));
        assert_eq!(load(&f.path(&format!("a.{format}"))).width, 64);
    }
    f.bad(2, "run -e white -o a.png -o a.png", &["two outputs are called a.png"]);
}

#[test]
fn params_are_set_by_expressions() {
    let f = Folder::new();
    f.write("p.pse", "param tint = [1 1 1]\nparam k = 1 in [0 10]\ncolor = tint * k\n");
    let set = ["run", "p.pse", "-o", "p.exr", "--size", "8x8", "--set", "tint=[1 0 0] + 1", "--set", "k=2*2"];
    let ended = f.pse_with(&set, b"");
    assert_eq!(ended.code, 0, "{}", ended.err);
    let color = f.planes("p.exr", "color");
    assert_eq!([color[0][0], color[1][0]], [8.0, 4.0]);
    f.bad(1, "run p.pse --set tnt=1", &["the program has no param `tnt`", "Did you mean `tint`?"]);
    f.bad(2, "run p.pse --set k", &["--set k has no =", "--set veins=6"]);
    f.bad(2, "run p.pse --set k=", &["is not a value"]);
    f.bad(2, "run p.pse --set k=y=3", &["is not a value"]);
    f.bad(1, "run p.pse --set k=(1", &["--set k:1:1", "never closed"]);
    f.bad(2, "run p.pse --set k=point", &["--set cannot read pixels", "`point`"]);
}

#[test]
fn variables_are_chosen() {
    let f = Folder::new();
    f.write("v.pse", "near = point.z\nway = normal\npair = [1 2]\n");
    f.good(&format!("run v.pse -o all.exr {SMALL}"));
    let names: Vec<String> = load(&f.path("all.exr")).variables.iter().map(|v| v.name.clone()).collect();
    assert!(["near", "way", "pair"].iter().all(|n| names.iter().any(|m| m == n)), "{names:?}");
    f.good(&format!("run v.pse -o one.exr --vars way,depth {SMALL}"));
    assert_eq!(f.planes("one.exr", "way").len(), 3);
    assert_eq!(f.planes("one.exr", "depth").len(), 1);
    // A picture shows one variable that is named, and else says what there is.
    f.good(&format!("run v.pse -o grey.png --vars near {SMALL}"));
    f.good(&format!("run v.pse -o way.png --vars way {SMALL}"));
    f.bad(1, "run v.pse -o a.png", &["assigns no color", "It assigns near, way, pair.", "--vars pair"]);
    f.bad(1, "run v.pse -o a.png --vars near,way", &["near and way", "Write an .exr file"]);
    f.bad(1, "run v.pse -o a.png --vars pair --size 8x8", &["pair is", "a picture cannot show"]);
    f.bad(1, "run v.pse -o a.exr --vars nar --size 8x8", &["no variable `nar`", "Did you mean `near`?"]);
}

#[test]
fn a_normal_alone_is_shown() {
    let f = Folder::new();
    let ended = f.good("run -e normal=normal+[0,0,1] --size 16x12 -o n.png");
    assert!(ended.err.contains("assigns no color"), "{}", ended.err);
    assert!(ended.err.contains("shaded with the program's normal"), "{}", ended.err);
}

#[test]
fn pixels_that_are_no_numbers_are_counted() {
    let f = Folder::new();
    let ended = f.good("run -e white/0 --size 8x4 -o a.exr");
    assert!(ended.err.contains("32 pixels hold NaN or infinity"), "{}", ended.err);
    let ended = f.good("run -e white/(pixel.x>1||pixel.y>1) --size 8x4 -o a.exr");
    assert!(ended.err.contains("1 pixel holds NaN or infinity"), "{}", ended.err);
}

#[test]
fn the_same_bytes_however_it_runs() {
    let f = Folder::new();
    f.write(
        "n.pse",
        "c = 0\nfor i in [1 .. 4]\n    if point.x > 0\n        c += sin(i * point.x) * Noise(i * point)\n\
         color = [c pixelsize sqrt(c)]\n",
    );
    f.good("run n.pse -o a.exr --threads 1 --size 150x120");
    let whole = f.read("a.exr");
    for options in ["--threads 2", "--batch 1", "--batch 7 --threads 3", "--batch 65536"] {
        f.good(&format!("run n.pse -o b.exr --size 150x120 {options}"));
        assert!(f.read("b.exr") == whole, "{options}");
    }
    let arguments = ["run", "n.pse", "-o", "b.exr", "--size", "150x120"];
    let run = |simd: &str| super::ended(f.command().args(arguments).env("PSE_SIMD", simd));
    for simd in ["baseline", "avx2", "avx512"] {
        let ended = run(simd);
        if simd != "baseline" && ended.err.contains("this machine has no") {
            continue;
        }
        assert_eq!(ended.code, 0, "PSE_SIMD={simd}: {}", ended.err);
        assert!(f.read("b.exr") == whole, "PSE_SIMD={simd}");
    }
    let ended = run("sse9");
    assert_eq!(ended.code, 2);
    assert!(ended.err.contains("there are auto, baseline, avx2 and avx512"), "{}", ended.err);
}

#[test]
fn a_region_is_a_cut_of_the_whole() {
    let f = Folder::new();
    f.write("r.pse", "color = [point.x pixelsize Du(normal.x) + Dv(uv.x)]\nat = pixel\n");
    f.good("run r.pse -o whole.exr --size 60x40 --vars color,at");
    let ended = f.good("run r.pse -o part.exr --size 60x40 --vars color,at --region 20,10,50,35");
    assert!(ended.err.contains("(30x25 at 20,10,50,35)"), "{}", ended.err);
    f.good("run r.pse -o same.exr --size 60x40 --vars color,at --region 30x25+20+10");
    assert_eq!(f.read("part.exr"), f.read("same.exr"));
    let part = load(&f.path("part.exr"));
    assert_eq!((part.width, part.height, part.metadata.origin), (30, 25, [20, 10]));
    assert_eq!(part.resolution(), [60, 40]);
    for variable in ["color", "at"] {
        let (whole, part) = (f.planes("whole.exr", variable), f.planes("part.exr", variable));
        for (whole, part) in whole.iter().zip(&part) {
            for (row, line) in part.chunks(30).enumerate() {
                let start = (row + 10) * 60 + 20;
                assert_eq!(line, &whole[start..start + 30], "{variable}, row {row}");
            }
        }
    }
    f.bad(2, "run r.pse --region 1,2", &["is not a region", "320x240+0+0"]);
    f.bad(2, "run r.pse --region 9,9,3,3", &["no pixels"]);
    f.bad(1, "run r.pse --region 700,9,800,30 -o a.exr", &["outside the image", "0,0,640,480"]);
}

#[test]
fn frames_in_step_with_names() {
    let f = Folder::new();
    f.write("t.pse", "color = white * frame + (first.color)[1]\n");
    for i in 1..4 {
        f.good(&format!("run -e white*{i}/2 -o in.{i:04}.exr --size 8x8"));
    }
    f.good("run t.pse -i first=in.####.exr -o out_%02d.exr --frames 1-3");
    for i in 1..4 {
        assert_eq!(f.planes(&format!("out_{i:02}.exr"), "color")[0][0], i as f32 * 1.5);
    }
    f.good("run -e white*frame --frames 3,9 -o o@@.exr --size 8x8");
    assert_eq!(f.planes("o09.exr", "color")[0][0], 9.0);
    f.good("run -e white*frame --frame 7 -o s.##.exr --size 8x8");
    assert_eq!(f.planes("s.07.exr", "color")[0][0], 7.0);
    f.good("run -e white*frame --frames 2-6x4 --size 8x8");
    assert!(f.path("out.0006.png").exists());
    f.bad(2, "run -e white --frames 1-3 -o a.png", &["3 frames", "a.png", "-o out.####.png"]);
    f.bad(2, "run -e white -o o.##.png", &["o.##.png needs a frame number", "--frame 1"]);
    f.bad(2, "run -e white --frame 7.5 -o s.##.exr", &["s.##.exr", "7.5"]);
    f.bad(2, "run -e white --frames 1..3", &["1-20x2"]);
    f.bad(2, "run -e white --frames 1-3 --frame 2", &["cannot be used with"]);
}

#[test]
fn limits_are_options() {
    let f = Folder::new();
    f.write("loop.pse", "i = 0\nwhile i < 5000\n    i += 1\ncolor = white * i\n");
    f.good("run loop.pse --size 4x4");
    f.bad(1, "run loop.pse --size 4x4 --max-steps 1000", &["loop.pse:2", "1000"]);
    f.write("deep.pse", "function f(n)\n    return n < 1 ? 0 : 1 + f(n - 1)\ncolor = white * f(100)\n");
    f.good("run deep.pse --size 4x4");
    f.bad(1, "run deep.pse --size 4x4 --max-depth 50", &["50"]);
    f.bad(1, "run -e color=white*[1..99][9] --size 4x4 --max-vector 50", &["50"]);
    f.good("run -e white --size 4x4 --max-memory 64");
    f.bad(2, "run -e white --max-steps many", &["--max-steps"]);
}

#[test]
fn speed_is_told() {
    let f = Folder::new();
    let ended = f.good("run -e white*point.x --size 64x48 --stats --batch 64 --threads 1");
    for word in ["read", "run", "write", "ns", "threads", "batch                64", "instruction set"] {
        assert!(ended.err.contains(word), "{word}: {}", ended.err);
    }
    let f = Folder::new();
    let ended = f.good("run -e white --size 64x48 --repeat 3");
    assert!(ended.err.contains("ns/pixel, the median of 3 runs"), "{}", ended.err);
    assert!(!f.path("out.png").exists(), "a run in memory writes nothing that was not asked for");
    f.bad(2, "run -e white --repeat 0", &["1 to 65536"]);
    f.bad(2, "run -e white --threads 0", &["1 to 65536"]);
}

#[test]
fn the_view_of_a_scene() {
    let f = Folder::new();
    f.good("run -e [depth,0,0] --scene card --size 9x9 --eye 0,-5,0 --look-at 0,0,0 --fov 30 -o d.exr");
    let depth = f.planes("d.exr", "color")[0][40];
    assert!((depth - 5.0).abs() < 1e-5, "{depth}");
    f.good("run -e white --scene sphere --size 9x9 --scale 2 -o s.exr");
    f.bad(2, "run -e white --size 640", &["640x480"]);
    f.bad(2, "run -e white --eye 1,2", &["three numbers"]);
    f.bad(1, "run -e white --scene dount", &["no scene `dount`", "did you mean `donut`?"]);
    f.bad(1, "run -e white --fov 190", &["190"]);
    f.good("scene card -o c.exr --size 8x8 -q");
    f.bad(2, "run -e white --size 8x8 -i c.exr", &["need a --scene"]);
    f.bad(2, "run -e white --look-at 0,0,0 -i c.exr", &["--look-at needs --eye"]);
    f.bad(2, "run -e white --eye 0,-5,0 --fov 30 -i c.exr", &["--fov needs --look-at"]);
    f.bad(2, "run -e white --scene donut -i c.exr", &["cannot be combined"]);
}

#[test]
fn pixelsize_is_given() {
    let f = Folder::new();
    f.good("run -e [pixelsize,pixel_freq,0] --pixelsize 0.25 --size 4x4 -o p.exr");
    let color = f.planes("p.exr", "color");
    assert_eq!([color[0][0], color[1][0]], [0.25, 2.0]);
}

#[test]
fn imports_are_found_on_the_path() {
    let f = Folder::new();
    std::fs::create_dir(f.path("lib")).expect("a folder");
    f.write("lib/half.pse", "function halved(x)\n    return x / 2\n");
    f.write("main.pse", "import \"half.pse\"\ncolor = white * halved(3)\n");
    f.good("run main.pse --path lib -o a.exr --size 4x4");
    assert_eq!(f.planes("a.exr", "color")[0][0], 1.5);
    f.bad(1, "run main.pse", &["main.pse:1", "half.pse"]);
    f.good("check main.pse --path lib");
}

#[test]
fn wrong_programs() {
    let f = Folder::new();
    f.write("empty.pse", "");
    f.write("two.pse", "color = wite\nx = (1 +\n");
    f.bad(1, "run empty.pse", &["has no output", "Assign to `color`"]);
    f.bad(1, "run two.pse", &["two.pse:2"]);
    f.bad(1, "run -e color=wite", &["<command line>:1:7", "Did you mean `white`?"]);
    f.bad(1, "run none.pse", &["cannot read `none.pse`: there is no such file"]);
    f.bad(1, "run .", &["it is a directory"]);
    f.bad(2, "run", &["PROGRAM"]);
    f.bad(2, "run a.pse -e white", &["cannot be used with"]);
    f.bad(1, "run -e white*nope.x --size 8x8", &["no variable `nope`", "donut"]);
    f.bad(1, "run -e white*albedo --size 8x8", &["no variable `albedo`", "The scene donut has surface"]);
    f.bad(1, "run -e white*bg.color --size 8x8", &["bg.color", "-i bg=FILE"]);
    // At run time the pixel is named.
    f.bad(1, "run -e color=[1,2,3][pixel.x] --size 8x8", &["at pixel [3 0]"]);
    std::fs::write(f.path("bin.pse"), [0u8, 159, 146, 150]).expect("a file");
    f.bad(1, "run bin.pse", &["not UTF-8 text", "with -i"]);
}

#[test]
fn derived_buffers_keep_their_windows() {
    let f = Folder::new();
    for name in ["donut_320x180_plain_datawindow_crop.exr", "donut_320x180_plain_datawindow_overscan.exr"] {
        let path = gbuffer(name);
        f.good(&format!("run -e [pixel.x,pixel.y,1] -i {path} -o w.exr"));
        let (from, to) = (load(std::path::Path::new(&path)), load(&f.path("w.exr")));
        assert_eq!((from.width, from.height), (to.width, to.height));
        assert_eq!(from.metadata.origin, to.metadata.origin);
        assert_eq!(from.resolution(), to.resolution());
        let color = f.planes("w.exr", "color");
        let [x, y] = from.metadata.origin;
        assert_eq!([color[0][0], color[1][0]], [x as f32 + 0.5, y as f32 + 0.5]);
    }
}
