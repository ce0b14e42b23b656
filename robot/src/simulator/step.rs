//! One step of the simulation.

use super::model::SimulatorModel;
use super::percept::{Commands, Percept};
use super::state::SimulatorState;

impl SimulatorModel {
    /// Carries the state one step on: people walk, the robot accelerates and drives, odometry and
    /// gripper follow, and the sensors look at the result. The same state and commands give the same
    /// result, bit by bit.
    pub fn step(&self, state: &mut SimulatorState, commands: &Commands) -> Percept {
        state.time_us += self.settings.step_us;
        self.walk(state);
        self.accelerate(state, commands);
        let driven = self.drive(state);
        state.odometry_in_odom = state.odometry_bias.measure(
            &self.settings,
            &mut state.streams.odometry,
            state.odometry_in_odom,
            driven.way_m,
            driven.turn_rad,
        );
        self.use_battery(state);
        let (stream, robot_in_map) = (&mut state.streams.gripper, state.robot_in_map);
        state.gripper.step(&self.settings, stream, &commands.gripper, state.time_us, robot_in_map);
        Percept {
            time_us: state.time_us,
            odometry_in_odom: state.odometry_in_odom,
            translation_mps: state.translation_mps,
            rotation_radps: state.rotation_radps,
            sonar_m: self.fire_sonars(state, commands),
            laser_m: self.scan_laser(state),
            bumped: state.touching || state.people.iter().any(|person| person.touching),
            gripper: state.gripper.status(),
            battery: state.battery,
            messages: state.unread_messages(),
        }
    }
}
