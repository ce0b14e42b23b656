//! Instructions: what leads from room to room without a map.

mod grammar;
mod meaning;
mod said;
mod words;

pub use meaning::parse;
pub use said::ordinal_in_words;

use crate::feature::{Feature, Side};
use serde::{Deserialize, Serialize};

/// One instruction of a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Instruction {
    /// Leave the room one is in, and go on along the hallway to this side.
    Leave(Side),
    /// Turn into the hallway that is the nth opening, from 1 to 10, on this side.
    Turn {
        /// Of the openings on this side, the first is 1.
        ordinal: u8,
        /// On which side.
        side: Side,
    },
    /// Enter the room whose door is the nth opening, from 1 to 10, on this side.
    Enter {
        /// Of the openings on this side, the first is 1.
        ordinal: u8,
        /// On which side.
        side: Side,
    },
    /// Go on until a foyer was passed.
    GoPastFoyer,
    /// Go on to the end of the hallway.
    GoHallwayEnd,
}

/// Openings are counted up to the tenth, as in the event.
pub const MOST_ORDINAL: u8 = 10;

/// An opening an instruction leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Goal {
    /// Of the openings on this side, the first is 1.
    pub ordinal: u8,
    /// On which side.
    pub side: Side,
    /// What it is: a hallway, or an open door.
    pub kind: Feature,
}

impl Instruction {
    /// The opening it leads to, if it leads to one that is counted.
    pub fn goal(self) -> Option<Goal> {
        match self {
            Self::Turn { ordinal, side } => Some(Goal { ordinal, side, kind: Feature::Hallway }),
            Self::Enter { ordinal, side } => Some(Goal { ordinal, side, kind: Feature::OpenDoor }),
            Self::Leave(_) | Self::GoPastFoyer | Self::GoHallwayEnd => None,
        }
    }
}

impl Goal {
    /// The instruction that leads to it: into a hallway one turns, everything else is entered.
    pub fn instruction(self) -> Instruction {
        let Self { ordinal, side, kind } = self;
        match kind {
            Feature::Hallway | Feature::Foyer => Instruction::Turn { ordinal, side },
            Feature::OpenDoor | Feature::ClosedDoor | Feature::Wall => Instruction::Enter { ordinal, side },
        }
    }
}
