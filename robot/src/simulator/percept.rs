//! What goes into a step and what comes out of it.

use super::gripper::{GripperCommand, GripperStatus};
use crate::geometry::Pose;
use crate::sensors::SONARS;
use serde::{Deserialize, Serialize};

/// What the robot is asked to do during one step; the default is to stop.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Commands {
    /// Wanted speed ahead, negative backwards.
    pub translation_mps: f64,
    /// Wanted turning speed, counter-clockwise.
    pub rotation_radps: f64,
    /// Whether the sonars fire.
    pub sonars_on: bool,
    /// What the gripper is to begin.
    pub gripper: GripperCommand,
}

/// What the robot perceives at the end of one step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Percept {
    /// Time since the start.
    pub time_us: u64,
    /// Where dead reckoning says the robot is; the start is the origin.
    pub odometry_in_odom: Pose,
    /// Speed ahead, from the wheels.
    pub translation_mps: f64,
    /// Turning speed, from the wheels.
    pub rotation_radps: f64,
    /// Distance from the *middle of the robot* to the nearest surface in each sonar's cone (the
    /// radius of the ring is already added); the maximum range where there was no echo. None if the
    /// sonars are off or failed.
    pub sonar_m: Option<[f32; SONARS]>,
    /// Distance from the middle of the robot, [`LASER_READINGS`](crate::sensors::LASER_READINGS) of them; the maximum range where
    /// nothing came back. None if there is no laser.
    pub laser_m: Option<Vec<f32>>,
    /// Whether something presses against the body.
    pub bumped: bool,
    /// State of the gripper.
    pub gripper: GripperStatus,
    /// Charge of the battery, from 0 to 1.
    pub battery: f64,
    /// What people have sent since the last step, word by word.
    pub messages: Vec<Vec<String>>,
}
