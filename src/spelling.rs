//! Which known name a misspelt one most likely means.
//!
//! A suggestion is a claim, so it has to be likely: words that only sound alike (`rand` and `tanh`, `P` and `pi`) are
//! no slips of each other. How many slips count depends on the length of the name, and the first letter is one that
//! people rarely get wrong.

/// The longest name that is compared letter by letter, in bytes. Nobody misspells a longer one by a slip or two.
const MAX_NAME: usize = 64;

/// The name out of `known` that `name` is a slip of, if there is one. A slip of case alone is the nearest.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if name.len() > MAX_NAME || name.is_empty() {
        return None;
    }
    let written = name.to_lowercase();
    let length = written.chars().count();
    let slips = |candidate: &&'a str| slips(&written, length, candidate);
    known
        .into_iter()
        .filter(|candidate| *candidate != name)
        .filter_map(|candidate| Some((slips(&candidate)?, candidate)))
        .min_by_key(|(slips, candidate)| (*slips, candidate.len().abs_diff(name.len()), *candidate))
        .map(|(_, candidate)| candidate)
}

/// How many slips lead from `written`, in small letters and of so many characters, to the candidate; `None` if there
/// are too many for one to be meant by the other.
fn slips(written: &str, length: usize, candidate: &str) -> Option<usize> {
    // A look at the length spares most comparisons: a program may have a great many names.
    if candidate.len() > MAX_NAME || candidate.len().abs_diff(written.len()) > 3 {
        return None;
    }
    let candidate = candidate.to_lowercase();
    if written == candidate {
        return Some(0);
    }
    let other = candidate.chars().count();
    let (shorter, longer) = (length.min(other), length.max(other));
    let same_first = written.chars().next() == candidate.chars().next();
    let swapped = || {
        let mut first = written.chars();
        let mut second = candidate.chars();
        let (a, b) = (first.next(), first.next());
        b.is_some() && (b, a) == (second.next(), second.next()) && first.as_str() == second.as_str()
    };
    let allowed = match (longer, same_first) {
        // Of two letters each one counts.
        (0..=2, _) => 0,
        // `sni` and `sqr` may be `sin` and `sqrt`; `sun` is another word.
        (3, true) if shorter < longer || is_transposition(written, &candidate) => 1,
        (3, _) => 0,
        (4..=5, true) => 1,
        (4..=5, false) => usize::from(swapped()),
        (6..=8, true) => 2,
        (9.., true) => 3,
        // The first letter was left out, doubled or hit beside.
        (6.., false) => 1,
    };
    if allowed == 0 {
        return None;
    }
    Some(strsim::osa_distance(written, &candidate)).filter(|distance| *distance <= allowed)
}

/// Whether two words of the same letters differ by the order of two neighbours.
fn is_transposition(a: &str, b: &str) -> bool {
    let sorted = |word: &str| {
        let mut letters: Vec<char> = word.chars().collect();
        letters.sort_unstable();
        letters
    };
    strsim::osa_distance(a, b) == 1 && sorted(a) == sorted(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_find_what_was_meant() {
        let known = [
            "normal",
            "point",
            "Noise",
            "norm",
            "x",
            "pi",
            "sin",
            "sqrt",
            "abs",
            "max",
            "min",
            "color",
            "smoothstep",
            "turbulence",
            "direction",
            "white",
            "clamp",
            "floor",
            "length",
            "gray",
            "pow",
            "frame",
        ];
        for (written, meant) in [
            ("nrmal", "normal"),
            ("Point", "point"),
            ("pont", "point"),
            ("ponit", "point"),
            ("opint", "point"),
            ("NOISE", "Noise"),
            ("niose", "Noise"),
            ("sni", "sin"),
            ("ssin", "sin"),
            ("sqr", "sqrt"),
            ("PI", "pi"),
            ("absx", "abs"),
            ("colour", "color"),
            ("colr", "color"),
            ("wite", "white"),
            ("clmap", "clamp"),
            ("flor", "floor"),
            ("smothstep", "smoothstep"),
            ("smooth_step", "smoothstep"),
            ("turbulance", "turbulence"),
            ("urbulence", "turbulence"),
            ("dirction", "direction"),
            ("lenght", "length"),
            ("grey", "gray"),
            ("powr", "pow"),
            ("X", "x"),
        ] {
            assert_eq!(nearest(written, known), Some(meant), "{written}");
        }
    }

    #[test]
    fn what_merely_sounds_alike_is_no_slip() {
        let known = [
            "pi", "tanh", "sum", "product", "clamp", "fire", "cosh", "sinh", "point", "pixel", "star", "sin",
            "step", "x", "max", "min", "mix", "exp", "gain", "rings", "curl", "table", "red", "blue",
            "green", "eye",
        ];
        for written in [
            "P", "N", "Z", "Ci", "Cs", "Os", "st", "s", "t", "u", "v", "E", "L", "ramp", "fit", "rand",
            "hash", "luma", "premult", "sun", "zebra", "q", "abc", "pos", "time", "lamp", "near", "far",
            "hit", "bed", "bump", "uvw", "id",
        ] {
            assert_eq!(nearest(written, known), None, "{written}");
        }
    }

    #[test]
    fn names_beyond_reason_are_not_compared() {
        let (long, other) = ("a".repeat(1 << 20), "a".repeat((1 << 20) - 1));
        assert_eq!(nearest(&long, [other.as_str()]), None);
        assert_eq!(nearest("point", [long.as_str(), "pont"]), Some("pont"));
        assert_eq!(nearest("", ["x"]), None);
    }
}
