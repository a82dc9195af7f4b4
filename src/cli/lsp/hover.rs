//! What the word under the pointer means.

use super::connection::{Refusal, Server};
use gen_lsp_types::{Contents, Documentation, Hover, HoverParams, MarkupContent, MarkupKind};

/// Markdown as the protocol has it.
pub(super) fn markdown(value: String) -> MarkupContent {
    MarkupContent { kind: MarkupKind::Markdown, value }
}

/// The same as documentation; nothing if there is none.
pub(super) fn documentation(value: String) -> Option<Documentation> {
    (!value.is_empty()).then(|| Documentation::MarkupContent(markdown(value)))
}

pub(super) fn hover(server: &mut Server, params: HoverParams) -> Result<Option<Hover>, Refusal> {
    let asked = params.text_document_position_params;
    let Some((reading, offset)) = server.documents.at(&asked.text_document.uri, asked.position) else {
        return Ok(None);
    };
    Ok(reading.describe(offset).map(|described| Hover {
        range: Some(server.documents.lines(reading.text()).range(described.range)),
        contents: Contents::MarkupContent(markdown(described.text)),
    }))
}
