//! A single room that is larger than most sensors reach, with few things in it.

use super::draft::{Draft, mostly_short, people};
use super::furniture::{furnish, glaze, point_in};
use crate::geometry::Vector;
use crate::world::{SeenBy, Shape};
use rpl_random::Stream;

pub(super) fn draw(stream: &mut Stream) -> Draft {
    let size_m = Vector::new(mostly_short(stream, 20.0, 80.0), mostly_short(stream, 20.0, 80.0));
    let mut draft = Draft::walled(size_m);
    let floor = draft.inside();
    draft.floors.push(floor);
    for _ in 0..stream.index(7) {
        let shape = Shape::Circle { centre: point_in(floor, stream), radius_m: stream.uniform_in(0.15, 0.5) };
        draft.fixture("pillar", shape, SeenBy { sonar: true, laser: true });
    }
    glaze(&mut draft, stream);
    let pieces = stream.index(7);
    furnish(&mut draft, stream, pieces);
    draft.people = people(stream);
    draft
}
