//! Very many of one kind: what takes time for each pair of them would not come to an end here.

use super::Folder;

#[test]
fn outputs_and_values() {
    let f = Folder::new();
    let mut words: Vec<String> = ["run", "-e", "white", "--size", "1x1", "-q"].map(String::from).to_vec();
    words.extend((0..3000).flat_map(|i| ["-o".to_string(), format!("o{i}.exr")]));
    let ended = f.pse_with(&words.iter().map(String::as_str).collect::<Vec<_>>(), b"");
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(f.path("o2999.exr").exists());
    let params: String = (0..5000).map(|i| format!("param p{i} = {i}\n")).collect();
    f.write("params.pse", &(params + "color = white * p4999\n"));
    let mut words: Vec<String> =
        ["run", "params.pse", "--size", "1x1", "-q", "-o", "set.exr"].map(String::from).to_vec();
    words.extend((0..5000).flat_map(|i| ["--set".to_string(), format!("p{i}=0.5")]));
    let ended = f.pse_with(&words.iter().map(String::as_str).collect::<Vec<_>>(), b"");
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert_eq!(f.planes("set.exr", "color")[0], [0.5]);
}

#[test]
fn folders_to_search() {
    let f = Folder::new();
    let textures: String = (0..2000).map(|i| format!("a{i} = texture(\"no{i}.png\", uv)\n")).collect();
    f.write("t.pse", &textures);
    std::fs::create_dir(f.path("folder")).expect("a folder");
    let with = |count: usize| {
        let mut words = vec!["run", "t.pse", "-o", "a.exr"];
        (0..count).for_each(|_| words.extend(["--path", "folder"]));
        f.pse_with(&words, b"")
    };
    let ended = with(256);
    assert!(ended.code == 1 && ended.err.contains("no0.png"), "{}", ended.err);
    let ended = with(257);
    assert_eq!(ended.code, 2);
    assert!(ended.err.contains("--path is given 257 times; the limit is 256"), "{}", ended.err);
}
