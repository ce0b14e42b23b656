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

/// Readings of beyond the wall in a row.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Stretch {
    /// The part of the wall that their cones looked through.
    from_m: f64,
    to_m: f64,
    /// Where the robot was when the first and the last of them were heard.
    heard_from_m: f64,
    heard_to_m: f64,
    /// The nearest that was heard.
    depth_m: f64,
}

impl Stretch {
    fn of(point: &ContourPoint) -> Self {
        let (from_m, to_m) = point.footprint_m();
        let heard_m = point.robot_along_m;
        Self { from_m, to_m, heard_from_m: heard_m, heard_to_m: heard_m, depth_m: point.depth_m() }
    }

    fn with(self, later: &Self) -> Self {
        Self {
            to_m: self.to_m.max(later.to_m),
            heard_to_m: later.heard_to_m,
            depth_m: self.depth_m.min(later.depth_m),
            ..self
        }
    }

    fn heard_m(&self) -> f64 {
        self.heard_to_m - self.heard_from_m
    }
}

/// An opening under way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Passing {
    /// All of its stretches.
    whole: Stretch,
    /// The longest.
    longest_m: f64,
    /// Whether it was open when the detection began, so that its beginning is not known.
    is_cut: bool,
}

/// The monitor flag of a side.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct OpeningMonitor {
    passing: Option<Passing>,
    stretch: Option<Stretch>,
    /// Where the wall was heard again, without a break since, and how often.
    wall: Option<(f64, u32)>,
    has_heard_wall: bool,
}

/// How many readings of the wall in a row end an opening.
const WALL_READINGS: u32 = 3;

impl OpeningMonitor {
    /// The same before the last of the way, which is to be looked at once more.
    pub fn begun_anew(&self) -> Self {
        Self { has_heard_wall: self.has_heard_wall, ..Self::default() }
    }

    /// Takes in the reading of the transducer nearest to the perpendicular; answers the opening that has ended.
    pub fn take_in(&mut self, point: &ContourPoint, kept: &[ContourPoint]) -> Option<Found> {
        let along_m = point.robot_along_m;
        match point.heard() {
            Heard::Beyond => {
                self.wall = None;
                self.beyond(point);
                None
            }
            Heard::Obstacle => None,
            Heard::Wall => {
                let (from_m, count) = self.wall.unwrap_or((along_m, 0));
                self.wall = Some((from_m, count + 1));
                if count + 1 < WALL_READINGS || along_m - from_m < PARAMETERS.wall_again_m {
                    return None;
                }
                self.has_heard_wall = true;
                self.stretch = None;
                let has_ended = self.passing.as_ref().is_some_and(|passing| passing.is_wall_behind(kept));
                self.passing.take_if(|_| has_ended).and_then(|passing| passing.judged(kept))
            }
        }
    }

    fn beyond(&mut self, point: &ContourPoint) {
        let heard = Stretch::of(point);
        let goes_on = |stretch: &Stretch| heard.heard_to_m - stretch.heard_to_m <= PARAMETERS.break_m;
        let stretch = self.stretch.filter(goes_on).map_or(heard, |stretch| stretch.with(&heard));
        self.stretch = Some(stretch);
        if stretch.heard_m() < PARAMETERS.least_stretch_m {
            return;
        }
        let is_cut = !self.has_heard_wall;
        let passing = self.passing.get_or_insert(Passing { whole: stretch, longest_m: 0.0, is_cut });
        passing.whole = passing.whole.with(&stretch);
        passing.longest_m = passing.longest_m.max(stretch.heard_m());
    }

    /// Nothing comes any more: an opening under way ends at the hallway's end, which is the far wall of one that
    /// has no other, or where it was heard last.
    pub fn close(&mut self, end_m: Option<f64>, kept: &[ContourPoint]) -> Option<Found> {
        let mut passing = self.passing.take()?;
        if let Some(end_m) = end_m.filter(|_| self.wall.is_none() && !passing.is_wall_behind(kept)) {
            passing.whole.to_m = passing.whole.to_m.max(end_m);
        }
        passing.judged(kept)
    }

    /// The part of the wall that is open as far as was heard, while an opening is passed.
    pub fn passing_m(&self) -> Option<(f64, f64)> {
        self.passing.as_ref().map(|passing| (passing.whole.from_m, passing.whole.to_m))
    }
}

impl Passing {
    /// What it was, by its width.
    fn judged(&self, kept: &[ContourPoint]) -> Option<Found> {
        let Stretch { from_m, to_m, depth_m, .. } = self.whole;
        let p = &PARAMETERS;
        let is_narrow = to_m - from_m < p.least_width_m || self.longest_m < p.least_heard_m;
        if is_narrow || !self.is_heard_through(kept) {
            return None;
        }
        let is_hidden = is_hidden(from_m - HIDDEN_M, from_m, kept) || is_hidden(to_m, to_m + HIDDEN_M, kept);
        let seen = opening_of_width(to_m - from_m, is_hidden);
        let is_own_door = self.is_cut && seen == Feature::OpenDoor;
        (!is_own_door).then_some(Found { seen, from_m, to_m, depth_m })
    }

    /// Whether it is the wall that was heard where it seems to end, and not somebody who stands in it: the cones
    /// that look ahead and back have looked through there.
    fn is_wall_behind(&self, kept: &[ContourPoint]) -> bool {
        let to_m = self.whole.to_m;
        let (mut wall, mut beyond) = (0.0, 0.0);
        for point in kept {
            let is_behind = point.footprint_m().0 >= to_m - PARAMETERS.grain_m && point.foot_m() <= to_m + BEHIND_M;
            match point.heard() {
                Heard::Wall if is_behind => wall += 1.0,
                Heard::Beyond if is_behind => beyond += 1.0,
                Heard::Wall | Heard::Beyond | Heard::Obstacle => {}
            }
        }
        wall > 0.0 && wall >= PARAMETERS.least_share * (wall + beyond)
    }

    /// Whether most of the cones that looked wholly into it heard beyond the wall. What is no longer kept was wide
    /// enough.
    fn is_heard_through(&self, kept: &[ContourPoint]) -> bool {
        let (mut beyond, mut wall, mut obstacle) = (0.0, 0.0, 0.0);
        for point in kept {
            let (from_m, to_m) = point.footprint_m();
            // A cone that looks in aslant hears the side of the jamb, too, near it.
            let edge_m = 0.03 + 0.2 * point.reading.off_rad();
            if from_m >= self.whole.from_m + edge_m && to_m <= self.whole.to_m - edge_m {
                match point.heard() {
                    Heard::Beyond => beyond += 1.0,
                    Heard::Wall => wall += 1.0,
                    Heard::Obstacle => obstacle += 1.0,
                }
            }
        }
        let p = &PARAMETERS;
        beyond >= p.least_share * (beyond + wall) && beyond >= p.least_share_past * (beyond + wall + obstacle)
    }
}

/// How much of the wall behind an opening is looked at.
const BEHIND_M: f64 = 0.4;

/// Something that stands within this of an edge hides it.
const HIDDEN_M: f64 = 0.2;

/// Whether something stands before most of a part of the wall.
fn is_hidden(from_m: f64, to_m: f64, kept: &[ContourPoint]) -> bool {
    let here = kept.iter().filter(|point| point.is_nearest && (from_m..=to_m).contains(&point.foot_m()));
    let (all, hidden) =
        here.fold((0, 0), |(all, hidden), point| (all + 1, hidden + u32::from(point.heard() == Heard::Obstacle)));
    2 * hidden > all
}

/// Door, hallway or foyer: of one that is partly hidden, as much wider as the widest of its kind may be.
pub fn opening_of_width(width_m: f64, is_hidden: bool) -> Feature {
    let p = &PARAMETERS;
    let [hallway_m, foyer_m] = if is_hidden { p.hidden_m } else { [p.hallway_m, p.foyer_m] };
    if width_m < hallway_m {
        Feature::OpenDoor
    } else if width_m < foyer_m {
        Feature::Hallway
    } else {
        Feature::Foyer
    }
}
