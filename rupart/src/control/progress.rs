//! Whether the robot gets nearer to its short-term goal.

use serde::{Deserialize, Serialize};

/// Nearer by this is progress.
const PROGRESS_M: f64 = 0.2;

/// Without any for longer than this, the robot does not progress.
const PATIENCE_S: f64 = 4.0;

/// Without any for longer than this, it is blocked, unless it has another patience.
pub const BLOCKED_S: f64 = 30.0;

/// How near the robot has come to a goal, and when.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    nearest_m: f64,
    idle_s: f64,
}

impl Default for Progress {
    fn default() -> Self {
        Self { nearest_m: f64::INFINITY, idle_s: 0.0 }
    }
}

impl Progress {
    /// A step later, with the goal at this distance.
    pub fn note(&mut self, goal_m: f64, step_s: f64) {
        if goal_m < self.nearest_m - PROGRESS_M {
            *self = Self { nearest_m: goal_m, idle_s: 0.0 };
        } else {
            self.idle_s += step_s;
        }
    }

    /// For how long the robot has not come nearer.
    pub fn idle_s(&self) -> f64 {
        self.idle_s
    }

    /// Whether it gets on.
    pub fn is_made(&self) -> bool {
        self.idle_s < PATIENCE_S
    }
}
