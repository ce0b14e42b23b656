//! What several looks along a hallway's side saw, place by place.

use crate::feature::{Feature, HiddenWall, Percept, Side};
use serde::{Deserialize, Serialize};

/// One drive along a hallway, or along a part of it, and all that was perceived. Places are along the axis
/// from the same start, and sides as seen in the same direction, for all looks: see [`Percept::turned`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Look {
    /// Where the part of the hallway begins whose sides were seen.
    pub from_m: f64,
    /// Where it ends.
    pub to_m: f64,
    /// What was perceived there.
    pub percepts: Vec<Percept>,
    /// Where something stood before the wall.
    pub hidden: Vec<HiddenWall>,
}

impl Look {
    /// Whether the sides were seen there.
    pub fn covers(&self, at_m: f64) -> bool {
        self.from_m <= at_m && at_m <= self.to_m
    }

    /// The parts of a side that something hid.
    pub(super) fn hidden_on(&self, side: Side) -> impl Iterator<Item = &HiddenWall> {
        self.hidden.iter().filter(move |wall| wall.side == side)
    }

    /// Whether a feature of this kind would have shown there: something before the wall hides closed doors alone.
    pub(super) fn shows(&self, feature: Feature, side: Side, at_m: f64) -> bool {
        let is_hidden = |wall: &HiddenWall| wall.from_m <= at_m && at_m <= wall.to_m;
        self.covers(at_m) && !(feature == Feature::ClosedDoor && self.hidden_on(side).any(is_hidden))
    }
}

/// A place where some look perceived something.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Spot {
    /// The first percept there.
    pub percept: Percept,
    /// What each look took it for; none if it did not come there.
    pub seen: Vec<Option<Feature>>,
}

/// Two looks see one thing if its middles are no farther apart: dead reckoning over a hallway and back, and
/// less than the width of a door with its frame, which is the least distance of two doors.
const SAME_PLACE_M: f64 = 0.9;

/// The spots of a side in order along the hallway. Cost: n log n in the percepts.
pub(super) fn spots(looks: &[Look], side: Side) -> Vec<Spot> {
    let numbered =
        looks.iter().enumerate().flat_map(|(look, of)| of.percepts.iter().map(move |percept| (look, percept)));
    let mut percepts: Vec<(usize, &Percept)> = numbered.filter(|(_, percept)| percept.side == side).collect();
    percepts.sort_by(|(_, a), (_, b)| a.middle_m().total_cmp(&b.middle_m()));
    let mut spots: Vec<Spot> = Vec::new();
    for (look, percept) in percepts {
        let at_m = percept.middle_m();
        let same = spots.last_mut().filter(|spot| at_m - spot.percept.middle_m() < SAME_PLACE_M);
        match same.map(|spot| &mut spot.seen[look]) {
            Some(seen @ (None | Some(Feature::Wall))) => *seen = Some(percept.seen),
            _ => {
                let mut seen: Vec<_> = looks.iter().map(|look| look.covers(at_m).then_some(Feature::Wall)).collect();
                seen[look] = Some(percept.seen);
                spots.push(Spot { percept: *percept, seen });
            }
        }
    }
    spots
}
