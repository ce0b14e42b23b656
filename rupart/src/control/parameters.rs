//! What a behaviour case holds.

use serde::{Deserialize, Serialize};

/// The parameters of the state Wander: velocities, and how much each of its behaviours weighs (Fox and
/// Anderson-Sprecher, Behavior-based control in RUPART).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BehaviourParameters {
    /// How fast Avoid drives ahead where nothing is near.
    pub translation_mps: f64,
    /// The fastest any of the behaviours turns.
    pub rotation_radps: f64,
    /// What is nearer to the robot's rim than this ahead of it slows it down and turns it away.
    pub avoid_distance_m: f64,
    /// Sonars that hear nothing up to this distance look into a gap.
    pub gap_distance_m: f64,
    /// Weight of Avoid, 0 to 1.
    pub avoid_weight: f64,
    /// Weight of Escape, 0 to 1.
    pub escape_weight: f64,
    /// Weight of ToGoal, 0 to 1.
    pub to_goal_weight: f64,
}

impl BehaviourParameters {
    /// The set that drives best on its own: a memory begins with it.
    pub const TUNED: BehaviourParameters = BehaviourParameters {
        translation_mps: 0.6,
        rotation_radps: 0.8,
        avoid_distance_m: 0.5,
        gap_distance_m: 1.2,
        avoid_weight: 0.6,
        escape_weight: 0.4,
        to_goal_weight: 0.8,
    };
}

impl Default for BehaviourParameters {
    fn default() -> Self {
        Self::TUNED
    }
}
