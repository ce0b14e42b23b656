//! Where people stay who gather about the robot.

use crate::geometry::{Point, Pose, Vector};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Nobody stays ahead of the robot within this angle to either side, so that it can drive and half of its beams are free.
const OPEN_RAD: f64 = std::f64::consts::FRAC_PI_2;

/// The angle they stay in, around its back.
const ANGLE_RAD: f64 = TAU - 2.0 * OPEN_RAD;

/// Those next to the robot stay so far from its middle.
const NEAREST_M: f64 = 0.9;

/// People for each square metre: they stand close, and do not touch.
const PER_M2: f64 = 1.5;

/// The golden section spreads consecutive people over the angles.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Where a person stays beside the robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Company {
    /// From straight ahead to the left.
    bearing_rad: f64,
    /// From the middle of the robot.
    pub distance_m: f64,
}

impl Company {
    /// That of the so-manieth person: all around but ahead, the next one as much farther as room for one takes.
    pub fn of(number: usize) -> Self {
        let bearing_rad = OPEN_RAD + number as f64 * GOLDEN % 1.0 * ANGLE_RAD;
        let area_m2 = number as f64 / PER_M2;
        Self { bearing_rad, distance_m: (NEAREST_M * NEAREST_M + 2.0 * area_m2 / ANGLE_RAD).sqrt() }
    }

    /// The same so far away, at the so-manieth of the angles that are tried in turn.
    pub fn at_angle(&self, number: usize) -> Self {
        let on_rad = number as f64 * GOLDEN % 1.0 * ANGLE_RAD;
        Self { bearing_rad: OPEN_RAD + (self.bearing_rad - OPEN_RAD + on_rad) % ANGLE_RAD, ..*self }
    }

    /// Beside a robot.
    pub fn spot_in_map(&self, robot_in_map: Pose) -> Point {
        let (sin, cos) = libm::sincos(robot_in_map.heading_rad + self.bearing_rad);
        robot_in_map.point() + Vector::new(cos, sin) * self.distance_m
    }
}
