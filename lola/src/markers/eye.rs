//! What markers are looked for with.

use rpl_robot::description::Camera;
use rpl_robot::vision::FloorMark;

/// What markers are looked for with.
#[derive(Clone, Copy, Debug)]
pub struct MarkerEye<'a> {
    /// The camera of the robot.
    pub camera: &'a Camera,
    /// What a marker looks like.
    pub mark: &'a FloorMark,
    /// Time from percept to percept.
    pub step_s: f64,
}
