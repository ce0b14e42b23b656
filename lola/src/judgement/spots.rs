//! What several looks along a hallway's side saw, place by place.

use crate::feature::{Feature, HiddenWall, Percept, Side};
use crate::features::{HIDES_BESIDE_M, opening_of_width};
use serde::{Deserialize, Serialize};

/// One drive along a hallway, or along a part of it, and all that was perceived. Places are along the axis
/// from the same start, and sides as seen in the same direction, for all looks: see [`Percept::turned`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Look {
    /// Where the part of the hallway begins whose sides were seen.
    pub from_m: f64,
    /// Where it ends.
    pub to_m: f64,
    /// Where the robot turned round for it, if it did: of what it was beside it saw the rest.
    pub turned_at_m: Option<f64>,
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

    /// Whether the wall was seen there, and nothing before it.
    fn sees(&self, side: Side, at_m: f64) -> bool {
        let is_hidden = |wall: &HiddenWall| wall.from_m <= at_m && at_m <= wall.to_m;
        self.covers(at_m) && !self.hidden_on(side).any(is_hidden)
    }

    /// What was perceived on a side, but for what somebody hid who stood before more than half of it: he may have
    /// looked so. Openings with too little between them for a wall are one.
    fn perceived(&self, side: Side) -> Vec<Percept> {
        let hidden_m = |percept: &Percept| {
            let overlap_m = |wall: &HiddenWall| {
                (wall.to_m - HIDES_BESIDE_M).min(percept.to_m) - (wall.from_m + HIDES_BESIDE_M).max(percept.from_m)
            };
            self.hidden_on(side).map(|wall| overlap_m(wall).max(0.0)).sum::<f64>()
        };
        let is_seen = |percept: &&Percept| percept.side == side && hidden_m(percept) <= percept.width_m() / 2.0;
        joined(self.percepts.iter().filter(is_seen))
    }

    /// Whether an opening may be wider than it was seen: it ends beside something that stood there, or where the robot
    /// had turned round.
    fn is_partial(&self, percept: &Percept) -> bool {
        let is_edge_hidden = |edge_m: f64| {
            let is_beside = |wall: &HiddenWall| {
                let near_m = HIDES_BESIDE_M - EDGE_M;
                (wall.from_m + near_m..=wall.to_m - near_m).contains(&edge_m)
            };
            self.turned_at_m.is_some_and(|turned_at_m| (edge_m - turned_at_m).abs() < TURNED_BESIDE_M)
                || self.hidden_on(percept.side).any(is_beside)
        };
        percept.seen > Feature::ClosedDoor && (is_edge_hidden(percept.from_m) || is_edge_hidden(percept.to_m))
    }

    /// Whether a feature of this kind would have shown there: things stand before closed doors alone.
    pub(super) fn shows(&self, feature: Feature, side: Side, at_m: f64) -> bool {
        self.sees(side, at_m) || feature != Feature::ClosedDoor && self.covers(at_m)
    }
}

/// What a look took something for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sighting {
    /// The kind; a wall for nothing.
    pub kind: Feature,
    /// Whether a part of it was hidden: then it may be of a wider kind.
    pub is_partial: bool,
}

impl Sighting {
    pub const NOTHING: Self = Self { kind: Feature::Wall, is_partial: false };
}

/// A place where some look perceived something.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Spot {
    /// The widest percept there.
    pub percept: Percept,
    /// What each look took it for; none if it did not come there, or something stood before it.
    pub seen: Vec<Option<Sighting>>,
}

/// Two looks see one thing if its middles are no farther apart: dead reckoning over a hallway and back, and
/// less than the width of a door with its frame, which is the least distance of two doors.
const SAME_PLACE_M: f64 = 0.9;

/// There is more wall between two openings: what parts them was somebody who stood there.
const LEAST_BETWEEN_M: f64 = 0.3;

/// An edge so near to what is hidden may be that of what hides it.
const EDGE_M: f64 = 0.3;

/// And one so near to where the robot turned round, that of what it saw then.
const TURNED_BESIDE_M: f64 = 0.8;

/// The spots of a side in order along the hallway. Cost: n log n in the percepts.
pub(super) fn spots(looks: &[Look], side: Side) -> Vec<Spot> {
    let of_look =
        |(number, look): (usize, &Look)| look.perceived(side).into_iter().map(move |percept| (number, percept));
    let mut percepts: Vec<(usize, Percept)> = looks.iter().enumerate().flat_map(of_look).collect();
    percepts.sort_by(|(_, a), (_, b)| a.middle_m().total_cmp(&b.middle_m()));
    let mut spots: Vec<Spot> = Vec::new();
    for (number, percept) in percepts {
        let sighting = Sighting { kind: percept.seen, is_partial: looks[number].is_partial(&percept) };
        let same = spots.last_mut().filter(|spot| is_same(&spot.percept, &percept));
        match same {
            Some(spot) if spot.seen[number].is_none_or(|seen| seen.kind == Feature::Wall) => {
                spot.seen[number] = Some(sighting);
                spot.percept = wider(spot.percept, percept);
            }
            Some(_) | None => {
                let at_m = percept.middle_m();
                let nothing = |look: &Look| look.sees(side, at_m).then_some(Sighting::NOTHING);
                let mut seen: Vec<_> = looks.iter().map(nothing).collect();
                seen[number] = Some(sighting);
                spots.push(Spot { percept, seen });
            }
        }
    }
    spots
}

/// Openings with too little between them for a wall are one.
fn joined<'a>(percepts: impl Iterator<Item = &'a Percept>) -> Vec<Percept> {
    let mut percepts: Vec<Percept> = percepts.copied().collect();
    percepts.sort_by(|one, other| one.middle_m().total_cmp(&other.middle_m()));
    let mut joined: Vec<Percept> = Vec::new();
    for percept in percepts {
        let is_open = |one: &Percept| one.seen > Feature::ClosedDoor;
        let is_rest =
            |last: &Percept| is_open(last) && is_open(&percept) && percept.from_m - last.to_m < LEAST_BETWEEN_M;
        match joined.last_mut().filter(|last| is_rest(last)) {
            Some(last) => {
                last.to_m = last.to_m.max(percept.to_m);
                last.seen = last.seen.max(percept.seen).max(opening_of_width(last.width_m(), false));
            }
            None => joined.push(percept),
        }
    }
    joined
}

/// Whether two looks saw one thing.
fn is_same(one: &Percept, other: &Percept) -> bool {
    let overlap_m = one.to_m.min(other.to_m) - one.from_m.max(other.from_m);
    other.middle_m() - one.middle_m() < SAME_PLACE_M || overlap_m > one.width_m().min(other.width_m()) / 2.0
}

fn wider(one: Percept, other: Percept) -> Percept {
    if other.width_m() > one.width_m() { other } else { one }
}
