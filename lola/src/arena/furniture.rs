//! What stands in an arena, and where the robot begins.

use super::area::Area;
use super::bands::centimetres;
use super::floor_plan::{Doorway, FloorPlan, Opening};
use super::hallway::{Hallway, SideFeature};
use super::interval::{Interval, Millimetres};
use super::settings::ArenaSettings;
use super::walls::{overlap, shrunk};
use crate::feature::Feature;
use rpl_random::Stream;
use rpl_robot::world::Axis;

/// A point, by x and y.
pub type Spot = (Millimetres, Millimetres);

/// Boxes, markers, and the robot's start.
#[derive(Clone, Debug, PartialEq)]
pub struct Furniture {
    /// Boxes in rooms and hallways.
    pub boxes: Vec<Area>,
    /// The middle of each marker.
    pub markers_mm: Vec<Spot>,
    /// Where the robot starts.
    pub start_mm: Spot,
    /// And how it is turned, in whole degrees.
    pub start_heading_deg: Millimetres,
}

/// How far from walls and boxes the robot starts: more than the radius of either robot.
const START_OFF_MM: Millimetres = 450;

/// A robot that starts in a hallway stands this far off its blind end ...
const START_OFF_END_MM: Millimetres = 450;

/// ... and is turned by at most this angle.
const ROUGHLY_DEG: usize = 10;

/// How much floor stays free before a door, on the room's side: along the wall beyond the door's posts, and
/// into the room.
const DOOR_FREE_MM: (Millimetres, Millimetres) = (500, 1700);

/// A box in a room.
const ROOM_BOX_MM: Interval = (400, 900);

/// A box in a hallway, along and across it.
const HALLWAY_BOX_MM: (Interval, Interval) = ((300, 600), (250, 450));

/// How much floor stays free beside a box in a hallway.
const PASSAGE_MM: Millimetres = 1500;

/// How far a box in a hallway keeps from whatever leads out of it but closed doors, and from other boxes.
const BOX_OFF_MM: Millimetres = 900;

/// And how far from the robot's start.
const BOX_OFF_START_MM: Millimetres = 1000;

/// One box is tried for each such length of a hallway.
const HALLWAY_FOR_BOX_MM: Millimetres = 5000;

/// How far a marker lies before the face of its door's wall.
const MARKER_OFF_WALL_MM: Millimetres = 250;

/// Places tried for the robot's start; a room without furniture always has one.
const TRIES: usize = 200;

/// Where the robot begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// Anywhere in a room, turned anyhow.
    Room(usize),
    /// In the middle of a hallway near its beginning, turned about along it.
    Hallway(usize),
}

impl Furniture {
    /// Sparse furniture in the rooms, and boxes in the hallways if asked for.
    pub fn draw(stream: &mut Stream, plan: &FloorPlan, start: Start, settings: &ArenaSettings) -> Self {
        let mut boxes = Vec::new();
        for room in 0..plan.rooms.len() {
            boxes.extend(room_boxes(stream, plan, room));
        }
        let (start_mm, start_heading_deg) = match start {
            Start::Room(room) => anywhere_in(stream, plan, room, &boxes),
            Start::Hallway(hallway) => at_beginning_of(stream, plan, hallway),
        };
        if settings.boxes {
            for hallway in 0..plan.hallways.len() {
                hallway_boxes(stream, plan, hallway, start_mm, &mut boxes);
            }
        }
        let markers_mm = if settings.markers { markers(plan) } else { Vec::new() };
        Self { boxes, markers_mm, start_mm, start_heading_deg }
    }
}

/// At most two boxes in corners of a room, off its door.
fn room_boxes(stream: &mut Stream, plan: &FloorPlan, room: usize) -> Vec<Area> {
    let Opening::Door(door) = plan.rooms[room].opening else { return Vec::new() };
    let floor = plan.clear_area(room);
    let free = before_door(plan, &door);
    let mut boxes: Vec<Area> = Vec::new();
    for _ in 0..stream.index(3) {
        let (width_mm, height_mm) = (centimetres(stream, ROOM_BOX_MM), centimetres(stream, ROOM_BOX_MM));
        let ((x0, x1), (y0, y1)) = (floor.x_mm, floor.y_mm);
        let x_mm = if stream.chance(0.5) { (x0, x0 + width_mm) } else { (x1 - width_mm, x1) };
        let y_mm = if stream.chance(0.5) { (y0, y0 + height_mm) } else { (y1 - height_mm, y1) };
        let found = Area { x_mm, y_mm };
        if !found.overlaps(free) && !boxes.iter().any(|other| other.overlaps(found)) {
            boxes.push(found);
        }
    }
    boxes
}

/// The floor of a room before its door.
fn before_door(plan: &FloorPlan, door: &Doorway) -> Area {
    let (beside_mm, into_mm) = DOOR_FREE_MM;
    let along_mm = shrunk(door.along_mm, -beside_mm);
    let hallway = &plan.hallways[door.hallway];
    let is_above = door.wall_mm > hallway.across_mm.0;
    let across_mm =
        if is_above { (door.wall_mm, door.wall_mm + into_mm) } else { (door.wall_mm - into_mm, door.wall_mm) };
    laid(hallway.axis, along_mm, across_mm)
}

/// An area by an axis, along and across it.
fn laid(axis: Axis, along_mm: Interval, across_mm: Interval) -> Area {
    match axis {
        Axis::X => Area { x_mm: along_mm, y_mm: across_mm },
        Axis::Y => Area { x_mm: across_mm, y_mm: along_mm },
    }
}

/// Anywhere in a room, turned anyhow.
fn anywhere_in(stream: &mut Stream, plan: &FloorPlan, room: usize, boxes: &[Area]) -> (Spot, Millimetres) {
    let floor = plan.clear_area(room).shrunk(START_OFF_MM);
    let heading_deg = stream.index(360) as Millimetres - 180;
    let middle = ((floor.x_mm.0 + floor.x_mm.1) / 2, (floor.y_mm.0 + floor.y_mm.1) / 2);
    let mut anywhere = || (centimetres(stream, floor.x_mm), centimetres(stream, floor.y_mm));
    let is_free = |&(x_mm, y_mm): &Spot| {
        let around = Area { x_mm: (x_mm, x_mm), y_mm: (y_mm, y_mm) }.shrunk(-START_OFF_MM);
        !boxes.iter().any(|found| found.overlaps(around))
    };
    let start_mm = (0..TRIES).map(|_| anywhere()).find(is_free).unwrap_or(middle);
    (start_mm, heading_deg)
}

/// In the middle of a hallway near its beginning, and turned by at most [`ROUGHLY_DEG`].
fn at_beginning_of(stream: &mut Stream, plan: &FloorPlan, hallway: usize) -> (Spot, Millimetres) {
    let Hallway { axis, along_mm, across_mm, .. } = plan.hallways[hallway];
    let (along_mm, across_mm) = (along_mm.0 + START_OFF_END_MM, (across_mm.0 + across_mm.1) / 2);
    let off_deg = stream.index(2 * ROUGHLY_DEG + 1) as Millimetres - ROUGHLY_DEG as Millimetres;
    match axis {
        Axis::X => ((along_mm, across_mm), off_deg),
        Axis::Y => ((across_mm, along_mm), 90 + off_deg),
    }
}

/// Boxes at the walls of a hallway. They may hide closed doors, and leave a passage.
fn hallway_boxes(stream: &mut Stream, plan: &FloorPlan, index: usize, start_mm: Spot, boxes: &mut Vec<Area>) {
    let hallway = &plan.hallways[index];
    let around_start =
        Area { x_mm: (start_mm.0, start_mm.0), y_mm: (start_mm.1, start_mm.1) }.shrunk(-BOX_OFF_START_MM);
    let (low_mm, high_mm) = hallway.across_mm;
    let length_mm = hallway.along_mm.1 - hallway.along_mm.0;
    for _ in 0..length_mm / HALLWAY_FOR_BOX_MM {
        let (long_mm, deep_mm) = (centimetres(stream, HALLWAY_BOX_MM.0), centimetres(stream, HALLWAY_BOX_MM.1));
        let from_mm = centimetres(stream, (hallway.along_mm.0, hallway.along_mm.1 - long_mm));
        let along_mm = (from_mm, from_mm + long_mm);
        let is_above = stream.chance(0.5);
        let deep_mm = deep_mm.min(high_mm - low_mm - PASSAGE_MM);
        let across_mm = if is_above { (high_mm - deep_mm, high_mm) } else { (low_mm, low_mm + deep_mm) };
        let found = laid(hallway.axis, along_mm, across_mm);
        let around_mm = shrunk(along_mm, -BOX_OFF_MM);
        let side = hallway.side_towards(is_above);
        let is_off = |feature: &SideFeature| !overlap((feature.from_mm, feature.to_mm), around_mm);
        let keeps_off = hallway.side(side).iter().filter(|found| found.feature != Feature::ClosedDoor).all(is_off)
            && hallway.side(side.other()).iter().filter(|found| found.feature == Feature::Hallway).all(is_off)
            && !found.overlaps(around_start);
        let apart = laid(hallway.axis, around_mm, hallway.across_mm);
        if keeps_off && !boxes.iter().any(|other| other.overlaps(apart)) {
            boxes.push(found);
        }
    }
}

/// One before each door, in the hallway.
fn markers(plan: &FloorPlan) -> Vec<Spot> {
    let doors = plan.rooms.iter().filter_map(|room| match room.opening {
        Opening::Door(door) => Some(door),
        Opening::Foyer { .. } | Opening::None => None,
    });
    let marker = |door: Doorway| {
        let hallway = &plan.hallways[door.hallway];
        let (low_mm, high_mm) = hallway.across_mm;
        let is_above = door.wall_mm > low_mm;
        let across_mm = if is_above { high_mm - MARKER_OFF_WALL_MM } else { low_mm + MARKER_OFF_WALL_MM };
        let along_mm = door.middle_mm();
        match hallway.axis {
            Axis::X => (along_mm, across_mm),
            Axis::Y => (across_mm, along_mm),
        }
    };
    doors.map(marker).collect()
}
