//! A stack that takes one word while it is empty.

use serde::{Deserialize, Serialize};

/// A stack that takes one word while it is empty.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stack<T>(
    #[expect(clippy::box_collection, reason = "a word in every task instead of three")] Option<Box<Vec<T>>>,
);

impl<T> Default for Stack<T> {
    fn default() -> Self {
        Self(None)
    }
}

impl<T> Stack<T> {
    /// Adds on top.
    pub fn push(&mut self, item: T) {
        self.0.get_or_insert_default().push(item);
    }
}

impl<T: Clone> Stack<T> {
    /// Holds these items and no others from now on.
    pub fn set(&mut self, items: &[T]) {
        match &mut self.0 {
            Some(held) => {
                held.clear();
                held.extend_from_slice(items);
            }
            None if items.is_empty() => {}
            None => self.0 = Some(Box::new(items.to_vec())),
        }
    }
}

impl<T> std::ops::Deref for Stack<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        self.0.as_ref().map_or(&[], |items| items)
    }
}

impl<T> std::ops::DerefMut for Stack<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        self.0.as_mut().map_or(&mut [], |items| items)
    }
}
