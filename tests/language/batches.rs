//! The result of a program on many pixels is what it gives on each pixel alone: the same bits, or the same
//! error at the same pixel, for any batch, any number of threads, any instruction set. Held over random
//! programs with branches, loops, early returns, recursion and values that change shape.

use proptest::prelude::*;
use pse::Origin;
use pse::internal::lanes::Isa;
use pse::{Compiler, Host, Image, Limits, PixelValue, Program, RunOptions, Shape, Variable};
use std::sync::Arc;

/// Writes a program from a stream of choices; when the stream ends it writes the simplest thing.
struct Writer<'a> {
    choices: std::slice::Iter<'a, u8>,
    text: String,
    loops: usize,
    /// May it ask for derivatives? Then all pixels run with shadows.
    derivatives: bool,
}

impl Writer<'_> {
    fn pick(&mut self, n: u8) -> u8 {
        self.choices.next().map_or(0, |c| c % n)
    }

    fn line(&mut self, depth: usize, text: &str) {
        self.text.push_str(&"    ".repeat(depth));
        self.text.push_str(text);
        self.text.push('\n');
    }

    fn number(&mut self) -> String {
        ["0", "1", "0.5", "-2", "3", "1e20", "0/0", "7.25"][usize::from(self.pick(8))].into()
    }

    /// A scalar expression.
    fn scalar(&mut self, depth: usize) -> String {
        if depth == 0 {
            return match self.pick(8) {
                0 => "x".into(),
                1 => "y".into(),
                2 => format!("s{}", self.pick(3)),
                3 => "k".into(),
                4 => "p.y".into(),
                5 => "pixel.x".into(),
                _ => self.number(),
            };
        }
        let d = depth - 1;
        match self.pick(if self.derivatives { 29 } else { 25 }) {
            0 => format!("({} + {})", self.scalar(d), self.scalar(d)),
            1 => format!("({} - {})", self.scalar(d), self.scalar(d)),
            2 => format!("({} * {})", self.scalar(d), self.scalar(d)),
            3 => format!("({} / {})", self.scalar(d), self.scalar(d)),
            4 => format!("({} % {})", self.scalar(d), self.scalar(d)),
            5 => format!("({} < {})", self.scalar(d), self.scalar(d)),
            6 => format!("({} && {})", self.scalar(d), self.scalar(d)),
            7 => format!("({} || {})", self.scalar(d), self.scalar(d)),
            8 => format!("({} ? {} : {})", self.scalar(d), self.scalar(d), self.scalar(d)),
            9 => format!("sin({})", self.scalar(d)),
            10 => format!("Noise({})", self.vector(d)),
            11 => format!("sum({})", self.vector(d)),
            12 => format!("deep({}, {})", self.scalar(d), self.pick(5)),
            13 => format!("norm({})", self.vector(d)),
            14 => format!("max({}, {})", self.scalar(d), self.scalar(d)),
            15 => format!("clamp({})", self.scalar(d)),
            16 => format!("spline({}, 0, 1, -1, 2, 0.5)", self.scalar(d)),
            17 => format!("-{}", self.scalar(d)),
            18 => format!("Noise({}, seed = {})", self.vector(d), self.scalar(d)),
            19 => format!("seeds({})", self.scalar(d)),
            20 => format!("fBm({}, octaves = 2.5, high = 100)", self.vector(d)),
            21 => format!("texture(\"map\", {}, x, width = {})", self.scalar(d), self.scalar(0)),
            22 => {
                let filter = ["sat", "cubic", "nearest"][usize::from(self.pick(3))];
                let (s, t, width) = (self.scalar(d), self.scalar(0), self.scalar(0));
                let width = if filter == "sat" { format!(", width = [{width} 0.2]") } else { String::new() };
                format!("texture(\"map\", {s}, {t}{width}, filter = \"{filter}\", wrap = \"mirror\")")
            }
            23 => format!(
                "(environment(\"map\", p, width = {}) + table([y x 3], {}))",
                self.scalar(0),
                self.scalar(d)
            ),
            24 => format!("early({}, {})", self.vector(d), self.scalar(d)),
            25 => format!("Du({})", self.scalar(d)),
            26 => format!("sum(Dv({}))", self.vector(d)),
            27 => format!("filterwidth({})", self.scalar(d)),
            _ => format!("texture(\"map\", {}, {})", self.scalar(d), self.scalar(0)),
        }
    }

    /// A vector, of whatever length.
    fn vector(&mut self, depth: usize) -> String {
        match self.pick(9) {
            0 => "p".into(),
            1 => "v0".into(),
            2 => "v1".into(),
            3 if depth > 0 => format!("[{} {}]", self.scalar(depth - 1), self.scalar(depth - 1)),
            4 if depth > 0 => format!("({} * {})", self.vector(depth - 1), self.scalar(depth - 1)),
            5 if depth > 0 => {
                format!("({} ? {} : {})", self.scalar(0), self.vector(depth - 1), self.vector(depth - 1))
            }
            6 if depth > 0 => format!("direction({})", self.vector(depth - 1)),
            7 if depth > 0 => format!("Dnoise({})", self.vector(depth - 1)),
            _ => "[1 2 x]".into(),
        }
    }

    fn block(&mut self, depth: usize, in_loop: bool) {
        let n = 1 + self.pick(3);
        for _ in 0..n {
            self.statement(depth, in_loop);
        }
    }

    fn statement(&mut self, depth: usize, in_loop: bool) {
        let shallow = depth < 4;
        match self.pick(12) {
            0 | 1 => {
                let (i, e) = (self.pick(3), self.scalar(2));
                self.line(depth, &format!("s{i} = {e}"));
            }
            2 => {
                let (i, e) = (self.pick(3), self.scalar(2));
                let op = ["+=", "*=", "-=", "&&=", "||="][usize::from(self.pick(5))];
                self.line(depth, &format!("s{i} {op} {e}"));
            }
            3 => {
                let (i, e) = (self.pick(2), self.vector(2));
                self.line(depth, &format!("v{i} = {e}"));
            }
            4 => {
                let (i, e) = (self.pick(2), self.scalar(1));
                self.line(depth, &format!("v{i}[size(v{i}) + {}] = {e}", self.text.len() % 2));
            }
            5 => {
                let (i, e, index) = (self.pick(2), self.scalar(1), self.scalar(1));
                self.line(depth, &format!("v{i}[1 + abs({index}) % 2] = {e}"));
            }
            6 | 7 if shallow => {
                let c = self.scalar(2);
                self.line(depth, &format!("if {c}"));
                self.block(depth + 1, in_loop);
                if self.pick(2) == 1 {
                    self.line(depth, "else");
                    self.block(depth + 1, in_loop);
                }
            }
            8 if shallow && self.loops < 3 => {
                self.loops += 1;
                let c = self.scalar(1);
                self.line(depth, "n = 0");
                self.line(depth, &format!("while n < 6 && {c}"));
                self.line(depth + 1, "n += 1");
                self.block(depth + 1, true);
            }
            9 if shallow && self.loops < 3 => {
                self.loops += 1;
                let v = self.vector(1);
                self.line(depth, &format!("for k in {v}"));
                self.block(depth + 1, true);
            }
            10 if in_loop => {
                let c = self.scalar(1);
                self.line(depth, &format!("if {c}"));
                let word = if self.pick(2) == 0 { "break" } else { "continue" };
                self.line(depth + 1, word);
            }
            _ => {
                let e = self.scalar(1);
                self.line(depth, &format!("s0 = {e}"));
            }
        }
    }
}

fn program(choices: &[u8], derivatives: bool) -> String {
    let mut writer = Writer { choices: choices.iter(), text: String::new(), loops: 0, derivatives };
    writer.text.push_str(
        "function deep(a, n)\n    if n <= 0 || a > 100\n        return a\n    return deep(a + x, n - 1)\n\
         function early(v, a)\n    for e in v\n        if e > a\n            return e * 2\n        a += y\n    return a\n\
         function seeded(a)\n    return Noise(1, seed = a)\n\
         function seeds(a)\n    j = 0\n    while j < 2\n        j += 1\n        b = seeded(a)\n    return b\n\
         s0 = x\ns1 = y\ns2 = 0.25\nk = 0\nv0 = [x y]\nv1 = p\n",
    );
    writer.block(0, false);
    writer.block(0, false);
    writer.text.push_str("color = [s0 s1 s2]\nlast = sum(v0) + sum(v1)\nif x > 0.5\n    some = y\n");
    writer.text
}

const WIDTH: usize = 37;
const HEIGHT: usize = 29;

/// Planes with plain and awkward numbers, in patches and scattered.
fn image() -> Image<'static> {
    let n = WIDTH * HEIGHT;
    let hash = |i: usize| (i.wrapping_mul(2_654_435_761) >> 7) % 1000;
    let x: Vec<f32> = (0..n).map(|i| hash(i) as f32 / 500.0 - 1.0).collect();
    let y: Vec<f32> = (0..n)
        .map(|i| match i % 101 {
            0 => f32::NAN,
            1 => f32::INFINITY,
            2 => -0.0,
            _ => (i / 64) as f32 * 0.125 - 1.0,
        })
        .collect();
    let p = [0, 1, 2].map(|c| (0..n).map(|i| hash(i * 3 + c) as f32 * 0.01).collect::<Vec<f32>>());
    let variables = [
        Variable::new("x", Shape::Scalar, [x]).unwrap(),
        Variable::new("y", Shape::Scalar, [y]).unwrap(),
        Variable::new("p", Shape::Vector(3), p).unwrap(),
    ];
    Image::new(WIDTH, HEIGHT, variables).unwrap()
}

/// A run's result, as something to compare: the outputs' bits, or the error's text and pixel.
fn outcome(program: &Program, image: &Image<'_>, options: &RunOptions<'_>) -> Result<Vec<Vec<u32>>, String> {
    let outputs = ["color", "last", "some"].map(String::from).to_vec();
    let limits = Limits { steps: 3000, depth: 20, cells: 200, memory: 64 << 20 };
    let options = RunOptions { outputs: Some(outputs), limits, ..options.clone() };
    match program.run(image, &options) {
        Ok(report) => Ok(report
            .image
            .variables
            .iter()
            .flat_map(|v| &v.planes)
            .map(|p| p.iter().map(|x| if x.is_nan() { 0x7fc0_0000 } else { x.to_bits() }).collect())
            .collect()),
        Err(error) => Err(error.to_string()),
    }
}

/// One small image in memory, called `map`.
struct Map(Arc<Image<'static>>);

impl Map {
    fn new() -> Map {
        let plane: Vec<f32> = (0..13 * 7).map(|i| (i * i % 17) as f32 / 16.0).collect();
        Map(Arc::new(Image::new(13, 7, [Variable::new("grey", Shape::Scalar, [plane]).unwrap()]).unwrap()))
    }
}

impl Host for Map {
    fn import(&self, _: &str, _: &str) -> Result<(String, String), pse::HostError> {
        Err("there are no files".into())
    }

    fn image(&self, _: &str, name: &str) -> Result<Origin, pse::HostError> {
        if name == "map" { Ok(Origin::Image(self.0.clone())) } else { Err("there is only `map`".into()) }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 160, ..ProptestConfig::default() })]

    #[test]
    fn batches_threads_and_instruction_sets_agree(
        choices in prop::collection::vec(any::<u8>(), 0..160),
        derivatives in any::<bool>(),
    ) {
        let text = program(&choices, derivatives);
        let program = Compiler::new().host(&Map::new()).compile("program", &text);
        let program = program.unwrap_or_else(|e| panic!("{text}\n{e}"));
        let image = image();
        let alone = RunOptions { batch: Some(1), threads: Some(1), isa: Some(Isa::baseline()), ..RunOptions::default() };
        let expected = outcome(&program, &image, &alone);
        let plain = RunOptions { threads: Some(1), no_optimize: true, ..RunOptions::default() };
        prop_assert_eq!(&outcome(&program, &image, &plain), &expected, "not optimized\n{}", text);
        for batch in [7, 255, 256, 257, 512, 4096] {
            let options = RunOptions { batch: Some(batch), threads: Some(1), ..RunOptions::default() };
            prop_assert_eq!(&outcome(&program, &image, &options), &expected, "batch {}\n{}", batch, text);
        }
        let two = RunOptions { threads: Some(2), ..RunOptions::default() };
        prop_assert_eq!(&outcome(&program, &image, &two), &expected, "2 threads\n{}", text);
    }
}

/// A coarse picture has every so many pixels of the whole one, with derivatives and outputs that are inputs.
#[test]
fn a_coarse_picture_is_a_part_of_the_whole() {
    let text =
        "color = [Noise(p) Du(x) filterwidth(p.x)]\nif pixel.x > 9\n    v = [x pixel.y]\nelse\n    v = x\n";
    let program = Program::compile(text).unwrap();
    let image = image();
    let run = |every, batch| {
        let outputs = Some(["color", "v", "p"].map(String::from).to_vec());
        let options = RunOptions { every, batch: Some(batch), outputs, ..RunOptions::default() };
        program.run(&image, &options).unwrap().image
    };
    let whole = run(1, 512);
    for (every, batch) in [(2, 512), (4, 7), (4, 2048), (20, 512)] {
        let coarse = run(every, batch);
        assert_eq!([coarse.width, coarse.height], [WIDTH.div_ceil(every), HEIGHT.div_ceil(every)]);
        for (part, all) in coarse.variables.iter().zip(&whole.variables) {
            assert_eq!(part.shape, all.shape);
            for (part, all) in part.planes.iter().zip(&all.planes) {
                for (i, x) in part.iter().enumerate() {
                    let (column, row) = (i % coarse.width * every, i / coarse.width * every);
                    assert_eq!(x.to_bits(), all[row * WIDTH + column].to_bits(), "{every} {column} {row}");
                }
            }
        }
    }
    // An error is told at its own pixel.
    let program =
        Program::compile("if pixel.x > 9 && pixel.y > 5\n    color = [1 2][7]\nelse\n    color = 1\n")
            .unwrap();
    let error = program.run(&image, &RunOptions { every: 4, ..RunOptions::default() }).unwrap_err();
    assert_eq!(error.diagnostics[0].pixel, Some([12, 8]));
}

/// The threads above share one chunk of a small image; here there are many.
#[test]
fn two_threads_equal_one_on_a_large_image() {
    let n = 300_000;
    let x: Vec<f32> = (0..n).map(|i| (i % 977) as f32 * 0.01).collect();
    let image = Image::new(n, 1, [Variable::new("x", Shape::Scalar, [x]).unwrap()]).unwrap();
    let program = Program::compile(
        "t = 0\nwhile t < x\n    t += 0.5 + 0.25 * sin(t)\nif t > 5\n    v = [t]\nelse\n    v = [t t]\ncolor = t * sum(v)\n",
    )
    .unwrap();
    let bits = |threads| {
        let report =
            program.run(&image, &RunOptions { threads: Some(threads), ..RunOptions::default() }).unwrap();
        report.image.variables[0].planes[0].iter().map(|x| x.to_bits()).collect::<Vec<_>>()
    };
    assert!(bits(1) == bits(2));
}

/// Lanes that part in shape or seed in the middle of calls and loops, which were run for the active lanes alone.
#[test]
fn lanes_part_in_the_middle_of_calls() {
    let text = "function f1()\n    return Noise(1, seed = x)\n\
                function f2()\n    j = 0\n    while j < 2\n        j += 1\n        b = f1()\n    return b\n\
                color = 0\nn = 0\nwhile n < 1 && pixel.y < 19\n    n += 1\n    color = f2()\n";
    let program = Program::compile(text).unwrap();
    let planes = [(0..72 * 48).map(|i| f32::from(u8::from(i / 72 > 9 && i % 72 > 20))).collect::<Vec<f32>>()];
    let image = Image::new(72, 48, [Variable::new("x", Shape::Scalar, planes).unwrap()]).unwrap();
    let run = |batch| {
        let options = RunOptions { batch: Some(batch), threads: Some(1), ..RunOptions::default() };
        program.run(&image, &options).unwrap().image.variables[0].planes[0].to_vec()
    };
    assert!(run(2048) == run(1));
}

/// The limit on steps is each lane's own, also of a lane that is gathered alone from a batch that took more.
#[test]
fn steps_are_counted_for_each_lane() {
    let text = "i = 0\nwhile x < 1 && i < 101\n    i += 1\n\
                while x >= 1\n    j = 0\n    while j < 1\n        j += 1\ncolor = i\n";
    let program = Program::compile(text).unwrap();
    let planes = [(0..64).map(|i| f32::from(u8::from(i == 3))).collect::<Vec<f32>>()];
    let image = Image::new(64, 1, [Variable::new("x", Shape::Scalar, planes).unwrap()]).unwrap();
    for steps in 3000..3006 {
        let told = |batch| {
            let limits = Limits { steps, ..Limits::default() };
            let options = RunOptions { batch: Some(batch), limits, ..RunOptions::default() };
            program.run(&image, &options).unwrap_err().to_string()
        };
        assert_eq!(told(64), told(1));
    }
}

/// What a plan comes upon that goes wrong is told as the walk tells it, with the calls that led there.
#[test]
fn errors_in_what_is_kept_have_their_calls() {
    let text = "function bad()\n    v = [1 2]\n    return v[3]\n\
                function f(a)\n    q = a + 1\n    w = q + bad()\n    return w\n\
                color = f(pixel.x)\n";
    let program = Program::compile(text).unwrap();
    let image = Image::new(64, 8, []).unwrap();
    let told = |batch, no_optimize| {
        let options = RunOptions { batch: Some(batch), no_optimize, ..RunOptions::default() };
        program.run(&image, &options).unwrap_err().to_string()
    };
    let known = told(1, true);
    assert!(known.contains("bad"), "{known}");
    assert_eq!(told(2048, false), known);
    assert_eq!(told(2048, true), known);
}

/// What is no number is the same one everywhere: its sign depends on the order of operands and on the machine.
#[test]
fn nans_are_alike() {
    let text = "zero = pixel.x - pixel.x\nn = zero / zero\nm = -n\ns = n + 2 * m\nt = n + m * 2\n\
                color = [Noise([0.3 0.4 0.5], seed = t), Noise([0.3 0.4 0.5], seed = s), 0]\nodd = [s t n m -n m ^ n]\n";
    let program = Program::compile(text).unwrap();
    let image = Image::new(100, 3, []).unwrap();
    let run = |options: RunOptions<'_>| {
        let outputs = Some(vec!["color".to_string(), "odd".to_string()]);
        let report = program.run(&image, &RunOptions { outputs, ..options }).unwrap();
        let planes = report.image.variables.iter().flat_map(|v| &v.planes);
        planes.map(|p| p.iter().map(|x| x.to_bits()).collect::<Vec<u32>>()).collect::<Vec<_>>()
    };
    let known = run(RunOptions { batch: Some(1), isa: Some(Isa::baseline()), ..RunOptions::default() });
    assert!(run(RunOptions::default()) == known);
    assert!(run(RunOptions { no_optimize: true, ..RunOptions::default() }) == known);
    assert!(
        known[2..]
            .iter()
            .flatten()
            .all(|x| *x == f32::NAN.to_bits() || *x == 0 || f32::from_bits(*x).is_finite())
    );
}

/// Branches that a plan follows both ways, where lanes of all ways are mixed and where they lie side by side: calls that
/// return early, costly functions, variables of one branch alone.
#[test]
fn mixed_branches_are_as_the_walk_has_them() {
    let branches = "function fold(p, n)\n    q = abs(p) - 0.4\n    d = norm(q) - 0.2\n    if n == 1 || d > x\n        return d\n    \
                    if d < 0\n        late = Noise(p)\n        if late > 0\n            return late\n    \
                    return min(d, fold(1.5 * [q.y q.z q.x], n - 1) / 1.5)\n\
                    if kind == 0\n    wave = sin(40 * x)\n    color = [wave wave ^ 3 wave % 2]\n\
                    else if kind == 1\n    t = fold(p, 5)\n    color = [t Noise(8 * p) t]\n\
                    else if kind < 3 && Noise(p) > 0\n    color = Dnoise(p)\n\
                    else\n    cell = floor(6 * p)\n    \
                    color = (cell.x + cell.y) % 2 == 0 ? [0.9 0.9 0.8] : [x y Noise(p)]\n";
    let again = "color = 0\nfor i in [1 2 3]\n    if y > 0\n        if i > 1\n            color += mark\n        \
                 mark = i * x + Noise(p)\n";
    let image = image();
    for text in [
        format!("kind = abs(round(100 * p.x)) % 4\n{branches}"),
        format!("kind = floor(pixel.x / 5) % 4\n{branches}"),
        format!("kind = pixel.y % 40 == 0 ? 1 : 3\n{branches}"),
        again.to_string(),
    ] {
        let program = Program::compile(&text).unwrap_or_else(|e| panic!("{text}\n{e}"));
        let run = |batch, no_optimize| {
            let outputs = Some(vec!["color".to_string()]);
            let options = RunOptions { batch: Some(batch), no_optimize, outputs, ..RunOptions::default() };
            let report = program.run(&image, &options).unwrap_or_else(|e| panic!("{text}\n{e}"));
            let planes = report.image.variables.iter().flat_map(|v| &v.planes);
            let bits = |x: &f32| if x.is_nan() { 0x7fc0_0000 } else { x.to_bits() };
            planes.map(|p| p.iter().map(bits).collect::<Vec<u32>>()).collect::<Vec<_>>()
        };
        let known = run(1, true);
        for batch in [100, 512, 2048] {
            assert!(run(batch, false) == known, "batch {batch}\n{text}");
            assert!(run(batch, true) == known, "not optimized, batch {batch}\n{text}");
        }
    }
}

/// An error is that of the first pixel in reading order, wherever in the program it happens.
#[test]
fn the_first_pixel_in_error_is_reported() {
    let program = Program::compile(
        "v = [1 2]\nif pixel.x > 30\n    color = v[5]\nif pixel.x > 20 && pixel.y > 3\n    color = v[7]\ncolor = 1\n",
    )
    .unwrap();
    let image = Image { width: WIDTH, height: HEIGHT, ..Image::default() };
    for batch in [1, 7, 512] {
        let options = RunOptions { batch: Some(batch), ..RunOptions::default() };
        let error = program.run(&image, &options).unwrap_err();
        assert_eq!(error.diagnostics[0].pixel, Some([30, 0]), "batch {batch}");
        assert!(error.diagnostics[0].message.contains("element 5"), "{error}");
    }
}

#[test]
fn runaway_programs_end_soon() {
    let image = Image { width: 640, height: 480, ..Image::default() };
    for (text, word) in [
        ("t = 0\nwhile 1\n    t += 1\ncolor = t", "steps"),
        ("t = pixel.x\nwhile pixel.x > 300\n    t += sin(t)\ncolor = t", "steps"),
        ("function f(x)\n    return f(x + 1)\ncolor = f(pixel.x)", "nested"),
        (
            "function f(x)\n    if x > 25\n        return 1\n    return f(x + 1) + f(x + 1)\ncolor = f(0)",
            "steps",
        ),
        ("v = [1]\nwhile 1\n    v = append(v, v)\ncolor = 1", "limit is"),
        ("color = sum([1 .. 1000000000])", "more than"),
        (
            "v = [1 .. 60000] * pixel.x\nw = v * 2\nu = w + 1\nz = u + w\nwhile 1\n    z += v\ncolor = z[1]",
            "more than",
        ),
    ] {
        let program = Program::compile(text).unwrap_or_else(|e| panic!("{e}"));
        let start = std::time::Instant::now();
        let error = program.run(&image, &RunOptions::default()).unwrap_err();
        assert!(error.diagnostics[0].message.contains(word), "{error}");
        // Far above what it takes, far below what a user would call hanging.
        assert!(start.elapsed().as_secs() < 120, "{text} took {:?}", start.elapsed());
    }
}

#[test]
fn a_pixel_alone_is_the_pixel_of_the_image() {
    let program = Program::compile("color = p * x + Noise(p)\n").unwrap();
    let image = image();
    let whole = program.run(&image, &RunOptions::default()).unwrap().image;
    for (column, row) in [(0, 0), (5, 3), (WIDTH - 1, HEIGHT - 1)] {
        let values = program.eval_pixel_of(&image, column, row, &RunOptions::default()).unwrap();
        let pixel: Vec<f32> = whole.variables[0].planes.iter().map(|p| p[row * WIDTH + column]).collect();
        let expected = PixelValue::from(&pixel[..]);
        assert_eq!(values, [("color".to_string(), expected)]);
    }
}
