//! Open ground, its fence missing here and there: what lies beyond the edge is nobody's.

use super::draft::{Draft, mostly_short, people, rect};
use super::furniture::{furnish, glaze, point_in};
use crate::geometry::{Point, Vector};
use crate::world::{Rect, SeenBy, Shape};
use rpl_random::Stream;

/// How wide gaps in the fence are.
const GAP_M: (f64, f64) = (2.0, 10.0);

pub(super) fn draw(stream: &mut Stream) -> Draft {
    let size_m = Vector::new(mostly_short(stream, 10.0, 60.0), mostly_short(stream, 10.0, 60.0));
    let mut draft = Draft::new(size_m);
    let Rect { min, max } = draft.outline();
    let corners = [min, Point::new(max.x, min.y), max, Point::new(min.x, max.y)];
    for side in 0..4 {
        fence(&mut draft, stream, corners[side], corners[(side + 1) % 4]);
    }
    let floor = draft.inside();
    draft.floors.push(floor);
    for _ in 0..stream.index(4) {
        let min = point_in(floor, stream);
        let size = Vector::new(stream.uniform_in(1.5, 5.0), stream.uniform_in(1.5, 5.0));
        let bounds = rect(min.x, min.y, min.x + size.x, min.y + size.y);
        if draft.has_room_for(bounds, &[]) {
            draft.fixture("shed", Shape::Rect(bounds), SeenBy { sonar: true, laser: true });
        }
    }
    glaze(&mut draft, stream);
    let pieces = 2 + stream.index(9);
    furnish(&mut draft, stream, pieces);
    draft.people = people(stream);
    draft
}

/// A fence from one corner to the next, with a gap on most sides.
fn fence(draft: &mut Draft, stream: &mut Stream, from: Point, to: Point) {
    let length_m = (to - from).norm();
    let along = (to - from) / length_m;
    let mut post = |from_m: f64, to_m: f64| {
        let (a, b) = (from + along * from_m, from + along * to_m);
        if to_m - from_m > 0.2 {
            draft.wall(&[(a.x, a.y), (b.x, b.y)]);
        }
    };
    if stream.chance(0.3) {
        return post(0.0, length_m);
    }
    let gap_m = stream.uniform_in(GAP_M.0, GAP_M.1.min(0.7 * length_m));
    let opens_m = stream.uniform_in(0.0, length_m - gap_m);
    post(0.0, opens_m);
    post(opens_m + gap_m, length_m);
}
