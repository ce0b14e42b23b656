//! The monitor of openings on a side: from where the transducers hear beyond the wall to where they hear the wall
//! again.

use super::contour::{ContourPoint, Heard};
use super::parameters::PARAMETERS;
use crate::feature::Feature;
use serde::{Deserialize, Serialize};

/// An opening or an indentation that was passed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Found {
    pub seen: Feature,
    pub from_m: f64,
    pub to_m: f64,
    pub depth_m: f64,
}

/// An opening under way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Passing {
    /// The part of the wall that the cones which heard beyond it looked through.
    from_m: f64,
    to_m: f64,
    /// Where the robot was when the first and the last of them did.
    heard_from_m: f64,
    heard_to_m: f64,
    /// The nearest that was heard in it.
    depth_m: f64,
    /// Where the wall was heard again, without a break since, and how often.
    wall_from_m: Option<f64>,
    wall_count: u32,
    /// Whether it was open when the detection began, so that its beginning is not known.
    is_cut: bool,
}

/// The monitor flag of a side.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct OpeningMonitor {
    passing: Option<Passing>,
    has_heard_wall: bool,
}

/// So many readings of the wall in a row end an opening.
const WALL_READINGS: u32 = 3;

impl OpeningMonitor {
    /// Takes in the reading of the transducer nearest to the perpendicular; answers the opening that has ended.
    pub fn take_in(&mut self, point: &ContourPoint, kept: &[ContourPoint]) -> Option<Found> {
        let along_m = point.robot_along_m;
        match point.heard() {
            Heard::Beyond => {
                self.beyond(point);
                None
            }
            Heard::Obstacle => None,
            Heard::Wall => {
                self.has_heard_wall = true;
                let passing = self.passing.as_mut()?;
                let from_m = *passing.wall_from_m.get_or_insert(along_m);
                passing.wall_count += 1;
                let has_ended = passing.wall_count >= WALL_READINGS && along_m - from_m >= PARAMETERS.wall_again_m;
                if has_ended { self.passing.take().and_then(|passing| passing.judged(kept)) } else { None }
            }
        }
    }

    fn beyond(&mut self, point: &ContourPoint) {
        let (from_m, to_m) = point.footprint_m();
        let along_m = point.robot_along_m;
        let is_cut = !self.has_heard_wall;
        let passing = self.passing.get_or_insert(Passing {
            from_m,
            to_m,
            heard_from_m: along_m,
            heard_to_m: along_m,
            depth_m: f64::INFINITY,
            wall_from_m: None,
            wall_count: 0,
            is_cut,
        });
        passing.to_m = passing.to_m.max(to_m);
        passing.heard_to_m = along_m;
        passing.depth_m = passing.depth_m.min(point.depth_m());
        (passing.wall_from_m, passing.wall_count) = (None, 0);
    }

    /// Nothing comes any more: an opening under way ends at the hallway's end, which is the far wall of one that
    /// has no other, or where it was heard last.
    pub fn close(&mut self, end_m: Option<f64>, kept: &[ContourPoint]) -> Option<Found> {
        let passing = self.passing.take()?;
        let is_open = passing.wall_from_m.is_none();
        let to_m = end_m.filter(|_| is_open).map_or(passing.to_m, |end_m| end_m.max(passing.to_m));
        Passing { to_m, ..passing }.judged(kept)
    }

    /// The part of the wall that is open as far as was heard, while an opening is passed.
    pub fn passing_m(&self) -> Option<(f64, f64)> {
        self.passing.as_ref().map(|passing| (passing.from_m, passing.to_m))
    }
}

impl Passing {
    /// What it was, by its width.
    fn judged(&self, kept: &[ContourPoint]) -> Option<Found> {
        let width_m = self.to_m - self.from_m;
        let heard_m = self.heard_to_m - self.heard_from_m;
        let p = &PARAMETERS;
        if heard_m < p.least_heard_m || width_m < p.least_width_m || self.share(kept) < p.least_share {
            return None;
        }
        let seen = opening_of_width(width_m);
        let is_own_door = self.is_cut && seen == Feature::OpenDoor;
        (!is_own_door).then_some(Found { seen, from_m: self.from_m, to_m: self.to_m, depth_m: self.depth_m })
    }

    /// Of the cones that looked wholly into it, the share that heard beyond the wall; something that stands
    /// before it says nothing. What is no longer kept was wide enough.
    fn share(&self, kept: &[ContourPoint]) -> f64 {
        let (mut beyond, mut all) = (0.0, 0.0);
        for point in kept {
            let (from_m, to_m) = point.footprint_m();
            // A cone that looks in aslant hears the side of the jamb, too, near it.
            let edge_m = 0.03 + 0.2 * point.reading.off_rad();
            if from_m >= self.from_m + edge_m && to_m <= self.to_m - edge_m {
                match point.heard() {
                    Heard::Beyond => (beyond, all) = (beyond + 1.0, all + 1.0),
                    Heard::Wall => all += 1.0,
                    Heard::Obstacle => {}
                }
            }
        }
        if all > 0.0 { beyond / all } else { 1.0 }
    }
}

/// Door, hallway or foyer.
pub(super) fn opening_of_width(width_m: f64) -> Feature {
    if width_m < PARAMETERS.hallway_m {
        Feature::OpenDoor
    } else if width_m < PARAMETERS.foyer_m {
        Feature::Hallway
    } else {
        Feature::Foyer
    }
}
