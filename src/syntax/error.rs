//! The parser's faults in words: what was found, what was expected, how to mend it.
//!
//! A generated parser knows the token that did not fit and a list of terminals that would have. Both say little to
//! someone who forgot a bracket, so the message is made from the line around the token.

use super::actions::Fault;
use super::layout::Spanned;
use super::token::Token;
use crate::diagnostic::{Diagnostic, SourceId, Span};

/// Turns a fault into a diagnostic; `tokens` is what the parser read.
pub fn explain(fault: Fault, source: SourceId, text: &str, tokens: &[Spanned]) -> Diagnostic {
    let (start, end, found, expected) = match fault {
        Fault::Found(diagnostic) => return diagnostic,
        Fault::Unexpected { start, end, found, expected } => (start, end, found, expected),
    };
    let at = tokens.partition_point(|t| t.0 < start);
    // Tokens without width share their start with the next one.
    let at = (at..tokens.len()).find(|&i| Some(tokens[i].1) == found).unwrap_or(at.min(tokens.len()));
    let first = tokens[..at].iter().rposition(|t| is_line_start(t.1)).map_or(0, |i| i + 1);
    let last = tokens[at..].iter().position(|t| t.1 == Token::EndOfLine).map_or(tokens.len(), |i| at + i);
    let scene = Scene {
        source,
        text,
        line: &tokens[first..last.max(first)],
        at: at - first,
        found: found.unwrap_or(Token::EndOfLine),
        expected,
    };
    let (end, found) = if scene.found == Token::EndOfLine {
        (start, "the end of the line".to_string())
    } else {
        (end, scene.describe(scene.found, &text[start..end.max(start)]))
    };
    let said = scene.say(&found);
    let mut span = Span::new(source, start, end);
    if scene.found == Token::Separator {
        span = Span::new(source, start, scene.line.get(scene.at + 1).map_or(end, |t| t.2));
    }
    let span = said.place.unwrap_or(span);
    let mut error = Diagnostic::error("syntax", said.message, span);
    if !said.label.is_empty() {
        error = error.label(span, said.label);
    }
    for hint in said.hints {
        error = error.hint(hint);
    }
    error
}

fn is_line_start(token: Token) -> bool {
    matches!(token, Token::EndOfLine | Token::Indent | Token::Dedent)
}

/// The line with the fault.
struct Scene<'a> {
    source: SourceId,
    text: &'a str,
    /// The tokens of the line, without its end.
    line: &'a [Spanned],
    /// Which of them did not fit; the line's length for its end.
    at: usize,
    found: Token,
    expected: Vec<String>,
}

/// What to say.
#[derive(Default)]
struct Said {
    message: String,
    label: String,
    hints: Vec<String>,
    /// The place to show, if it is not the token that did not fit.
    place: Option<Span>,
}

fn said(message: impl Into<String>, hint: impl Into<String>) -> Said {
    Said { message: message.into(), hints: vec![hint.into()], ..Said::default() }
}

impl Said {
    fn label(mut self, label: impl Into<String>) -> Said {
        self.label = label.into();
        self
    }
}

impl<'a> Scene<'a> {
    fn word(&self, token: &Spanned) -> &'a str {
        &self.text[token.0..token.2]
    }

    fn before(&self) -> Option<&Spanned> {
        self.at.checked_sub(1).and_then(|i| self.line.get(i))
    }

    fn first(&self) -> Option<Token> {
        self.line.first().map(|t| t.1)
    }

    /// The innermost bracket that is open before the fault.
    fn open(&self) -> Option<&Spanned> {
        let mut open = Vec::new();
        for token in &self.line[..self.at.min(self.line.len())] {
            match token.1 {
                Token::OpenParen | Token::OpenSquare => open.push(token),
                Token::CloseParen | Token::CloseSquare => {
                    open.pop();
                }
                _ => {}
            }
        }
        open.pop()
    }

    fn describe(&self, token: Token, word: &str) -> String {
        let short = if word.len() > 24 || word.contains(['\n', '\r']) { "…" } else { word };
        match token {
            Token::Number => format!("the number `{short}`"),
            Token::Name => format!("the name `{short}`"),
            Token::Text => format!("the string {short}"),
            Token::EndOfLine => "the end of the line".into(),
            Token::Separator => "another element".into(),
            _ => format!("`{short}`"),
        }
    }

    /// The statement's form, for a line that starts with a keyword.
    fn form(&self) -> Option<&'static str> {
        Some(match self.first()? {
            Token::If => "if condition",
            Token::Else if self.line.get(1).is_some_and(|t| t.1 == Token::If) => "else if condition",
            Token::Else => "else",
            Token::While => "while condition",
            Token::For => "for name in vector",
            Token::Function => "function name(a, b, c = 1)",
            Token::Return => "return value",
            Token::Param => "param name = value in [low high]",
            Token::Import => "import \"file.pse\"",
            Token::Break => "break",
            Token::Continue => "continue",
            _ => return None,
        })
    }

    fn form_hint(&self) -> Vec<String> {
        self.form().map(|f| format!("The form is `{f}`.")).into_iter().collect()
    }

    fn expects(&self, terminal: &str) -> bool {
        self.expected.iter().any(|e| e.trim_matches('"') == terminal)
    }

    fn say(&self, found: &str) -> Said {
        let before = self.before().copied();
        let after_operand = before.is_some_and(|t| t.1.ends_operand());
        self.head(found).or_else(|| self.by_token(found, after_operand)).unwrap_or_else(|| match before {
            Some(before) if after_operand => self.two_operands(found, before),
            _ => self.no_operand(found, before),
        })
    }

    /// The parts of a statement that stand before any expression.
    fn head(&self, found: &str) -> Option<Said> {
        let hints = self.form_hint();
        let make = |message: String| Some(Said { message, hints: hints.clone(), ..Said::default() });
        if self.found == Token::Assign && self.at == 1 && self.first()?.is_keyword() {
            let word = self.word(&self.line[0]);
            return Some(Said {
                place: Some(Span::new(self.source, self.line[0].0, self.line[0].2)),
                ..said(format!("`{word}` is a word of the language"), "Give the variable another name.")
            });
        }
        match (self.first()?, self.at) {
            (Token::For, 1) if self.found == Token::OpenParen => Some(said(
                "`for` has no brackets",
                "Write `for i in [1 .. 10]`; to loop with a condition, use `while`.",
            )),
            (Token::For, 1) | (Token::Function, 1) | (Token::Param, 1) => {
                make(format!("a name is expected here, and {found} was found"))
            }
            (Token::For, 2) => make(format!("`in` is expected here, and {found} was found")),
            (Token::Function, 2) => make(format!("`(` is expected here, and {found} was found")),
            (Token::Param, 2) => make(format!("`=` and a value are expected here, and {found} was found")),
            (Token::Import, 1) => {
                make(format!("a file name in quotes is expected here, and {found} was found"))
            }
            (Token::Break | Token::Continue, 1) => make(format!(
                "`{}` must be alone on its line, and {found} was found",
                self.word(&self.line[0])
            )),
            (Token::Else, 1) => Some(said(
                format!("{found} cannot follow `else`"),
                "With a condition, write `else if condition`.",
            )),
            (Token::Function, n) if self.open().is_some() && n > 2 && self.found != Token::Assign => {
                let in_default = self.line[..n].iter().rev().take_while(|t| t.1 != Token::Comma);
                if in_default.into_iter().any(|t| t.1 == Token::Assign) {
                    return None;
                }
                match self.before()?.1 {
                    Token::Name => make(format!("`,` or `)` is expected here, and {found} was found")),
                    _ => make(format!("the name of a parameter is expected here, and {found} was found")),
                }
            }
            _ => None,
        }
    }

    /// Tokens that have their own story.
    fn by_token(&self, found: &str, after_operand: bool) -> Option<Said> {
        let header = self.first().is_some_and(|t| t.opens_block() || t == Token::Return);
        let open = self.open();
        match self.found {
            Token::Assign if header || open.is_some() => Some(if self.argument_name_with_path() {
                said("an argument's name is a single name", "Write `f(v, name = value)`.")
            } else {
                said("`=` assigns, and cannot be used in an expression", "Use `==` to compare.")
                    .label("`==`?")
            }),
            Token::Assign => Some(said(
                "a line can have only one `=`",
                "Assign on two lines: `b = 1`, then `a = b`. To compare, use `==`.",
            )),
            token if token.is_assignment() => Some(said(
                format!("{found} cannot be used in an expression"),
                "It changes a variable, as a statement on a line of its own.",
            )),
            Token::Colon if header && open.is_none() => Some(said(
                "no colon, and no statement, after a condition",
                "End the line here, and put the block on the lines below, indented.",
            )),
            Token::Colon => Some(said(
                "this `:` has no `?`",
                "Write a choice as `condition ? value : other`; a range `[1 .. 5]`.",
            )),
            Token::Range if self.line.iter().take(self.at).any(|t| t.1 == Token::Range) => Some(said(
                "a range has two ends, and no step",
                "Write `[1 .. 5]`, or `2*[1 .. 5]` for steps of 2.",
            )),
            Token::Range => Some(said("a range is only allowed inside `[ ]`", "Write `[1 .. 5]`.")),
            Token::Comma if open.is_none() && after_operand => Some(said(
                "`,` is only allowed between arguments or elements",
                if self.line.iter().take(self.at).any(|t| t.1 == Token::Assign) {
                    "Write a vector in `[ ]`: `a = [1 2]`."
                } else {
                    "Assign one variable on each line."
                },
            )),
            Token::Add if !after_operand => {
                Some(said("an expression is expected here, and `+` was found", "Remove the `+`."))
            }
            Token::If if self.at > 0 => Some(said(
                "`if` starts a statement, and cannot be used in an expression",
                "To choose between two values write `condition ? value : other`.",
            )),
            token if token.starts_statement() && self.at > 0 => {
                let mut answer = said(
                    format!("{found} starts a statement, and cannot be used here"),
                    "Put the statement on a line of its own.",
                );
                if self.line.get(self.at + 1).is_none_or(|t| !t.1.starts_operand()) {
                    answer.hints =
                        vec![format!("{found} is a word of the language. Give the variable another name.")];
                }
                Some(answer)
            }
            Token::In | Token::EndOfLine if self.missing_colon() => {
                Some(said("this `?` has no `:`", "Write a choice as `condition ? value : other`."))
            }
            Token::CloseParen | Token::CloseSquare | Token::Comma | Token::Separator
                if self.missing_colon() =>
            {
                Some(said(
                    format!("`:` is expected here, and {found} was found"),
                    "Write a choice as `condition ? value : other`.",
                ))
            }
            Token::In if self.at == 0 => Some(said(
                "`in` is a word of the language",
                "Give the variable another name; to loop over a vector, write `for name in vector`.",
            )),
            Token::In => Some(said(
                "`in` is a word of `for` and `param`, not an operator",
                "To loop over a vector, write `for name in vector`.",
            )),
            Token::Not if after_operand => {
                Some(said("`!` must come before its operand", "For \"not equal\" write `!=`."))
            }
            _ => None,
        }
    }

    /// `f(a.b = 1)`.
    fn argument_name_with_path(&self) -> bool {
        let called = self.open().is_some_and(|t| t.1 == Token::OpenParen)
            && self.line[..self.at].iter().any(|t| t.1 == Token::Dot);
        called && self.at >= 3 && self.line[self.at - 2].1 == Token::Dot
    }

    fn missing_colon(&self) -> bool {
        self.expects(":") && self.line[..self.at.min(self.line.len())].iter().any(|t| t.1 == Token::Question)
    }

    /// An operand, or a closing bracket, where an operator should be.
    fn two_operands(&self, found: &str, before: Spanned) -> Said {
        let word = self.word(&before);
        let wanted = match self.open().map(|t| t.1) {
            Some(Token::OpenSquare) => "an operator or `]`",
            Some(_) if self.expects(",") => "an operator, `,` or `)`",
            Some(_) => "an operator or `)`",
            None => "an operator or the end of the line",
        };
        let mut answer =
            Said { message: format!("{wanted} is expected here, and {found} was found"), ..Said::default() };
        let here = self.line.get(self.at);
        // The first word may be a keyword with a slip in it.
        if self.at == 1 && before.1 == Token::Name {
            if let Some(keyword) = nearest_keyword(word) {
                answer.message = format!("`{word}` does not start a statement");
                answer.place = Some(Span::new(self.source, before.0, before.2));
                answer.hints.push(format!("Did you mean `{keyword}`?"));
                return answer;
            }
            if self.line.get(2).is_some_and(|t| t.1 == Token::Assign) {
                answer.hints.push(
                    "Variables are not declared: start the line with the name of the variable.".to_string(),
                );
                return answer;
            }
            answer.hints.push(format!("To call a function, write `{word}(…)`."));
            return answer;
        }
        match (before.1, self.found, here) {
            (_, Token::Number, Some(number)) if number.0 == before.2 => {
                answer.hints.push(format!("The first component is `{word}[1]`, or `{word}.x`."));
            }
            (_, Token::Comma, _) => {
                answer.hints.push("Write a vector in `[ ]`: `[1 2]`.".to_string());
            }
            (_, Token::Number | Token::Name | Token::Text | Token::OpenSquare, _)
                if self.open().is_some_and(|t| t.1 == Token::OpenParen) && self.expects(",") =>
            {
                answer.hints.push("Arguments are separated by `,`.".to_string());
            }
            (Token::Name, Token::Name | Token::Number | Token::Text, Some(_)) => {
                let operand = self.operand(self.at);
                answer.hints.push(format!("Write a call with brackets: `{word}({operand})`."));
                if self.found != Token::Text {
                    answer.hints.push(format!("Put an operator between two values: `{word} * {operand}`."));
                }
            }
            (Token::Number, Token::Name, Some(name)) | (Token::CloseParen, Token::Name, Some(name)) => {
                answer.hints.push(format!("To multiply, write `… * {}`.", self.word(name)));
            }
            (_, Token::Number | Token::Name | Token::Separator, _) if self.open().is_none() => {
                answer.hints.push("Write a vector in `[ ]`: `[1 0 0]`.".to_string());
            }
            _ => {}
        }
        answer
    }

    /// The operand that begins with a token, as far as it is written without blanks and operators: `point.x`.
    fn operand(&self, from: usize) -> &'a str {
        let follows =
            |pair: &&[Spanned]| pair[0].2 == pair[1].0 && matches!(pair[1].1, Token::Dot | Token::Name);
        let more = self.line[from..].windows(2).take_while(follows).count();
        &self.text[self.line[from].0..self.line[from + more].2]
    }

    /// No operand where one should be.
    fn no_operand(&self, found: &str, before: Option<Spanned>) -> Said {
        let mut answer = Said {
            message: format!("an expression is expected here, and {found} was found"),
            hints: self.form_hint(),
            ..Said::default()
        };
        let Some(before) = before else {
            answer.message = format!("a line cannot start with {found}");
            return answer;
        };
        let word = self.word(&before);
        match (before.1, self.found) {
            (Token::OpenParen, Token::CloseParen) => {
                answer.message = "these brackets are empty".to_string();
                answer.hints = vec!["Put an expression between them.".to_string()];
            }
            (_, Token::EndOfLine) if self.at == 1 && self.form().is_some() => {
                let what = match before.1 {
                    Token::Return => "value",
                    _ => "condition",
                };
                answer.message = format!("the {what} is missing after `{word}`");
            }
            (Token::Assign, Token::EndOfLine) => {
                answer.message = "the value is missing after `=`".to_string();
            }
            (Token::OpenParen | Token::OpenSquare, Token::Comma) => {
                answer.hints = vec!["Delete the `,`, or put something before it.".to_string()];
            }
            (Token::Comma, Token::Comma) => {
                answer.message = "something is missing between these commas".to_string();
                answer.hints = vec!["Delete one of them.".to_string()];
            }
            (_, token) if token.is_infix() || before.1.is_infix() || before.1 == Token::Sub => {
                answer.message = format!("an expression is expected after `{word}`, and {found} was found");
                if answer.hints.is_empty() {
                    answer.hints.push("Put an operator between two values.".to_string());
                }
            }
            _ => {}
        }
        answer
    }
}

/// The keyword that starts statements and differs from `word` by a slip.
fn nearest_keyword(word: &str) -> Option<&'static str> {
    const KEYWORDS: [&str; 9] =
        ["if", "else", "while", "for", "function", "return", "param", "import", "continue"];
    let lower = word.to_lowercase();
    KEYWORDS
        .into_iter()
        .map(|k| (strsim::osa_distance(&lower, k), k))
        .filter(|(d, k)| *d <= if k.len() > 4 { 2 } else { 1 } && (k.len() > 2 || lower.starts_with('i')))
        .min()
        .map(|(_, k)| k)
}
