//! Walls as lines along the axes, and intervals along them.

use super::hallway::Hallway;
use super::interval::{Interval, Millimetres};
use crate::feature::Feature;
use rpl_robot::world::Axis;
use std::collections::BTreeMap;

/// A wall along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WallLine {
    /// Along which axis it runs.
    pub axis: Axis,
    /// Its middle, across that axis.
    pub across_mm: Millimetres,
    /// Its ends.
    pub along_mm: Interval,
}

/// With both ends moved inwards, or outwards by a negative length.
pub fn shrunk((from_mm, to_mm): Interval, by_mm: Millimetres) -> Interval {
    (from_mm + by_mm, to_mm - by_mm)
}

/// Whether two share more than an end.
pub fn overlap(one: Interval, other: Interval) -> bool {
    one.0 < other.1 && other.0 < one.1
}

/// What is left of some intervals when another is cut out of them.
pub fn without(intervals: &[Interval], cut: Interval) -> Vec<Interval> {
    let pieces = |&(from_mm, to_mm): &Interval| [(from_mm, to_mm.min(cut.0)), (from_mm.max(cut.1), to_mm)];
    intervals.iter().flat_map(pieces).filter(|(from_mm, to_mm)| from_mm < to_mm).collect()
}

/// Each wall once, as long as it is: a door must stand in one wall.
pub fn joined(walls: &[WallLine]) -> Vec<WallLine> {
    let mut lines: BTreeMap<(bool, Millimetres), Vec<Interval>> = BTreeMap::new();
    for wall in walls {
        lines.entry((wall.axis == Axis::Y, wall.across_mm)).or_default().push(wall.along_mm);
    }
    let mut joined: Vec<WallLine> = Vec::new();
    for ((is_along_y, across_mm), mut pieces) in lines {
        pieces.sort_unstable();
        let axis = if is_along_y { Axis::Y } else { Axis::X };
        let mut last: Option<Interval> = None;
        for (from_mm, to_mm) in pieces {
            last = match last {
                Some((begun_mm, reached_mm)) if from_mm <= reached_mm => Some((begun_mm, reached_mm.max(to_mm))),
                done => {
                    joined.extend(done.map(|along_mm| WallLine { axis, across_mm, along_mm }));
                    Some((from_mm, to_mm))
                }
            };
        }
        joined.extend(last.map(|along_mm| WallLine { axis, across_mm, along_mm }));
    }
    joined
}

/// With foyers cut out of the walls of hallways. A wall reaches half its thickness beyond its ends, so that
/// as much more is cut out at both.
pub fn without_foyers(walls: Vec<WallLine>, hallways: &[Hallway], walls_mm: Millimetres) -> Vec<WallLine> {
    let half_mm = walls_mm / 2;
    let mut left = Vec::with_capacity(walls.len());
    for wall in walls {
        let beside = hallways.iter().filter(|hallway| {
            let (low_mm, high_mm) = shrunk(hallway.across_mm, -half_mm);
            hallway.axis == wall.axis && (wall.across_mm == low_mm || wall.across_mm == high_mm)
        });
        let mut pieces = vec![wall.along_mm];
        for hallway in beside {
            let side = hallway.side_towards(wall.across_mm > hallway.across_mm.0);
            for foyer in hallway.side(side).iter().filter(|found| found.feature == Feature::Foyer) {
                pieces = without(&pieces, shrunk((foyer.from_mm, foyer.to_mm), -half_mm));
            }
        }
        left.extend(pieces.into_iter().map(|along_mm| WallLine { along_mm, ..wall }));
    }
    left
}
