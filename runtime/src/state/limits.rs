//! Limits that turn endless plans into failures.

use serde::{Deserialize, Serialize};

/// Limits that turn endless plans into failures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Limits {
    /// Calls and loop turns of one task in one instant.
    pub steps: u32,
    /// Frames of one task.
    pub frames: u32,
    /// Bytes of everything it makes, as [`crate::step::memory::room`] counts them.
    pub bytes: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { steps: 100_000_000, frames: 1_000_000, bytes: 1 << 30 }
    }
}
