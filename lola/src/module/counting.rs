//! How far the robot has got with an instruction.

use super::hallway::counts;
use crate::feature::{HiddenWall, Percept};
use crate::instruction::Instruction;
use crate::state_set::{Inference, StateSet};
use serde::{Deserialize, Serialize};

/// An instruction under way: its state set, and from where on along the hallway it counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Counting {
    /// Its certainties.
    pub state_set: StateSet,
    /// From there on along the hallway openings count.
    pub from_m: f64,
}

impl Counting {
    /// Begins with an instruction; none for one that is followed without counting.
    pub fn start(instruction: Instruction, from_m: f64) -> Option<Self> {
        Some(Self { state_set: StateSet::start(instruction)?, from_m })
    }

    /// Takes in what was perceived since, each percept once. Answers the one that is most likely the goal, if the
    /// robot has most likely passed that.
    pub fn progress(&mut self, inference: &Inference, percepts: &[Percept], hidden: &[HiddenWall]) -> Option<Percept> {
        let own: Vec<Percept> = percepts.iter().filter(|percept| counts(percept, self.from_m)).copied().collect();
        self.state_set.progress(inference, &own, hidden);
        self.state_set.arrived()
    }
}
