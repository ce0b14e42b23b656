//! What there is beside a hallway, and what a robot that drives past perceives of it.

use serde::{Deserialize, Serialize};

/// A side of a hallway, as seen by the robot that drives along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Side {
    /// On the left.
    Left,
    /// On the right.
    Right,
}

impl Side {
    /// Both.
    pub const ALL: [Side; 2] = [Side::Left, Side::Right];

    /// The other one.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }

    /// 1 on the left, −1 on the right: the sign of `y` in `base`.
    pub fn sign(self) -> f64 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }
}

/// The five features of a hallway's side, and the five percepts (Gutierrez-Osuna and Luo, "State-Set
/// Progression"). As a percept, a wall is nothing perceived.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Feature {
    /// Nothing but a wall.
    Wall,
    /// A door that is closed.
    ClosedDoor,
    /// A door that is open.
    OpenDoor,
    /// A hallway that branches off.
    Hallway,
    /// A foyer: an opening wider than a hallway.
    Foyer,
}

impl Feature {
    /// All of them, in the order of tables.
    pub const ALL: [Feature; 5] =
        [Feature::Wall, Feature::ClosedDoor, Feature::OpenDoor, Feature::Hallway, Feature::Foyer];

    /// What an instruction counts: an opening of any kind, closed doors included, but no foyer.
    pub const OPENINGS: [Feature; 3] = [Feature::ClosedDoor, Feature::OpenDoor, Feature::Hallway];

    /// As plans and people call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wall => "wall",
            Self::ClosedDoor => "closed-door",
            Self::OpenDoor => "open-door",
            Self::Hallway => "hallway",
            Self::Foyer => "foyer",
        }
    }
}

/// A part of a hallway's side before which something stands, a box or somebody: a closed door there does not show.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HiddenWall {
    /// On which side.
    pub side: Side,
    /// Where it begins along the hallway's axis, in metres from where the detection was started.
    pub from_m: f64,
    /// Where it ends.
    pub to_m: f64,
}

impl HiddenWall {
    /// The same as seen by one who drives the other way: see [`Percept::turned`].
    #[must_use]
    pub fn turned(&self, turned_at_m: f64) -> Self {
        Self { side: self.side.other(), from_m: turned_at_m - self.to_m, to_m: turned_at_m - self.from_m }
    }

    /// The same, with places from another start: see [`Percept::shifted`].
    #[must_use]
    pub fn shifted(&self, start_m: f64) -> Self {
        Self { from_m: start_m + self.from_m, to_m: start_m + self.to_m, ..*self }
    }
}

/// A feature as it was perceived, when the robot had passed it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Percept {
    /// How many came before it since the detection was started: no percept has the number of another.
    pub number: u64,
    /// On which side.
    pub side: Side,
    /// What it was taken for; never a wall.
    pub seen: Feature,
    /// Where it begins and ends along the hallway's axis, in metres from where the detection was started,
    /// in the direction of driving.
    pub from_m: f64,
    /// Where it ends.
    pub to_m: f64,
    /// How much deeper than the wall it is, at the least; infinite if nothing was heard in it.
    pub depth_m: f64,
    /// Whether the camera has seen a marker beside it.
    pub marked: bool,
}

impl Percept {
    /// The same as seen by one who drives the other way, with the axis reversed: what was at `turned_at_m`
    /// is at 0, and left is right. Twice around the same place it is what it was.
    #[must_use]
    pub fn turned(&self, turned_at_m: f64) -> Self {
        Self { side: self.side.other(), from_m: turned_at_m - self.to_m, to_m: turned_at_m - self.from_m, ..*self }
    }

    /// The same, with places from another start: what was at 0 is at `start_m`.
    #[must_use]
    pub fn shifted(&self, start_m: f64) -> Self {
        Self { from_m: start_m + self.from_m, to_m: start_m + self.to_m, ..*self }
    }

    /// Its middle, along the axis.
    pub fn middle_m(&self) -> f64 {
        (self.from_m + self.to_m) / 2.0
    }

    /// Its width, along the axis.
    pub fn width_m(&self) -> f64 {
        self.to_m - self.from_m
    }
}
