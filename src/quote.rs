//! Words for a shell: every command that is suggested to the user is made of these, so that pasting it runs the command
//! that is meant.

use crate::visible;
use std::path::Path;

/// The text as one word of a POSIX shell: as it is where that is safe, else in quotes.
///
/// Control characters, which a terminal would obey, are escaped as in `$'\x1b'` (bash, zsh, ksh, and POSIX since 2024).
pub fn word(text: &str) -> String {
    let safe = |c: char| c.is_alphanumeric() || "_-+=./,:@%#{}".contains(c);
    // `~` and `#` mean something at the start, `=` after a word that could be a variable, braces with commas or dots inside.
    let plain = text.chars().all(safe)
        && !text.is_empty()
        && !text.starts_with(['#', '=', '%'])
        && !(text.contains('{') && (text.contains(',') || text.contains("..")));
    if plain && text != "{" && text != "}" {
        return text.to_string();
    }
    if !text.contains(is_hidden) {
        return format!("'{}'", text.replace('\'', r"'\''"));
    }
    let mut out = String::from("$'");
    for c in text.chars() {
        match c {
            '\'' | '\\' => out.extend(['\\', c]),
            '\n' => out.push_str("\\n"),
            '\t' => out.push_str("\\t"),
            '\r' => out.push_str("\\r"),
            // By its bytes, always in two digits: shells do not agree on `\u`.
            c if is_hidden(c) => c.to_string().bytes().for_each(|b| out.push_str(&format!("\\x{b:02x}"))),
            c => out.push(c),
        }
    }
    out.push('\'');
    out
}

/// A path as one word, which no command takes for an option.
pub fn path(path: &Path) -> String {
    let text = path.to_string_lossy();
    if text.starts_with('-') { word(&format!("./{text}")) } else { word(&text) }
}

/// Characters that are shown otherwise than they are: what is printed would not be the word any more.
fn is_hidden(c: char) -> bool {
    c.is_control() || visible::is_hidden(c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn simple_words_stay() {
        for text in
            ["a.png", "/a/b-c_d.exr", "fire.####.png", "a,b", "x=1", "bg=a.exr", "{tile}.exr", "ü.png"]
        {
            assert_eq!(word(text), text);
        }
        assert_eq!(word("a b"), "'a b'");
        assert_eq!(word("it's"), r"'it'\''s'");
        assert_eq!(word("a\u{1b}[2J'\n"), r"$'a\x1b[2J\'\n'");
        assert_eq!(path(Path::new("-rf")), "./-rf");
    }

    /// What shells of this machine make of the words is the text again.
    #[cfg(unix)]
    #[test]
    fn shells_read_the_same_text() {
        let texts = [
            "",
            "a",
            "x';touch PWNED;'",
            "b$(touch PWNED)",
            "`id`",
            "a b",
            "$HOME",
            "~",
            "~root",
            "#a",
            "a#b",
            "*",
            "[a]",
            "{a,b}",
            "{1..3}",
            "a\\b",
            "\"",
            "!!",
            "a!b",
            "=ls",
            "a=b",
            "-n",
            "a\nb",
            "a\tb",
            "a\u{1b}[31mb'\\",
            "\u{202e}abc",
            "é ü",
            "%s",
            "a;b",
            "a&b",
            "a|b",
            "<a>",
            "(a)",
            "a\u{7f}0",
            "a\rb",
            "\u{85}1",
            "a\u{2028}b\u{61c}",
            "a\u{200b}b",
        ];
        for shell in ["sh", "bash", "zsh"] {
            for text in texts {
                let word = word(text);
                // A plain sh may be older than the escapes.
                if shell == "sh" && word.starts_with("$'") {
                    continue;
                }
                let mut command = std::process::Command::new(shell);
                let Ok(output) = command.args(["-c", &format!("printf '%s' {word}")]).output() else { break };
                assert_eq!(String::from_utf8_lossy(&output.stdout), text, "{shell}: {word}");
            }
        }
    }
}
