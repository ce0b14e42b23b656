//! The behaviour `look-around`: turns to the left, to the right, and back, on the spot. It goes by the
//! odometry, whatever becomes of the estimate meanwhile.

use super::turning::turn_to;
use crate::avoidance::DriveLimits;
use crate::geometry::{Pose, Velocity, wrap_angle_rad};
use serde::{Deserialize, Serialize};

/// So far to either side: two scans of the ring of sonars apart, so that each wall is met anew.
const ASIDE_RAD: f64 = 30.0 / 180.0 * std::f64::consts::PI;

/// The headings still to be turned to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LookAround {
    headings_in_odom_rad: Vec<f64>,
}

impl LookAround {
    /// Will look to both sides of where the robot looks now, and there again.
    pub fn from(odometry_in_odom: Pose) -> Self {
        let ahead_rad = odometry_in_odom.heading_rad;
        let asides_rad = [ASIDE_RAD, -ASIDE_RAD, 0.0];
        Self { headings_in_odom_rad: asides_rad.map(|aside_rad| wrap_angle_rad(ahead_rad + aside_rad)).to_vec() }
    }

    /// The speeds of this step; `None` once the robot has looked to all sides.
    pub fn step(&mut self, limits: &DriveLimits, odometry_in_odom: Pose, velocity: Velocity) -> Option<Velocity> {
        let next_rad = *self.headings_in_odom_rad.first()?;
        let turn = turn_to(limits, Some(next_rad), odometry_in_odom, velocity);
        if turn.is_none() {
            self.headings_in_odom_rad.remove(0);
        }
        turn.or_else(|| (!self.headings_in_odom_rad.is_empty()).then(Velocity::default))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_looks_to_both_sides_and_ends_as_it_began() {
        let limits = DriveLimits::default();
        let (mut heading_rad, mut rotation_radps) = (3.0, 0.0);
        let (mut left_rad, mut right_rad, mut time_s) = (0.0_f64, 0.0_f64, 0.0);
        let mut look = LookAround::from(Pose::new(1.0, 2.0, heading_rad));
        loop {
            let velocity = Velocity { translation_mps: 0.0, rotation_radps };
            let Some(wanted) = look.step(&limits, Pose::new(1.0, 2.0, heading_rad), velocity) else { break };
            assert!(wanted.translation_mps == 0.0);
            rotation_radps = wanted.rotation_radps;
            heading_rad = wrap_angle_rad(heading_rad + rotation_radps * limits.step_s);
            let off_rad = wrap_angle_rad(heading_rad - 3.0);
            (left_rad, right_rad) = (left_rad.max(off_rad), right_rad.min(off_rad));
            time_s += limits.step_s;
            assert!(time_s < 10.0, "it never ends");
        }
        assert!(left_rad > 0.4 && right_rad < -0.4, "{left_rad} {right_rad}");
        assert!(wrap_angle_rad(heading_rad - 3.0).abs() < 0.11, "{heading_rad}");
    }
}
