//! What a behaviour case holds.

use serde::{Deserialize, Serialize};

/// The parameters of the state Wander: velocities, and how much each of its behaviours weighs (Fox and
/// Anderson-Sprecher, Behavior-based control in RUPART).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
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

    /// The parameters that are outside their domain, and what that is: speeds and distances are finite and not negative,
    /// weights are from 0 to 1.
    pub fn faults(&self) -> Vec<(&'static str, &'static str)> {
        let Self { translation_mps, rotation_radps, avoid_distance_m, gap_distance_m, .. } = *self;
        let Self { avoid_weight, escape_weight, to_goal_weight, .. } = *self;
        let sizes = [
            ("translation_mps", translation_mps),
            ("rotation_radps", rotation_radps),
            ("avoid_distance_m", avoid_distance_m),
            ("gap_distance_m", gap_distance_m),
        ];
        let weights =
            [("avoid_weight", avoid_weight), ("escape_weight", escape_weight), ("to_goal_weight", to_goal_weight)];
        let sizes = sizes.into_iter().filter(|(_, size)| !(0.0..f64::INFINITY).contains(size));
        let weights = weights.into_iter().filter(|(_, weight)| !(0.0..=1.0).contains(weight));
        let sizes = sizes.map(|(name, _)| (name, "finite and not negative"));
        sizes.chain(weights.map(|(name, _)| (name, "a number from 0 to 1"))).collect()
    }
}

impl Default for BehaviourParameters {
    fn default() -> Self {
        Self::TUNED
    }
}
