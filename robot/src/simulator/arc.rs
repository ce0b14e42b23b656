//! Driving along an arc.

use crate::geometry::Pose;

/// The pose after driving `way_m` along a circular arc while turning by `turn_rad`, exact for
/// any turn: the chord has the length way · sin(turn/2) / (turn/2).
pub fn drive_arc(pose: Pose, way_m: f64, turn_rad: f64) -> Pose {
    let half_rad = turn_rad / 2.0;
    let chord_m = if half_rad.abs() < 1e-4 {
        way_m * (1.0 - half_rad * half_rad / 6.0)
    } else {
        way_m * libm::sin(half_rad) / half_rad
    };
    let (sin, cos) = libm::sincos(pose.heading_rad + half_rad);
    Pose::new(pose.x_m + chord_m * cos, pose.y_m + chord_m * sin, pose.heading_rad + turn_rad)
}
