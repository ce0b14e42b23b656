//! The proportional derivative compensator of the pan axis, which keeps the camera at an angle while the
//! robot under it turns (Gutierrez-Osuna and Luo, "Vision").

use crate::description::Camera;
use crate::geometry::wrap_angle_rad;
use serde::{Deserialize, Serialize};

/// Speed for each radian that the camera is off: it is there after about three tenths of a second.
const PROPORTIONAL_PER_S: f64 = 8.0;

/// Of the speed at which the error changes so much is added, to stop in time and to lead where the robot
/// turns.
const DERIVATIVE: f64 = 0.35;

/// What it remembers from step to step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PanControl {
    /// How far the camera was off in the step before; none at first.
    off_rad: Option<f64>,
}

impl PanControl {
    /// The speed of the pan unit that turns the camera to an angle from straight ahead, or as near to it as
    /// it gets. `pan_rad` is where it is, `step_s` the time from step to step.
    pub fn speed_radps(&mut self, camera: &Camera, wanted_rad: f64, pan_rad: f64, step_s: f64) -> f64 {
        let range_rad = camera.pan_range_rad;
        let off_rad = wrap_angle_rad(wanted_rad).clamp(-range_rad, range_rad) - pan_rad;
        let change_radps = self.off_rad.map_or(0.0, |before_rad| (off_rad - before_rad) / step_s);
        self.off_rad = Some(off_rad);
        let speed_radps = PROPORTIONAL_PER_S * off_rad + DERIVATIVE * change_radps;
        speed_radps.clamp(-camera.max_pan_radps, camera.max_pan_radps)
    }
}
