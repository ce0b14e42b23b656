//! Rooms along one to three corridors, which a crossing one joins.

use super::draft::{
    Draft, INSET_M, WALL_M, cuts, door_width_m, floor_within, mostly_short, people, rect, widest_door_m,
};
use super::furniture::{furnish, glaze};
use crate::geometry::{Point, Vector};
use crate::world::{Axis, Rect};
use rpl_random::Stream;

/// A corridor with rooms on both sides, by the heights of its walls.
struct Wing {
    south_m: f64,
    corridor_m: (f64, f64),
    north_m: f64,
}

pub(super) fn draw(stream: &mut Stream, robot_radius_m: f64) -> Draft {
    let count = if stream.chance(0.6) { 1 } else { 2 + stream.index(2) };
    let length_m = mostly_short(stream, 10.0, if count == 1 { 160.0 } else { 50.0 });
    let crossing_m = if count == 1 { 0.0 } else { stream.uniform_in(2.0, 3.2) };
    let mut wings = Vec::new();
    let mut at_m = INSET_M;
    for _ in 0..count {
        let south_m = at_m;
        let low_m = south_m + stream.uniform_in(3.2, 6.0);
        let high_m = low_m + stream.uniform_in(1.8, 3.0);
        at_m = high_m + stream.uniform_in(3.2, 6.0);
        wings.push(Wing { south_m, corridor_m: (low_m, high_m), north_m: at_m });
    }
    let (east_m, north_m) = (INSET_M + crossing_m + length_m, at_m);
    let mut draft = Draft::walled(Vector::new(east_m + INSET_M, north_m + INSET_M));
    let west_m = INSET_M + crossing_m;
    if count > 1 {
        draft.hallways.push(floor_within(rect(INSET_M, INSET_M, west_m, north_m)));
    }
    for (index, wing) in wings.iter().enumerate() {
        let (low_m, high_m) = wing.corridor_m;
        draft.hallways.push(floor_within(rect(west_m, low_m, east_m, high_m)));
        if index > 0 {
            draft.wall(&[(west_m, wing.south_m), (east_m, wing.south_m)]);
        }
        for (from_m, to_m, wall_m) in [(wing.south_m, low_m, low_m), (high_m, wing.north_m, high_m)] {
            draft.wall(&[(west_m, wall_m), (east_m, wall_m)]);
            if count > 1 {
                draft.wall(&[(west_m, from_m), (west_m, to_m)]);
            }
            row_of_rooms(&mut draft, stream, robot_radius_m, rect(west_m, from_m, east_m, to_m), wall_m);
        }
    }
    let rooms = draft.rooms.len();
    glaze(&mut draft, stream);
    let pieces = rooms + stream.index(2 * rooms + 1);
    furnish(&mut draft, stream, pieces);
    draft.people = people(stream);
    draft
}

/// Rooms side by side, each with a door in the wall at this height.
pub(super) fn row_of_rooms(draft: &mut Draft, stream: &mut Stream, robot_radius_m: f64, row: Rect, wall_m: f64) {
    let narrowest_m = 2.6_f64.max(widest_door_m(robot_radius_m) + 0.6);
    let mut ends = cuts(stream, row.min.x, row.max.x, (narrowest_m, 7.0));
    for &end_m in &ends {
        draft.wall(&[(end_m, row.min.y), (end_m, row.max.y)]);
    }
    ends.push(row.max.x);
    let mut from_m = row.min.x;
    for end_m in ends {
        let name = draft.room(rect(from_m, row.min.y, end_m, row.max.y));
        let width_m = door_width_m(stream, robot_radius_m);
        let off_m = width_m / 2.0 + WALL_M;
        let at = Point::new(stream.uniform_in(from_m + off_m, end_m - off_m), wall_m);
        draft.door(name, at, width_m, Axis::X);
        from_m = end_m;
    }
}
