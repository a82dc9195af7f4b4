//! Frame numbers: lists of them, and which one a command runs.

pub(super) use pse::image::{Frame, fill, has_pattern};

use super::failure::Failure;
use pse::image::{MAX_FRAME, frame_number};
use pse::internal::program::Program;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The most frames of one run.
const MAX_FRAMES: usize = 1_000_000;

/// A frame as `--frame` gives it: `7`, `-3`, or between two frames `2.5`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct FrameArg(pub Frame);

impl FromStr for FrameArg {
    type Err = String;

    fn from_str(text: &str) -> Result<FrameArg, String> {
        if let Ok(number) = text.trim().parse::<i64>() {
            return number_within(number, text).map(|number| FrameArg(number.into()));
        }
        match text.trim().parse::<f64>() {
            Ok(value) if (value as f32).is_finite() && value.abs() <= MAX_FRAME as f64 => {
                Ok(FrameArg(value.into()))
            }
            _ if text.parse::<Frames>().is_ok() => {
                Err(format!("`{text}` is a list of frames; use --frames {text}"))
            }
            _ => Err(format!("`{text}` is not a frame; write a number like 7 or -3")),
        }
    }
}

/// A number that is not too large for a frame.
fn number_within(number: i64, text: &str) -> Result<i64, String> {
    match number.unsigned_abs() <= MAX_FRAME as u64 {
        true => Ok(number),
        false => Err(format!("`{}` is too large for a frame", text.trim())),
    }
}

/// Frame numbers in the order in which they are run: `1-24`, `1,5,9`, `-3-3`, `1-20x2`. Open Job Description writes
/// `1-20:2`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Frames(pub Vec<i64>);

impl FromStr for Frames {
    type Err = String;

    fn from_str(text: &str) -> Result<Frames, String> {
        const FORM: &str = "write 1-24, 1,5,9, -3-3 or 1-20x2";
        let number = |t: &str| match t.trim().parse::<i64>() {
            Ok(number) => number_within(number, t),
            Err(_) if t.trim().is_empty() => Err(format!("a number is missing in `{text}`; {FORM}")),
            Err(_) => Err(format!("`{}` is not a frame; {FORM}", t.trim())),
        };
        let mut frames = Vec::new();
        for part in text.split(',') {
            let (range, step) = match part.split_once(['x', ':']) {
                Some((range, step)) => (range, number(step)?),
                None => (part, 1),
            };
            // The first minus sign belongs to the number, the one behind its digits makes the range.
            let range = range.trim();
            let digits = range.strip_prefix('-').unwrap_or(range);
            let (first, last) = match digits.find('-') {
                Some(at) => {
                    let at = at + range.len() - digits.len();
                    (number(&range[..at])?, number(&range[at + 1..])?)
                }
                None => (number(range)?, number(range)?),
            };
            // A range that runs down may have its step with the sign, as Open Job Description has it.
            let step = if step < 0 && last < first { -step } else { step };
            if step <= 0 {
                return Err(format!("a step of {step} does not lead from {first} to {last}; {FORM}"));
            }
            let count = first.abs_diff(last) / step as u64 + 1;
            if count > (MAX_FRAMES - frames.len()) as u64 {
                return Err(format!("more than {MAX_FRAMES} frames"));
            }
            let step = if last < first { -step } else { step };
            frames.extend((0..count as i64).map(|i| first + i * step));
        }
        Ok(Frames(frames))
    }
}

/// Which frames a command runs, and how it knows.
pub(super) struct Chosen {
    /// At least one.
    pub frames: Vec<Frame>,
    /// The file whose name or header has the number, if no option gives one.
    pub source: Option<String>,
    /// That the files are of different frames, if they are and no option gives one.
    disagreement: Option<String>,
}

impl Chosen {
    /// What `--frames` or `--frame` gives, or else the number that the inputs have. Names that need the number of a frame
    /// are refused without one.
    pub fn new<'n>(
        list: Option<&Frames>,
        one: Option<FrameArg>,
        inputs: &[FrameSource<'n>],
        outputs: impl Iterator<Item = &'n str>,
    ) -> Result<Chosen, Failure> {
        if let Some(list) = list {
            let frames = list.0.iter().map(|&number| number.into()).collect();
            return Ok(Chosen { frames, source: None, disagreement: None });
        }
        let (frame, source) = given_or_found(one, inputs);
        let needs = inputs.iter().map(|input| input.path).filter(|path| is_sequence(path));
        let needs = needs.chain(outputs.filter(|name| has_pattern(name)));
        for name in needs {
            check_number(name, frame)?;
        }
        let disagreement = one.is_none().then(|| disagreement(&numbers_of(inputs))).flatten();
        Ok(Chosen { frames: vec![frame], source, disagreement })
    }

    /// What the user should know of the frames that a program reads: where the number comes from, and which number the
    /// program does not see as it is.
    pub fn notes(&self, program: &Program) -> Vec<String> {
        let read = program.resolved().globals.iter().any(|g| g.name == "frame" && g.read.is_some());
        let mut notes: Vec<String> = self.disagreement.iter().filter(|_| read).cloned().collect();
        if let (Some(source), [Frame { number: Some(number), .. }], true) =
            (&self.source, &self.frames[..], read)
        {
            notes.push(format!("using frame {number}, from `{source}`; --frame sets another"));
        }
        let rounded = |frame: &&Frame| frame.number.is_some_and(|number| number != frame.value as i64);
        if let Some(Frame { value, number: Some(number) }) = self.frames.iter().find(rounded).filter(|_| read)
        {
            notes.push(format!(
                "the program reads frame {number} as {value}: 32-bit floats do not hold every whole number above 16777216"
            ));
        }
        notes
    }
}

/// The frame that `--frame` gives, or else the inputs, and which of these says so; 0 without a number if none does.
pub(super) fn given_or_found(one: Option<FrameArg>, inputs: &[FrameSource<'_>]) -> (Frame, Option<String>) {
    match one {
        Some(FrameArg(frame)) => (frame, None),
        None => match numbers_of(inputs).as_slice() {
            // Files that disagree say nothing.
            [(number, name), others @ ..] if others.iter().all(|(other, _)| other == number) => {
                ((*number).into(), Some(name.clone()))
            }
            _ => Default::default(),
        },
    }
}

/// An input that may say which frame it is of.
#[derive(Clone, Copy, Debug)]
pub(super) struct FrameSource<'n> {
    /// The file.
    pub path: &'n str,
    /// Whether its variables have a name before them in the program, so that it stands beside the input proper.
    pub named: bool,
}

/// The numbers that the inputs have in their names or headers, and the files that they come from: those of the inputs
/// without a name, else of those with one.
fn numbers_of(inputs: &[FrameSource<'_>]) -> Vec<(i64, String)> {
    let files = |named: bool| {
        let files = inputs.iter().filter(move |input| input.named == named).map(|input| input.path);
        let files = files.filter(|path| *path != "-" && !is_sequence(path));
        files.filter_map(|path| Some((frame_number(Path::new(path))?, path.to_string())))
    };
    let mut numbers = [false, true].into_iter().map(|named| files(named).collect::<Vec<_>>());
    numbers.find(|numbers| !numbers.is_empty()).unwrap_or_default()
}

/// Two of the files that are of different frames.
fn disagreement(numbers: &[(i64, String)]) -> Option<String> {
    let (first, one) = numbers.first()?;
    let (second, other) = numbers.iter().find(|(number, _)| number != first)?;
    Some(format!(
        "`{one}` has frame {first} and `{other}` has frame {second}, so frame is 0. Set it with --frame"
    ))
}

/// Whether an input is another file in each frame: its name has a place for the number, and no file is called so.
pub(super) fn is_sequence(path: &str) -> bool {
    has_pattern(path) && !Path::new(path).exists()
}

/// The file of an input in a frame.
pub(super) fn input(path: &str, number: Option<i64>) -> PathBuf {
    match number {
        Some(number) if is_sequence(path) => fill(path, number).into(),
        _ => path.into(),
    }
}

/// Refuses a name that needs the number of a frame which has none.
pub(super) fn check_number(name: &str, frame: Frame) -> Result<(), Failure> {
    match frame {
        Frame { number: Some(_), .. } => Ok(()),
        Frame { value, .. } if value != 0.0 => {
            let message = format!("{name} takes a whole frame number, and the frame is {value}");
            Err(Failure::usage(message).hint("Give a whole number: --frame 1."))
        }
        _ => Err(Failure::usage(format!("{name} needs a frame number, and none is given"))
            .hint("Give it: --frame 1, or --frames 1-24 for a command that runs several.")),
    }
}

/// Refuses textures whose names need the number of a frame which has none: one message, whatever the program looks up.
pub(super) fn check_textures(program: &Program, frame: Frame) -> Result<(), Failure> {
    let mut textures = program.resolved().textures.iter().map(|(source, _)| source);
    match textures.find(|source| source.is_sequence()) {
        Some(source) => check_number(&format!("the texture `{}`", source.name), frame),
        None => Ok(()),
    }
}

/// The same numbers as a list of ranges, sorted and each once; `step` stands before the step of a range.
pub(super) fn ranges(frames: &[i64], step: &str) -> String {
    let mut sorted = frames.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    let mut parts = Vec::new();
    let mut rest = &sorted[..];
    while let [first, more @ ..] = rest {
        let by = more.first().map_or(1, |second| second - first);
        let run = 1 + rest.windows(2).take_while(|pair| pair[1] - pair[0] == by).count();
        // Two that do not follow each other are no range yet.
        let (part, taken) = match run {
            1 => (first.to_string(), 1),
            2 if by > 1 => (first.to_string(), 1),
            _ if by == 1 => (format!("{first}-{}", rest[run - 1]), run),
            _ => (format!("{first}-{}{step}{by}", rest[run - 1]), run),
        };
        parts.push(part);
        rest = &rest[taken..];
    }
    parts.join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_become_ranges() {
        let text = |frames: &[i64]| ranges(frames, "x");
        assert_eq!(text(&[3, 1, 2, 2]), "1-3");
        assert_eq!(text(&[1, 3, 5, 20]), "1-5x2,20");
        assert_eq!(text(&[1, 5, 9, 10, 11]), "1-9x4,10-11");
        assert_eq!(text(&[1, 5]), "1,5");
        assert_eq!(text(&[]), "");
        assert_eq!(text(&[-3, -2, -1, 0]), "-3-0");
        assert_eq!(text(&[-7, -5, -3]), "-7--3x2");
    }

    #[test]
    fn lists_ranges_and_steps() {
        let frames = |t: &str| t.parse::<Frames>().map(|f| f.0);
        assert_eq!(frames("1-4"), Ok(vec![1, 2, 3, 4]));
        assert_eq!(frames("1,5,9"), Ok(vec![1, 5, 9]));
        assert_eq!(frames("1-8x3,20"), Ok(vec![1, 4, 7, 20]));
        assert_eq!(frames("3-1"), Ok(vec![3, 2, 1]));
        assert_eq!(frames("1-8:3"), Ok(vec![1, 4, 7]));
        assert_eq!(frames("-3--1"), Ok(vec![-3, -2, -1]));
        assert_eq!(frames("-1-1"), Ok(vec![-1, 0, 1]));
        assert_eq!(frames("1--1"), Ok(vec![1, 0, -1]));
        assert_eq!(frames("-4"), Ok(vec![-4]));
        assert_eq!(frames("-9--1x4,7"), Ok(vec![-9, -5, -1, 7]));
        assert_eq!(frames("5-1:-2"), Ok(vec![5, 3, 1]));
        assert_eq!(frames("20240613-20240615"), Ok(vec![20_240_613, 20_240_614, 20_240_615]));
        let wrong = [
            "",
            "a",
            "1-",
            "1-3x0",
            "1-4000000000",
            "1,,2",
            "1-2-3",
            "--3",
            "-",
            "1-3x-1",
            "1.5",
            "1-3x",
            "-9999999999999999-9999999999999999",
            "99999999999999999999",
            "1e3",
        ];
        for text in wrong {
            assert!(frames(text).is_err(), "{text}");
        }
    }

    #[test]
    fn one_frame_is_exact() {
        let frame = |t: &str| t.parse::<FrameArg>().map(|f| f.0);
        assert_eq!(frame("20240613").unwrap().number, Some(20_240_613));
        assert_eq!(frame("99999999").unwrap().number, Some(99_999_999));
        assert_eq!(frame("-3").unwrap(), Frame { value: -3.0, number: Some(-3) });
        assert_eq!(frame("2.5").unwrap(), Frame { value: 2.5, number: None });
        assert_eq!(frame("3.0").unwrap().number, Some(3));
        assert!(frame("1-3").unwrap_err().contains("use --frames 1-3"));
        assert!(frame("1,5").unwrap_err().contains("use --frames 1,5"));
        for text in ["nan", "inf", "", "x", "1e30", "9999999999999999"] {
            assert!(frame(text).is_err(), "{text}");
        }
    }
}
