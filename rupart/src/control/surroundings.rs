//! What the behaviours look at.

use rpl_robot::avoidance::{DriveLimits, open_distance_m};
use rpl_robot::geometry::Point;
use std::f64::consts::TAU;

/// The number of directions all around in which ways are looked for.
const DIRECTIONS: u32 = 36;

/// What stands around the robot, and where it is to go.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings<'a> {
    /// What the robot can do.
    pub limits: &'a DriveLimits,
    /// What was heard lately.
    pub obstacles_in_base: &'a [Point],
    /// The short-term goal.
    pub goal_in_base: Option<Point>,
}

impl Surroundings<'_> {
    /// How far the robot could go straight in a direction, up to a limit.
    pub fn open_m(&self, direction_rad: f64, horizon_m: f64) -> f64 {
        open_distance_m(self.limits, self.obstacles_in_base, direction_rad, horizon_m)
    }

    /// How near to the robot's rim something is whose bearing is between two, counter-clockwise from ahead;
    /// infinite if nothing is.
    pub fn nearest_m(&self, from_rad: f64, to_rad: f64) -> f64 {
        let off_rim_m = |point: &Point| {
            let bearing_rad = libm::atan2(point.y, point.x);
            (from_rad <= bearing_rad && bearing_rad <= to_rad)
                .then(|| (point.coords.norm() - self.limits.robot_radius_m).max(0.0))
        };
        self.obstacles_in_base.iter().filter_map(off_rim_m).fold(f64::INFINITY, f64::min)
    }

    /// Of the directions that are open so far, the one least off a wanted one. Cost: a look in each direction.
    pub fn gap_rad(&self, wanted_rad: f64, open_m: f64) -> Option<f64> {
        // The least off come first, left before right.
        let off = (0..=DIRECTIONS / 2).flat_map(|step| {
            let off_rad = f64::from(step) * TAU / f64::from(DIRECTIONS);
            [wanted_rad + off_rad, wanted_rad - off_rad]
        });
        off.into_iter().find(|&direction_rad| self.open_m(direction_rad, open_m) >= open_m)
    }
}
