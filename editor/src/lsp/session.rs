//! The server as a value: where the conversation is, and what is known of the open texts.

use super::editor::Editor;
use super::folder_files::FolderFiles;
use super::messages::{ErrorCode, Notification, Refusal, Request, RequestId, Said};
use super::open_texts::OpenTexts;
use crate::analysis::Analysis;
use crate::document::Document;
use crate::surroundings::Surroundings;
use lsp_types::notification::{Notification as KnownNotification, ShowMessage};
use lsp_types::request::Request as KnownRequest;
use lsp_types::{MessageType, ShowMessageParams, Uri};
use rpl_lang::compile::Loader;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// How a server has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// It was shut down first.
    ShutDown,
    /// It was told to exit without having been shut down.
    ToldToExit,
    /// Nobody was there any more.
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
    /// `exit` has come without `shutdown`.
    Exited,
}

impl Refusal {
    /// A request that cannot be done, and why.
    pub(super) fn failed(reason: impl Into<String>) -> Self {
        Self::new(ErrorCode::RequestFailed, reason)
    }
}

/// What comes of a request.
pub(super) type Answer<T> = Result<T, Refusal>;

/// A conversation with an editor.
pub struct Session<'s> {
    pub(super) surroundings: &'s dyn Surroundings,
    pub(super) phase: Phase,
    pub(super) editor: Editor,
    pub(super) open: OpenTexts,
    pub(super) files: FolderFiles,
    /// For each open text the others that its findings were told of.
    pub(super) told: BTreeMap<String, BTreeSet<Uri>>,
    pub(super) said: Vec<Said>,
    /// How often a text was looked at as a whole.
    pub looks: u64,
    /// How often a file was read for what it defines.
    pub reads: u64,
}

impl<'s> Session<'s> {
    /// A conversation that has not begun.
    pub fn new(surroundings: &'s dyn Surroundings) -> Self {
        Self {
            surroundings,
            phase: Phase::Before,
            editor: Editor::default(),
            open: OpenTexts::default(),
            files: FolderFiles::default(),
            told: BTreeMap::new(),
            said: Vec::new(),
            looks: 0,
            reads: 0,
        }
    }

    /// What there is to say to the editor since this was last asked.
    pub fn take_said(&mut self) -> Vec<Said> {
        std::mem::take(&mut self.said)
    }

    /// How the conversation ends if it ends now.
    pub fn ending(&self) -> Ending {
        match self.phase {
            Phase::ShutDown => Ending::ShutDown,
            Phase::Exited => Ending::ToldToExit,
            Phase::Before | Phase::Running => Ending::Abandoned,
        }
    }

    /// Whether there is something to look at when nobody asks for anything: a changed text whose findings are to be told,
    /// or files; and if so, whether that is a long text.
    pub fn waits(&self) -> Option<bool> {
        self.open.waits().or_else(|| self.files.waits().then_some(false))
    }

    /// Says something that asks for no answer.
    pub(super) fn notify<N: KnownNotification>(&mut self, params: N::Params) {
        let params = serde_json::to_value(params).unwrap_or_else(|error| unreachable!("a message is JSON: {error}"));
        self.said.push(Said::Notification(Notification { method: N::METHOD.to_string(), params }));
    }

    /// Asks for something; the answer changes nothing.
    pub(super) fn ask<R: KnownRequest>(&mut self, id: &str, params: R::Params) {
        let params = serde_json::to_value(params).unwrap_or_else(|error| unreachable!("a message is JSON: {error}"));
        let id = RequestId::Text(id.to_string());
        self.said.push(Said::Request(Request { id, method: R::METHOD.to_string(), params }));
    }

    /// The folders that somebody works in: those that the editor has open, or else those of the open texts.
    pub(super) fn folders(&self) -> Vec<PathBuf> {
        if !self.editor.folders.is_empty() {
            return self.editor.folders.clone();
        }
        let beside = self.open.all().filter_map(|document| document.path.parent()).map(Path::to_path_buf);
        beside.filter(|folder| folder.is_absolute()).collect::<BTreeSet<_>>().into_iter().collect()
    }

    /// An open text.
    pub(super) fn document(&self, uri: &Uri) -> Answer<&Document> {
        let refusal = || Refusal::new(ErrorCode::InvalidParams, format!("`{}` is not open", uri.as_str()));
        self.open.get(uri.as_str()).ok_or_else(refusal)
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
        let Some(document) = self.open.get(uri) else { return Err(Refusal::failed("it is not open")) };
        if let (true, Some(analysis)) = (document.is_analysed, &document.analysis) {
            return Ok(analysis.clone());
        }
        match self.examine_noting(document, &document.text, BTreeMap::new()) {
            Ok((analysis, lacks_some)) => {
                self.looks += 1;
                let analysis = Rc::new(analysis);
                self.open.keep(uri, analysis.clone(), lacks_some);
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
        Ok(self.examine_noting(document, text, BTreeMap::new())?.0)
    }

    /// Looks at texts, by their names, in the place of an open one and of those it loads.
    pub(super) fn examine_all(
        &self,
        document: &Document,
        mut texts: BTreeMap<String, String>,
    ) -> Result<Analysis, String> {
        let text = texts.remove(&document.name()).unwrap_or_default();
        Ok(self.examine_noting(document, &text, texts)?.0)
    }

    /// Looks at a text, with others in the place of those it loads; and whether it loads what there is not.
    fn examine_noting(
        &self,
        document: &Document,
        text: &str,
        instead: BTreeMap<String, String>,
    ) -> Result<(Analysis, bool), String> {
        let setting = self.surroundings.setting(&document.path)?;
        let beside = self.surroundings.loader(&document.path);
        let mut loader = Loading { beside, instead, open: &self.open, lacks_some: false };
        // While it is typed, a text goes on naming the robot; when it is opened, all libraries are tried.
        let analysis = Analysis::of(setting, document.library, &document.name(), text, &mut loader);
        Ok((analysis, loader.lacks_some))
    }
}

/// Loads what the editor has open from there, and all else from its file.
struct Loading<'s> {
    beside: Box<dyn Loader>,
    /// Texts, by name, that stand for others.
    instead: BTreeMap<String, String>,
    open: &'s OpenTexts,
    lacks_some: bool,
}

impl Loader for Loading<'_> {
    fn load(&mut self, from: &str, path: &str) -> Result<(String, String), String> {
        let (name, text) = self.beside.load(from, path).inspect_err(|_| self.lacks_some = true)?;
        let open = || self.open.named(&name).map(|document| document.text.clone());
        let text = self.instead.get(&name).cloned().or_else(open).unwrap_or(text);
        Ok((name, text))
    }
}
