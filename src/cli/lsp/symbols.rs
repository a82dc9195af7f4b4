//! What a document consists of.

use super::connection::{Refusal, Server};
use gen_lsp_types::{DocumentSymbol, DocumentSymbolParams, DocumentSymbolResponse, SymbolKind};
use pse::internal::assist::Outlined;

pub(super) fn symbols(
    server: &mut Server,
    params: DocumentSymbolParams,
) -> Result<Option<DocumentSymbolResponse>, Refusal> {
    let Some(reading) = server.documents.reading(&params.text_document.uri.0) else { return Ok(None) };
    let lines = server.documents.lines(reading.text());
    // A field that no editor reads any more has to be filled in.
    #[allow(deprecated)]
    let symbols = reading.outline().into_iter().map(|entry| DocumentSymbol {
        kind: match entry.kind {
            Outlined::Function => SymbolKind::Function,
            Outlined::Param => SymbolKind::Property,
            Outlined::Output => SymbolKind::Variable,
        },
        detail: Some(entry.detail),
        tags: None,
        deprecated: None,
        range: lines.range(entry.whole),
        selection_range: lines.range(entry.place),
        children: None,
        name: entry.name,
    });
    Ok(Some(DocumentSymbolResponse::DocumentSymbolList(symbols.collect())))
}
