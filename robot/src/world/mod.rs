//! A world: what stands where, what the robot's map says of it, and the names people use.

mod blocks;
mod builtin;
mod check;
mod close_up;
mod greys;
mod image;
mod landmark;
mod lookup;
mod map;
mod marker;
mod parse;
mod read;
mod recorded;
mod ros_map;
mod solid;
mod start;
#[cfg(test)]
mod tests;
mod yaml;

pub use blocks::Noise;
pub(crate) use close_up::CloseUp;
pub use greys::Greys;
pub use image::{GreyImage, ImageError};
pub use landmark::Landmark;
pub use lookup::{UnknownName, is_same_name};
pub(crate) use map::TOUCH_M;
pub use marker::{Marker, MarkerColour};
pub use recorded::NoRoom;
pub use ros_map::{MapMode, RosMap};
pub(crate) use solid::part_within;
pub use solid::{DOOR_LEAF_M, Outline, Solid, SolidOrigin, distance_to_segment_m, nearest_on_segment};
pub use start::StartTaken;

use crate::geometry::{Point, Pose, Vector};
use crate::occupancy::OccupancyGrid;
use serde::{Deserialize, Serialize};

/// A world may not be larger, along x or y: maps and beliefs are grids over all of it.
pub(crate) const LARGEST_M: f64 = 1000.0;

/// Nor smaller: the papers' robot would fill it.
pub(crate) const SMALLEST_M: f64 = 0.53;

/// An axis-parallel rectangle, in the map frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rect {
    /// Smallest x and y.
    pub min: Point,
    /// Largest x and y.
    pub max: Point,
}

impl Rect {
    /// Whether the point lies in the rectangle or on its edge.
    pub fn contains(&self, point_in_map: Point) -> bool {
        self.min.x <= point_in_map.x
            && point_in_map.x <= self.max.x
            && self.min.y <= point_in_map.y
            && point_in_map.y <= self.max.y
    }

    /// The middle.
    pub fn centre(&self) -> Point {
        nalgebra::center(&self.min, &self.max)
    }
}

/// A wall along a line of points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wall {
    /// At least two points.
    pub line: Vec<Point>,
    /// Across the line; 0 is a line without thickness.
    pub thickness_m: f64,
}

/// A room, known by the rectangle of its floor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Room {
    /// Its name, as plans use it.
    pub name: String,
    /// Its floor.
    pub rect: Rect,
}

/// Along which axis the wall runs that a door is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Axis {
    /// The wall runs along x; one goes through in the direction of y.
    X,
    /// The wall runs along y; one goes through in the direction of x.
    Y,
}

/// A door in a wall; it cuts the wall it stands in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Door {
    /// The room it belongs to.
    pub room: String,
    /// Middle of the opening.
    pub at: Point,
    /// Clear width of the opening.
    pub width_m: f64,
    /// Along which axis its wall runs.
    pub axis: Axis,
    /// Whether it really is open at the start.
    pub open: bool,
    /// Whether the robot's map shows it open.
    pub mapped_open: bool,
}

/// Outline of an object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Shape {
    /// An axis-parallel box.
    Rect(Rect),
    /// A disc.
    Circle {
        /// Its middle.
        centre: Point,
        /// Its radius.
        radius_m: f64,
    },
    /// A simple polygon.
    Polygon(Vec<Point>),
}

/// Which sensors an object is seen by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SeenBy {
    /// The sonars.
    pub sonar: bool,
    /// The laser range finder.
    pub laser: bool,
}

/// A piece of furniture or an obstacle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Object {
    /// Its name.
    pub name: String,
    /// Its outline.
    pub shape: Shape,
    /// Whether it is in the robot's map.
    pub mapped: bool,
    /// Which sensors see it.
    pub seen_by: SeenBy,
}

/// A named pose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// Its name, as plans use it.
    pub name: String,
    /// Where to stand.
    pub pose_in_map: Pose,
    /// The room it is in; none in a corridor.
    pub room: Option<String>,
    /// Whether the robot's battery is charged while it stands there.
    pub charges: bool,
}

/// How the robot drives in a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum TravelMode {
    /// Fast.
    Hallway,
    /// Slowly, among furniture.
    Office,
    /// Slowly, sonars off.
    Doorway,
}

/// A region with its travel mode; where regions overlap, `Doorway` wins over `Office` over
/// `Hallway`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// How to drive there.
    pub mode: TravelMode,
    /// Where.
    pub rect: Rect,
}

/// A person on a fixed round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Person {
    /// Walked there and back.
    pub path: Vec<Point>,
    /// Walking speed.
    pub speed_mps: f64,
}

/// A thing that can be carried.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Item {
    /// Its name, as plans use it.
    pub name: String,
    /// Where it lies at the start.
    pub at: Point,
}

/// A world file, read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct World {
    /// Its name.
    pub name: String,
    /// The lower left corner: (0, 0), or where a recorded map has it.
    pub origin_in_map: Point,
    /// Width and height.
    pub size_m: Vector,
    /// A recorded map: what is occupied there is a wall, what is unknown there is so in the robot's map.
    pub recorded: Option<OccupancyGrid>,
    /// Where the robot stands at the start.
    pub start_in_map: Pose,
    /// Walls.
    pub walls: Vec<Wall>,
    /// Rooms.
    pub rooms: Vec<Room>,
    /// Doors.
    pub doors: Vec<Door>,
    /// Objects.
    pub objects: Vec<Object>,
    /// Places.
    pub places: Vec<Place>,
    /// Regions.
    pub regions: Vec<Region>,
    /// People on rounds of their own.
    pub people: Vec<Person>,
    /// How many more walk about, drawn from the seed.
    pub crowd: usize,
    /// Things that can be carried.
    pub items: Vec<Item>,
    /// Sheets on the floor.
    pub markers: Vec<Marker>,
    /// Sheets on walls.
    pub landmarks: Vec<Landmark>,
}

impl World {
    /// The rectangle that everything is in.
    pub fn bounds(&self) -> Rect {
        Rect { min: self.origin_in_map, max: self.origin_in_map + self.size_m }
    }

    /// The world as the robot's map shows it: doors as they are drawn there, and nothing that is not in the map, such
    /// as people and things that can be carried.
    #[must_use]
    pub fn known(&self) -> Self {
        let mut known = self.clone();
        known.doors.iter_mut().for_each(|door| door.open = door.mapped_open);
        known.objects.retain(|object| object.mapped);
        (known.people, known.crowd, known.items, known.markers) = (Vec::new(), 0, Vec::new(), Vec::new());
        known
    }
}
