//! Instructions: what leads from room to room without a map.

use crate::feature::Side;
use serde::{Deserialize, Serialize};

/// One instruction of a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Instruction {
    /// Leave the room one is in, and go on along the hallway to this side.
    Leave(Side),
    /// Turn into the hallway that is the so-manieth opening, from 1 to 10, on this side.
    Turn {
        /// Of the openings on this side, the first is 1.
        ordinal: u8,
        /// On which side.
        side: Side,
    },
    /// Enter the room whose door is the so-manieth opening, from 1 to 10, on this side.
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
