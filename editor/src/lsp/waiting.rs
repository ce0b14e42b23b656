//! The open texts whose findings are to be told: short ones first, and the one that was changed last, which is the one
//! somebody looks at.

use std::cmp::Reverse;
use std::collections::BTreeMap;

/// A text of up to this many bytes is looked at after each change; reading 2,500 lines takes some 20 ms.
const SHORT_BYTES: usize = 100_000;

/// Whether a text is long, and the number of its last change.
type Turn = (bool, Reverse<u64>);

/// What waits, by URIs.
#[derive(Default)]
pub(super) struct Waiting {
    texts: BTreeMap<Turn, String>,
    turns: BTreeMap<String, Turn>,
    changes: u64,
}

impl Waiting {
    /// A text of `bytes` bytes waits from now on.
    pub(super) fn add(&mut self, uri: &str, bytes: usize) {
        self.remove(uri);
        self.changes += 1;
        let turn = (bytes > SHORT_BYTES, Reverse(self.changes));
        self.texts.insert(turn, uri.to_string());
        self.turns.insert(uri.to_string(), turn);
    }

    /// A text does not wait any more.
    pub(super) fn remove(&mut self, uri: &str) {
        if let Some(turn) = self.turns.remove(uri) {
            self.texts.remove(&turn);
        }
    }

    /// Whether the next one is long, if one waits.
    pub(super) fn is_next_long(&self) -> Option<bool> {
        self.texts.first_key_value().map(|((is_long, _), _)| *is_long)
    }

    /// The next one.
    pub(super) fn take(&mut self) -> Option<String> {
        let (_, uri) = self.texts.pop_first()?;
        self.turns.remove(&uri);
        Some(uri)
    }
}
