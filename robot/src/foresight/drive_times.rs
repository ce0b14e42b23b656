//! How long a drive takes: a constant, the length in each travel mode at the speed of that mode, and the
//! turns. Fitted to undisturbed drives of the simulated robot; `rpl experiment drive-times` measures the
//! error.

use crate::description::RobotDescription;
use crate::world::TravelMode;
use serde::{Deserialize, Serialize};

/// What of a way makes it long.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WayFeatures {
    /// Length in hallways.
    pub hallway_m: f64,
    /// Length among furniture.
    pub office_m: f64,
    /// Length through doors.
    pub doorway_m: f64,
    /// Turns of its corners, of the start and of the end.
    pub turned_rad: f64,
}

impl WayFeatures {
    /// Its length.
    pub fn length_m(&self) -> f64 {
        self.hallway_m + self.office_m + self.doorway_m
    }

    /// Adds a stretch.
    pub fn add(&mut self, mode: TravelMode, length_m: f64) {
        match mode {
            TravelMode::Hallway => self.hallway_m += length_m,
            TravelMode::Office => self.office_m += length_m,
            TravelMode::Doorway => self.doorway_m += length_m,
        }
    }
}

/// The table by which drives are timed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DriveTimes {
    /// Of every drive: speeding up, braking, arriving.
    pub constant_s: f64,
    /// Of a metre in a hallway.
    pub hallway_s_per_m: f64,
    /// Of a metre among furniture.
    pub office_s_per_m: f64,
    /// Of a metre through a door.
    pub doorway_s_per_m: f64,
    /// Of a turn.
    pub turn_s_per_rad: f64,
}

/// How much longer a metre takes than at the speed of its mode, a turn than at the speed of
/// turning, and the constant in seconds: least squares of the relative error over 38 drives of `b21` between
/// places of `dept`, `rpl experiment drive-times --row dept --runs 40`. Doorways take less than their length:
/// the mode is set a moment after the robot has entered one.
const CONSTANT_S: f64 = 1.39;
const HALLWAY_FACTOR: f64 = 1.017;
const OFFICE_FACTOR: f64 = 1.031;
const DOORWAY_FACTOR: f64 = 0.637;
const TURN_FACTOR: f64 = 0.876;

impl DriveTimes {
    /// Of a robot, by how it is driven.
    pub fn of(robot: &RobotDescription) -> Self {
        let driving = &robot.driving;
        Self {
            constant_s: CONSTANT_S,
            hallway_s_per_m: HALLWAY_FACTOR / driving.hallway_mps,
            office_s_per_m: OFFICE_FACTOR / driving.office_mps,
            doorway_s_per_m: DOORWAY_FACTOR / driving.doorway_mps,
            turn_s_per_rad: TURN_FACTOR / driving.max_rotation_radps,
        }
    }

    /// How long a robot takes to look around: turns of 30°, 60° and 30°, each with its speeding up and
    /// braking.
    pub fn look_s(robot: &RobotDescription) -> f64 {
        let driving = &robot.driving;
        let starts_s = 3.0 * driving.max_rotation_radps / driving.rotation_acceleration_radps2;
        120.0_f64.to_radians() / driving.max_rotation_radps + starts_s
    }

    /// Of a metre in a mode.
    pub fn metre_s(&self, mode: TravelMode) -> f64 {
        match mode {
            TravelMode::Hallway => self.hallway_s_per_m,
            TravelMode::Office => self.office_s_per_m,
            TravelMode::Doorway => self.doorway_s_per_m,
        }
    }

    /// Of a way.
    pub fn time_s(&self, way: &WayFeatures) -> f64 {
        self.constant_s
            + way.hallway_m * self.hallway_s_per_m
            + way.office_m * self.office_s_per_m
            + way.doorway_m * self.doorway_s_per_m
            + way.turned_rad * self.turn_s_per_rad
    }
}
