//! One step of the simulation.

use super::commands::Commands;
use super::gripper::Hand;
use super::model::SimulatorModel;
use super::percept::Percept;
use super::state::SimulatorState;

impl SimulatorModel {
    /// Carries the state one step on: people walk, the robot accelerates and drives, odometry and
    /// gripper follow, and the sensors look at the result. The same state and commands give the same
    /// result, bit by bit.
    pub fn step(&self, state: &mut SimulatorState, commands: &Commands) -> Percept {
        state.time_us += self.robot().step_us;
        self.walk(state);
        self.move_robot(state, commands);
        if let Some(camera) = &self.robot().camera {
            let wanted_radps = commands.camera.map_or(0.0, |command| command.pan_radps);
            state.pan.step(camera, wanted_radps, self.robot().step_s());
        }
        self.use_battery(state);
        if let Some(gripper) = &self.robot().gripper {
            let hand = Hand { gripper, robot_in_map: state.robot_in_map, robot_radius_m: self.robot().radius_m };
            state.gripper.step(hand, &mut state.streams.gripper, &commands.gripper, state.time_us);
        }
        self.sense(state, commands)
    }
    /// What the wheels do in a step: the robot accelerates and drives, and its odometry follows.
    pub fn move_robot(&self, state: &mut SimulatorState, commands: &Commands) {
        let before_mps = state.translation_mps;
        self.accelerate(state, commands);
        self.judge_braking(state, before_mps);
        let driven = self.drive(state);
        state.odometry_in_odom = state.odometry_bias.measure(
            &self.robot().odometry,
            &mut state.streams.odometry,
            state.odometry_in_odom,
            driven.way_m,
            driven.turn_rad,
        );
    }
}
