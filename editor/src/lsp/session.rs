//! The server as a value.

use super::serve::Ending;
use super::{
    actions, capabilities, completion, diagnostics, folding, formatting, hover, navigation, rename, signatures,
    symbols, tokens,
};
use crate::analysis::Analysis;
use crate::document::Document;
use crate::surroundings::Surroundings;
use lsp_server::{ErrorCode, Message, Notification, Request, Response};
use lsp_types::notification::{
    DidChangeTextDocument, DidChangeWatchedFiles, DidCloseTextDocument, DidOpenTextDocument, DidSaveTextDocument, Exit,
    Notification as _, PublishDiagnostics, ShowMessage,
};
use lsp_types::request::{
    CodeActionRequest, Completion, DocumentHighlightRequest, DocumentSymbolRequest, FoldingRangeRequest, Formatting,
    GotoDefinition, HoverRequest, Initialize, PrepareRenameRequest, RangeFormatting, References, Rename,
    Request as KnownRequest, ResolveCompletionItem, SemanticTokensFullRequest, SemanticTokensRangeRequest, Shutdown,
    SignatureHelpRequest,
};
use lsp_types::{MessageType, ShowMessageParams, Uri};
use rpl_lang::compile::Loader;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// A text of up to so many bytes is looked at after each change; reading 2,500 lines takes some 20 ms.
const SHORT_BYTES: usize = 100_000;

/// Where the conversation is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Nothing but `initialize` is answered.
    Before,
    Running,
    /// Nothing is answered any more.
    ShutDown,
}

/// A request that is not answered: the protocol's code and a sentence.
pub(super) struct Refusal(ErrorCode, String);

impl Refusal {
    /// A request that cannot be done, and why.
    pub(super) fn failed(reason: impl Into<String>) -> Self {
        Self(ErrorCode::RequestFailed, reason.into())
    }
}

/// What comes of a request.
pub(super) type Answer<T> = Result<T, Refusal>;

/// A conversation with an editor.
pub struct Session<'s> {
    surroundings: &'s dyn Surroundings,
    phase: Phase,
    documents: BTreeMap<String, Document>,
    /// For each open text the others that its findings were told of.
    pub(super) told: BTreeMap<String, BTreeSet<Uri>>,
    said: Vec<Message>,
    /// How often a text was looked at as a whole.
    pub looks: u64,
}

impl<'s> Session<'s> {
    /// A conversation that has not begun.
    pub fn new(surroundings: &'s dyn Surroundings) -> Self {
        let (documents, told) = (BTreeMap::new(), BTreeMap::new());
        Self { surroundings, phase: Phase::Before, documents, told, said: Vec::new(), looks: 0 }
    }

    /// What there is to say to the editor since this was last asked.
    pub fn take_said(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.said)
    }

    /// How the conversation ends if it ends now.
    pub fn ending(&self) -> Ending {
        if self.phase == Phase::ShutDown { Ending::ShutDown } else { Ending::Abandoned }
    }

    /// Whether a changed text waits for its findings to be told, and if so, whether that is a long one.
    pub fn waits(&self) -> Option<bool> {
        let waiting = self.documents.values().filter(|document| !document.is_told);
        waiting.map(|document| document.text.len() > SHORT_BYTES).min()
    }

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
        fn params<N: lsp_types::notification::Notification>(notification: Notification) -> Option<N::Params> {
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

    fn notify<N: lsp_types::notification::Notification>(&mut self, params: N::Params) {
        self.said.push(Notification::new(N::METHOD.to_string(), params).into());
    }

    /// An open text.
    pub(super) fn document(&self, uri: &Uri) -> Answer<&Document> {
        let reason = || Refusal(ErrorCode::InvalidParams, format!("`{}` is not open", uri.as_str()));
        self.documents.get(uri.as_str()).ok_or_else(reason)
    }

    /// The open text of a file.
    pub(super) fn open_file(&self, path: &str) -> Option<&Document> {
        self.documents.values().find(|document| document.path.to_str() == Some(path))
    }

    /// Where the files and worlds come from.
    pub(super) fn surroundings(&self) -> &'s dyn Surroundings {
        self.surroundings
    }

    /// What is known of an open text as it is now; looks at it if it has changed.
    pub(super) fn analysis(&mut self, uri: &Uri) -> Answer<Rc<Analysis>> {
        self.document(uri)?;
        self.analysed(uri.as_str())
    }

    /// What was known of an open text when it was last looked at; looks at it if it never was.
    pub(super) fn last_analysis(&mut self, uri: &Uri) -> Answer<Rc<Analysis>> {
        match &self.document(uri)?.analysis {
            Some(analysis) => Ok(analysis.clone()),
            None => self.analysed(uri.as_str()),
        }
    }

    fn analysed(&mut self, uri: &str) -> Answer<Rc<Analysis>> {
        let Some(document) = self.documents.get(uri) else { return Err(Refusal::failed("it is not open")) };
        if let (true, Some(analysis)) = (document.is_analysed, &document.analysis) {
            return Ok(analysis.clone());
        }
        let analysed = self.examine(document, &document.text);
        let Some(document) = self.documents.get_mut(uri) else { return Err(Refusal::failed("it is not open")) };
        document.is_analysed = true;
        match analysed {
            Ok(analysis) => {
                self.looks += 1;
                let analysis = Rc::new(analysis);
                document.analysis = Some(analysis.clone());
                Ok(analysis)
            }
            Err(reason) => {
                self.notify::<ShowMessage>(ShowMessageParams { typ: MessageType::ERROR, message: reason.clone() });
                Err(Refusal::failed(reason))
            }
        }
    }

    /// Looks at a text in the place of an open one.
    pub(super) fn examine(&self, document: &Document, text: &str) -> Result<Analysis, String> {
        self.examine_all(document, BTreeMap::from([(document.name(), text.to_string())]))
    }

    /// Looks at texts, by their names, in the place of an open one and of those it loads.
    pub(super) fn examine_all(
        &self,
        document: &Document,
        mut texts: BTreeMap<String, String>,
    ) -> Result<Analysis, String> {
        let setting = self.surroundings.setting(&document.path)?;
        let text = texts.remove(&document.name()).unwrap_or_default();
        for open in self.documents.values() {
            texts.entry(open.name()).or_insert_with(|| open.text.clone());
        }
        let mut loader = OpenTexts { beside: self.surroundings.loader(&document.path), texts };
        // While it is typed, a text goes on naming the robot; when it is opened, all libraries are tried.
        let first = document.analysis.as_ref().map_or(0, |last| last.library);
        Ok(Analysis::of(setting, first, &document.name(), &text, &mut loader))
    }
}

/// Loads what the editor has open from there, and all else from its file.
struct OpenTexts {
    beside: Box<dyn Loader>,
    /// By name.
    texts: BTreeMap<String, String>,
}

impl Loader for OpenTexts {
    fn load(&mut self, from: &str, path: &str) -> Result<(String, String), String> {
        let (name, text) = self.beside.load(from, path)?;
        let text = self.texts.get(&name).cloned().unwrap_or(text);
        Ok((name, text))
    }
}
