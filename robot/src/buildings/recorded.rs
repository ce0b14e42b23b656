//! Floor plans that somebody has recorded.

use super::draft::{Draft, people};
use super::furniture::{Furniture, furnish};
use crate::world::World;
use rpl_random::Stream;

/// Ground for each piece of furniture, which the robot's map has.
const PIECE_M2: f64 = 40.0;

/// The most pieces.
const MOST_PIECES: usize = 60;

pub(super) fn draw(plan: &World, stream: &mut Stream, furniture: Furniture) -> Draft {
    let mut draft = Draft {
        origin_in_map: plan.origin_in_map,
        recorded: plan.recorded.clone(),
        within: Some(plan.start_in_map.point()),
        ..Draft::new(plan.size_m)
    };
    draft.floors.push(plan.bounds());
    draft.people = people(stream);
    match furniture {
        Furniture::AsMapped => {}
        Furniture::Rearranged => {
            let count = (plan.size_m.x * plan.size_m.y / PIECE_M2) as usize;
            // The places are drawn from the same stream, and stay where they are.
            let mut stream = Stream::new(stream.clone().seed(), "pieces");
            furnish(&mut draft, &mut stream, count.min(MOST_PIECES));
        }
    }
    draft
}
