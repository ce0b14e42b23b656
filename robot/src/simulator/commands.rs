//! What goes into a step.

use super::gripper::GripperCommand;
use crate::sensors::Signals;
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
    /// What the camera is to do; off without one.
    pub camera: Option<CameraCommand>,
    /// The motors are cut and the brakes close, whatever speeds are wanted: what a host does by itself when
    /// nobody commands it any more. No plan commands it.
    pub motors_off: bool,
    /// What is asked of what the simulator does not know; a host that knows it takes it from here.
    pub others: Signals,
}

/// What a camera that is on is to do during one step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CameraCommand {
    /// Wanted turning speed of the pan unit, counter-clockwise.
    pub pan_radps: f64,
}
