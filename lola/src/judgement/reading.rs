//! What might have been meant.

use crate::feature::Percept;
use crate::instruction::Goal;
use serde::{Deserialize, Serialize};

/// What might have been meant by a wrong instruction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// What should have been said.
    pub goal: Goal,
    /// Where that is.
    pub at: Percept,
    /// How likely it was meant, given that the instruction is wrong.
    pub probability: f64,
}
