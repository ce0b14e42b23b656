//! Texts of strings.

use foldhash::fast::FixedState;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::hash::BuildHasher;
use std::ops::Deref;
use std::sync::Arc;

/// What a string says. It never changes, and so its hash is kept with it once it has been the key of a hash table.
#[derive(Clone, Debug)]
pub struct Text {
    /// The text itself.
    pub text: Arc<str>,
    /// Its hash; 0 if nobody has asked for it, or it happens to be that.
    hash: u64,
}

/// The hash of a text.
pub(super) fn text_hash(text: &str) -> u64 {
    FixedState::default().hash_one(text.as_bytes())
}

impl Text {
    /// Its hash. O(length) the first time, O(1) from then on.
    #[inline]
    pub(super) fn hash(&mut self) -> u64 {
        if self.hash == 0 {
            self.hash = text_hash(&self.text);
        }
        self.hash
    }
}

impl From<&str> for Text {
    fn from(text: &str) -> Self {
        Self { text: text.into(), hash: 0 }
    }
}

impl Deref for Text {
    type Target = str;

    #[inline]
    fn deref(&self) -> &str {
        &self.text
    }
}

impl PartialEq for Text {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

impl Serialize for Text {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.text.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Text {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Self { text: Arc::<str>::deserialize(deserializer)?, hash: 0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hash_that_is_kept_is_that_of_the_text() {
        let mut asked = Text::from("word");
        assert_eq!(asked.hash(), text_hash("word"));
        assert_eq!(asked.hash(), text_hash("word"));
        let fresh = Text::from("word");
        assert_eq!(asked, fresh, "what was asked for is no part of it");
        assert_eq!(postcard::to_allocvec(&asked), postcard::to_allocvec(&fresh));
    }
}
