use pse::*;
fn cpu() -> f64 {
    std::fs::read_to_string("/proc/thread-self/schedstat")
        .unwrap()
        .split(' ')
        .next()
        .unwrap()
        .parse::<f64>()
        .unwrap()
        * 1e-9
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let o = pse::scene::Options {
        width: 1920,
        height: 1080,
        eye: Some([0.0, -2.6, 2.9]),
        look_at: Some([0.0, 0.0, 0.0]),
        fov: Some(33.0),
        ..Default::default()
    };
    let image = pse::scene::render("donut", &o).unwrap();
    let s = &image.variable("surface").unwrap().planes[0];
    println!("cover {}", s.iter().sum::<f32>() / s.len() as f32);
    for f in &args[1..] {
        let text = std::fs::read_to_string(f).unwrap();
        let p = Program::compile(&text).unwrap_or_else(|e| panic!("{e}"));
        for batch in [512] {
            let mut best = f64::MAX;
            for _ in 0..7 {
                let t = cpu();
                let r = p
                    .run(&image, &RunOptions { threads: Some(1), batch: Some(batch), ..Default::default() })
                    .unwrap_or_else(|e| panic!("{e}"));
                best = best.min(cpu() - t);
                std::hint::black_box(r);
            }
            print!("{f} batch {batch} ns/px {:.2}  ", best * 1e9 / 1920.0 / 1080.0);
        }
        println!();
    }
}
