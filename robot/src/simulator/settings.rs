//! What is simulated, and how people behave who are about.

use crate::description::RobotDescription;
use std::sync::Arc;

/// The robot, and the people around it; the default is the papers' robot.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatorSettings {
    /// The robot.
    pub robot: Arc<RobotDescription>,
    /// Air that people keep between themselves and the robot. At 0 they do not mind it, and run into
    /// it.
    pub person_clearance_m: f64,
    /// How long a person who gets no further waits before turning back, or going elsewhere.
    pub person_patience_us: u64,
}

impl SimulatorSettings {
    /// A robot among people as they are.
    pub fn of(robot: impl Into<Arc<RobotDescription>>) -> Self {
        Self { robot: robot.into(), person_clearance_m: 0.25, person_patience_us: 5_000_000 }
    }
}

impl Default for SimulatorSettings {
    fn default() -> Self {
        Self::of(RobotDescription::papers())
    }
}
