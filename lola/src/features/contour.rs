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

/// The side reference: where the wall is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct WallReference {
    /// How far to the side of the line on which the detection was started.
    pub aside_m: Option<f64>,
    /// What was heard lately: where along, and how far aside.
    recent_m: Vec<(f64, f64)>,
    /// Where along it was last heard to be right.
    held_at_m: f64,
}

impl WallReference {
    pub fn new(aside_m: Option<f64>) -> Self {
        Self { aside_m, recent_m: Vec::new(), held_at_m: 0.0 }
    }

    /// Takes in what the nearest transducer heard: where a wall of this echo would be.
    pub fn take_in(&mut self, along_m: f64, heard_aside_m: f64) {
        self.recent_m.push((along_m, heard_aside_m));
        self.recent_m.retain(|(at_m, _)| (along_m - at_m).abs() <= PARAMETERS.reference_m);
        let mut asides_m: Vec<f64> = self.recent_m.iter().map(|(_, aside_m)| *aside_m).collect();
        asides_m.sort_by(f64::total_cmp);
        let (median_m, spread_m) =
            (asides_m[asides_m.len() / 2], asides_m[asides_m.len() * 3 / 4] - asides_m[asides_m.len() / 4]);
        let is_flat = spread_m < PARAMETERS.obstacle_m && asides_m.len() >= 6;
        match self.aside_m {
            None if is_flat => self.hold(along_m, median_m),
            None => {}
            Some(aside_m) if (median_m - aside_m).abs() <= PARAMETERS.obstacle_m => {
                // A leaf pulls it a little, the wall behind pulls it back.
                self.hold(along_m, aside_m + (median_m - aside_m) * PARAMETERS.scan_m / PARAMETERS.reference_m);
            }
            Some(aside_m) => {
                let is_new = median_m < aside_m && (along_m - self.held_at_m).abs() > PARAMETERS.new_wall_m;
                if is_flat && is_new {
                    self.hold(along_m, median_m);
                }
            }
        }
    }

    fn hold(&mut self, along_m: f64, aside_m: f64) {
        self.aside_m = Some(aside_m);
        self.held_at_m = along_m;
    }
}
