//! A few small rooms, one leading into the next, and much in them.

use super::draft::{Draft, WALL_M, door_width_m, mostly_short, people, widest_door_m};
use super::furniture::{furnish, glaze};
use crate::geometry::{Point, Vector};
use crate::world::{Axis, Rect};
use rpl_random::Stream;

/// No wall ends nearer to the edge of a door.
const OFF_DOOR_M: f64 = 0.15;

/// A door between two rooms, before the rooms have names.
struct Opening {
    at: Point,
    width_m: f64,
    axis: Axis,
}

pub(super) fn draw(stream: &mut Stream, robot_radius_m: f64) -> Draft {
    let size_m = Vector::new(mostly_short(stream, 8.0, 16.0), mostly_short(stream, 8.0, 12.0));
    let mut draft = Draft::walled(size_m);
    let mut rooms = vec![draft.outline()];
    let mut openings: Vec<Opening> = Vec::new();
    let wanted = 3 + stream.index(4);
    for _ in 0..40 {
        if rooms.len() == wanted {
            break;
        }
        let index = stream.index(rooms.len());
        if let Some((parts, opening)) = split(rooms[index], &openings, stream, robot_radius_m) {
            let Rect { min, max } = parts[1];
            match opening.axis {
                Axis::X => draft.wall(&[(min.x, min.y), (max.x, min.y)]),
                Axis::Y => draft.wall(&[(min.x, min.y), (min.x, max.y)]),
            }
            rooms[index] = parts[0];
            rooms.push(parts[1]);
            openings.push(opening);
        }
    }
    for between in &rooms {
        draft.room(*between);
    }
    for Opening { at, width_m, axis } in openings {
        let beside = match axis {
            Axis::X => Vector::new(0.0, WALL_M),
            Axis::Y => Vector::new(WALL_M, 0.0),
        };
        let room = draft.rooms.iter().find(|room| room.rect.contains(at + beside)).map(|room| room.name.clone());
        draft.door(room.unwrap_or_default(), at, width_m, axis);
    }
    glaze(&mut draft, stream);
    let pieces = rooms.len() + stream.index(2 * rooms.len() + 1);
    furnish(&mut draft, stream, pieces);
    draft.people = people(stream);
    draft
}

/// Cuts a room in two, with a door between them, across its longer side; none if that is too short or the wall would
/// end in a door.
fn split(room: Rect, openings: &[Opening], stream: &mut Stream, robot_radius_m: f64) -> Option<([Rect; 2], Opening)> {
    let narrowest_m = 2.4_f64.max(widest_door_m(robot_radius_m) + 0.8);
    let size = room.max - room.min;
    let axis = if size.x > size.y { Axis::Y } else { Axis::X };
    let (low_m, high_m) = match axis {
        Axis::X => (room.min.y, room.max.y),
        Axis::Y => (room.min.x, room.max.x),
    };
    if high_m - low_m < 2.0 * narrowest_m {
        return None;
    }
    let at_m = stream.uniform_in(low_m + narrowest_m, high_m - narrowest_m);
    let width_m = door_width_m(stream, robot_radius_m);
    let off_m = width_m / 2.0 + WALL_M / 2.0 + OFF_DOOR_M;
    let (parts, at) = match axis {
        Axis::X => (
            [Rect { max: Point::new(room.max.x, at_m), ..room }, Rect { min: Point::new(room.min.x, at_m), ..room }],
            Point::new(stream.uniform_in(room.min.x + off_m, room.max.x - off_m), at_m),
        ),
        Axis::Y => (
            [Rect { max: Point::new(at_m, room.max.y), ..room }, Rect { min: Point::new(at_m, room.min.y), ..room }],
            Point::new(at_m, stream.uniform_in(room.min.y + off_m, room.max.y - off_m)),
        ),
    };
    let Rect { min, max } = parts[1];
    let ends = match axis {
        Axis::X => [min, Point::new(max.x, min.y)],
        Axis::Y => [min, Point::new(min.x, max.y)],
    };
    let is_in_door = |end: &Point| {
        openings.iter().any(|opening| (opening.at - end).norm() < opening.width_m / 2.0 + WALL_M / 2.0 + OFF_DOOR_M)
    };
    (!ends.iter().any(is_in_door)).then_some((parts, Opening { at, width_m, axis }))
}
