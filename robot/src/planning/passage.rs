//! Where one gets from one part of the floor into another.

use super::areas::{Area, Opening, is_in_doorway};
use crate::geometry::{Point, Vector, distance_m};
use crate::world::{Door, World};

/// How far before and behind a door its target points lie.
pub(super) const DOOR_APPROACH_M: f64 = 0.75;

/// A gap without a door that leaves the robot's middle no more than this is gone through like a door.
const NARROW_M: f64 = 0.8;

/// A way from one area into another: a door the map shows open, or a gap in a wall without one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passage {
    /// As an index into the world's doors.
    pub door: Option<usize>,
    /// Its middle.
    pub at: Point,
    /// So narrow that it is gone through straight.
    pub is_narrow: bool,
    /// Across the wall, of unit length, from the first area to the second.
    pub through: Vector,
    /// On its two sides.
    pub areas: [Area; 2],
}

impl Passage {
    /// The passage that an opening is: that of an open door if it lies in its doorway.
    pub fn of(world: &World, opening: Opening) -> Self {
        let Opening { at, clear_m, through, areas } = opening;
        let in_doorway = |door: &&(usize, &Door)| {
            door.1.mapped_open && is_in_doorway(&opening, door.1.at, door.1.width_m, door.1.through())
        };
        let doors: Vec<(usize, &Door)> = world.doors.iter().enumerate().collect();
        match doors.iter().find(in_doorway) {
            Some(&(door, found)) => Self { door: Some(door), at: found.at, is_narrow: true, through, areas },
            None => Self { door: None, at, is_narrow: clear_m <= NARROW_M, through, areas },
        }
    }

    /// Gone through the other way.
    pub fn reversed(self) -> Self {
        Self { through: -self.through, areas: [self.areas[1], self.areas[0]], ..self }
    }

    /// Whether both are edges of one doorway.
    pub fn is_doorway_of(&self, next: &Self) -> bool {
        let is_same_door = self.door.is_some() && self.door == next.door;
        let is_ahead = self.through.dot(&next.through) > 0.5 && distance_m(self.at, next.at) < DOOR_APPROACH_M;
        is_same_door || self.door.is_none() && next.door.is_none() && is_ahead
    }
}

/// One of several that lie in one another's way: the two edges of a doorway between rooms.
pub(super) fn one_of_each(mut chain: Vec<Passage>) -> Vec<Passage> {
    chain.dedup_by(|next, passage| passage.is_doorway_of(next));
    chain
}
