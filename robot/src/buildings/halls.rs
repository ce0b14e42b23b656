//! A single room that is larger than most sensors reach, with few things in it.

use super::draft::{Draft, mostly_short, people};
use super::furniture::{furnish, glaze, point_in};
use crate::geometry::Vector;
use crate::world::{Rect, SeenBy, Shape};
use rpl_random::Stream;

pub(super) fn draw(stream: &mut Stream) -> Draft {
    let size_m = Vector::new(mostly_short(stream, 20.0, 80.0), mostly_short(stream, 20.0, 80.0));
    let mut draft = Draft::walled(size_m);
    let floor = draft.inside();
    draft.floors.push(floor);
    for _ in 0..stream.index(7) {
        let (centre, radius_m) = (point_in(floor, stream), stream.uniform_in(0.15, 0.5));
        let reach = Vector::new(radius_m, radius_m);
        if draft.has_room_for(Rect { min: centre - reach, max: centre + reach }, &[]) {
            draft.fixture("pillar", Shape::Circle { centre, radius_m }, SeenBy { sonar: true, laser: true });
        }
    }
    glaze(&mut draft, stream);
    let pieces = stream.index(7);
    furnish(&mut draft, stream, pieces);
    draft.people = people(stream);
    draft
}
