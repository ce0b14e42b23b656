//! The prompt while the clock runs.

use std::sync::{Arc, Mutex};

/// A prompt that changes while it is shown: the text it stands for was as wide.
#[derive(Clone, Debug, Default)]
pub struct LivePrompt(Arc<Mutex<String>>);

impl LivePrompt {
    /// What is to be shown for a prompt.
    pub fn text(&self, prompt: &str) -> String {
        let live = self.0.lock().map_or_else(|_| String::new(), |live| live.clone());
        if live.chars().count() == prompt.chars().count() { live } else { prompt.to_string() }
    }

    /// Tells whether the text is another one than before.
    pub fn set(&self, text: &str) -> bool {
        let Ok(mut live) = self.0.lock() else { return false };
        let changes = *live != text;
        *live = text.to_string();
        changes
    }
}
