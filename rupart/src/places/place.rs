//! A known place, and a stretch between two of them.

use rpl_robot::geometry::Point;
use rpl_robot::world::Rect;
use serde::{Deserialize, Serialize};

/// A known place, by its place in [`Places::all`](super::Places::all).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct PlaceId(pub u32);

impl PlaceId {
    /// For looking it up in a list.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A known place.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownPlace {
    /// As plans and files call it.
    pub name: String,
    /// Where it is.
    pub at_in_map: Point,
    /// The room whose points are all nearer to its places than to any other, whatever lies beyond its walls.
    pub influence: Option<Rect>,
}

/// Two places that see each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Where it leads.
    pub to: PlaceId,
    /// How long it is.
    pub length_m: f64,
    /// How much room there is on either side of the robot, at least.
    pub room_m: f64,
    /// The same in both directions.
    pub id: usize,
}
