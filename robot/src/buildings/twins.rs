//! Rooms along a corridor that half a turn about its middle brings onto each other: only few things tell them apart.

use super::draft::{Draft, INSET_M, WALL_M, floor_within, mostly_short, people, rect};
use super::furniture::{furnish, half_turned};
use super::offices::row_of_rooms;
use crate::geometry::{Point, Vector};
use crate::world::{Object, Rect};
use rpl_random::Stream;

pub(super) fn draw(stream: &mut Stream, robot_radius_m: f64) -> Draft {
    let (length_m, width_m) = (mostly_short(stream, 9.0, 50.0), stream.uniform_in(1.8, 3.0));
    let depth_m = stream.uniform_in(3.2, 5.5);
    let size_m = Vector::new(length_m, 2.0 * depth_m + width_m) + Vector::new(INSET_M, INSET_M) * 2.0;
    let mut draft = Draft::walled(size_m);
    let Rect { min, max } = draft.outline();
    let middle = Point::from(size_m / 2.0);
    let corridor = rect(min.x, min.y + depth_m, max.x, max.y - depth_m);
    draft.hallways.push(floor_within(corridor));
    draft.wall(&[(min.x, corridor.min.y), (max.x, corridor.min.y)]);
    draft.wall(&[(min.x, corridor.max.y), (max.x, corridor.max.y)]);
    let walls = draft.walls.len();
    row_of_rooms(&mut draft, stream, robot_radius_m, rect(min.x, min.y, max.x, corridor.min.y), corridor.min.y);
    let rooms = draft.rooms.len();
    let pieces = rooms + stream.index(2 * rooms + 1);
    furnish(&mut draft, stream, pieces);
    turn_over(&mut draft, walls, middle);
    let apart = 1 + stream.index(3);
    furnish(&mut draft, stream, apart);
    draft.people = people(stream);
    draft
}

/// The same on the other side of the corridor, after half a turn: rooms, their doors, the walls between them from a
/// number on, and what stands in them.
fn turn_over(draft: &mut Draft, first_wall: usize, middle: Point) {
    let turned = |point: Point| middle + (middle - point);
    for index in first_wall..draft.walls.len() {
        let line: Vec<(f64, f64)> =
            draft.walls[index].line.iter().map(|&point| turned(point)).map(|point| (point.x, point.y)).collect();
        draft.wall(&line);
    }
    for index in 0..draft.rooms.len() {
        let (Rect { min, max }, door) = (draft.rooms[index].rect, draft.doors[index].clone());
        let half = Vector::new(WALL_M, WALL_M) / 2.0;
        let name = draft.room(Rect { min: turned(max) - half, max: turned(min) + half });
        draft.door(name, turned(door.at), door.width_m, door.axis);
    }
    let image = |piece: &Object| Object {
        name: format!("{}-twin", piece.name),
        shape: half_turned(&piece.shape, middle),
        ..piece.clone()
    };
    let images: Vec<Object> = draft.furniture.iter().map(image).collect();
    draft.furniture.extend(images);
}
