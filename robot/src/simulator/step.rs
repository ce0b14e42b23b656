//! One step of the simulation.

use super::model::SimulatorModel;
use super::sensors::{Commands, Percept};
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
        self.sense(state, commands)
    }
}
