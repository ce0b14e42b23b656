//! Turning on the spot to a heading.

use crate::avoidance::DriveLimits;
use crate::geometry::{Pose, Velocity, wrap_angle_rad};

/// The robot stops turning this near to the wanted heading; 10° would do.
const HEADING_TOLERANCE_RAD: f64 = 0.1;

/// Slower than this it stands.
const STANDING_MPS: f64 = 0.02;
const STANDING_RADPS: f64 = 0.1;

/// The velocity that turns the robot on the spot to a heading; `None` once it stands and looks there.
pub fn turn_to(limits: &DriveLimits, wanted_rad: Option<f64>, here: Pose, velocity: Velocity) -> Option<Velocity> {
    let off_rad = wanted_rad.map_or(0.0, |wanted_rad| wrap_angle_rad(wanted_rad - here.heading_rad));
    if off_rad.abs() > HEADING_TOLERANCE_RAD {
        return Some(Velocity { translation_mps: 0.0, rotation_radps: limits.braked_turn_radps(off_rad) });
    }
    let stands = velocity.translation_mps.abs() < STANDING_MPS && velocity.rotation_radps.abs() < STANDING_RADPS;
    (!stands).then(Velocity::default)
}
