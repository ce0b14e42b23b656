//! Limits that turn endless plans into failures.

use serde::{Deserialize, Serialize};

/// Limits that turn endless plans into failures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Limits {
    /// Calls and loop turns of all tasks in one instant.
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

/// What the tasks have spent in one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Spent {
    /// Of [`Limits::steps`]; a turn of a task counts as [`Spent::A_TURN`] of them.
    pub steps: u32,
    /// How often all steps were spent, or all tasks were deadlocked.
    pub times: u8,
}

impl Spent {
    /// To take up a task and lay it aside takes as long as some thirty calls.
    pub const A_TURN: u32 = 32;
    /// To raise a failure and to bring it to where it is handled takes as long as some three hundred instructions.
    pub const A_FAILURE: u32 = 256;
}
