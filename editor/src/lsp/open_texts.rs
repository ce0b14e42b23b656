//! The texts that are open in an editor. Neither opening one nor changing one costs more the more others are open.

use super::loads::Loads;
use super::waiting::Waiting;
use crate::analysis::Analysis;
use crate::document::Document;
use lsp_types::TextDocumentContentChangeEvent;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::rc::Rc;

/// Texts of which the analyses are kept, those that were looked at last: an analysis has all names that a text can use.
const MOST_ANALYSES: usize = 64;

/// The open texts.
#[derive(Default)]
pub(super) struct OpenTexts {
    /// By their URIs.
    documents: BTreeMap<String, Document>,
    /// The URIs by the names that findings have for the texts.
    uris: BTreeMap<String, String>,
    loads: Loads,
    waiting: Waiting,
    /// Those whose analysis is kept, in the order in which they were looked at.
    analysed: VecDeque<String>,
}

impl OpenTexts {
    /// One by its URI.
    pub(super) fn get(&self, uri: &str) -> Option<&Document> {
        self.documents.get(uri)
    }

    /// All of them, by their URIs.
    pub(super) fn all(&self) -> impl Iterator<Item = &Document> {
        self.documents.values()
    }

    /// One by the name that findings have for it.
    pub(super) fn named(&self, name: &str) -> Option<&Document> {
        self.documents.get(self.uris.get(name)?)
    }

    /// A text is open, or opened anew.
    pub(super) fn open(&mut self, document: Document) {
        let (uri, name) = (document.uri.as_str().to_string(), document.name());
        self.close(&uri);
        self.waiting.add(&uri, document.text.len());
        self.uris.insert(name.clone(), uri.clone());
        self.documents.insert(uri, document);
        self.look_again_at_loading(&name);
    }

    /// A text has changed; whether it is open.
    pub(super) fn change(&mut self, uri: &str, version: i32, changes: Vec<TextDocumentContentChangeEvent>) -> bool {
        let Some(document) = self.documents.get_mut(uri) else { return false };
        document.version = version;
        document.change(changes);
        self.waiting.add(uri, document.text.len());
        // Their findings are told when it is saved; who asks before is answered for the texts as they are.
        for loading in self.loads.loading(&document.name()) {
            self.outdate(&loading);
        }
        true
    }

    /// A text is not open any more; whether it was.
    pub(super) fn close(&mut self, uri: &str) -> bool {
        let Some(document) = self.documents.remove(uri) else { return false };
        let name = document.name();
        if self.uris.get(&name).is_some_and(|of_name| of_name == uri) {
            self.uris.remove(&name);
        }
        self.loads.forget(uri);
        self.waiting.remove(uri);
        self.analysed.retain(|analysed| analysed != uri);
        self.look_again_at_loading(&name);
        true
    }

    /// The file of a name has changed: texts that load it, or could not.
    pub(super) fn look_again_at_loading(&mut self, name: &str) {
        for loading in self.loads.loading(name).into_iter().chain(self.loads.lacking()) {
            self.look_again(&loading);
        }
    }

    /// All may be for another world now.
    pub(super) fn look_again_at_all(&mut self) {
        let all: Vec<String> = self.documents.keys().cloned().collect();
        all.iter().for_each(|uri| self.look_again(uri));
    }

    fn look_again(&mut self, uri: &str) {
        self.outdate(uri);
        if let Some(document) = self.documents.get(uri) {
            self.waiting.add(uri, document.text.len());
        }
    }

    /// What was found may not hold any more.
    fn outdate(&mut self, uri: &str) {
        if let Some(document) = self.documents.get_mut(uri) {
            document.is_analysed = false;
        }
    }

    /// Whether a text waits for its findings to be told, and if so, whether the next one is long.
    pub(super) fn waits(&self) -> Option<bool> {
        self.waiting.is_next_long()
    }

    /// The next text whose findings are to be told.
    pub(super) fn take_waiting(&mut self) -> Option<String> {
        self.waiting.take()
    }

    /// Keeps what was found in a text, and what it loads.
    pub(super) fn keep(&mut self, uri: &str, analysis: Rc<Analysis>, lacks_some: bool) {
        let Some(document) = self.documents.get_mut(uri) else { return };
        let sources = &analysis.examined.program.sources;
        let others = analysis.sources().filter(|&source| source != analysis.examined.source);
        let names: BTreeSet<String> = others.map(|source| sources.get(source).name.to_string()).collect();
        self.loads.set(uri, names, lacks_some);
        (document.library, document.is_analysed) = (analysis.library, true);
        document.analysis = Some(analysis);
        self.analysed.retain(|analysed| analysed != uri);
        self.analysed.push_back(uri.to_string());
        if self.analysed.len() > MOST_ANALYSES
            && let Some(oldest) = self.analysed.pop_front()
            && let Some(document) = self.documents.get_mut(&oldest)
        {
            (document.analysis, document.is_analysed) = (None, false);
        }
    }
}
