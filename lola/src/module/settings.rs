//! What can be set about it: the rows of experiments.

use crate::state_set::Inference;

/// How percepts are made and judged.
#[derive(Clone, Debug, PartialEq)]
pub struct LolaSettings {
    /// How percepts become a place in an instruction; none follows from whether the robot has a camera.
    pub inference: Option<Inference>,
    /// Whether the axis of the hallway is fitted to its walls. Without, it is what was guessed when it was entered.
    pub registers: bool,
}

impl Default for LolaSettings {
    fn default() -> Self {
        Self { inference: None, registers: true }
    }
}
