//! What the robot does with its wheels.

use super::hallway_drive::HallwayDrive;
use crate::routines::DoorwayDetection;
use rpl_robot::navigation::{LocalDrive, MaplessNavigation};
use serde::{Deserialize, Serialize};

/// What the robot does with its wheels.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Drive {
    /// Nothing.
    #[default]
    Idle,
    /// It drives along a hallway: direction-follow and registration.
    Hallway(Box<HallwayDrive>),
    /// It keeps a wall at its side.
    Wall {
        /// How.
        drive: Box<LocalDrive>,
        /// For how long it has not got on.
        stuck_s: f64,
    },
    /// It seeks a goal.
    Goal {
        /// How.
        navigation: Box<MaplessNavigation>,
        /// Looks for the door it is to come through, if it is to leave a room.
        doorways: Option<DoorwayDetection>,
    },
}
