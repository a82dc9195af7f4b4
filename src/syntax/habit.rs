//! Habits from other languages: what was written, what to write here, and how to read on.
//!
//! Where the meaning is plain (`&` for `&&`, `elif` for `else if`) the tokens that were meant take the
//! place, so that the rest of the line is still checked.

use super::token::Token;
use crate::vocabulary;

/// What a habit is read as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meant {
    /// As these tokens, perhaps none.
    Tokens(&'static [Token]),
    /// Nobody can tell; the line is not looked at further.
    Unknown,
}

/// A fault that comes from another language or keyboard.
pub struct Habit {
    /// What is wrong.
    pub message: String,
    /// A word for the underlined place.
    pub label: &'static str,
    /// How to mend it.
    pub hint: String,
    /// How to read on.
    pub meant: Meant,
}

/// Where a token stands, as far as habits depend on it.
pub struct Place<'t> {
    /// It is the first of its line.
    pub first: bool,
    /// The token before it on the line ends an operand.
    pub after_operand: bool,
    /// The token before it is the `.` of a member.
    pub after_dot: bool,
    /// The next token, blanks skipped.
    pub next: Option<Token>,
    /// The text of the next token.
    pub next_text: &'t str,
    /// No bracket is open.
    pub outside: bool,
    /// The line starts with `for`.
    pub in_for: bool,
    /// The line starts with `if`, `while` or another word that takes a block.
    pub header: bool,
}

impl Place<'_> {
    /// Nothing but perhaps a comment follows on the line.
    fn last(&self) -> bool {
        matches!(self.next, None | Some(Token::Newline | Token::Comment))
    }
}

fn habit(message: impl Into<String>, hint: impl Into<String>, meant: Meant) -> Option<Habit> {
    Some(Habit { message: message.into(), label: "", hint: hint.into(), meant })
}

/// The habit that `token`, written as `text`, shows at `place`, if any.
pub fn find(token: Token, text: &str, place: &Place<'_>) -> Option<Habit> {
    use Meant::{Tokens, Unknown};
    match token {
        Token::Ampersand => {
            habit("a single `&` is not an operator", "Write `&&` for \"and\".", Tokens(&[Token::And]))
        }
        Token::Pipe => {
            habit("a single `|` is not an operator", "Write `||` for \"or\".", Tokens(&[Token::Or]))
        }
        Token::StarStar => {
            habit("`**` is not an operator", "Write `^` for a power: `x ^ 2`.", Tokens(&[Token::Pow]))
        }
        Token::SlashSlash => habit(
            "`//` is neither an operator nor a comment",
            "A comment starts with `#`; to divide and round down, write floor(a / b).",
            Tokens(&[Token::Div]),
        ),
        Token::SlashStar => {
            habit("`/*` does not start a comment", "Start every line of a comment with `#`.", Tokens(&[]))
        }
        Token::PlusPlus => habit(
            "there is no operator `++`",
            if place.last() && place.after_operand {
                "To count up, write `name += 1`."
            } else {
                "For a sum write one `+`."
            },
            Unknown,
        ),
        Token::EqEqEq => habit("`===` is not an operator", "Write `==` to compare.", Tokens(&[Token::Eq])),
        Token::NotEqEq => {
            habit("`!==` is not an operator", "Write `!=` for \"not equal\".", Tokens(&[Token::Ne]))
        }
        Token::LessGreater => {
            habit("`<>` is not an operator", "Write `!=` for \"not equal\".", Tokens(&[Token::Ne]))
        }
        Token::ColonAssign => {
            habit("`:=` is not an operator", "Write `=` to assign.", Tokens(&[Token::Assign]))
        }
        Token::AssignGreater => {
            habit("`=>` is not an operator", "Write `>=` for \"greater or equal\".", Tokens(&[Token::Ge]))
        }
        Token::AssignLess => {
            habit("`=<` is not an operator", "Write `<=` for \"less or equal\".", Tokens(&[Token::Le]))
        }
        Token::Ellipsis => {
            habit("a range has two dots, this has three", "Write `[1 .. 5]`.", Tokens(&[Token::Range]))
        }
        Token::Semicolon if place.outside => habit(
            "a statement does not end with `;`",
            "Remove it, and put each statement on its own line.",
            Tokens(if place.last() { &[] } else { &[Token::EndOfLine] }),
        ),
        Token::Semicolon if place.in_for => habit(
            "`for` loops over the elements of a vector",
            "Write `for i in [1 .. 10]`; to loop with a condition, use `while`.",
            Unknown,
        ),
        Token::Semicolon => habit(
            "`;` separates nothing",
            "Separate elements by spaces, and write rows as vectors of their own: `[[1 2] [3 4]]`.",
            Unknown,
        ),
        Token::OpenBrace | Token::CloseBrace => habit(
            "blocks are not written with `{` and `}`",
            "Indent the lines of the block, and remove the braces.",
            if place.outside { Tokens(&[]) } else { Unknown },
        ),
        Token::SingleQuoted => habit(
            "a string is written in double quotes",
            format!("Write \"{}\".", text.trim_matches('\'')),
            Tokens(&[Token::Text]),
        ),
        Token::Backslash => habit(
            "`\\` is not allowed here",
            "To continue an expression on the next line, put it in `( )`.",
            Unknown,
        ),
        Token::BadNumber => Some(bad_number(text)),
        Token::Unknown => Some(unknown(text, place)),
        Token::Name if !place.after_dot => word(text, place),
        Token::Colon if place.header && place.last() && place.outside => habit(
            "no colon before a block",
            "Remove the `:`; the indented lines below are the block.",
            Tokens(&[]),
        ),
        _ => None,
    }
}

/// Words that mean something elsewhere.
fn word(text: &str, place: &Place<'_>) -> Option<Habit> {
    use Meant::{Tokens, Unknown};
    let declares = matches!(place.next, Some(Token::Name));
    match text {
        "elif" | "elseif" | "elsif" if place.first => habit(
            format!("`{text}` is not a word of the language"),
            "Write `else if`.",
            Tokens(&[Token::Else, Token::If]),
        ),
        "def" | "fn" | "func" | "fun" | "proc" if place.first && declares => habit(
            format!("a function does not start with `{text}`"),
            "Write `function name(a, b)`.",
            Tokens(&[Token::Function]),
        ),
        "let" | "var" | "const" | "local" | "float" | "int" | "bool" | "double" | "vec2" | "vec3"
        | "vec4" | "vector" | "point" | "color"
            if place.first && declares =>
        {
            habit(
                "variables are not declared",
                format!("Remove `{text}`: the first assignment creates the variable."),
                Tokens(&[]),
            )
        }
        "and" => habit("`and` is not an operator", "Write `&&`.", Tokens(&[Token::And])),
        "or" => habit("`or` is not an operator", "Write `||`.", Tokens(&[Token::Or])),
        "not" => habit("`not` is not an operator", "Write `!`, as in `!a`.", Tokens(&[Token::Not])),
        "true" | "True" | "TRUE" => {
            habit(format!("there is no `{text}`"), "True is 1.", Tokens(&[Token::Number]))
        }
        "false" | "False" | "FALSE" => {
            habit(format!("there is no `{text}`"), "False is 0.", Tokens(&[Token::Number]))
        }
        "then" | "do" if place.header && place.last() => habit(
            format!("no `{text}` before a block"),
            format!("Remove `{text}`; the indented lines below are the block."),
            Tokens(&[]),
        ),
        "pass" if place.first && place.last() => {
            habit("there is no `pass`", "Remove the empty branch.", Tokens(&[Token::Number]))
        }
        "end" | "endif" | "fi" | "done" if place.first && place.last() => habit(
            format!("a block does not end with `{text}`"),
            "It ends where the indentation ends. Remove the line.",
            Tokens(&[]),
        ),
        "end" | "endif" | "fi" | "done" => None,
        "switch" | "case" | "foreach" | "until" | "loop" | "repeat" | "unless"
            if place.first && !place.last() && place.next.is_some_and(Token::starts_operand) && declares =>
        {
            habit(
                format!("there is no `{text}`"),
                "The blocks of the language are if, else if, else, while, for and function.",
                Unknown,
            )
        }
        _ => None,
    }
}

fn bad_number(text: &str) -> Habit {
    let digits = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (number, rest) = text.split_at(digits);
    let (message, hint) = match rest {
        "f" | "F" => (
            format!("a number has no suffix: `{text}`"),
            format!("Write `{number}`; every number is a float."),
        ),
        _ if text.starts_with("0x") || text.starts_with("0X") => {
            (format!("`{text}` is not a number"), "Numbers are decimal: `255`, `0.5`, `1e-3`.".to_string())
        }
        _ if rest.trim_matches(['e', 'E']).is_empty() => (
            format!("the exponent of `{text}` has no digits"),
            format!("Write `{number}{rest}3`, for example, or remove the `{rest}`."),
        ),
        _ => (
            format!("`{text}` is neither a number nor a name"),
            format!("To multiply, write `{number} * {rest}`; a name cannot start with a digit."),
        ),
    };
    Habit { message, label: "", hint, meant: Meant::Tokens(&[Token::Number]) }
}

/// A character that is in no token: typographic look-alikes get the plain character named.
fn unknown(text: &str, place: &Place<'_>) -> Habit {
    use Meant::{Tokens, Unknown};
    let first = text.chars().next().unwrap_or(' ');
    let looks: (&str, &'static [Token]) = match first {
        '×' | '·' | '∗' | '⋅' => ("*", &[Token::Mul]),
        '−' | '–' | '—' | '‐' | '‑' => ("-", &[Token::Sub]),
        '÷' | '∕' => ("/", &[Token::Div]),
        '≤' => ("<=", &[Token::Le]),
        '≥' => (">=", &[Token::Ge]),
        '≠' => ("!=", &[Token::Ne]),
        '¬' => ("!", &[Token::Not]),
        '∧' => ("&&", &[Token::And]),
        '∨' => ("||", &[Token::Or]),
        '…' => ("..", &[Token::Range]),
        '，' => (",", &[Token::Comma]),
        '（' => ("(", &[Token::OpenParen]),
        '）' => (")", &[Token::CloseParen]),
        _ => ("", &[]),
    };
    if !looks.0.is_empty() {
        return Habit {
            message: format!("`{first}` is not a character of the language"),
            label: "",
            hint: format!("Write `{}`.", looks.0),
            meant: Tokens(looks.1),
        };
    }
    let (message, hint, meant) = match first {
        '“' | '”' | '„' | '‘' | '’' | '«' | '»' | '`' | '\'' => (
            format!("`{first}` is not a quotation mark of the language"),
            "Write a string in plain double quotes: \"name\".".to_string(),
            if text.chars().count() > 1 { Tokens(&[Token::Text]) } else { Unknown },
        ),
        '\u{a0}' | '\u{2000}'..='\u{200b}' | '\u{202f}' | '\u{3000}' | '\u{feff}' => (
            format!("a character that only looks like a space (U+{:04X})", first as u32),
            "Replace it by a normal space.".to_string(),
            Tokens(&[]),
        ),
        '²' | '³' => (
            format!("`{first}` is not a character of the language"),
            format!("Write `^ {}`.", if first == '²' { 2 } else { 3 }),
            Unknown,
        ),
        'π' if text == "π" => {
            ("names are made of A-Z, a-z, 0-9 and `_`".into(), "Write `pi`.".into(), Tokens(&[Token::Name]))
        }
        '@' | '$' if place.next == Some(Token::Name) => (
            format!("`{first}` is not a character of the language"),
            match vocabulary::variable(place.next_text) {
                Some(instead) => instead.to_string(),
                None => "Write the name without it.".to_string(),
            },
            // `v@P` has the type before the mark.
            if place.after_operand { Unknown } else { Tokens(&[]) },
        ),
        '~' => (
            "`~` is not a character of the language".to_string(),
            "Write `!` for \"not\".".to_string(),
            Unknown,
        ),
        _ if text.chars().any(char::is_alphabetic) => (
            format!("`{text}` cannot be a name"),
            "Names are made of A-Z, a-z, 0-9 and `_`.".to_string(),
            Tokens(&[Token::Name]),
        ),
        c if c.is_control() => (
            format!("an invisible character (U+{:04X}) that is not part of the language", c as u32),
            "Delete it.".to_string(),
            Unknown,
        ),
        c => (
            format!("`{c}` is not a character of the language"),
            "Delete it, or put it into a comment.".to_string(),
            Unknown,
        ),
    };
    Habit { message, label: "", hint, meant }
}
