//! The conversation with the editor: from its first message to its last.

use super::documents::Documents;
use super::position::Encoding;
use super::{completion, diagnostics, formatting, hover, navigation, rename, symbols, uri};
use gen_lsp_types::{
    self as lsp, CompletionOptions, InitializeParams, InitializeResult, RenameOptions, Save,
    ServerCapabilities, ServerInfo, SignatureHelpOptions, TextDocumentSync, TextDocumentSyncKind,
    TextDocumentSyncOptions,
};
use lsp_server::{Connection, ErrorCode, Message, Notification, Request, RequestId, Response};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::time::Duration;

/// Nothing came for so long: there is time to check what was typed.
const QUIET: Duration = Duration::from_millis(30);

/// Why a request was not granted, as a sentence.
pub(super) struct Refusal(pub String);

/// What the server knows.
#[derive(Default)]
pub(super) struct Server {
    /// The texts.
    pub documents: Documents,
    /// What was last found in each open document, by the URI of the text that it is about.
    pub found: BTreeMap<String, diagnostics::Found>,
    /// The open documents that have to be checked again.
    pub unchecked: BTreeSet<String>,
    /// Does the editor understand places to fill in, in what it inserts?
    pub snippets: bool,
}

/// How far the conversation is.
#[derive(PartialEq)]
enum Stage {
    /// Before `initialize`.
    New,
    /// In between.
    Ready,
    /// After `shutdown`.
    Over,
}

/// Answers until `exit` or the end of the input; true if the editor had said `shutdown` before.
pub(super) fn serve(connection: &Connection, path: Vec<PathBuf>) -> bool {
    let mut server = Server::default();
    server.documents.path = path;
    let mut stage = Stage::New;
    loop {
        let message = match server.unchecked.is_empty() {
            true => connection.receiver.recv().ok(),
            false => match connection.receiver.recv_timeout(QUIET) {
                Ok(message) => Some(message),
                Err(e) if e.is_timeout() => {
                    for message in guarded(|| server.check_next()).unwrap_or_default() {
                        let _ = connection.sender.send(message.into());
                    }
                    continue;
                }
                Err(_) => None,
            },
        };
        match message {
            // Nobody is there any more.
            None => return false,
            Some(Message::Notification(note)) if note.method == "exit" => return stage == Stage::Over,
            Some(Message::Notification(note)) if stage == Stage::Ready => {
                for message in guarded(|| server.note(note)).unwrap_or_default() {
                    let _ = connection.sender.send(message.into());
                }
            }
            Some(Message::Request(request)) => {
                let response = server.request(request, &mut stage);
                // An editor that went away is noticed when its next message does not come.
                let _ = connection.sender.send(response.into());
            }
            Some(Message::Notification(_) | Message::Response(_)) => {}
        }
    }
}

/// A fault of the server is no reason to leave the editor alone; it is told on standard error.
fn guarded<T>(work: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(work)).ok()
}

impl Server {
    fn request(&mut self, request: Request, stage: &mut Stage) -> Response {
        let refuse = |id: &RequestId, code: ErrorCode, why: &str| {
            Response::new_err(id.clone(), code as i32, why.into())
        };
        let id = request.id.clone();
        match (&stage, request.method.as_str()) {
            (Stage::New, "initialize") => match serde_json::from_value::<InitializeParams>(request.params) {
                Ok(params) => {
                    *stage = Stage::Ready;
                    Response::new_ok(id, self.initialize(&params))
                }
                Err(e) => refuse(&id, ErrorCode::InvalidParams, &e.to_string()),
            },
            (Stage::New, _) => refuse(&id, ErrorCode::ServerNotInitialized, "send initialize first"),
            (Stage::Ready, "initialize") => {
                refuse(&id, ErrorCode::InvalidRequest, "initialize was already sent")
            }
            (Stage::Ready, "shutdown") => {
                *stage = Stage::Over;
                Response::new_ok(id, Value::Null)
            }
            (Stage::Over, _) => refuse(&id, ErrorCode::InvalidRequest, "only exit can come after shutdown"),
            (Stage::Ready, _) => guarded(|| self.answer(request)).unwrap_or_else(|| {
                refuse(&id, ErrorCode::InternalError, "internal error of pse; please report it")
            }),
        }
    }

    fn initialize(&mut self, params: &InitializeParams) -> InitializeResult {
        let general = params.capabilities.general.as_ref();
        let encoding = Encoding::best(general.and_then(|g| g.position_encodings.as_deref()));
        self.documents.encoding = encoding;
        let completion = params.capabilities.text_document.as_ref().and_then(|t| t.completion.as_ref());
        let item = completion.and_then(|c| c.completion_item.as_ref());
        self.snippets = item.and_then(|i| i.snippet_support) == Some(true);
        let folder = match &params.workspace_folders_initialize_params.workspace_folders {
            Some(lsp::WorkspaceFolders::WorkspaceFolderList(list)) => list.first().map(|f| f.uri.clone()),
            _ => None,
        };
        // Older editors have one folder alone.
        #[allow(deprecated)]
        let folder = folder.or_else(|| params.root_uri.clone());
        self.documents.root = folder.as_ref().and_then(uri::path);
        let characters = |list: &[&str]| Some(list.iter().map(|c| c.to_string()).collect());
        InitializeResult {
            capabilities: ServerCapabilities {
                position_encoding: Some(encoding.kind()),
                text_document_sync: Some(TextDocumentSync::Options(TextDocumentSyncOptions {
                    open_close: Some(true),
                    change: Some(TextDocumentSyncKind::Incremental),
                    save: Some(Save::Bool(true)),
                    ..TextDocumentSyncOptions::default()
                })),
                completion_provider: Some(CompletionOptions {
                    trigger_characters: characters(&[".", "\""]),
                    ..CompletionOptions::default()
                }),
                hover_provider: Some(true.into()),
                signature_help_provider: Some(SignatureHelpOptions {
                    trigger_characters: characters(&["(", ",", "="]),
                    ..SignatureHelpOptions::default()
                }),
                definition_provider: Some(true.into()),
                references_provider: Some(true.into()),
                document_highlight_provider: Some(true.into()),
                document_symbol_provider: Some(true.into()),
                document_formatting_provider: Some(true.into()),
                rename_provider: Some(
                    RenameOptions { prepare_provider: Some(true), ..RenameOptions::default() }.into(),
                ),
                ..ServerCapabilities::default()
            },
            server_info: Some(ServerInfo {
                name: "pse".into(),
                version: Some(env!("CARGO_PKG_VERSION").into()),
            }),
        }
    }

    fn answer(&mut self, request: Request) -> Response {
        match request.method.as_str() {
            "textDocument/completion" => self.with::<lsp::CompletionRequest>(request, completion::complete),
            "textDocument/signatureHelp" => {
                self.with::<lsp::SignatureHelpRequest>(request, completion::signature)
            }
            "textDocument/hover" => self.with::<lsp::HoverRequest>(request, hover::hover),
            "textDocument/definition" => self.with::<lsp::DefinitionRequest>(request, navigation::definition),
            "textDocument/references" => self.with::<lsp::ReferencesRequest>(request, navigation::references),
            "textDocument/documentHighlight" => {
                self.with::<lsp::DocumentHighlightRequest>(request, navigation::highlight)
            }
            "textDocument/documentSymbol" => {
                self.with::<lsp::DocumentSymbolRequest>(request, symbols::symbols)
            }
            "textDocument/formatting" => {
                self.with::<lsp::DocumentFormattingRequest>(request, formatting::format)
            }
            "textDocument/prepareRename" => self.with::<lsp::PrepareRenameRequest>(request, rename::prepare),
            "textDocument/rename" => self.with::<lsp::RenameRequest>(request, rename::rename),
            method => {
                let message = format!("unknown method {method}");
                Response::new_err(request.id, ErrorCode::MethodNotFound as i32, message)
            }
        }
    }

    /// Answers a request of this kind.
    fn with<R: lsp::Request>(
        &mut self,
        request: Request,
        work: fn(&mut Server, R::Params) -> Result<R::Result, Refusal>,
    ) -> Response {
        match serde_json::from_value(request.params) {
            Ok(params) => match work(self, params) {
                Ok(result) => Response::new_ok(request.id, result),
                Err(Refusal(why)) => Response::new_err(request.id, ErrorCode::RequestFailed as i32, why),
            },
            Err(e) => Response::new_err(request.id, ErrorCode::InvalidParams as i32, e.to_string()),
        }
    }

    /// Takes what the editor tells without asking. Gives what is to be told in turn.
    fn note(&mut self, note: Notification) -> Vec<Notification> {
        let all = |server: &mut Server| {
            server.documents.forget();
            server.unchecked = server.documents.open.keys().cloned().collect();
        };
        // There is nobody to answer that parameters are wrong.
        match note.method.as_str() {
            "textDocument/didOpen" => {
                if let Some(params) = read::<lsp::DidOpenTextDocumentNotification>(note) {
                    let document = params.text_document;
                    self.documents.put(&document.uri, document.version, document.text);
                    all(self);
                }
            }
            "textDocument/didChange" => {
                if let Some(params) = read::<lsp::DidChangeTextDocumentNotification>(note) {
                    let document = params.text_document;
                    let uri = document.text_document_identifier.uri;
                    self.unchecked.extend(self.documents.change(
                        &uri,
                        document.version,
                        params.content_changes,
                    ));
                }
            }
            "textDocument/didClose" => {
                if let Some(params) = read::<lsp::DidCloseTextDocumentNotification>(note) {
                    let uri = params.text_document.uri;
                    self.documents.open.remove(&uri.0);
                    all(self);
                    return self.publish(&uri.0, diagnostics::Found::new());
                }
            }
            // What is on disk may be another text now.
            "textDocument/didSave" | "workspace/didChangeWatchedFiles" => all(self),
            _ => {}
        }
        Vec::new()
    }
}

/// A notification's parameters.
fn read<N: lsp::Notification>(note: Notification) -> Option<N::Params> {
    serde_json::from_value(note.params).ok()
}

/// Something to tell the editor.
pub(super) fn tell<N: lsp::Notification>(params: N::Params) -> Notification {
    Notification::new(N::METHOD.to_string(), params)
}
