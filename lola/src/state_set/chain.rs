//! The nodes of an instruction (Gutierrez-Osuna and Luo, Figs. 4 and 5).

use crate::feature::{Feature, Percept, Side};
use crate::instruction::Instruction;

/// The nodes an instruction leads along: the start, those that are counted, the goal, and what lies beyond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Chain {
    /// On which side percepts matter; on both if there is none.
    pub side: Option<Side>,
    /// How many nodes there are up to the goal, without the start; at least 1.
    pub length: usize,
    /// What the last one is.
    pub goal: Feature,
    /// What every other node may be.
    pub counted: &'static [Feature],
    /// What stands beside the hallway and is no node.
    pub uncounted: &'static [Feature],
    /// How likely the next thing beside the hallway is one of those.
    pub uncounted_share: f64,
}

/// Of the things beside a hallway, how many are foyers. The certainty of a foyer among openings hangs on it
/// only where hallways are taken for foyers, which is rare.
const FOYER_SHARE: f64 = 0.05;

impl Chain {
    /// Of an instruction that is followed by counting; leaving a room and going to the end of a hallway are
    /// not.
    pub fn of(instruction: Instruction) -> Option<Self> {
        let opening = |ordinal: u8, side, goal| Self {
            side: Some(side),
            length: usize::from(ordinal.max(1)),
            goal,
            counted: &Feature::OPENINGS,
            uncounted: &[Feature::Foyer],
            uncounted_share: FOYER_SHARE,
        };
        match instruction {
            Instruction::Turn { ordinal, side } => Some(opening(ordinal, side, Feature::Hallway)),
            Instruction::Enter { ordinal, side } => Some(opening(ordinal, side, Feature::OpenDoor)),
            Instruction::GoPastFoyer => Some(Self {
                side: None,
                length: 1,
                goal: Feature::Foyer,
                counted: &[Feature::Foyer],
                uncounted: &Feature::OPENINGS,
                uncounted_share: 1.0 - FOYER_SHARE,
            }),
            Instruction::Leave(_) | Instruction::GoHallwayEnd => None,
        }
    }

    /// How many of the nodes before the goal are of a kind: each that may be is as likely as the others.
    pub fn share(&self, feature: Feature) -> f64 {
        if self.counted.contains(&feature) { 1.0 / self.counted.len() as f64 } else { 0.0 }
    }

    /// Whether a percept is on the side that matters.
    pub fn concerns(&self, percept: &Percept) -> bool {
        self.side.is_none_or(|side| side == percept.side)
    }
}
