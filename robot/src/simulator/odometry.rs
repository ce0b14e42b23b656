//! Dead reckoning that drifts.

use super::arc::drive_arc;
use crate::description::OdometryDrift;
use crate::geometry::Pose;
use rpl_random::Stream;
use serde::{Deserialize, Serialize};

/// The constant errors of one robot, drawn at the start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct OdometryBias {
    translation_scale: f64,
    rotation_scale: f64,
    heading_radpm: f64,
}

impl OdometryBias {
    pub fn draw(drift: &OdometryDrift, stream: &mut Stream) -> Self {
        Self {
            translation_scale: 1.0 + drift.translation_bias * stream.normal(),
            rotation_scale: 1.0 + drift.rotation_bias * stream.normal(),
            heading_radpm: drift.heading_bias_radpm * stream.normal(),
        }
    }

    /// The odometry after really having driven `distance_m` along an arc of `turn_rad`. A robot at
    /// rest measures no motion.
    pub fn measure(
        &self,
        drift: &OdometryDrift,
        stream: &mut Stream,
        before_in_odom: Pose,
        distance_m: f64,
        turn_rad: f64,
    ) -> Pose {
        let (way_m, angle_rad) = (distance_m.abs(), turn_rad.abs());
        if way_m == 0.0 && angle_rad == 0.0 {
            return before_in_odom;
        }
        let translation_sigma_m = drift.translation_noise_m_per_sqrt_m * way_m.sqrt();
        let by_turn_rad = drift.rotation_noise_rad_per_sqrt_rad;
        let by_way_rad = drift.rotation_noise_rad_per_sqrt_m;
        let rotation_sigma_rad = (by_turn_rad * by_turn_rad * angle_rad + by_way_rad * by_way_rad * way_m).sqrt();
        let measured_m = self.translation_scale * distance_m + translation_sigma_m * stream.normal();
        let measured_rad =
            self.rotation_scale * turn_rad + self.heading_radpm * way_m + rotation_sigma_rad * stream.normal();
        drive_arc(before_in_odom, measured_m, measured_rad)
    }
}
