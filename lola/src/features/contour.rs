//! The contour line of a side: what the sonars that look there heard along the way, against the side reference.

use super::parameters::PARAMETERS;
use crate::beside::SideReading;
use serde::{Deserialize, Serialize};

/// A reading of the contour.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContourPoint {
    /// Where the robot was, along the axis.
    pub robot_along_m: f64,
    /// How far it was to the side of the line on which the detection was started.
    pub robot_aside_m: f64,
    /// The reading.
    pub reading: SideReading,
    /// Whether it is of the transducer that was nearest to the perpendicular.
    pub is_nearest: bool,
    /// The side reference then: how far the wall is to the side of the line on which the detection was started.
    pub wall_aside_m: f64,
}

/// What a reading is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Heard {
    /// Something before the wall.
    Obstacle,
    /// The wall, or a leaf in it.
    Wall,
    /// Something behind it, or nothing.
    Beyond,
}

impl ContourPoint {
    /// The perpendicular distance of the wall from the transducer.
    pub fn wall_distance_m(&self) -> f64 {
        self.wall_aside_m - self.robot_aside_m - self.reading.apex_aside_m
    }

    /// How much deeper than the wall it was heard, negative before it; infinite for silence.
    pub fn depth_m(&self) -> f64 {
        self.reading.perpendicular_m() - self.wall_distance_m()
    }

    /// The part of the wall in the cone, along the axis.
    pub fn footprint_m(&self) -> (f64, f64) {
        let (from_m, to_m) = self.reading.footprint_m(self.wall_distance_m());
        (self.robot_along_m + from_m, self.robot_along_m + to_m)
    }

    /// Where on the wall the echo of a wall would come from, along the axis.
    pub fn foot_m(&self) -> f64 {
        self.robot_along_m + self.reading.foot_m(self.wall_distance_m())
    }

    /// Whether it tells of openings: the one transducer whose cone has the perpendicular in it.
    pub(super) fn is_of_opening(&self) -> bool {
        self.is_nearest && self.reading.nearest_rad() == 0.0
    }

    pub(super) fn heard(&self) -> Heard {
        let depth_m = self.depth_m();
        if depth_m < -PARAMETERS.obstacle_m {
            Heard::Obstacle
        } else if depth_m <= PARAMETERS.opening_m {
            Heard::Wall
        } else {
            Heard::Beyond
        }
    }
}

/// The side reference as long as registration knows of no wall on a side: the median of what the nearest transducer
/// heard over the last 25 cm, where that is flat.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct WallReference {
    /// How far to the side of the line on which the detection was started.
    pub aside_m: Option<f64>,
    /// What was heard lately: where along, and how far aside.
    recent_m: Vec<(f64, f64)>,
}

/// With fewer readings there is no median.
const LEAST_READINGS: usize = 6;

impl WallReference {
    /// Takes in what the nearest transducer heard: where a wall of this echo would be.
    pub fn take_in(&mut self, along_m: f64, heard_aside_m: f64) {
        self.recent_m.push((along_m, heard_aside_m));
        self.recent_m.retain(|(at_m, _)| (along_m - at_m).abs() <= PARAMETERS.reference_m);
        let mut asides_m: Vec<f64> = self.recent_m.iter().map(|(_, aside_m)| *aside_m).collect();
        asides_m.sort_by(f64::total_cmp);
        let quarter_m = |quarters: usize| asides_m[asides_m.len() * quarters / 4];
        if asides_m.len() >= LEAST_READINGS && quarter_m(3) - quarter_m(1) < PARAMETERS.obstacle_m {
            // A box or a person is nearer than a wall, the wall of a room behind a door is farther.
            let median_m = quarter_m(2);
            self.aside_m = Some(self.aside_m.map_or(median_m, |aside_m| aside_m.min(median_m)));
        }
    }
}
