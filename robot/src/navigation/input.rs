//! What a step of driving gets to know.

use crate::geometry::{Pose, Velocity};
use crate::sensors::{LaserScan, SonarScan};

/// What one step gets to know.
#[derive(Clone, Copy, Debug)]
pub struct NavigationInput<'a> {
    /// Dead reckoning.
    pub odometry_in_odom: Pose,
    /// As measured.
    pub velocity: Velocity,
    /// What the sonars heard; `None` without sonars, or while they are off.
    pub sonar: Option<SonarScan<'a>>,
    /// What the laser saw; `None` without a laser.
    pub laser: Option<LaserScan<'a>>,
    /// Whether something touches the robot.
    pub bumped: bool,
}

impl NavigationInput<'_> {
    /// Whether the robot measures distances just now, in any direction.
    pub fn sees(&self) -> bool {
        self.sonar.is_some() || self.laser.is_some()
    }

    /// Whether it does in this one.
    pub fn sees_towards(&self, direction_rad: f64) -> bool {
        self.sonar.is_some_and(|scan| scan.sonars.looks(direction_rad))
            || self.laser.is_some_and(|scan| scan.laser.looks(direction_rad))
    }
}
