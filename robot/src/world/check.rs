//! What the values of a world file must agree on with each other.

use super::lookup::is_same_name;
use super::{Door, Item, Landmark, Marker, Object, Person, Place, Rect, Region, Room, SolidOrigin, Wall, World};
use super::{distance_to_segment_m, nearest_on_segment};
use crate::description::LEAST_RADIUS_M;
use crate::file_text::{Placed, Reader, TomlTable, nearest};
use crate::geometry::{Point, Pose, distance_m, wrap_angle_rad};
use crate::occupancy::Cell;
use rpl_lang::symbol::fold_name;
use std::collections::BTreeSet;
use std::ops::Range;

/// No two rooms or places share a name, and the rooms of places exist.
pub(super) fn names(reader: &mut Reader, rooms: &[Placed<'_, '_, Room>], places: &[Placed<'_, '_, Place>]) {
    let named_rooms = rooms.iter().map(|room| ("room", room.value.name.as_str(), room.table.span_of("name")));
    let named_places = places.iter().map(|place| ("place", place.value.name.as_str(), place.table.span_of("name")));
    let all: Vec<_> = named_rooms.chain(named_places).collect();
    for (index, (kind, name, span)) in all.iter().enumerate() {
        if let Some((other, earlier, _)) = all[..index].iter().find(|(_, earlier, _)| is_same_name(earlier, name)) {
            let message = match earlier == name {
                true => format!("the {kind} `{name}` has the name of a {other} above"),
                false => format!(
                    "the {kind} `{name}` has the name of the {other} `{earlier}` above but for capitals, and plans know no capitals"
                ),
            };
            reader.note(span.clone(), "name", message, "give each room and each place a name of its own");
        }
    }
    for place in places {
        if let Some(room) = &place.value.room {
            room_exists(reader, room, rooms, place.table.span_of("room"), &format!("the place `{}`", place.value.name));
        }
    }
}

fn room_exists(reader: &mut Reader, name: &str, rooms: &[Placed<'_, '_, Room>], span: Range<usize>, owner: &str) {
    let known = || rooms.iter().map(|room| room.value.name.as_str());
    if known().any(|room| is_same_name(room, name)) {
        return;
    }
    let help = match nearest(name, known()) {
        Some(suggestion) => format!("did you mean `{suggestion}`?"),
        None => "add a [[room]] of this name".to_owned(),
    };
    reader.note(span, "room", format!("{owner} belongs to the room `{name}`, which does not exist"), help);
}

/// Doors belong to rooms and stand in walls.
pub(super) fn doors(
    reader: &mut Reader,
    doors: &[Placed<'_, '_, Door>],
    rooms: &[Placed<'_, '_, Room>],
    walls: &[Placed<'_, '_, Wall>],
) {
    for door in doors {
        let Door { room, at, .. } = &door.value;
        room_exists(reader, room, rooms, door.table.span_of("room"), "the door");
        let in_wall = walls.iter().any(|wall| {
            let Wall { line, thickness_m } = &wall.value;
            line.windows(2).any(|ends| door.value.opening_in(ends[0], ends[1], *thickness_m).is_some())
        });
        if !in_wall {
            let message = format!("the door of `{room}` at ({}, {}) stands in no wall", at.x, at.y);
            let help = "`at` is the middle of the opening, on the line of a wall along `axis` that is wide enough";
            reader.note(door.table.span_of("at"), "at", message, help);
        }
    }
}

fn reach(bounds: Rect) -> String {
    let Rect { min, max } = bounds;
    format!("the world reaches from ({}, {}) to ({}, {})", min.x, min.y, max.x, max.y)
}

/// Start, doors, objects and places lie within the world.
pub(super) fn inside(
    reader: &mut Reader,
    bounds: Rect,
    start: Option<&Placed<'_, '_, Pose>>,
    doors: &[Placed<'_, '_, Door>],
    objects: &[Placed<'_, '_, Object>],
    places: &[Placed<'_, '_, Place>],
) {
    let mut point = |what: String, key: &str, at: Point, table: &TomlTable| {
        if !bounds.contains(at) {
            let message = format!("{what} is at ({}, {}), outside the world", at.x, at.y);
            let help = reach(bounds);
            reader.note(table.span_of(key), key, message, help);
        }
    };
    if let Some(start) = start {
        point("the start".to_owned(), "start", start.value.point(), &start.table);
    }
    for door in doors {
        point(format!("the door of `{}`", door.value.room), "at", door.value.at, &door.table);
    }
    for object in objects {
        point(
            format!("the object `{}`", object.value.name),
            "object",
            object.value.outline().bounds().centre(),
            &object.table,
        );
    }
    for place in places {
        point(format!("the place `{}`", place.value.name), "pose", place.value.pose_in_map.point(), &place.table);
    }
}

/// A door stands at most so far from the floor of its room.
const DOOR_OFF_ROOM_M: f64 = 0.5;

/// No two rooms share floor, and doors are at the edge of their room.
pub(super) fn floors(reader: &mut Reader, rooms: &[Placed<'_, '_, Room>], doors: &[Placed<'_, '_, Door>]) {
    for (index, room) in rooms.iter().enumerate() {
        let shares = |other: &Placed<'_, '_, Room>| {
            let (a, b) = (other.value.rect, room.value.rect);
            let (min, max) = (a.min.sup(&b.min), a.max.inf(&b.max));
            max.x - min.x > 1e-6 && max.y - min.y > 1e-6
        };
        if let Some(other) = rooms[..index].iter().find(|other| shares(other)) {
            let message = format!("the rooms `{}` and `{}` overlap", other.value.name, room.value.name);
            reader.note(
                room.table.span_of("rect"),
                "rect",
                message,
                "a point of the floor belongs to one room at most",
            );
        }
    }
    for door in doors {
        let Some(room) = rooms.iter().find(|room| is_same_name(&room.value.name, &door.value.room)) else { continue };
        let Rect { min, max } = room.value.rect;
        let at = door.value.at;
        let off_m = (at - at.sup(&min).inf(&max)).norm_squared().sqrt();
        if off_m > DOOR_OFF_ROOM_M {
            let message =
                format!("the door at ({}, {}) is {off_m:.1} m away from its room `{}`", at.x, at.y, door.value.room);
            let help = "`room` is a room the door leads into: its floor begins beside the door";
            reader.note(door.table.span_of("room"), "room", message, help);
        }
    }
}

/// Every region counts somewhere.
pub(super) fn regions(reader: &mut Reader, regions: &[Placed<'_, '_, Region>]) {
    for region in regions {
        let Rect { min, max } = region.value.rect;
        let covers = |other: &&Placed<'_, '_, Region>| {
            other.value.mode > region.value.mode && other.value.rect.contains(min) && other.value.rect.contains(max)
        };
        if let Some(other) = regions.iter().find(covers) {
            let Rect { min, max } = other.value.rect;
            let message = format!(
                "the region counts nowhere: a region of another mode from ({}, {}) to ({}, {}) covers it",
                min.x, min.y, max.x, max.y
            );
            let help = "where regions overlap, a doorway counts before an office and an office before a hallway";
            reader.note(region.table.span_of("rect"), "rect", message, help);
        }
    }
}

/// People walk within the world.
pub(super) fn people_inside(reader: &mut Reader, bounds: Rect, people: &[Placed<'_, '_, Person>]) {
    for person in people {
        if let Some(at) = person.value.path.iter().find(|at| !bounds.contains(**at)) {
            let message = format!("a person walks to ({}, {}), outside the world", at.x, at.y);
            let help = reach(bounds);
            reader.note(person.table.span_of("path"), "path", message, help);
        }
    }
}

/// No two things share a name.
pub(super) fn item_names(reader: &mut Reader, items: &[Placed<'_, '_, Item>]) {
    for (index, item) in items.iter().enumerate() {
        let name = &item.value.name;
        if items[..index].iter().any(|earlier| earlier.value.name == *name) {
            let message = format!("the item `{name}` has the name of an item above");
            reader.note(item.table.span_of("name"), "name", message, "give each item a name of its own");
        }
    }
}

/// Things lie within the world.
pub(super) fn items_inside(reader: &mut Reader, bounds: Rect, items: &[Placed<'_, '_, Item>]) {
    for item in items.iter().filter(|item| !bounds.contains(item.value.at)) {
        let Item { name, at } = &item.value;
        let message = format!("the item `{name}` is at ({}, {}), outside the world", at.x, at.y);
        let help = reach(bounds);
        reader.note(item.table.span_of("at"), "at", message, help);
    }
}

/// Markers lie within the world.
pub(super) fn markers_inside(reader: &mut Reader, bounds: Rect, markers: &[Placed<'_, '_, Marker>]) {
    for marker in markers.iter().filter(|marker| !bounds.contains(marker.value.at)) {
        let at = marker.value.at;
        let message = format!("the marker is at ({}, {}), outside the world", at.x, at.y);
        let help = reach(bounds);
        reader.note(marker.table.span_of("at"), "at", message, help);
    }
}

/// No two landmarks share a name.
pub(super) fn landmark_names(reader: &mut Reader, landmarks: &[Placed<'_, '_, Landmark>]) {
    let mut known = BTreeSet::new();
    for landmark in landmarks {
        let name = &landmark.value.name;
        if !known.insert(fold_name(name).into_owned()) {
            let message = format!("the landmark `{name}` has the name of a landmark above");
            reader.note(landmark.table.span_of("name"), "name", message, "give each landmark a name of its own");
        }
    }
}

/// A sheet hangs on a face that is at most so far off ...
const OFF_FACE_M: f64 = 0.02;

/// ... and turned by at most this angle.
const OFF_FACE_RAD: f64 = 2.0 / 180.0 * std::f64::consts::PI;

/// The face of a wall, from one end to the other, and where it looks.
struct Face {
    ends: [Point; 2],
    facing_rad: f64,
}

fn faces(world: &World) -> Vec<Face> {
    let walls = world.solids().into_iter().filter(|solid| solid.origin == SolidOrigin::Wall);
    let edges = walls.flat_map(|solid| solid.outline.edges().collect::<Vec<_>>());
    // A body is on the left of its edges, so that they look to the right.
    let face = |(a, b): (Point, Point)| Face { ends: [a, b], facing_rad: libm::atan2(a.x - b.x, b.y - a.y) };
    edges.map(face).collect()
}

/// Landmarks hang on walls, with both edges: `spans` are where their poses stand.
pub(super) fn landmarks_hang(reader: &mut Reader, world: &World, spans: &[Range<usize>]) {
    if world.landmarks.is_empty() {
        return;
    }
    let faces = faces(world);
    for (landmark, span) in world.landmarks.iter().zip(spans) {
        let pose = landmark.pose_in_map;
        let is_turned = |face: &Face| wrap_angle_rad(face.facing_rad - pose.heading_rad).abs() > OFF_FACE_RAD;
        let looking: Vec<&Face> = faces.iter().filter(|face| !is_turned(face)).collect();
        let hangs =
            |at: Point| looking.iter().any(|face| distance_to_segment_m(at, face.ends[0], face.ends[1]) <= OFF_FACE_M);
        let [left, right] = landmark.edges_in_map();
        if !([left, pose.point(), right].into_iter().all(hangs)) {
            let Landmark { name, width_m, .. } = landmark;
            let message =
                format!("the landmark `{name}`, {width_m} m wide, hangs on no wall at ({}, {})", pose.x_m, pose.y_m);
            reader.note(span.clone(), "pose", message, advice(&faces, pose.point()));
        }
    }
}

/// Where the nearest wall is.
fn advice(faces: &[Face], point: Point) -> String {
    let nearest = |face: &Face| nearest_on_segment(point, face.ends[0], face.ends[1]);
    let by_distance = |a: &&Face, b: &&Face| distance_m(nearest(a), point).total_cmp(&distance_m(nearest(b), point));
    let rule = "`pose` is the middle of the sheet on the face of a wall, and the direction it faces";
    let Some(face) = faces.iter().min_by(by_distance) else { return format!("{rule}; this world has no walls") };
    let (at, degrees) = (nearest(face), libm::round(face.facing_rad.to_degrees().rem_euclid(360.0)));
    format!("{rule}; the nearest is at [{:.3}, {:.3}, \"{degrees}deg\"]", at.x, at.y)
}

/// The start is on floor. Whether the robot that is to drive has room there is looked at when there is one,
/// see [`World::room_at_start`].
pub(super) fn start_is_free(reader: &mut Reader, world: &World, span: Range<usize>) {
    let start = world.start_in_map.point();
    if world.recorded.as_ref().is_some_and(|map| map.at(start) == Cell::Unknown) {
        let message = format!("the start ({}, {}) is where the map knows nothing", start.x, start.y);
        reader.note(span, "start", message, "put it where the map is free");
        return;
    }
    if let Err(taken) = world.room_at_start(LEAST_RADIUS_M) {
        reader.note(span, "start", taken.to_string(), "put it where a robot can stand");
    }
}
