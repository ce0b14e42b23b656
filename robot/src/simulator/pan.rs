//! The pan unit that turns the camera.

use crate::description::Camera;
use serde::{Deserialize, Serialize};

/// Where the camera is turned to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pan {
    /// Counter-clockwise from straight ahead of the robot.
    pub angle_rad: f64,
    /// How fast it turns.
    pub speed_radps: f64,
}

impl Pan {
    /// One step towards a wanted speed; at the end of its range it stands.
    pub(crate) fn step(&mut self, camera: &Camera, wanted_radps: f64, step_s: f64) {
        let most_radps = camera.max_pan_radps;
        let change_radps = camera.pan_acceleration_radps2 * step_s;
        let wanted_radps = wanted_radps.clamp(-most_radps, most_radps);
        self.speed_radps += (wanted_radps - self.speed_radps).clamp(-change_radps, change_radps);
        let turned_rad = self.angle_rad + self.speed_radps * step_s;
        self.angle_rad = turned_rad.clamp(-camera.pan_range_rad, camera.pan_range_rad);
        if self.angle_rad != turned_rad {
            self.speed_radps = 0.0;
        }
    }
}
