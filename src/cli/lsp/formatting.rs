//! A document in its canonical form, as `pse fmt` prints it.

use super::connection::{Refusal, Server};
use gen_lsp_types::{DocumentFormattingParams, TextEdit};
use pse::internal::syntax;

pub(super) fn format(
    server: &mut Server,
    params: DocumentFormattingParams,
) -> Result<Option<Vec<TextEdit>>, Refusal> {
    let Some(document) = server.documents.open.get(&params.text_document.uri.0) else { return Ok(None) };
    let text = &document.text;
    // The errors are shown already.
    let Ok(mut formatted) = syntax::format(text) else { return Ok(Some(Vec::new())) };
    // Line ends are the editor's business.
    if text.find('\n').is_some_and(|i| text[..i].ends_with('\r')) {
        formatted = formatted.replace('\n', "\r\n");
    }
    if formatted == *text {
        return Ok(Some(Vec::new()));
    }
    // Whole lines that are the same at both ends stay, and the editor's marks in them.
    let head: usize = text
        .split_inclusive('\n')
        .zip(formatted.split_inclusive('\n'))
        .take_while(|(old, new)| old == new)
        .map(|(line, _)| line.len())
        .sum();
    let tail = |text: &str| -> Vec<String> {
        text[head..].split_inclusive('\n').rev().map(str::to_string).collect()
    };
    let tail: usize = tail(text)
        .iter()
        .zip(&tail(&formatted))
        .take_while(|(old, new)| old == new && old.ends_with('\n'))
        .map(|(line, _)| line.len())
        .sum();
    let range = server.documents.lines(text).range(head..text.len() - tail);
    let new_text = formatted[head..formatted.len() - tail].to_string();
    Ok(Some(vec![TextEdit { range, new_text }]))
}
