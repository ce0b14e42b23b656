//! Where the robot is to drive to.

use crate::geometry::{Point, Pose};
use serde::{Deserialize, Serialize};

/// A point to drive to, in the frame the robot navigates in: `map`, or `odom` without a map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// Where.
    pub point_in_frame: Point,
    /// Which way to look there; only the last target of a plan has one.
    pub heading_rad: Option<f64>,
}

impl Target {
    /// A target the robot only passes through.
    pub fn through(point_in_frame: Point) -> Self {
        Self { point_in_frame, heading_rad: None }
    }

    /// A target to stand at and look from.
    pub fn at(pose_in_frame: Pose) -> Self {
        Self { point_in_frame: pose_in_frame.point(), heading_rad: Some(pose_in_frame.heading_rad) }
    }
}
