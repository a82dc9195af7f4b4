//! `--iso`: solids on the command line.

#[test]
fn the_command_writes_pictures_and_meshes() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let text = "param size = 1 in [0.1 1.4]
function density(p)
    return size - length(p)
color = surface * (0.5 + 0.5 * normal)";
    std::fs::write(path("ball.pse"), text).expect("a program");
    std::fs::write(path("look.pse"), "param tint = 1\ncolor = tint * surface * white").expect("a program");
    let run = |words: &str| {
        let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_pse"));
        let output = command.current_dir(folder.path()).args(words.split(' ')).output().expect(words);
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let good = |words: &str| {
        let (code, told) = run(words);
        assert_eq!(code, Some(0), "{words}: {told}");
        told
    };
    let told = good("scene --iso ball.pse --size 32x24 --stats");
    assert!(told.contains("wrote ball.exr (32x24)") && told.contains("density evaluated at"), "{told}");
    for mesh in ["a.obj", "a.ply", "a.glb"] {
        let told = good(&format!("scene --iso ball.pse -o {mesh} --resolution 16 --set size=0.7"));
        assert!(told.contains("triangles)") && path(mesh).exists(), "{told}");
    }
    let told = good("scene --iso ball.pse --size 8x8 --level 5 -o none.exr");
    assert!(told.contains("no pixel shows the solid"), "{told}");
    // One program for both; one for each, with what either has set; what was written, painted.
    good("run ball.pse --iso ball.pse --size 32x24 -o both.exr --samples 2");
    good("run look.pse --iso ball.pse --size 32x24 -o each.exr --set size=0.5 --set tint=2");
    good("run ball.pse -i ball.exr -o later.exr");
    good("run ball.pse --iso ball.pse --size 32x24 -o now.exr");
    assert_eq!(
        std::fs::read(path("later.exr")).expect("later"),
        std::fs::read(path("now.exr")).expect("now")
    );
    let fails = |words: &str, part: &str| {
        let (code, told) = run(words);
        assert!(code != Some(0) && told.contains(part), "{words}: {told}");
    };
    fails("run ball.pse --iso ball.pse --scene donut", "cannot be combined");
    fails("scene --iso ball.pse --soft -o a.ply", "cannot be written as a mesh");
    fails("scene --iso ball.pse --level 5 -o b.ply", "the box contains no surface");
    fails("scene --iso ball.pse --box 1,2,3 -o b.exr", "six numbers");
    fails("scene --iso look.pse -o b.exr", "no function `density(point)`");
    fails("run look.pse --iso ball.pse --set nothing=1 -o b.png", "no param `nothing`");
    fails("run -e uv --iso ball.pse -o b.png --size 8x8", "The solid has surface");
}
