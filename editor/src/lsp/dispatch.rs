//! What an editor says, handed to what answers it.

use super::editor::Editor;
use super::library::TextDocumentContent;
use super::messages::{ErrorCode, Heard, Notification, Refusal, Request, Response, Said};
use super::session::{Answer, Phase, Session};
use super::{
    actions, capabilities, completion, diagnostics, folding, formatting, hints, hover, lenses, library, navigation,
    rename, signatures, symbols, tokens, workspace_symbols,
};
use crate::document::Document;
use crate::document::file_of;
use lsp_types::notification::{
    DidChangeTextDocument, DidChangeWatchedFiles, DidChangeWorkspaceFolders, DidCloseTextDocument, DidOpenTextDocument,
    DidSaveTextDocument, Exit, Initialized, LogMessage, Notification as KnownNotification, PublishDiagnostics,
    ShowMessage,
};
use lsp_types::request::{
    CodeActionRequest, CodeLensRequest, Completion, DocumentHighlightRequest, DocumentSymbolRequest,
    FoldingRangeRequest, Formatting, GotoDefinition, HoverRequest, Initialize, InlayHintRequest, PrepareRenameRequest,
    RangeFormatting, References, RegisterCapability, Rename, Request as KnownRequest, ResolveCompletionItem,
    SemanticTokensFullRequest, SemanticTokensRangeRequest, Shutdown, SignatureHelpRequest, WorkspaceSymbolRequest,
};
use lsp_types::{
    LogMessageParams, MessageType, PublishDiagnosticsParams, Registration, RegistrationParams, ShowMessageParams, Uri,
    WorkspaceFolder,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::path::PathBuf;

impl Session<'_> {
    /// Looks at one of the texts that have changed, a long one only if no short one waits, and says what was found; or, if
    /// there is none, at some of the files that are to be read.
    pub fn look(&mut self) {
        let Some(uri) = self.open.take_waiting() else {
            self.reads += self.files.read_some(self.surroundings);
            return;
        };
        if let Ok(analysis) = self.analysed(&uri) {
            let said = diagnostics::published(self, &uri, &analysis);
            said.into_iter().for_each(|params| self.notify::<PublishDiagnostics>(params));
        }
    }

    /// Takes what the editor says; whether the conversation goes on.
    pub fn hear(&mut self, message: Heard) -> bool {
        match message {
            Heard::Request(request) => {
                let Request { id, method, params } = request;
                let outcome = self.answer(&method, params);
                self.said.push(Said::Response(Response { id: Some(id), outcome }));
                true
            }
            Heard::Notification(notification) if notification.method == Exit::METHOD => {
                if self.phase != Phase::ShutDown {
                    self.phase = Phase::Exited;
                }
                false
            }
            Heard::Notification(notification) => {
                if self.phase == Phase::Running {
                    self.take(notification);
                }
                true
            }
            Heard::Malformed(response) => {
                self.said.push(Said::Response(response));
                true
            }
            // Nothing depends on the answer to a request of the server.
            Heard::Response => true,
            Heard::End => false,
        }
    }

    fn answer(&mut self, method: &str, params: Value) -> Answer<Value> {
        match (self.phase, method) {
            (Phase::Before, Initialize::METHOD) => {
                self.phase = Phase::Running;
                self.editor = Editor::of(&params);
                Ok(capabilities::capabilities(&self.editor))
            }
            (Phase::Before, _) => Err(Refusal::new(ErrorCode::ServerNotInitialized, "`initialize` comes first")),
            (Phase::ShutDown | Phase::Exited, _) => {
                Err(Refusal::new(ErrorCode::InvalidRequest, "the server has been shut down"))
            }
            (Phase::Running, Initialize::METHOD) => {
                Err(Refusal::new(ErrorCode::InvalidRequest, "`initialize` comes once"))
            }
            (Phase::Running, Shutdown::METHOD) => {
                self.phase = Phase::ShutDown;
                Ok(Value::Null)
            }
            (Phase::Running, HoverRequest::METHOD) => self.on::<HoverRequest>(params, hover::hover),
            (Phase::Running, Completion::METHOD) => self.on::<Completion>(params, completion::complete),
            (Phase::Running, ResolveCompletionItem::METHOD) => {
                self.on::<ResolveCompletionItem>(params, completion::resolve)
            }
            (Phase::Running, SignatureHelpRequest::METHOD) => self.on::<SignatureHelpRequest>(params, signatures::help),
            (Phase::Running, GotoDefinition::METHOD) => self.on::<GotoDefinition>(params, navigation::definition),
            (Phase::Running, References::METHOD) => self.on::<References>(params, navigation::references),
            (Phase::Running, DocumentHighlightRequest::METHOD) => {
                self.on::<DocumentHighlightRequest>(params, navigation::highlights)
            }
            (Phase::Running, PrepareRenameRequest::METHOD) => self.on::<PrepareRenameRequest>(params, rename::prepare),
            (Phase::Running, Rename::METHOD) => self.on::<Rename>(params, rename::rename),
            (Phase::Running, DocumentSymbolRequest::METHOD) => {
                self.on::<DocumentSymbolRequest>(params, symbols::symbols)
            }
            (Phase::Running, FoldingRangeRequest::METHOD) => self.on::<FoldingRangeRequest>(params, folding::folds),
            (Phase::Running, Formatting::METHOD) => self.on::<Formatting>(params, formatting::whole),
            (Phase::Running, RangeFormatting::METHOD) => self.on::<RangeFormatting>(params, formatting::range),
            (Phase::Running, SemanticTokensFullRequest::METHOD) => {
                self.on::<SemanticTokensFullRequest>(params, tokens::full)
            }
            (Phase::Running, SemanticTokensRangeRequest::METHOD) => {
                self.on::<SemanticTokensRangeRequest>(params, tokens::range)
            }
            (Phase::Running, CodeActionRequest::METHOD) => self.on::<CodeActionRequest>(params, actions::actions),
            (Phase::Running, WorkspaceSymbolRequest::METHOD) => {
                self.on::<WorkspaceSymbolRequest>(params, workspace_symbols::symbols)
            }
            (Phase::Running, CodeLensRequest::METHOD) => self.on::<CodeLensRequest>(params, lenses::lenses),
            (Phase::Running, InlayHintRequest::METHOD) => self.on::<InlayHintRequest>(params, hints::hints),
            (Phase::Running, TextDocumentContent::METHOD) => self.on::<TextDocumentContent>(params, library::content),
            (Phase::Running, _) => {
                Err(Refusal::new(ErrorCode::MethodNotFound, format!("there is no request `{method}`")))
            }
        }
    }

    fn on<R: KnownRequest>(
        &mut self,
        params: Value,
        answer: impl FnOnce(&mut Self, R::Params) -> Answer<R::Result>,
    ) -> Answer<Value>
    where
        R::Params: DeserializeOwned,
        R::Result: Serialize,
    {
        let params = serde_json::from_value(params)
            .map_err(|error| Refusal::new(ErrorCode::InvalidParams, format!("`{}`: {error}", R::METHOD)))?;
        answered(answer(self, params)?)
    }

    fn take(&mut self, notification: Notification) {
        match notification.method.as_str() {
            Initialized::METHOD if self.editor.watches_files => self.ask::<RegisterCapability>("watch", watched()),
            DidChangeWorkspaceFolders::METHOD => {
                if let Some(params) = self.params::<DidChangeWorkspaceFolders>(notification) {
                    let uris = |folders: Vec<WorkspaceFolder>| folders.into_iter().map(|folder| folder.uri).collect();
                    let (added, removed): (Vec<Uri>, Vec<Uri>) = (uris(params.event.added), uris(params.event.removed));
                    self.editor.change_folders(&added, &removed);
                }
            }
            DidOpenTextDocument::METHOD => {
                if let Some(params) = self.params::<DidOpenTextDocument>(notification) {
                    let opened = params.text_document;
                    self.open.open(Document::new(opened.uri, opened.version, opened.text));
                }
            }
            DidChangeTextDocument::METHOD => {
                if let Some(params) = self.params::<DidChangeTextDocument>(notification) {
                    let (uri, version) = (params.text_document.uri, params.text_document.version);
                    if !self.open.change(uri.as_str(), version, params.content_changes) {
                        self.log(format!("`{}` has changed and is not open", uri.as_str()));
                    }
                }
            }
            DidCloseTextDocument::METHOD => {
                if let Some(params) = self.params::<DidCloseTextDocument>(notification) {
                    self.close(&params.text_document.uri);
                }
            }
            DidSaveTextDocument::METHOD => {
                if let Some(params) = self.params::<DidSaveTextDocument>(notification)
                    && self.open.get(params.text_document.uri.as_str()).is_some()
                {
                    self.files_changed(&[params.text_document.uri]);
                }
            }
            DidChangeWatchedFiles::METHOD => {
                if let Some(params) = self.params::<DidChangeWatchedFiles>(notification) {
                    let changed: Vec<Uri> = params.changes.into_iter().map(|change| change.uri).collect();
                    self.files_changed(&changed);
                }
            }
            // What else is told may be passed over; what is asked is answered in any case, whether it is still wanted
            // or not.
            _ => {}
        }
    }

    /// What a notification says. One that says nothing sensible has no answer in which to say so, and a text that has changed
    /// in a way that nobody knows is not known any more: what was answered for it would land elsewhere.
    fn params<N: KnownNotification>(&mut self, notification: Notification) -> Option<N::Params> {
        let uri = notification.params.pointer("/textDocument/uri").and_then(Value::as_str).map(str::to_string);
        let error = match serde_json::from_value(notification.params) {
            Ok(params) => return Some(params),
            Err(error) => error,
        };
        let lost = uri.filter(|_| [DidOpenTextDocument::METHOD, DidChangeTextDocument::METHOD].contains(&N::METHOD));
        match lost.and_then(|uri| self.open.get(&uri)).map(|document| document.uri.clone()) {
            Some(uri) => {
                self.close(&uri);
                let message = format!(
                    "the change of `{}` is not understood: {error}; close the text and open it again",
                    uri.as_str()
                );
                self.notify::<ShowMessage>(ShowMessageParams { typ: MessageType::ERROR, message });
            }
            None => self.log(format!("`{}` is not understood: {error}", N::METHOD)),
        }
        None
    }

    fn log(&mut self, message: String) {
        self.notify::<LogMessage>(LogMessageParams { typ: MessageType::WARNING, message });
    }

    /// Texts may load one that has changed, or be for another world now.
    fn files_changed(&mut self, uris: &[Uri]) {
        let files: Vec<PathBuf> = uris.iter().filter_map(file_of).collect();
        for plan in files.iter().filter(|file| file.extension().is_some_and(|extension| extension == "rpl")) {
            self.open.look_again_at_loading(&plan.to_string_lossy());
        }
        if self.surroundings.files_changed(&files) {
            self.open.look_again_at_all();
        }
    }

    fn close(&mut self, uri: &Uri) {
        if !self.open.close(uri.as_str()) {
            self.log(format!("`{}` is closed and was not open", uri.as_str()));
            return;
        }
        let told = self.told.remove(uri.as_str()).unwrap_or_default();
        let closed = told.into_iter().filter(|other| self.open.get(other.as_str()).is_none());
        for gone in closed.chain([uri.clone()]).collect::<Vec<_>>() {
            self.notify::<PublishDiagnostics>(PublishDiagnosticsParams::new(gone, Vec::new(), None));
        }
    }
}

/// The files whose changes the server wants to be told of.
fn watched() -> RegistrationParams {
    let options = serde_json::json!({ "watchers": [{ "globPattern": "**/*.{rpl,toml}" }] });
    let method = DidChangeWatchedFiles::METHOD.to_string();
    let registration = Registration { id: "files".into(), method, register_options: Some(options) };
    RegistrationParams { registrations: vec![registration] }
}

fn answered(result: impl Serialize) -> Answer<Value> {
    serde_json::to_value(result).map_err(|error| Refusal::new(ErrorCode::InternalError, error.to_string()))
}
