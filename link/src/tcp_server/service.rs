//! How a host is served, and how long it waits for whom.

use crate::message_lines::LINE;
use rpl_protocol::token::Token;
use std::time::Duration;

/// Whoever connects says who it is within this time.
const GREETING: Duration = Duration::from_secs(5);

/// A mission that has not taken in the percepts of this time drives blindly: its commands count for nothing, and it is
/// gone for the host once as many wait to be sent.
const BLIND: Duration = Duration::from_secs(2);

/// The same in percepts, however fast the time of the robot goes.
const MOST_UNSENT: usize = 600;

/// A mission that gives no commands for this time has lost the robot, if no other time is given.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// How a host is served.
#[derive(Clone, Debug, PartialEq)]
pub struct Service {
    /// The robot that it moves.
    pub robot: String,
    /// Time of the robot between two percepts.
    pub period_us: u64,
    /// Seconds of the robot for each second on the wall.
    pub factor: f64,
    /// Time of the robot at which it ends, if it does.
    pub until_us: Option<u64>,
    /// It ends when the first mission has gone and the robot stands.
    pub once: bool,
    /// The robot stands where the world says it starts; only the first mission is told.
    pub start_known: bool,
    /// A mission that gives no commands for this time has lost the robot.
    pub patience: Duration,
    /// What missions have to know.
    pub token: Option<Token>,
}

impl Service {
    pub(super) fn period(&self) -> Duration {
        Duration::from_secs_f64(self.period_us as f64 / 1e6 / self.factor)
    }

    /// How long a greeting may take, and a line: no longer than a mission may be silent.
    pub(super) fn times(&self) -> (Duration, Duration) {
        (GREETING.min(self.patience), LINE.min(self.patience))
    }

    /// Whether a mission that has not taken in `behind` percepts drives blindly.
    pub(super) fn is_blind(&self, behind: u64) -> bool {
        self.period().mul_f64(behind as f64) > BLIND.min(self.patience)
    }

    /// Percepts of [`BLIND`].
    pub(super) fn most_unsent(&self) -> usize {
        (BLIND.div_duration_f64(self.period()) as usize).clamp(4, MOST_UNSENT)
    }
}
