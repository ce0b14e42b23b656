//! How far it is between what a scan hears on both sides.

use rpl_robot::geometry::wrap_angle_rad;
use rpl_robot::sensors::SonarScan;
use std::f64::consts::{FRAC_PI_2, PI};

/// How far it is, square to an axis given in `base`, between what is heard on the left and on the right.
pub fn across_m(scan: SonarScan<'_>, axis_in_base_rad: f64) -> f64 {
    between_m(scan, &scan.ranges_from_middle_m(), axis_in_base_rad + FRAC_PI_2)
}

/// Between what is heard in a direction and opposite to it; silence is taken for the range of the sonars.
fn between_m(scan: SonarScan<'_>, ranges_m: &[f32], direction_rad: f64) -> f64 {
    let heard_m = |direction_rad: f64| f64::from(ranges_m[nearest(scan, direction_rad)]).min(scan.sonars.range_m);
    heard_m(direction_rad) + heard_m(direction_rad + PI)
}

/// The sonar that looks nearest to a direction.
fn nearest(scan: SonarScan<'_>, direction_rad: f64) -> usize {
    let off_rad = |sonar: &usize| wrap_angle_rad(scan.sonars.mounts[*sonar].heading_rad - direction_rad).abs();
    (0..scan.sonars.mounts.len()).min_by(|one, other| off_rad(one).total_cmp(&off_rad(other))).unwrap_or(0)
}
