//! What can be set about active localization.

use serde::{Deserialize, Serialize};

/// How the robot moves about while it does not know where it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Exploration {
    /// To where it learns most.
    Active,
    /// At random, for comparison.
    Wander,
    /// Along walls, for comparison.
    WallFollow,
    /// By a fixed routine on the spot, for comparison.
    SpinAndBackUp,
}

/// Everything that can be set about active localization.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActiveParameters {
    /// How the robot moves about.
    pub exploration: Exploration,
    /// Edge of a cell of the action grid; half the free width of a door at most.
    pub resolution_m: f64,
    /// Actions reach this far ahead, back, left and right.
    pub reach_m: f64,
    /// Every how many cells, in each direction, an action's entropy is computed.
    pub target_step: usize,
    /// Targets nearer than this do not move the robot to anything new.
    pub min_target_m: f64,
    /// Radius of the robot, with a margin: nearer to a surface is occupied.
    pub robot_radius_m: f64,
    /// From the radius to this clearance the occupancy falls from one quarter to 0, so that paths
    /// keep off walls where there is room.
    pub comfortable_m: f64,
    /// Cost of a metre through something certainly occupied, in metres of free way.
    pub occupied_cost: f64,
    /// Points more probably occupied than this are neither targets nor passed.
    pub blocked_probability: f64,
    /// α of Eq. (9): nats per metre of way.
    pub alpha_per_m: f64,
    /// Tempered scans an arrival is worth: the robot senses on its way as well.
    pub scans: usize,
    /// Expected distances that differ by less than this are not told apart, because maxima are
    /// known no better.
    pub tolerance_m: f64,
    /// Most maxima taken into account.
    pub max_maxima: usize,
    /// Maxima lighter than this are ignored.
    pub min_mass: f64,
    /// Wandering ends when the maxima hold this much of the belief ...
    pub concentrated_mass: f64,
    /// ... or after this way.
    pub max_wander_m: f64,
    /// The pose is lost when the probability that dead reckoning has led on from the last known one is at or below this.
    pub certainty: f64,
    /// A lost pose is known again when the certainty exceeds this ...
    ///
    /// # Deviation
    /// Beetz et al. (§3.2) wait for the same 0.8. But a certainty of 0.8 is wrong once in five times,
    /// and of two mirror poses one easily has that much; at 0.9 for a while wrong recoveries are rare.
    pub found_certainty: f64,
    /// ... at this number of updates in a row.
    pub confirmations: u32,
    /// A target is reached within this distance.
    pub arrival_m: f64,
    /// The choice is made anew when this much mass lies at maxima that were not there.
    pub changed_mass: f64,
    /// Updates between two looks at the maxima.
    pub look_every: u32,
    /// Failure after this time.
    pub timeout_s: f64,
}

impl Default for ActiveParameters {
    fn default() -> Self {
        Self {
            exploration: Exploration::Active,
            resolution_m: 0.15,
            reach_m: 21.0,
            target_step: 3,
            min_target_m: 1.0,
            robot_radius_m: 0.29,
            comfortable_m: 0.55,
            occupied_cost: 10.0,
            blocked_probability: 0.95,
            alpha_per_m: 0.02,
            scans: 3,
            tolerance_m: 0.2,
            max_maxima: 10,
            min_mass: 0.01,
            concentrated_mass: 0.6,
            max_wander_m: 20.0,
            certainty: 0.7,
            found_certainty: 0.9,
            confirmations: 8,
            arrival_m: 0.4,
            changed_mass: 0.3,
            look_every: 5,
            timeout_s: 600.0,
        }
    }
}
