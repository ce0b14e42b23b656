//! What stands in a building, and what becomes of it.

use super::draft::{Draft, rect};
use crate::geometry::{Point, Vector};
use crate::world::{Object, Rect, SeenBy, Shape};
use rpl_random::Stream;

/// What became of the furniture since the map was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Furniture {
    /// It stands as it is mapped.
    AsMapped,
    /// Some pieces were moved by half a metre to two metres, some are gone, and some are new.
    Rearranged,
}

/// Spots that are tried for a piece.
const TRIES: usize = 40;

/// The share of rearranged pieces that are gone ...
const GONE: f64 = 0.15;

/// ... the share that were moved ...
const MOVED: f64 = 0.45;

/// ... and by how much.
const MOVED_M: (f64, f64) = (0.5, 2.0);

/// As many new pieces as this share of those there were, and one more.
const NEW: f64 = 0.15;

/// The share of pieces that stand against a wall.
const AT_WALL: f64 = 0.6;

const SEEN_BY_ALL: SeenBy = SeenBy { sonar: true, laser: true };

/// Puts pieces onto the floors of a plan; some that find no room are left out.
pub(super) fn furnish(draft: &mut Draft, stream: &mut Stream, count: usize) {
    for _ in 0..count {
        let name = format!("piece-{}", draft.furniture.len() + 1);
        let piece = piece(draft, stream, name, &draft.furniture);
        draft.furniture.extend(piece);
    }
}

/// Hangs a pane into some plans, which sonars hear and lasers look through.
pub(super) fn glaze(draft: &mut Draft, stream: &mut Stream) {
    const PANE_M: f64 = 0.06;
    if !stream.chance(0.25) || draft.floors.is_empty() {
        return;
    }
    let floor = draft.floors[stream.index(draft.floors.len())];
    let length_m = stream.uniform_in(1.0, 2.5);
    let size = if stream.chance(0.5) { Vector::new(length_m, PANE_M) } else { Vector::new(PANE_M, length_m) };
    let min = point_in(floor, stream);
    let bounds = Rect { min, max: min + size };
    if draft.has_room_for(bounds, &draft.furniture) {
        draft.fixture("pane", Shape::Rect(bounds), SeenBy { sonar: true, laser: false });
    }
}

/// The furniture of a plan some time after it was mapped: some moved, some gone, some new. What stands where the map
/// does not show it is not mapped.
pub(super) fn rearranged(draft: &Draft, stream: &mut Stream) -> Vec<Object> {
    let mut there: Vec<Object> = draft.furniture.iter().filter(|_| !stream.chance(GONE)).cloned().collect();
    for index in 0..there.len() {
        if !stream.chance(MOVED) {
            continue;
        }
        let others = || there.iter().enumerate().filter(move |(other, _)| *other != index).map(|(_, other)| other);
        let shape = (0..TRIES).find_map(|_| {
            let angle_rad = stream.uniform_in(-std::f64::consts::PI, std::f64::consts::PI);
            let way_m = stream.uniform_in(MOVED_M.0, MOVED_M.1);
            let by = Vector::new(libm::cos(angle_rad), libm::sin(angle_rad)) * way_m;
            let moved = Object { shape: shifted(&there[index].shape, by), ..there[index].clone() };
            draft.has_room_for(moved.outline().bounds(), others()).then_some(moved.shape)
        });
        if let Some(shape) = shape {
            (there[index].shape, there[index].mapped) = (shape, false);
        }
    }
    let new = 1 + (NEW * draft.furniture.len() as f64) as usize;
    for number in 1..=new {
        let piece = piece(draft, stream, format!("new-{number}"), &there);
        there.extend(piece.map(|piece| Object { mapped: false, ..piece }));
    }
    there
}

fn piece(draft: &Draft, stream: &mut Stream, name: String, others: &[Object]) -> Option<Object> {
    if draft.floors.is_empty() {
        return None;
    }
    (0..TRIES).find_map(|_| {
        let floor = draft.floors[stream.index(draft.floors.len())];
        let shape = shape(floor, stream);
        let piece = Object { name: name.clone(), shape, mapped: true, seen_by: SEEN_BY_ALL };
        draft.has_room_for(piece.outline().bounds(), others).then_some(piece)
    })
}

/// A cupboard or a table along the axes, a round thing, or a table that stands askew.
fn shape(floor: Rect, stream: &mut Stream) -> Shape {
    let (length_m, depth_m) = (stream.uniform_in(0.5, 1.8), stream.uniform_in(0.4, 0.9));
    let kind = stream.uniform();
    let centre = point_in(floor, stream);
    if kind < 0.15 {
        return Shape::Circle { centre, radius_m: depth_m / 2.0 };
    }
    if kind < 0.3 {
        let angle_rad = stream.uniform_in(0.2, 1.4);
        let along = Vector::new(libm::cos(angle_rad), libm::sin(angle_rad));
        let (half, across) = (along * (length_m / 2.0), Vector::new(-along.y, along.x) * (depth_m / 2.0));
        return Shape::Polygon(vec![
            centre - half - across,
            centre + half - across,
            centre + half + across,
            centre - half + across,
        ]);
    }
    let lies_along = stream.chance(0.5);
    let half = if lies_along { Vector::new(length_m, depth_m) } else { Vector::new(depth_m, length_m) } / 2.0;
    let mut centre = centre;
    if stream.chance(AT_WALL) {
        let gap_m = stream.uniform_in(0.01, 0.06);
        match (lies_along, stream.chance(0.5)) {
            (true, true) => centre.y = floor.min.y + gap_m + half.y,
            (true, false) => centre.y = floor.max.y - gap_m - half.y,
            (false, true) => centre.x = floor.min.x + gap_m + half.x,
            (false, false) => centre.x = floor.max.x - gap_m - half.x,
        }
    }
    Shape::Rect(Rect { min: centre - half, max: centre + half })
}

pub(super) fn point_in(floor: Rect, stream: &mut Stream) -> Point {
    Point::new(stream.uniform_in(floor.min.x, floor.max.x), stream.uniform_in(floor.min.y, floor.max.y))
}

fn shifted(shape: &Shape, by: Vector) -> Shape {
    match shape {
        Shape::Rect(Rect { min, max }) => Shape::Rect(Rect { min: min + by, max: max + by }),
        Shape::Circle { centre, radius_m } => Shape::Circle { centre: centre + by, radius_m: *radius_m },
        Shape::Polygon(corners) => Shape::Polygon(corners.iter().map(|corner| corner + by).collect()),
    }
}

/// The same after half a turn about a point.
pub(super) fn half_turned(shape: &Shape, about: Point) -> Shape {
    let turned = |point: &Point| about + (about - point);
    match shape {
        Shape::Rect(Rect { min, max }) => {
            let (min, max) = (turned(max), turned(min));
            Shape::Rect(rect(min.x, min.y, max.x, max.y))
        }
        Shape::Circle { centre, radius_m } => Shape::Circle { centre: turned(centre), radius_m: *radius_m },
        Shape::Polygon(corners) => Shape::Polygon(corners.iter().map(turned).collect()),
    }
}
