//! Another name for something, in the document and in the open ones that import it.

use super::connection::{Refusal, Server};
use gen_lsp_types::{
    PrepareRenameParams, PrepareRenamePlaceholder, PrepareRenameResult, RenameParams, TextEdit, WorkspaceEdit,
};
use std::collections::HashMap;

pub(super) fn prepare(
    server: &mut Server,
    params: PrepareRenameParams,
) -> Result<Option<PrepareRenameResult>, Refusal> {
    let asked = params.text_document_position_params;
    let Some((reading, offset)) = server.documents.at(&asked.text_document.uri, asked.position) else {
        return Ok(None);
    };
    let Some((symbol, place)) = reading.symbol(offset) else { return Ok(None) };
    reading.may_rename(&symbol).map_err(Refusal)?;
    let range = server.documents.lines(reading.text()).range(place);
    let placeholder = symbol.name().to_string();
    Ok(Some(PrepareRenameResult::PrepareRenamePlaceholder(PrepareRenamePlaceholder { range, placeholder })))
}

pub(super) fn rename(server: &mut Server, params: RenameParams) -> Result<Option<WorkspaceEdit>, Refusal> {
    let asked = params.text_document_position_params;
    let uri = asked.text_document.uri;
    let found = server.documents.at(&uri, asked.position);
    let found = found.and_then(|(reading, offset)| Some((reading.symbol(offset)?.0, reading)));
    let Some((symbol, reading)) = found else { return Err(Refusal("There is no name here.".into())) };
    reading.may_rename(&symbol).map_err(Refusal)?;
    let mut changes = HashMap::new();
    for (uri, name, reading) in server.texts_with(&uri, &reading, &symbol) {
        let told = |why: String| Refusal(format!("{name}: {why}"));
        reading.may_rename(&symbol).map_err(told)?;
        let places =
            reading.rename(&symbol, &params.new_name, &name, &server.documents.host()).map_err(told)?;
        let lines = server.documents.lines(reading.text());
        let edit = |place| TextEdit { range: lines.range(place), new_text: params.new_name.clone() };
        changes.insert(uri, places.into_iter().map(edit).collect());
    }
    Ok(Some(WorkspaceEdit { changes: Some(changes), ..WorkspaceEdit::default() }))
}
