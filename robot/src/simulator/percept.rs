//! What comes out of a step: the one list of the sensors, and what follows from it, the percept and the random
//! stream of each. How they look stands in `sensors`.

use super::gripper::GripperStatus;
use crate::geometry::Pose;
use crate::sensors::{CameraReading, FailedSensors, Signals};
use rpl_random::Stream;
use serde::{Deserialize, Serialize};

/// Gives the list of the sensors to a macro: the field of the percept, what a sensor reads, its stream, and the method
/// of the model that reads it.
macro_rules! with_sensors {
    ($made:ident) => {
        $made! {
            /// Distance from each sonar's mount, which of a ring is the *middle of the robot*, to the nearest surface
            /// in its cone, in the order of the description; the maximum range where there was no echo. None if
            /// there are no sonars, or they are off or failed.
            sonar_m: Option<Vec<f32>> = sonar, fire_sonars;
            /// Distance from the middle of the robot, in the order of
            /// [`LaserScanner::direction_rad`](crate::sensors::LaserScanner::direction_rad); the maximum range where
            /// nothing came back. None if there is no laser.
            laser_m: Option<Vec<f32>> = laser, scan_laser;
            /// Where the camera is turned to, and what it sees. None if there is no camera, or it is off.
            camera: Option<CameraReading> = camera, see;
        }
    };
}
pub(super) use with_sensors;

/// Makes of the list of sensors the percept and their streams.
macro_rules! percept {
    ($($(#[$doc:meta])* $field:ident: $reading:ty = $stream:ident, $sense:ident;)+) => {
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
            $($(#[$doc])* pub $field: $reading,)+
            /// Of which sensors nothing is to be expected.
            pub failed: FailedSensors,
            /// Whether something presses against the body.
            pub bumped: bool,
            /// State of the gripper.
            pub gripper: GripperStatus,
            /// Charge of the battery, from 0 to 1.
            pub battery: f64,
            /// What people have sent since the last step, word by word.
            pub messages: Vec<Vec<String>>,
            /// What is perceived by sensors that the simulator does not know; a host that has them puts it
            /// here.
            pub others: Signals,
        }

        /// The random stream of each sensor.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        pub struct SensorStreams {
            $(pub(super) $stream: Stream,)+
        }

        impl SensorStreams {
            pub(super) fn new(seed: u64) -> Self {
                Self { $($stream: Stream::new(seed, stringify!($stream)),)+ }
            }
        }
    };
}

with_sensors!(percept);
