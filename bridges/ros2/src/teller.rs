//! Tells whoever runs the bridge what he should know.

use std::collections::BTreeSet;

/// Tells sentences, some of them once.
pub struct Teller {
    tell: Box<dyn FnMut(&str) + Send>,
    told: BTreeSet<&'static str>,
}

impl Teller {
    /// Sentences go there.
    pub fn new(tell: impl FnMut(&str) + Send + 'static) -> Self {
        Self { tell: Box::new(tell), told: BTreeSet::new() }
    }

    /// Tells a sentence.
    pub fn tell(&mut self, sentence: &str) {
        (self.tell)(sentence);
    }

    /// Tells a sentence about a subject, unless one was told.
    pub fn once(&mut self, subject: &'static str, sentence: impl FnOnce() -> String) {
        if self.told.insert(subject) {
            (self.tell)(&sentence());
        }
    }
}
