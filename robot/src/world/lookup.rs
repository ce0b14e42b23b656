//! Questions about a world by name or by point.

use super::{Door, Place, Room, TravelMode, World};
use crate::file_text::nearest;
use crate::geometry::Point;
use rpl_lang::symbol::fold_name;

/// A name no place, room or door of the world has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{kind} `{name}` is not in world `{world}`{}", self.advice())]
pub struct UnknownName {
    /// What was looked for: "place", "room", "door".
    pub kind: &'static str,
    /// The name nobody has.
    pub name: String,
    /// The world.
    pub world: String,
    /// The name probably meant.
    pub suggestion: Option<String>,
    /// All names there are.
    pub known: Vec<String>,
}

impl UnknownName {
    fn advice(&self) -> String {
        match &self.suggestion {
            Some(suggestion) => format!("; did you mean `{suggestion}`?"),
            None if self.known.is_empty() => format!("; it has no {}s: add [[{}]] to the world", self.kind, self.kind),
            None => format!("; it has {}", self.known.join(", ")),
        }
    }
}

/// Whether two names are one: names in a world fold like symbols, so that a plan may write each
/// with or without capitals.
pub fn is_same_name(one: &str, other: &str) -> bool {
    fold_name(one) == fold_name(other)
}

impl World {
    /// The place of a name.
    ///
    /// # Errors
    /// No place has the name; the error suggests the nearest.
    pub fn place(&self, name: &str) -> Result<&Place, UnknownName> {
        let found = self.places.iter().find(|place| is_same_name(&place.name, name));
        found.ok_or_else(|| self.unknown("place", name, self.places.iter().map(|place| place.name.as_str())))
    }

    /// The room of a name.
    ///
    /// # Errors
    /// No room has the name; the error suggests the nearest.
    pub fn room(&self, name: &str) -> Result<&Room, UnknownName> {
        let found = self.rooms.iter().find(|room| is_same_name(&room.name, name));
        found.ok_or_else(|| self.unknown("room", name, self.rooms.iter().map(|room| room.name.as_str())))
    }

    /// The first door of a room, with its index in `doors`.
    ///
    /// # Errors
    /// The room has no door, or there is no such room.
    pub fn door_of(&self, room: &str) -> Result<(usize, &Door), UnknownName> {
        let found = self.doors.iter().enumerate().find(|(_, door)| is_same_name(&door.room, room));
        found.ok_or_else(|| self.unknown("door", room, self.doors.iter().map(|door| door.room.as_str())))
    }

    /// How to drive at a point: the mode of the regions there, `Doorway` over `Office` over
    /// `Hallway`; none outside all regions.
    pub fn mode_at(&self, point_in_map: Point) -> Option<TravelMode> {
        let here = self.regions.iter().filter(|region| region.rect.contains(point_in_map));
        here.map(|region| region.mode).max()
    }

    /// The room whose floor the point is on.
    pub fn room_at(&self, point_in_map: Point) -> Option<&Room> {
        self.rooms.iter().find(|room| room.rect.contains(point_in_map))
    }

    fn unknown<'a>(&self, kind: &'static str, name: &str, known: impl Iterator<Item = &'a str> + Clone) -> UnknownName {
        UnknownName {
            kind,
            name: name.to_owned(),
            world: self.name.clone(),
            suggestion: nearest(name, known.clone()).map(str::to_owned),
            known: known.map(str::to_owned).collect(),
        }
    }
}
