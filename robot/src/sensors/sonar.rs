//! The ring of sonars.

use std::f64::consts::TAU;

/// Sonars around the robot; their cones tile the full turn.
pub const SONARS: usize = 24;

/// Opening of a cone, and the angle from the axis of one to that of the next.
pub const SONAR_CONE_RAD: f64 = TAU / SONARS as f64;

/// Echoes from farther away are not heard.
pub const SONAR_RANGE_M: f64 = 5.0;

/// Direction of a sonar's axis in `base`: sonar 0 looks ahead, the others follow counter-clockwise; in
/// [0, 2π).
pub fn sonar_direction_rad(sonar: usize) -> f64 {
    sonar as f64 * SONAR_CONE_RAD
}

/// The directions of all sonars in whole degrees, which theirs are.
pub fn sonar_ring_deg() -> Vec<i32> {
    (0..SONARS).map(|sonar| (sonar * 360 / SONARS) as i32).collect()
}
