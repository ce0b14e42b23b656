//! Rows of racks with aisles between them, and open floor at both ends.

use super::draft::{Draft, cuts, mostly_short, people, rect};
use super::furniture::furnish;
use crate::geometry::Vector;
use crate::world::{SeenBy, Shape};
use rpl_random::Stream;

/// Racks that are missing.
const MISSING: f64 = 0.12;

pub(super) fn draw(stream: &mut Stream, robot_radius_m: f64) -> Draft {
    let size_m = Vector::new(mostly_short(stream, 20.0, 100.0), mostly_short(stream, 14.0, 60.0));
    let mut draft = Draft::walled(size_m);
    let inside = draft.inside();
    let (west_m, east_m) = (inside.min.x + stream.uniform_in(3.0, 5.0), inside.max.x - stream.uniform_in(3.0, 5.0));
    let narrowest_m = 2.0_f64.max(2.0 * robot_radius_m + 1.2);
    let (aisle_m, depth_m) = (stream.uniform_in(narrowest_m, narrowest_m + 1.6), stream.uniform_in(0.8, 2.2));
    let crossing_m = stream.uniform_in(narrowest_m, narrowest_m + 1.0);
    let mut at_m = inside.min.y + aisle_m;
    while at_m + depth_m + aisle_m <= inside.max.y {
        let mut from_m = west_m;
        let mut ends = cuts(stream, west_m, east_m, (5.0, 14.0));
        ends.push(east_m + crossing_m / 2.0);
        for end_m in ends {
            if end_m - crossing_m / 2.0 > from_m && !stream.chance(MISSING) {
                let shape = Shape::Rect(rect(from_m, at_m, end_m - crossing_m / 2.0, at_m + depth_m));
                draft.fixture("rack", shape, SeenBy { sonar: true, laser: true });
            }
            from_m = end_m + crossing_m / 2.0;
        }
        draft.floors.push(rect(west_m, at_m - aisle_m, east_m, at_m));
        at_m += depth_m + aisle_m;
    }
    draft.floors.push(rect(inside.min.x, inside.min.y, west_m, inside.max.y));
    draft.floors.push(rect(east_m, inside.min.y, inside.max.x, inside.max.y));
    let pieces = 3 + stream.index(10);
    furnish(&mut draft, stream, pieces);
    draft.people = people(stream);
    draft
}
