//! Where people stay who gather about the robot.

use crate::geometry::{Point, Pose, Vector, distance_m};
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI};

/// People stay on both sides of the robot, within this angle of what is straight to its left or right, so that it can
/// drive, and half of its beams are free.
const FLANK_RAD: f64 = 28.0 / 180.0 * PI;

/// Those next to the robot stay so far from its middle.
const NEAREST_M: f64 = 1.0;

/// People for each square metre: they stand in groups, and do not touch.
const PER_M2: f64 = 1.0;

/// The golden section spreads consecutive people over the angles.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Where a person stays beside the robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Company {
    /// From the foremost bearing on the left side, or the hindmost on the right, to the left.
    flank_rad: f64,
    /// From the middle of the robot.
    pub distance_m: f64,
}

impl Company {
    /// That of the nth person: the next one as much farther as room for one takes.
    pub fn of(number: usize) -> Self {
        let area_m2 = number as f64 / PER_M2;
        let distance_m = (NEAREST_M * NEAREST_M + area_m2 / (2.0 * FLANK_RAD)).sqrt();
        Self { flank_rad: number as f64 * GOLDEN % 1.0 * 2.0 * FLANK_RAD, distance_m }
    }

    /// The spots at its distance and at the nth of the angles that are tried in turn, on the left and on the right of a
    /// robot: nobody needs to walk when it turns round.
    pub fn spots_in_map(&self, robot_in_map: Pose, number: usize) -> [Point; 2] {
        let on_rad = number as f64 * GOLDEN % 1.0 * 2.0 * FLANK_RAD;
        let bearing_rad = FRAC_PI_2 - FLANK_RAD + (self.flank_rad + on_rad) % (2.0 * FLANK_RAD);
        [bearing_rad, bearing_rad + PI].map(|bearing_rad| {
            let (sin, cos) = libm::sincos(robot_in_map.heading_rad + bearing_rad);
            robot_in_map.point() + Vector::new(cos, sin) * self.distance_m
        })
    }

    /// The nearer of the two to somebody.
    pub fn nearer_spot_in_map(&self, robot_in_map: Pose, at_in_map: Point) -> Point {
        let [left, right] = self.spots_in_map(robot_in_map, 0);
        if distance_m(at_in_map, left) <= distance_m(at_in_map, right) { left } else { right }
    }
}
