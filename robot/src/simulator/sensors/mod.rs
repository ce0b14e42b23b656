//! What goes into a step and what comes out of it: the one list of the sensors, and what follows from it,
//! the percept and the stream of each.
//!
//! One circle, on purpose: the state of the simulator holds the streams that this list makes, and a look
//! is taken at the state.

mod camera;
mod laser;
mod sonar;

pub(super) use camera::{Eye, SIGHT_M};

use super::gripper::{GripperCommand, GripperStatus};
use super::model::SimulatorModel;
use super::state::SimulatorState;
use crate::geometry::Pose;
use crate::sensors::{CameraReading, FailedSensors, Signals};
use rpl_random::Stream;
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

/// Makes of a list of sensors the percept, their streams, and the look that all of them take.
macro_rules! compose {
    ($($(#[$doc:meta])* $field:ident: $reading:ty = $stream:ident, $sense:path;)+) => {
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
            $($stream: Stream,)+
        }

        impl SensorStreams {
            pub(super) fn new(seed: u64) -> Self {
                Self { $($stream: Stream::new(seed, stringify!($stream)),)+ }
            }
        }

        impl SimulatorModel {
            /// What all sensors find.
            pub fn sense(&self, state: &mut SimulatorState, commands: &Commands) -> Percept {
                let mut streams = state.streams.sensors.clone();
                let percept = Percept {
                    time_us: state.time_us,
                    odometry_in_odom: state.odometry_in_odom,
                    translation_mps: state.translation_mps,
                    rotation_radps: state.rotation_radps,
                    $($field: $sense(self, state, commands, &mut streams.$stream),)+
                    failed: FailedSensors { sonars: self.have_sonars_failed(state), ..FailedSensors::default() },
                    bumped: self.robot().bumper && (state.touching || state.people.iter().any(|person| person.touching)),
                    gripper: state.gripper.status(),
                    battery: state.battery,
                    messages: state.unread_messages(),
                    others: Signals::new(),
                };
                state.streams.sensors = streams;
                percept
            }
        }
    };
}

compose! {
    /// Distance from each sonar's mount, which of a ring is the *middle of the robot*, to the nearest surface
    /// in its cone, in the order of the description; the maximum range where there was no echo. None if
    /// there are no sonars, or they are off or failed.
    sonar_m: Option<Vec<f32>> = sonar, SimulatorModel::fire_sonars;
    /// Distance from the middle of the robot, in the order of
    /// [`LaserScanner::direction_rad`](crate::sensors::LaserScanner::direction_rad); the maximum range where
    /// nothing came back. None if there is no laser.
    laser_m: Option<Vec<f32>> = laser, SimulatorModel::scan_laser;
    /// Where the camera is turned to, and what it sees. None if there is no camera, or it is off.
    camera: Option<CameraReading> = camera, SimulatorModel::see;
}
