//! Where a name comes from, and where else it stands.

use super::connection::{Refusal, Server};
use super::uri;
use gen_lsp_types::{
    Definition, DefinitionParams, DefinitionResponse, DocumentHighlight, DocumentHighlightKind,
    DocumentHighlightParams, Location, Range, ReferenceParams, Uri,
};
use pse::internal::assist::{Reading, Role, Symbol};
use pse::internal::host::clean;
use std::path::Path;
use std::sync::Arc;

pub(super) fn definition(
    server: &mut Server,
    params: DefinitionParams,
) -> Result<Option<DefinitionResponse>, Refusal> {
    let asked = params.text_document_position_params;
    let uri = asked.text_document.uri;
    let Some((reading, offset)) = server.documents.at(&uri, asked.position) else { return Ok(None) };
    let answer =
        |uri, range| Some(DefinitionResponse::Definition(Definition::Location(Location { uri, range })));
    let import =
        reading.imports().iter().find(|i| i.span.start as usize <= offset && offset <= i.span.end as usize);
    if let Some(import) = import {
        let file = import.file.and_then(|id| server.documents.uri(&reading.sources().get(id).name));
        return Ok(file.and_then(|uri| answer(uri, Range::default())));
    }
    let Some((symbol, _)) = reading.symbol(offset) else { return Ok(None) };
    let Some(span) = reading.definition(&symbol) else { return Ok(None) };
    let source = reading.sources().get(span.source);
    let home = if span.source.0 == 0 { Some(uri) } else { server.documents.uri(&source.name) };
    let range = server.documents.lines(&source.text).range(span.start as usize..span.end as usize);
    Ok(home.and_then(|uri| answer(uri, range)))
}

pub(super) fn references(
    server: &mut Server,
    params: ReferenceParams,
) -> Result<Option<Vec<Location>>, Refusal> {
    let asked = params.text_document_position_params;
    let uri = asked.text_document.uri;
    let Some((reading, offset)) = server.documents.at(&uri, asked.position) else { return Ok(None) };
    let Some((symbol, _)) = reading.symbol(offset) else { return Ok(None) };
    let mut list = Vec::new();
    for (uri, _, reading) in server.texts_with(&uri, &reading, &symbol) {
        let lines = server.documents.lines(reading.text());
        for (place, role) in reading.places(&symbol) {
            if params.context.include_declaration || role != Role::Define {
                list.push(Location { uri: uri.clone(), range: lines.range(place) });
            }
        }
    }
    Ok(Some(list))
}

pub(super) fn highlight(
    server: &mut Server,
    params: DocumentHighlightParams,
) -> Result<Option<Vec<DocumentHighlight>>, Refusal> {
    let asked = params.text_document_position_params;
    let Some((reading, offset)) = server.documents.at(&asked.text_document.uri, asked.position) else {
        return Ok(None);
    };
    let Some((symbol, _)) = reading.symbol(offset) else { return Ok(None) };
    let lines = server.documents.lines(reading.text());
    let places = reading.places(&symbol).map(|(place, role)| DocumentHighlight {
        range: lines.range(place),
        kind: Some(match role {
            Role::Define | Role::Write => DocumentHighlightKind::Write,
            Role::Read | Role::Call | Role::Argument => DocumentHighlightKind::Read,
        }),
    });
    Ok(Some(places.collect()))
}

impl Server {
    /// The texts in which a symbol of this document may stand: its own, that which defines it, and all open ones that
    /// import that. Each with its URI and its name.
    pub fn texts_with(
        &mut self,
        uri: &Uri,
        reading: &Arc<Reading>,
        symbol: &Symbol,
    ) -> Vec<(Uri, String, Arc<Reading>)> {
        let name = |server: &Server, uri: &Uri| server.documents.open.get(&uri.0).map(|d| d.name.clone());
        let own = (uri.clone(), name(self, uri).unwrap_or_default(), reading.clone());
        let Some(span) = reading.definition(symbol).filter(|_| reading.is_shared(symbol)) else {
            return vec![own];
        };
        let home = reading.sources().get(span.source);
        let home_path = clean(Path::new(&home.name));
        let home_uri = match span.source.0 {
            0 => uri.clone(),
            _ => self.documents.uri(&home.name).unwrap_or_else(|| uri::of(&home_path)),
        };
        let defined_there = |reading: &Reading| {
            let span = reading.definition(symbol);
            span.is_some_and(|span| clean(Path::new(&reading.sources().get(span.source).name)) == home_path)
        };
        let mut texts = Vec::new();
        if !self.documents.open.contains_key(&home_uri.0) {
            let closed = Reading::new(&home.name, &home.text, &self.documents.host());
            texts.push((home_uri, home.name.clone(), Arc::new(closed)));
        }
        let open: Vec<(String, String)> =
            self.documents.open.iter().map(|(uri, d)| (uri.clone(), d.name.clone())).collect();
        for (other, name) in open {
            if let Some(reading) = self.documents.reading(&other).filter(|r| defined_there(r)) {
                texts.push((Uri(other), name, reading));
            }
        }
        texts
    }
}
