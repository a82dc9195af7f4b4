//! Frame numbers: lists of them, and their places in file names.

pub(super) use crate::image::{fill, has_pattern};

use std::str::FromStr;

/// The most frames of one run.
const MAX_FRAMES: usize = 1_000_000;

/// Frame numbers in the order in which they are run: `1-24`, `1,5,9`, `1-20x2`. Open Job Description writes `1-20:2`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Frames(pub Vec<i64>);

impl FromStr for Frames {
    type Err = String;

    fn from_str(text: &str) -> Result<Frames, String> {
        const FORM: &str = "write 1-24, 1,5,9 or 1-20x2";
        let number = |t: &str| {
            t.trim().parse::<u32>().map(i64::from).map_err(|_| format!("`{t}` is no frame; {FORM}"))
        };
        let mut frames = Vec::new();
        for part in text.split(',') {
            let (range, step) = match part.split_once(['x', ':']) {
                Some((range, step)) => (range, number(step)?),
                None => (part, 1),
            };
            if step == 0 {
                return Err(format!("a step of 0 goes nowhere; {FORM}"));
            }
            let (first, last) = match range.split_once('-') {
                Some((first, last)) => (number(first)?, number(last)?),
                None => (number(range)?, number(range)?),
            };
            let count = (first.abs_diff(last) / step as u64 + 1) as usize;
            if frames.len().saturating_add(count) > MAX_FRAMES {
                return Err(format!("more than {MAX_FRAMES} frames"));
            }
            let step = if last < first { -step } else { step };
            frames.extend((0..count as i64).map(|i| first + i * step));
        }
        Ok(Frames(frames))
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
    }

    #[test]
    fn lists_ranges_and_steps() {
        let frames = |t: &str| t.parse::<Frames>().map(|f| f.0);
        assert_eq!(frames("1-4"), Ok(vec![1, 2, 3, 4]));
        assert_eq!(frames("1,5,9"), Ok(vec![1, 5, 9]));
        assert_eq!(frames("1-8x3,20"), Ok(vec![1, 4, 7, 20]));
        assert_eq!(frames("3-1"), Ok(vec![3, 2, 1]));
        assert_eq!(frames("1-8:3"), Ok(vec![1, 4, 7]));
        for text in ["", "a", "1-", "1-3x0", "1-4000000000", "1,,2", "1-2-3"] {
            assert!(frames(text).is_err(), "{text}");
        }
    }
}
