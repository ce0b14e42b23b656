//! Lines that tasks stand in.

use crate::state::slab::NONE;
use serde::{Deserialize, Serialize};

/// A first-in first-out line of tasks, linked through the tasks themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Line {
    /// The first.
    pub first: u32,
    /// The last.
    pub last: u32,
}

impl Default for Line {
    fn default() -> Self {
        Self { first: NONE, last: NONE }
    }
}
