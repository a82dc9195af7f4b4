//! The words of the language: text to tokens, each with its bytes.
//!
//! Nothing is thrown away here, neither blanks nor comments: inside `[ ]` blanks have a meaning, and the
//! formatter keeps comments. Words of other languages (`&`, `**`, `'text'`) are tokens too, so that
//! [`super::habit`] can say what to write instead.

use logos::Logos;

/// The kind of a token; its text is the source's bytes at its span.
#[derive(Logos, Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // the texts say it
pub enum Token {
    // Operands.
    #[regex(r"[0-9]+(\.[0-9]+)?([eE][+-]?[0-9]+)?", priority = 20)]
    #[regex(r"\.[0-9]+([eE][+-]?[0-9]+)?", priority = 20)]
    Number,
    #[regex(r"[A-Za-z_][A-Za-z0-9_]*", priority = 5)]
    Name,
    #[regex(r#""([^"\\\r\n]|\\[^\r\n])*""#)]
    Text,

    // Keywords.
    #[token("if", priority = 20)]
    If,
    #[token("else", priority = 20)]
    Else,
    #[token("while", priority = 20)]
    While,
    #[token("for", priority = 20)]
    For,
    #[token("in", priority = 20)]
    In,
    #[token("break", priority = 20)]
    Break,
    #[token("continue", priority = 20)]
    Continue,
    #[token("function", priority = 20)]
    Function,
    #[token("return", priority = 20)]
    Return,
    #[token("param", priority = 20)]
    Param,
    #[token("import", priority = 20)]
    Import,

    // Operators.
    #[token("=")]
    Assign,
    #[token("+=")]
    AddAssign,
    #[token("-=")]
    SubAssign,
    #[token("*=")]
    MulAssign,
    #[token("/=")]
    DivAssign,
    #[token("%=")]
    RemAssign,
    #[token("^=")]
    PowAssign,
    #[token("&&=")]
    AndAssign,
    #[token("||=")]
    OrAssign,
    #[token("?")]
    Question,
    #[token(":")]
    Colon,
    #[token("||")]
    Or,
    #[token("&&")]
    And,
    #[token("==")]
    Eq,
    #[token("!=")]
    Ne,
    #[token("<")]
    Lt,
    #[token("<=")]
    Le,
    #[token(">")]
    Gt,
    #[token(">=")]
    Ge,
    #[token("+")]
    Add,
    #[token("-")]
    Sub,
    #[token("*")]
    Mul,
    #[token("/")]
    Div,
    #[token("%")]
    Rem,
    #[token("^")]
    Pow,
    #[token("!")]
    Not,
    #[token(".")]
    Dot,
    #[token("..")]
    Range,
    #[token(",")]
    Comma,
    #[token("(")]
    OpenParen,
    #[token(")")]
    CloseParen,
    #[token("[")]
    OpenSquare,
    #[token("]")]
    CloseSquare,

    // Between the words.
    #[regex(r"[ \t]+")]
    Blank,
    #[regex(r"#[^\r\n]*", allow_greedy = true)]
    Comment,
    #[regex(r"\r\n|\n|\r")]
    Newline,

    // Words of other languages, and words that are cut off.
    #[regex(r"[0-9]+(\.[0-9]+)?[A-Za-z_][A-Za-z0-9_]*", priority = 10)]
    BadNumber,
    #[regex(r#""([^"\\\r\n]|\\[^\r\n])*\\?"#, priority = 1)]
    UnclosedText,
    #[regex(r"'[^'\r\n]*'")]
    SingleQuoted,
    #[token("&")]
    Ampersand,
    #[token("|")]
    Pipe,
    #[token(";")]
    Semicolon,
    #[token("{")]
    OpenBrace,
    #[token("}")]
    CloseBrace,
    #[token("**")]
    StarStar,
    #[token("//")]
    SlashSlash,
    #[token("/*")]
    SlashStar,
    #[token("++")]
    PlusPlus,
    #[token("===")]
    EqEqEq,
    #[token("!==")]
    NotEqEq,
    #[token(":=")]
    ColonAssign,
    #[token("<>")]
    LessGreater,
    #[token("=>")]
    AssignGreater,
    #[token("=<")]
    AssignLess,
    #[token("...")]
    Ellipsis,
    #[token("\\")]
    Backslash,
    /// A character that starts no token, or a run of letters beyond `A-Z`.
    Unknown,

    // Made by the layout pass.
    /// A logical line ends.
    EndOfLine,
    /// A block begins.
    Indent,
    /// A block ends.
    Dedent,
    /// A blank that separates two elements inside `[ ]`.
    Separator,
    /// A line with a fault that is already reported.
    Unreadable,
}

/// A token and its bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lexeme {
    /// Its kind.
    pub token: Token,
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

/// Cuts `text` into tokens; together they cover all of it, but for a byte order mark at the start.
pub fn lex(text: &str) -> Vec<Lexeme> {
    let skipped = if text.starts_with('\u{feff}') { '\u{feff}'.len_utf8() } else { 0 };
    let mut lexer = Token::lexer(&text[skipped..]);
    let mut list: Vec<Lexeme> = Vec::new();
    while let Some(result) = lexer.next() {
        let (start, end) = (lexer.span().start + skipped, lexer.span().end + skipped);
        let token = match result {
            Ok(token) => token,
            Err(()) => {
                if let Some(rest) = typographic_string(&text[start..]) {
                    lexer.bump(rest - (end - start));
                    list.push(Lexeme { token: Token::Unknown, start, end: start + rest });
                    continue;
                }
                let rest = letters(&text[end..]);
                let foreign = text[start..end].chars().all(char::is_alphabetic);
                if !foreign {
                    list.push(Lexeme { token: Token::Unknown, start, end });
                    continue;
                }
                // A word such as `größe` comes as pieces: put them together again.
                lexer.bump(rest);
                let start = match list.last() {
                    Some(l) if l.end == start && matches!(l.token, Token::Name | Token::Unknown) => {
                        let start = l.start;
                        list.pop();
                        start
                    }
                    _ => start,
                };
                list.push(Lexeme { token: Token::Unknown, start, end: end + rest });
                continue;
            }
        };
        if token == Token::SlashStar {
            // A comment in the way of C is one token, to its end.
            let rest = text[end..].find("*/").map_or(text.len() - end, |i| i + 2);
            lexer.bump(rest);
            list.push(Lexeme { token, start, end: end + rest });
            continue;
        }
        list.push(Lexeme { token, start, end });
    }
    list
}

/// How many bytes at the start of `text` are a string in typographic quotes.
fn typographic_string(text: &str) -> Option<usize> {
    let mut chars = text.char_indices();
    chars.next().filter(|(_, c)| matches!(c, '“' | '”' | '„' | '‘' | '’' | '«' | '»'))?;
    chars
        .take_while(|(_, c)| !matches!(c, '\n' | '\r'))
        .find(|(_, c)| matches!(c, '“' | '”' | '‘' | '’' | '«' | '»'))
        .map(|(i, c)| i + c.len_utf8())
}

/// How many bytes at the start of `text` are letters, digits or `_`.
fn letters(text: &str) -> usize {
    text.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(text.len())
}

impl Token {
    /// Whether an operand may end with it, so that an infix operator may follow.
    pub fn ends_operand(self) -> bool {
        use Token::*;
        matches!(self, Number | Name | Text | CloseParen | CloseSquare)
    }

    /// Whether an operand may start with it, leaving aside `-` and `!`.
    pub fn starts_operand(self) -> bool {
        use Token::*;
        matches!(self, Number | Name | Text | OpenParen | OpenSquare)
    }

    /// Whether it stands only between two operands (`-` does not).
    pub fn is_infix(self) -> bool {
        use Token::*;
        matches!(
            self,
            Question | Colon | Or | And | Eq | Ne | Lt | Le | Gt | Ge | Add | Mul | Div | Rem | Pow | Range
        )
    }

    /// `=`, `+=` and the like.
    pub fn is_assignment(self) -> bool {
        use Token::*;
        matches!(
            self,
            Assign
                | AddAssign
                | SubAssign
                | MulAssign
                | DivAssign
                | RemAssign
                | PowAssign
                | AndAssign
                | OrAssign
        )
    }

    /// Whether a line that starts with it needs a block.
    pub fn opens_block(self) -> bool {
        use Token::*;
        matches!(self, If | Else | While | For | Function)
    }

    /// Whether only a statement can start with it.
    pub fn starts_statement(self) -> bool {
        use Token::*;
        self.opens_block() || matches!(self, Break | Continue | Return | Param | Import)
    }

    /// Whether it is a word of the language, which cannot be a name.
    pub fn is_keyword(self) -> bool {
        self.starts_statement() || self == Token::In
    }

    /// Whether a line may end or a comment may start here.
    pub fn is_space(self) -> bool {
        matches!(self, Token::Blank | Token::Comment | Token::Newline)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds(text: &str) -> Vec<Token> {
        lex(text).into_iter().map(|l| l.token).filter(|t| *t != Token::Blank).collect()
    }

    #[test]
    fn numbers_and_ranges() {
        use Token::*;
        assert_eq!(kinds("1..5"), [Number, Range, Number]);
        assert_eq!(kinds("1 .. 5"), [Number, Range, Number]);
        assert_eq!(kinds("0.5 .5 1e-3 2E4 1e5"), [Number; 5]);
        assert_eq!(kinds("1...5"), [Number, Ellipsis, Number]);
        assert_eq!(kinds("1."), [Number, Dot]);
        assert_eq!(kinds("2x 1.5f 1e"), [BadNumber; 3]);
        assert_eq!(kinds("a.b a.5"), [Name, Dot, Name, Name, Number]);
    }

    #[test]
    fn keywords_are_whole_words() {
        use Token::*;
        assert_eq!(kinds("if iffy in index _in"), [If, Name, In, Name, Name]);
    }

    #[test]
    fn strings() {
        use Token::*;
        assert_eq!(kinds(r#""a" "a\"b" "\\""#), [Text; 3]);
        assert_eq!(kinds("\"abc\n"), [UnclosedText, Newline]);
        assert_eq!(kinds("\"abc\\"), [UnclosedText]);
        assert_eq!(kinds("\""), [UnclosedText]);
    }

    #[test]
    fn lines_and_marks() {
        use Token::*;
        assert_eq!(
            kinds("\u{feff}a\r\nb\rc # d\r\n"),
            [Name, Newline, Name, Newline, Name, Comment, Newline]
        );
        assert_eq!(kinds("größe × é"), [Unknown, Unknown, Unknown]);
        assert_eq!(kinds("a /* b\nc */ d /* e"), [Name, SlashStar, Name, SlashStar]);
    }

    #[test]
    fn tokens_cover_the_text() {
        let text = "a = “x” − 2x 'q' \"open\nb\u{0}\u{a0}c\\\r\n";
        let mut at = 0;
        for lexeme in lex(text) {
            assert_eq!(lexeme.start, at);
            at = lexeme.end;
        }
        assert_eq!(at, text.len());
    }
}
