//! The monitor of what stands before the wall of a side.

use super::contour::{ContourPoint, Heard};
use crate::feature::{HiddenWall, Side};
use serde::{Deserialize, Serialize};

/// Something that is heard again within this distance is still the same.
const BREAK_M: f64 = 0.1;

/// Shorter things leave enough of a door to be seen; whoever walks by is one.
const LEAST_M: f64 = 0.25;

/// How much of the wall beside it is seen no better: a closed door shows by its leaf and the wall on both sides.
pub const HIDES_BESIDE_M: f64 = 0.4;

/// The parts of a side that are hidden.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct HiddenMonitor {
    /// From and to, in order.
    parts_m: Vec<(f64, f64)>,
}

impl HiddenMonitor {
    /// Takes in the reading of the transducer nearest to the perpendicular.
    pub fn take_in(&mut self, point: &ContourPoint) {
        if point.heard() != Heard::Obstacle {
            return;
        }
        let at_m = point.foot_m();
        match self.parts_m.last_mut() {
            Some(part) if at_m - part.1 <= BREAK_M => part.1 = part.1.max(at_m),
            Some(_) | None => self.parts_m.push((at_m, at_m)),
        }
    }

    /// What is hidden of the wall, in order.
    pub fn walls(&self, side: Side) -> impl Iterator<Item = HiddenWall> {
        let long = self.parts_m.iter().filter(|(from_m, to_m)| to_m - from_m >= LEAST_M);
        long.map(move |(from_m, to_m)| HiddenWall {
            side,
            from_m: from_m - HIDES_BESIDE_M,
            to_m: to_m + HIDES_BESIDE_M,
        })
    }
}
