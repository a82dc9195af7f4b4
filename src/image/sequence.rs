//! The place of a frame's number in the names of files.

/// The first pattern in a name: where it is, and how many digits it wants. Patterns are `####`, `@@@@` (two or
/// more; `#` may also be one), `%d` and `%04d`.
fn pattern(name: &str) -> Option<(std::ops::Range<usize>, usize)> {
    let bytes = name.as_bytes();
    let mut i = 0;
    while i < bytes.len() {
        let c = bytes[i];
        if c == b'#' || c == b'@' {
            let run = bytes[i..].iter().take_while(|b| **b == c).count();
            if c == b'#' || run > 1 {
                return Some((i..i + run, run));
            }
            i += run;
            continue;
        }
        if c == b'%' {
            let digits = bytes[i + 1..].iter().take_while(|b| b.is_ascii_digit()).count();
            if bytes.get(i + 1 + digits) == Some(&b'd') {
                let width = name[i + 1..i + 1 + digits].parse().unwrap_or(1);
                return Some((i..i + digits + 2, usize::min(width, 20)));
            }
        }
        i += 1;
    }
    None
}

/// Has the name a place for the frame's number?
pub fn has_pattern(name: &str) -> bool {
    pattern(name).is_some()
}

/// The name with the frame's number in each such place.
pub fn fill(name: &str, frame: i64) -> String {
    let mut text = String::new();
    let mut rest = name;
    while let Some((range, width)) = pattern(rest) {
        text.push_str(&rest[..range.start]);
        text.push_str(&format!("{frame:0width$}"));
        rest = &rest[range.end..];
    }
    text + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_are_filled() {
        assert_eq!(fill("a.####.exr", 7), "a.0007.exr");
        assert_eq!(fill("a_%04d.exr", 12345), "a_12345.exr");
        assert_eq!(fill("a_%d@@.exr", 3), "a_303.exr");
        assert_eq!(fill("me@home 100%.exr", 3), "me@home 100%.exr");
        assert!(has_pattern("#.png") && !has_pattern("a@b%.png"));
    }
}
