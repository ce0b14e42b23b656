//! What an editor says, handed to what answers it.

use super::session::{Answer, Phase, Refusal, SHORT_BYTES, Session};
use super::{
    actions, capabilities, completion, diagnostics, folding, formatting, hover, navigation, rename, signatures,
    symbols, tokens,
};
use crate::document::Document;
use lsp_server::{ErrorCode, Message, Notification, Request, Response};
use lsp_types::Uri;
use lsp_types::notification::{
    DidChangeTextDocument, DidChangeWatchedFiles, DidCloseTextDocument, DidOpenTextDocument, DidSaveTextDocument, Exit,
    Notification as KnownNotification, PublishDiagnostics,
};
use lsp_types::request::{
    CodeActionRequest, Completion, DocumentHighlightRequest, DocumentSymbolRequest, FoldingRangeRequest, Formatting,
    GotoDefinition, HoverRequest, Initialize, PrepareRenameRequest, RangeFormatting, References, Rename,
    Request as KnownRequest, ResolveCompletionItem, SemanticTokensFullRequest, SemanticTokensRangeRequest, Shutdown,
    SignatureHelpRequest,
};
use serde::Serialize;
use serde::de::DeserializeOwned;

impl Session<'_> {
    /// Looks at the texts that have changed, the long ones only if no short one waits, and says what was found.
    pub fn look(&mut self) {
        let Some(longest) = self.waits() else { return };
        let is_due = |document: &&Document| !document.is_told && (document.text.len() > SHORT_BYTES) == longest;
        let due: Vec<String> = self.documents.values().filter(is_due).map(|one| one.uri.as_str().to_string()).collect();
        for uri in due {
            if let Some(document) = self.documents.get_mut(&uri) {
                document.is_told = true;
            }
            if let Ok(analysis) = self.analysed(&uri) {
                let said = diagnostics::published(self, &uri, &analysis);
                said.into_iter().for_each(|params| self.notify::<PublishDiagnostics>(params));
            }
        }
    }

    /// Takes what the editor says; whether the conversation goes on.
    pub fn hear(&mut self, message: Message) -> bool {
        match message {
            Message::Request(request) => {
                let response = self.answer(request);
                self.said.push(response.into());
                true
            }
            Message::Notification(notification) if notification.method == Exit::METHOD => false,
            Message::Notification(notification) => {
                if self.phase == Phase::Running {
                    self.take(notification);
                }
                true
            }
            // The server asks nothing.
            Message::Response(_) => true,
        }
    }

    fn answer(&mut self, request: Request) -> Response {
        let id = request.id.clone();
        let refused = |code: ErrorCode, reason: String| Response::new_err(id, code as i32, reason);
        match (self.phase, request.method.as_str()) {
            (Phase::Before, Initialize::METHOD) => {
                self.phase = Phase::Running;
                Response::new_ok(request.id, capabilities::capabilities())
            }
            (Phase::Before, _) => refused(ErrorCode::ServerNotInitialized, "`initialize` comes first".into()),
            (Phase::ShutDown, _) => refused(ErrorCode::InvalidRequest, "the server has been shut down".into()),
            (Phase::Running, Initialize::METHOD) => {
                refused(ErrorCode::InvalidRequest, "`initialize` comes once".into())
            }
            (Phase::Running, Shutdown::METHOD) => {
                self.phase = Phase::ShutDown;
                Response::new_ok(request.id, ())
            }
            (Phase::Running, method) => match method {
                HoverRequest::METHOD => self.on::<HoverRequest>(request, hover::hover),
                Completion::METHOD => self.on::<Completion>(request, completion::complete),
                ResolveCompletionItem::METHOD => self.on::<ResolveCompletionItem>(request, completion::resolve),
                SignatureHelpRequest::METHOD => self.on::<SignatureHelpRequest>(request, signatures::help),
                GotoDefinition::METHOD => self.on::<GotoDefinition>(request, navigation::definition),
                References::METHOD => self.on::<References>(request, navigation::references),
                DocumentHighlightRequest::METHOD => {
                    self.on::<DocumentHighlightRequest>(request, navigation::highlights)
                }
                PrepareRenameRequest::METHOD => self.on::<PrepareRenameRequest>(request, rename::prepare),
                Rename::METHOD => self.on::<Rename>(request, rename::rename),
                DocumentSymbolRequest::METHOD => self.on::<DocumentSymbolRequest>(request, symbols::symbols),
                FoldingRangeRequest::METHOD => self.on::<FoldingRangeRequest>(request, folding::folds),
                Formatting::METHOD => self.on::<Formatting>(request, formatting::whole),
                RangeFormatting::METHOD => self.on::<RangeFormatting>(request, formatting::range),
                SemanticTokensFullRequest::METHOD => self.on::<SemanticTokensFullRequest>(request, tokens::full),
                SemanticTokensRangeRequest::METHOD => self.on::<SemanticTokensRangeRequest>(request, tokens::range),
                CodeActionRequest::METHOD => self.on::<CodeActionRequest>(request, actions::actions),
                _ => refused(ErrorCode::MethodNotFound, format!("there is no request `{method}`")),
            },
        }
    }

    fn on<R: KnownRequest>(
        &mut self,
        request: Request,
        answer: impl FnOnce(&mut Self, R::Params) -> Answer<R::Result>,
    ) -> Response
    where
        R::Params: DeserializeOwned,
        R::Result: Serialize,
    {
        let params = match serde_json::from_value(request.params) {
            Ok(params) => params,
            Err(error) => {
                return Response::new_err(request.id, ErrorCode::InvalidParams as i32, error.to_string());
            }
        };
        match answer(self, params) {
            Ok(result) => Response::new_ok(request.id, result),
            Err(Refusal(code, reason)) => Response::new_err(request.id, code as i32, reason),
        }
    }

    fn take(&mut self, notification: Notification) {
        fn params<N: KnownNotification>(notification: Notification) -> Option<N::Params> {
            // A notification that says nothing sensible has no answer in which to say so.
            serde_json::from_value(notification.params).ok()
        }
        match notification.method.as_str() {
            DidOpenTextDocument::METHOD => {
                if let Some(params) = params::<DidOpenTextDocument>(notification) {
                    let opened = params.text_document;
                    let document = Document::new(opened.uri, opened.version, opened.text);
                    self.documents.insert(document.uri.as_str().to_string(), document);
                    self.look_again_at_others();
                }
            }
            DidChangeTextDocument::METHOD => {
                if let Some(params) = params::<DidChangeTextDocument>(notification)
                    && let Some(document) = self.documents.get_mut(params.text_document.uri.as_str())
                {
                    document.version = params.text_document.version;
                    params.content_changes.into_iter().for_each(|change| document.change(change));
                }
            }
            DidCloseTextDocument::METHOD => {
                if let Some(params) = params::<DidCloseTextDocument>(notification) {
                    self.close(params.text_document.uri);
                }
            }
            DidSaveTextDocument::METHOD => {
                self.look_again_at_others();
            }
            DidChangeWatchedFiles::METHOD => {
                self.surroundings.files_changed();
                self.look_again_at_others();
            }
            _ => {}
        }
    }

    /// Texts may load one that has changed, or be for another world now.
    fn look_again_at_others(&mut self) {
        self.documents.values_mut().for_each(Document::look_again);
    }

    fn close(&mut self, uri: Uri) {
        self.documents.remove(uri.as_str());
        let told = self.told.remove(uri.as_str()).unwrap_or_default();
        for other in told.into_iter().chain([uri]) {
            self.notify::<PublishDiagnostics>(lsp_types::PublishDiagnosticsParams::new(other, Vec::new(), None));
        }
    }
}
