//! What a step of driving gets to know.

use crate::geometry::{Pose, Velocity};
use crate::sensors::SONARS;

/// What one step gets to know.
#[derive(Clone, Copy, Debug)]
pub struct NavigationInput<'a> {
    /// Dead reckoning.
    pub odometry_in_odom: Pose,
    /// As measured.
    pub velocity: Velocity,
    /// Distances from the robot's centre, in the order of [`sonar_direction_rad`]; `None` while the
    /// sonars are off.
    ///
    /// [`sonar_direction_rad`]: crate::sensors::sonar_direction_rad
    pub sonar_m: Option<&'a [f32; SONARS]>,
    /// Distances from the robot's centre, in the order of [`laser_direction_rad`]; `None` without a
    /// laser.
    ///
    /// [`laser_direction_rad`]: crate::sensors::laser_direction_rad
    pub laser_m: Option<&'a [f32]>,
    /// Whether something touches the robot.
    pub bumped: bool,
}
