//! How a robot without a map drives, or one with a map in narrow places, by how sharply it sees.

use crate::avoidance::DriveLimits;
use crate::geometry::Point;
use crate::sensors::RangeSensor;

/// How near, how fast and how far ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DrivingProfile {
    /// How far along the way the point lies that the collision avoidance heads for.
    pub lookahead_m: f64,
    /// A way is planned anew after this time even if nothing obstructs it: there may be a better one.
    pub plan_s: f64,
    /// From this obstacle distance on, the planner does not mind.
    pub comfortable_distance_m: f64,
    margin_m: f64,
    margin_s: f64,
    gap_mps: f64,
    gap_per_s: f64,
}

impl DrivingProfile {
    /// Beside narrow places of a map surfaces are where it has them, to a centimetre.
    pub const IN_NARROW: Self = Self { gap_mps: 0.2, gap_per_s: 4.0, ..Self::BY_LASER };

    /// Echoes come from arcs.
    const BY_SONAR: Self = Self {
        lookahead_m: 1.5,
        plan_s: 5.0,
        comfortable_distance_m: 0.75,
        margin_m: 0.02,
        margin_s: 0.1,
        gap_mps: 0.2,
        gap_per_s: 4.0,
    };

    /// Smoothed scans show surfaces to half a centimetre. What is behind the next post is seen late, so
    /// ways are planned often.
    const BY_LASER: Self = Self {
        lookahead_m: 1.3,
        plan_s: 1.0,
        comfortable_distance_m: 0.5,
        margin_m: 0.012,
        margin_s: 0.03,
        gap_mps: 0.3,
        gap_per_s: 5.0,
    };

    pub fn by(sharpest: RangeSensor) -> Self {
        match sharpest {
            RangeSensor::Sonar => Self::BY_SONAR,
            RangeSensor::Laser => Self::BY_LASER,
        }
    }

    /// The limits with no more margin than it takes.
    pub fn limits(&self, limits: &DriveLimits) -> DriveLimits {
        DriveLimits {
            margin_m: limits.margin_m.min(self.margin_m),
            margin_s: limits.margin_s.min(self.margin_s),
            ..*limits
        }
    }

    /// How fast the robot goes beside what it nearly touches, and how much faster for each metre of
    /// air. The window looks at a fixed number of speeds: below a low limit they lie as close together
    /// as a narrow gap needs.
    pub fn speed_in_gap_mps(&self, limits: &DriveLimits, obstacles_in_base: &[Point]) -> f64 {
        let nearest_m = obstacles_in_base.iter().map(|point| point.coords.norm()).fold(f64::INFINITY, f64::min);
        self.gap_mps + self.gap_per_s * (nearest_m - limits.robot_radius_m).max(0.0)
    }
}
