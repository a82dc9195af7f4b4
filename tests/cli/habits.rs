//! More of what an artist writes out of habit, and what the command says then: the whole messages are in
//! `tests/errors/commands`.

use super::Folder;
use super::messages::{exr, says};
use std::io::Read;
use std::process::{Command, Stdio};

/// A file of one view layer, as Blender writes it.
fn layer(f: &Folder) {
    let passes = [
        "Combined.R",
        "Combined.G",
        "Combined.B",
        "Combined.A",
        "Depth.Z",
        "Position.X",
        "Position.Y",
        "Position.Z",
    ];
    let names = passes.map(|pass| format!("ViewLayer.{pass}"));
    exr(f, "layer.exr", &names.each_ref().map(String::as_str));
}

#[test]
fn layers_and_channels_of_other_programs() {
    let f = Folder::new();
    layer(&f);
    for (name, program) in [
        ("layer_and_scalar", "white * ViewLayer.Depth.Z"),
        ("layer_and_vector", "white * ViewLayer.Position.X"),
        ("layer_without_the_pass", "white * ViewLayer.NoSuch.R"),
        ("layer_and_misspelt_pass", "white * ViewLayer.Dephh.Z"),
        ("component_of_a_scalar", "white * depth.Z"),
        ("nuke_alpha", "white * rgba.alpha"),
        ("nuke_red", "white * rgba.red"),
        ("alpha_of_the_color", "color = white * color.a"),
    ] {
        says(&f, name, &["run", "-e", program, "-i", "layer.exr", "-o", "a.exr"]);
    }
}

#[test]
fn functions_and_lines_of_other_programs() {
    let f = Folder::new();
    layer(&f);
    for (name, program) in [
        ("function_without_brackets", "white * sin * point.x"),
        ("function_matte", "color = matte(\"Torus\")"),
        ("function_cryptomatte", "color = white * cryptomatte(\"Torus\")"),
        ("function_ch", "color = white * ch(\"amp\")"),
        ("function_dotproduct", "color = white * dotproduct(point, point)"),
        ("function_mixrgb", "color = MixRGB(white, black, 0.5)"),
        ("function_keymix", "color = keymix(white, black, 0.5)"),
        ("include", "#include \"noise.h\"\ncolor = white * wobble(point)"),
        ("include_of_a_variable", "#include <colors.h>\ncolor = sky_blue"),
    ] {
        says(&f, name, &["run", "-e", program, "-i", "layer.exr", "-o", "a.exr"]);
    }
}

#[test]
fn outputs_by_the_names_of_other_languages() {
    let f = Folder::new();
    for (name, word) in [
        ("output_ci", "Ci"),
        ("output_fragcolor", "fragColor"),
        ("output_gl_fragcolor", "gl_FragColor"),
        ("output_colour", "colour"),
    ] {
        let program = format!("{word} = white");
        says(&f, name, &["run", "-e", &program, "--size", "2x2", "-o", "a.png"]);
        // An EXR file holds any variable, so it is written, with a warning.
        let said = f.pse_with(&["run", "-e", &program, "--size", "2x2", "-o", "a.exr"], b"");
        assert!(
            said.code == 0 && said.err.contains(&format!("`{word}` is assigned and never read")),
            "{}",
            said.err
        );
        assert!(said.err.contains("`color`"), "{}", said.err);
        let named = ["run", "-e", &program, "--vars", word, "--size", "2x2", "-o", "a.exr"];
        assert!(!f.pse_with(&named, b"").err.contains("never read"));
    }
    let said =
        f.pse_with(&["run", "-e", "Oi = 1", "-e", "color = white", "--size", "2x2", "-o", "a.exr"], b"").err;
    assert!(said.contains("The output is called `alpha` here."), "{said}");
}

#[test]
fn files_in_the_place_of_others() {
    let f = Folder::new();
    layer(&f);
    f.write("m.obj", "o thing\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    f.write("p.pse", "param amount = 1\ncolor = white * amount\n");
    says(&f, "mesh_as_program", &["run", "m.obj", "-o", "a.exr"]);
    says(&f, "mesh_as_checked_program", &["check", "m.obj"]);
    says(&f, "image_as_program", &["run", "layer.exr", "-o", "a.exr"]);
    says(&f, "recenter_apart", &["run", "p.pse", "--mesh", "m.obj", "--recenter", "1,2,3", "-o", "a.exr"]);
    says(
        &f,
        "fov_without_look_at",
        &["run", "p.pse", "-i", "layer.exr", "--eye", "1,2,3", "--fov", "30", "-o", "a.exr"],
    );
    says(
        &f,
        "look_at_without_eye",
        &["run", "p.pse", "-i", "layer.exr", "--look-at", "1,2,3", "-o", "a.exr"],
    );
    says(&f, "set_of_a_web_color", &["run", "p.pse", "--set", "amount=#ff0000", "-o", "a.exr"]);
    says(&f, "set_of_a_call", &["run", "p.pse", "--set", "amount=sin 3", "-o", "a.exr"]);
    says(&f, "info_of_no_sequence", &["info", "none.####.exr"]);
    for frame in [3, 4, 7] {
        std::fs::copy(f.path("layer.exr"), f.path(&format!("sq.000{frame}.exr"))).expect("a copy");
    }
    says(&f, "info_of_a_sequence", &["info", "sq.####.exr"]);
    f.write("comma.obj", "v 0,5 1 2\n");
    says(&f, "decimal_comma", &["info", "comma.obj"]);
    f.write("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    says(&f, "mesh_of_lines", &["scene", "--mesh", "line.obj", "-o", "a.exr"]);
}

/// A file that is missing is reported where the command was started, before any page is open.
#[test]
fn the_preview_reports_a_missing_file() {
    let f = Folder::new();
    f.write("p.pse", "color = white\n");
    let mut command = Command::new(env!("CARGO_BIN_EXE_pse"));
    let command = command.args(["view", "p.pse", "-i", "nosuch.exr"]).current_dir(f.path(""));
    let mut view = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("pse");
    let mut said = String::new();
    let mut bytes = [0; 256];
    let mut from = view.stderr.take().expect("standard error");
    while !said.contains("nosuch.exr") {
        let read = from.read(&mut bytes).expect("what it says");
        assert_ne!(read, 0, "{said}");
        said += &String::from_utf8_lossy(&bytes[..read]);
    }
    view.kill().expect("the end");
    view.wait().expect("the end");
}

#[test]
fn tabs_and_what_has_no_width_are_shown() {
    let f = Folder::new();
    let name = "a\tb\u{200b}c";
    f.write(&format!("{name}.pse"), "color = white\n");
    let written = f.pse_with(&["run", &format!("{name}.pse"), "--size", "2x2"], b"");
    assert!(written.err.contains("a\\tb\\u{200b}c.png"), "{}", written.err);
    f.write(&format!("{name}.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\ng x\u{200b}y\nf 1 2 3\n");
    let about = f.pse_with(&["info", &format!("{name}.obj")], b"");
    for text in [&written.err, &about.text, &f.pse_with(&["info", &format!("{name}.exr")], b"").err] {
        assert!(!text.contains(['\t', '\u{200b}']), "{text:?}");
    }
}
