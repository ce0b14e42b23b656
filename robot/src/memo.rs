//! What pure functions have answered before.

#![expect(
    clippy::disallowed_types,
    reason = "answers follow from their questions alone: nobody can tell who asked first"
)]

use std::sync::{Arc, Mutex, PoisonError};

/// Answers of pure functions, shared by all copies, on whichever thread they are.
#[derive(Debug, Default)]
pub(crate) struct Memo<T>(Arc<Mutex<T>>);

impl<T> Clone for Memo<T> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<T> Memo<T> {
    /// Looks something up or takes something down; nothing is to be computed meanwhile, for others wait.
    pub fn with<R>(&self, act: impl FnOnce(&mut T) -> R) -> R {
        act(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
