//! The server as a value: where the conversation is, and what is known of the open texts.

use crate::analysis::Analysis;
use crate::document::Document;
use crate::surroundings::Surroundings;
use lsp_server::{ErrorCode, Message, Notification};
use lsp_types::notification::{Notification as KnownNotification, ShowMessage};
use lsp_types::{MessageType, ShowMessageParams, Uri};
use rpl_lang::compile::Loader;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// A text of up to so many bytes is looked at after each change; reading 2,500 lines takes some 20 ms.
pub(super) const SHORT_BYTES: usize = 100_000;

/// How a server has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// It was shut down before it was told to exit.
    ShutDown,
    /// It was told to exit, or nobody was there any more, without having been shut down.
    Abandoned,
}

/// Where the conversation is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    /// Nothing but `initialize` is answered.
    Before,
    Running,
    /// Nothing is answered any more.
    ShutDown,
}

/// A request that is not answered: the protocol's code and a sentence.
pub(super) struct Refusal(pub(super) ErrorCode, pub(super) String);

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
    pub(super) surroundings: &'s dyn Surroundings,
    pub(super) phase: Phase,
    pub(super) documents: BTreeMap<String, Document>,
    /// For each open text the others that its findings were told of.
    pub(super) told: BTreeMap<String, BTreeSet<Uri>>,
    pub(super) said: Vec<Message>,
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

    /// Says something that asks for no answer.
    pub(super) fn notify<N: KnownNotification>(&mut self, params: N::Params) {
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

    /// What is known of a text as it is now.
    pub(super) fn analysed(&mut self, uri: &str) -> Answer<Rc<Analysis>> {
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
