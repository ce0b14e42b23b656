//! How the sensors look at the world: each has a file, and a row in the list beside the percept.

mod camera;
mod laser;
mod sonar;

use super::commands::Commands;
use super::model::SimulatorModel;
use super::percept::{Percept, with_sensors};
use super::state::SimulatorState;
use crate::sensors::{FailedSensors, Signals};

/// Makes of the list of sensors the look that all of them take.
macro_rules! look {
    ($($(#[$doc:meta])* $field:ident: $reading:ty = $stream:ident, $sense:ident;)+) => {
        impl SimulatorModel {
            /// What all sensors find.
            pub fn sense(&self, state: &mut SimulatorState, commands: &Commands) -> Percept {
                let mut streams = state.streams.sensors.clone();
                let percept = Percept {
                    time_us: state.time_us,
                    odometry_in_odom: state.odometry_in_odom,
                    translation_mps: state.translation_mps,
                    rotation_radps: state.rotation_radps,
                    $($field: self.$sense(state, commands, &mut streams.$stream),)+
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

with_sensors!(look);
