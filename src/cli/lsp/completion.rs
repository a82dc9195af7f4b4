//! What may come next, and what the call around it takes.

use super::connection::{Refusal, Server};
use super::hover::documentation;
use gen_lsp_types::{
    ActiveParameter, CompletionItem, CompletionItemKind, CompletionItemTextEdit, CompletionList,
    CompletionParams, CompletionResponse, InsertTextFormat, ParameterInformation, ParameterInformationLabel,
    Range, SignatureHelp, SignatureHelpParams, SignatureInformation, TextEdit,
};
use pse::internal::assist::{Item, Kind, card};

pub(super) fn complete(
    server: &mut Server,
    params: CompletionParams,
) -> Result<Option<CompletionResponse>, Refusal> {
    let asked = params.text_document_position_params;
    let Some((reading, offset)) = server.documents.at(&asked.text_document.uri, asked.position) else {
        return Ok(None);
    };
    let found = reading.complete(offset, &server.documents.host());
    let range = server.documents.lines(reading.text()).range(found.word);
    let bracket = reading.text()[offset..].starts_with('(');
    let snippets = server.snippets && !bracket;
    let items = found.items.into_iter().enumerate();
    let items = items.map(|(i, item)| converted(item, i, range, snippets)).collect();
    Ok(Some(CompletionResponse::CompletionList(CompletionList { items, ..CompletionList::default() })))
}

fn converted(item: Item, index: usize, range: Range, snippets: bool) -> CompletionItem {
    let snippet = snippets && item.kind == Kind::Function;
    let new_text = match item.kind {
        Kind::Function if snippet => format!("{}($0)", item.name),
        Kind::Argument => format!("{} = ", item.name),
        _ => item.name.clone(),
    };
    CompletionItem {
        kind: Some(match item.kind {
            Kind::Function => CompletionItemKind::Function,
            Kind::Variable => CompletionItemKind::Variable,
            Kind::Param | Kind::Argument => CompletionItemKind::Property,
            Kind::Constant => CompletionItemKind::Constant,
            Kind::Input => CompletionItemKind::Field,
            Kind::Keyword => CompletionItemKind::Keyword,
            Kind::Choice => CompletionItemKind::EnumMember,
        }),
        detail: Some(item.detail),
        documentation: documentation(item.documentation),
        // Editors sort by name if they are not told otherwise.
        sort_text: Some(format!("{index:04}")),
        insert_text_format: snippet.then_some(InsertTextFormat::Snippet),
        text_edit: Some(CompletionItemTextEdit::TextEdit(TextEdit { range, new_text })),
        label: item.name,
        ..CompletionItem::default()
    }
}

pub(super) fn signature(
    server: &mut Server,
    params: SignatureHelpParams,
) -> Result<Option<SignatureHelp>, Refusal> {
    let asked = params.text_document_position_params;
    let Some((reading, offset)) = server.documents.at(&asked.text_document.uri, asked.position) else {
        return Ok(None);
    };
    let Some((function, active)) = reading.call(offset) else { return Ok(None) };
    let label = function.entry.signature.clone();
    // The protocol counts here in UTF-16, whatever it counts columns in.
    let units = |bytes: usize| label[..bytes].encode_utf16().count() as u32;
    let parameters = function.params.iter().map(|param| ParameterInformation {
        label: ParameterInformationLabel::Tuple((units(param.place.start), units(param.place.end))),
        documentation: None,
    });
    // A parameter that there is not: none is active.
    let active = active.unwrap_or(function.params.len());
    Ok(Some(SignatureHelp {
        signatures: vec![SignatureInformation {
            parameters: Some(parameters.collect()),
            documentation: documentation(card(&function.entry)),
            active_parameter: None,
            label: label.clone(),
        }],
        active_signature: Some(0),
        active_parameter: Some(ActiveParameter::Int(active as u32)),
    }))
}
