//! Lengths, angles and places as the page has them: whole millimetres and milliradians.

use rpl_page::place::{Pose, Spot};
use rpl_robot::geometry::{self, Point};
use std::f64::consts::TAU;

/// Millimetres.
pub fn mm(length_m: f64) -> i32 {
    (length_m * 1000.0).round() as i32
}

/// Milliradians.
pub fn mrad(angle_rad: f64) -> i32 {
    (angle_rad * 1000.0).round() as i32
}

/// A point as the page has it.
pub fn spot(point: Point) -> Spot {
    [mm(point.x), mm(point.y)]
}

/// A pose as the page has it.
pub fn pose(pose: geometry::Pose) -> Pose {
    [mm(pose.x_m), mm(pose.y_m), mrad(pose.heading_rad.rem_euclid(TAU))]
}
