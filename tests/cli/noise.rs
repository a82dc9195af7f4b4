//! `pse noise`: lists, sheets, and what is wrong with arguments.

use super::Folder;
use pse::noise::KINDS;

/// The rows of a picture, as the bits of its colours.
fn rows(f: &Folder, name: &str) -> (usize, Vec<Vec<u32>>) {
    let image = super::load(&f.path(name));
    let color = image.variable("color").expect("a picture").planes.to_vec();
    let row = |y: usize| {
        let of = |plane: &[f32]| {
            plane[y * image.width..(y + 1) * image.width].iter().map(|x| x.to_bits()).collect()
        };
        color.iter().map(|plane| of(plane)).collect::<Vec<Vec<u32>>>().concat()
    };
    (image.width, (0..image.height).map(row).collect())
}

#[test]
fn the_kinds_are_listed() {
    let f = Folder::new();
    let (list, all) = (f.good("noise").text, f.good("noise --list").text);
    for kind in KINDS {
        assert!(list.lines().any(|l| l.starts_with(kind.name) && l.contains(kind.brief)), "{list}");
        let one = f.good(&format!("noise --list {}", kind.name)).text;
        assert!(one.starts_with(kind.name) && one.contains(kind.contract.source), "{one}");
        assert!(all.contains(&one), "{all}");
    }
    f.bad(2, "noise --list gradiant", &["no kind of noise called `gradiant`", "Did you mean gradient?"]);
    f.bad(2, "noise --list -o a.png", &["--list"]);
}

#[test]
fn a_sheet_has_a_row_for_each_noise() {
    let f = Folder::new();
    let text = "noise gradient perlin1985 gradient,seed=7 turbulence:gradient gradient --size 64 -o a.png";
    let ended = f.good(text);
    assert!(ended.err.contains("wrote a.png (5 noises)"), "{}", ended.err);
    let (width, lines) = rows(&f, "a.png");
    // A head, and rows of the same height.
    let height = (lines.len() - 40) / 5;
    let row = |i: usize| &lines[40 + i * height..40 + (i + 1) * height];
    assert!(height > 64 && lines.len() == 40 + 5 * height, "{}", lines.len());
    assert!(width > 64 * 7, "{width}");
    for i in 0..4 {
        for j in 0..i {
            assert!(row(i) != row(j), "rows {i} and {j}");
        }
    }
    assert!(row(0) == row(4), "the same noise is the same row");
    f.good(&text.replace("a.png", "b.png"));
    assert!(f.read("a.png") == f.read("b.png"), "and the same sheet the same bytes");
}

#[test]
fn options_change_the_noise() {
    let f = Folder::new();
    f.good("noise gradient --size 64 -q -o a.png");
    let others = ["--seed 1", "--dimensions 2", "--set period=4", "--set period=4,4,0", "--size 65"];
    for (i, options) in others.into_iter().enumerate() {
        let size = if options.contains("--size") { "" } else { "--size 64" };
        f.good(&format!("noise gradient -q -o b{i}.png {size} {options}"));
        assert!(f.read("a.png") != f.read(&format!("b{i}.png")), "{options}");
    }
    // Without a name the picture has one, and any format is as good.
    f.good("noise gradient --size 64 -q");
    assert!(f.read("noise.png") == f.read("a.png"));
    f.good("noise gradient --size 64 -q -o a.jpg");
    f.good("noise gradient --size 64 -q -o a.exr");
}

#[test]
fn wrong_arguments_are_said_and_leave_no_file() {
    let f = Folder::new();
    f.bad(2, "noise gradiant -o a.png", &["no kind of noise called `gradiant`", "Did you mean gradient?"]);
    f.bad(2, "noise qqqqqqqq -o a.png", &["There are perlin1985, gradient"]);
    f.bad(2, "noise turbo:gradient -o a.png", &["no sum called `turbo`", "turbulence"]);
    f.bad(2, "noise gradient --set perod=4 -o a.png", &["Did you mean period?"]);
    f.bad(2, "noise gradient --set jitter=1 -o a.png", &["`gradient` noise takes no jitter"]);
    f.bad(2, "noise gradient --set period=2.5 -o a.png", &["period must be a whole number"]);
    f.bad(2, "noise gradient --dimensions 5 -o a.png", &["1..=4"]);
    f.bad(2, "noise gradient --size 9 -o a.png", &["64..=1024"]);
    f.bad(1, "noise gradient -o a.qqq", &["unknown format `.qqq`"]);
    f.bad(1, "noise gradient -o none/a.png", &["there is no directory `none`"]);
    assert_eq!(std::fs::read_dir(f.path("")).map(|all| all.count()).ok(), Some(0));
}
