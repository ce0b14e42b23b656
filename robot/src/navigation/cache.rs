//! What follows from the rest of a state, kept beside it.

/// A value that can be computed again at any time: it is not saved, and does not count in comparisons.
#[derive(Clone, Debug)]
pub(super) struct Cache<T>(pub Option<T>);

impl<T> Default for Cache<T> {
    fn default() -> Self {
        Self(None)
    }
}

impl<T> PartialEq for Cache<T> {
    /// A cache is what it was computed from, which is compared elsewhere.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
