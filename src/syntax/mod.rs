//! Text to tree: tokens, lines and blocks, the grammar, and back to text again.
//!
//! [`parse()`] takes a whole text and gives a tree with every error that it found; it never fails and never panics.
//! On the way the text is cut into tokens (`token`), habits from other languages are recognised (`habit`), brackets
//! and the blanks inside them are settled (`line`), indentation becomes blocks (`layout`), and the grammar
//! builds the tree (`actions`). What did not fit is put into words (`error`).
//!
//! [`format()`] prints a text in its one canonical form; [`tree`] shows how it was understood.

mod actions;
pub mod ast;
mod dump;
mod error;
mod flat;
mod format;
mod habit;
mod hex;
mod layout;
mod line;
mod parse;
mod print;
mod token;
mod walk;
mod word;

pub use dump::tree;
pub use format::format;
pub use hex::color as web_color;
pub use layout::MAX_BLOCKS;
pub use line::{MAX_BRACKETS, MAX_DEPTH};
pub use parse::{MAX_ERRORS, MAX_TEXT, Parsed, check_name, is_incomplete, parse};
pub use token::{Lexeme, Token, lex};
pub use walk::{parameters, parse_expression, set_source, set_span, signature};

#[cfg(test)]
mod format_tests;
#[cfg(test)]
mod tests;
