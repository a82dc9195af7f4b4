//! Errors and warnings, as `pse check` finds them.

use super::connection::{Server, tell};
use crate::cli::check;
use gen_lsp_types::{
    self as lsp, Code, DiagnosticRelatedInformation, DiagnosticSeverity, Location,
    PublishDiagnosticsNotification, PublishDiagnosticsParams, Uri,
};
use lsp_server::Notification;
use pse::internal::diagnostic::{Diagnostic, Severity, Sources, Span};
use pse::internal::program::Compiler;
use std::collections::{BTreeMap, BTreeSet};

/// What was found in a program, by the URI of the text that it is about.
pub(super) type Found = BTreeMap<String, Vec<lsp::Diagnostic>>;

impl Server {
    /// Checks one of the documents that wait for it. Gives what is to be told of it.
    pub fn check_next(&mut self) -> Vec<Notification> {
        let Some(uri) = self.unchecked.pop_first() else { return Vec::new() };
        let Some(document) = self.documents.open.get(&uri) else { return Vec::new() };
        let host = self.documents.host();
        let (diagnostics, sources) = match Compiler::new().host(&host).compile(&document.name, &document.text)
        {
            Ok(program) => (check::without_images(&program), program.sources().clone()),
            Err(error) => (error.diagnostics, error.sources),
        };
        let mut found = Found::new();
        for diagnostic in &diagnostics {
            let place = diagnostic.span().and_then(|span| self.location(&uri, span, &sources));
            let place =
                place.unwrap_or_else(|| Location { uri: Uri(uri.clone()), range: lsp::Range::default() });
            let converted = self.converted(&uri, diagnostic, place.range, &sources);
            found.entry(place.uri.0).or_default().push(converted);
        }
        self.publish(&uri, found)
    }

    /// Keeps what was found in a document, and tells it of all texts that are concerned.
    pub fn publish(&mut self, uri: &str, found: Found) -> Vec<Notification> {
        let mut concerned: BTreeSet<String> = found.keys().cloned().collect();
        concerned.insert(uri.to_string());
        if let Some(old) = self.found.insert(uri.to_string(), found) {
            concerned.extend(old.into_keys());
        }
        if !self.documents.open.contains_key(uri) {
            self.found.remove(uri);
        }
        let about = |text: String| {
            let mut diagnostics: Vec<lsp::Diagnostic> = Vec::new();
            // Several documents may import the faulty one.
            for diagnostic in self.found.values().filter_map(|found| found.get(&text)).flatten() {
                if !diagnostics.contains(diagnostic) {
                    diagnostics.push(diagnostic.clone());
                }
            }
            diagnostics.sort_by_key(|d| d.range.start);
            let version = self.documents.open.get(&text).map(|document| document.version);
            let params = PublishDiagnosticsParams { uri: Uri(text), version, diagnostics };
            tell::<PublishDiagnosticsNotification>(params)
        };
        concerned.into_iter().map(about).collect()
    }

    /// Where a span of the program of this document is. `None` for what is no file.
    fn location(&self, uri: &str, span: Span, sources: &Sources) -> Option<Location> {
        let source = sources.get(span.source);
        let uri = match span.source.0 {
            0 => Uri(uri.to_string()),
            _ => self.documents.uri(&source.name)?,
        };
        let range = self.documents.lines(&source.text).range(span.start as usize..span.end as usize);
        Some(Location { uri, range })
    }

    fn converted(
        &self,
        uri: &str,
        diagnostic: &Diagnostic,
        range: lsp::Range,
        sources: &Sources,
    ) -> lsp::Diagnostic {
        let mut message = diagnostic.message.clone();
        let mut labels = diagnostic.labels.iter();
        let first = labels.next().filter(|label| !label.text.is_empty());
        for line in first.map(|label| &label.text).into_iter().chain(&diagnostic.hints) {
            message += "\n";
            message += line;
        }
        let related = labels.filter_map(|label| {
            let location = self.location(uri, label.span, sources)?;
            let message = if label.text.is_empty() { "see also".to_string() } else { label.text.clone() };
            Some(DiagnosticRelatedInformation { location, message })
        });
        let related: Vec<_> = related.collect();
        lsp::Diagnostic {
            range,
            severity: Some(match diagnostic.severity {
                Severity::Error => DiagnosticSeverity::Error,
                Severity::Warning => DiagnosticSeverity::Warning,
            }),
            code: Some(Code::String(diagnostic.code.to_string())),
            source: Some("pse".to_string()),
            message: lsp::Message::String(message),
            related_information: (!related.is_empty()).then_some(related),
            ..lsp::Diagnostic::default()
        }
    }
}
