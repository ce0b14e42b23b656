//! Wheels that are asked to turn and do not: an emergency stop that is pressed, a wheel that is held, an empty
//! battery.

use crate::geometry::{Pose, Velocity};
use crate::simulator::Percept;
use serde::{Deserialize, Serialize};

/// The time without moving after which a robot that is to move counts as immobile.
pub const IMMOBILE_S: f64 = 2.0;

/// Slower than this it need not move at all: motors have friction.
const ASKED_MPS: f64 = 0.03;
const ASKED_RADPS: f64 = 0.1;

/// A robot that has moved by this since moves.
const MOVED_M: f64 = 0.01;
const MOVED_RAD: f64 = 0.02;

/// Since when the robot has not moved although it is to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Immobility {
    /// When, and what the odometry was then.
    since: Option<(u64, Pose)>,
}

impl Immobility {
    /// Takes in a percept, and what was asked of the wheels before it. Whether the robot has not moved for
    /// [`IMMOBILE_S`], told once in each such time. What touches the robot may hold it, and is told otherwise.
    pub(super) fn watch(&mut self, asked: Velocity, percept: &Percept) -> bool {
        let Percept { time_us, odometry_in_odom, .. } = *percept;
        let is_asked = asked.translation_mps.abs() >= ASKED_MPS || asked.rotation_radps.abs() >= ASKED_RADPS;
        let has_moved = |from: Pose| {
            let moved = odometry_in_odom.relative_to(from);
            moved.point().coords.norm() > MOVED_M || moved.heading_rad.abs() > MOVED_RAD
        };
        if !is_asked || percept.bumped {
            self.since = None;
            return false;
        }
        let (since_us, from) = self.since.filter(|&(_, from)| !has_moved(from)).unwrap_or((time_us, odometry_in_odom));
        let is_immobile = time_us.saturating_sub(since_us) as f64 / 1e6 >= IMMOBILE_S;
        self.since = (!is_immobile).then_some((since_us, from));
        is_immobile
    }
}
