//! Which of the open texts load which files, as it was when they were last looked at.

use std::collections::{BTreeMap, BTreeSet};

/// Both ways, so that neither opening nor changing a text costs more the more others are open.
#[derive(Default)]
pub(super) struct Loads {
    /// By the URI of an open text the names of the texts it loads, also those that these load.
    loaded: BTreeMap<String, BTreeSet<String>>,
    /// The same the other way.
    loading: BTreeMap<String, BTreeSet<String>>,
    /// The open texts that load what there was not.
    lacking: BTreeSet<String>,
}

impl Loads {
    /// Takes what a text loads in the place of what it did.
    pub(super) fn set(&mut self, uri: &str, names: BTreeSet<String>, lacks_some: bool) {
        self.forget(uri);
        for name in &names {
            self.loading.entry(name.clone()).or_default().insert(uri.to_string());
        }
        self.loaded.insert(uri.to_string(), names);
        if lacks_some {
            self.lacking.insert(uri.to_string());
        }
    }

    /// A text is not open any more.
    pub(super) fn forget(&mut self, uri: &str) {
        for name in self.loaded.remove(uri).unwrap_or_default() {
            if let Some(loading) = self.loading.get_mut(&name) {
                loading.remove(uri);
                if loading.is_empty() {
                    self.loading.remove(&name);
                }
            }
        }
        self.lacking.remove(uri);
    }

    /// The texts that load one of a name.
    pub(super) fn loading(&self, name: &str) -> Vec<String> {
        self.loading.get(name).into_iter().flatten().cloned().collect()
    }

    /// The texts that load what there was not.
    pub(super) fn lacking(&self) -> Vec<String> {
        self.lacking.iter().cloned().collect()
    }
}
