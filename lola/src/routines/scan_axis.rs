//! How the walls of a hallway run around a robot that stands in it, from a few scans.

use rpl_robot::geometry::wrap_angle_rad;
use rpl_robot::sensors::SonarScan;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI};

/// Both walls of a hallway together are at most so far apart, and at least.
const WIDEST_M: f64 = 3.2;
const NARROWEST_M: f64 = 1.2;

/// How much of what is new goes into the mean of a step.
const SHARE: f64 = 0.15;

/// The axis of the walls around the robot, found in the scans themselves: where the readings of two sonars
/// that look opposite ways are least together, they look at the walls straight on. Good to about half a cone.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ScanAxis {
    /// For each sonar of the front half turn, left first: the mean distance between the surfaces that it and
    /// its opposite hear.
    across_m: Vec<f64>,
    steps: u32,
}

impl ScanAxis {
    /// Takes a scan in.
    pub fn take_in(&mut self, scan: SonarScan<'_>) {
        let ranges_m = scan.ranges_from_middle_m();
        let mounts = scan.sonars.mounts.iter();
        let across_m: Vec<f64> = mounts.map(|mount| between_m(scan, &ranges_m, mount.heading_rad)).collect();
        if self.across_m.len() != across_m.len() {
            *self = Self { across_m, steps: 1 };
            return;
        }
        for (mean_m, new_m) in self.across_m.iter_mut().zip(across_m) {
            *mean_m += SHARE * (new_m - *mean_m);
        }
        self.steps += 1;
    }

    /// Which way the hallway runs, nearest to straight ahead, in `base`; none if no two walls are heard.
    pub fn axis_in_base_rad(&self, scan: SonarScan<'_>) -> Option<f64> {
        let (sonar, &least_m) = self.across_m.iter().enumerate().min_by(|one, other| one.1.total_cmp(other.1))?;
        if !(NARROWEST_M..=WIDEST_M).contains(&least_m) || self.steps < 10 {
            return None;
        }
        let mounts = &scan.sonars.mounts;
        // Of the neighbours, the one that hears less tells to which side the wall is turned.
        let beside = |step: usize| {
            let neighbour = (sonar + step) % mounts.len();
            (wrap_angle_rad(mounts[neighbour].heading_rad - mounts[sonar].heading_rad), self.across_m[neighbour])
        };
        let ((left_rad, left_m), (right_rad, right_m)) = (beside(1), beside(mounts.len() - 1));
        let (left_rise_m, right_rise_m) = ((left_m - least_m).min(0.5), (right_m - least_m).min(0.5));
        let share = if left_rise_m + right_rise_m > 0.0 { right_rise_m / (left_rise_m + right_rise_m) } else { 0.5 };
        let normal_rad = mounts[sonar].heading_rad + (share * left_rad + (1.0 - share) * right_rad) / 2.0;
        let axis_rad = wrap_angle_rad(normal_rad + FRAC_PI_2);
        Some(if axis_rad.abs() <= FRAC_PI_2 { axis_rad } else { wrap_angle_rad(axis_rad + PI) })
    }
}

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
