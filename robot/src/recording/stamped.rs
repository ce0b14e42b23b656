//! Scans, odometry and reference that each have their own times: for each scan where the robot was then.

use super::drive::{LogError, Recording, Scan, ScanGeometry};
use super::track::{Between, Track, on_the_way};
use crate::geometry::Pose;

/// Odometry carries a reference on for this long before its first and after its last message.
const LONGEST_CARRIED_S: f64 = 2.0;

/// A scan and when it was taken.
#[derive(Clone, Debug, PartialEq)]
pub struct StampedScan {
    /// Its number in the recording, from 1.
    pub number: usize,
    /// When.
    pub stamp_s: f64,
    /// From right to left.
    pub ranges_m: Vec<f32>,
}

/// What was recorded of a drive, each with its own times.
#[derive(Clone, Debug, PartialEq)]
pub struct StampedDrive {
    /// Where the readings point.
    pub geometry: ScanGeometry,
    /// How far the laser sees, if it says so.
    pub range_m: Option<f64>,
    /// In any order.
    pub scans: Vec<StampedScan>,
    /// The odometry.
    pub base_in_odom: Track,
    /// The corrected poses.
    pub base_in_map: Track,
}

impl StampedDrive {
    /// The drive with a pose of both kinds for each scan, in order of time. Scans before the first odometry, after the
    /// last, or far from the corrected poses are left out. O((scans + poses) log poses).
    ///
    /// # Errors
    /// No scan has both poses; the robot or its odometry never moves.
    pub fn paired(mut self, laser_in_base: Pose) -> Result<Recording, LogError> {
        let reference = self.base_in_map.within(&self.base_in_odom);
        self.scans.sort_by(|a, b| a.stamp_s.total_cmp(&b.stamp_s));
        let times = Track::new(self.scans.iter().map(|scan| (scan.stamp_s, Pose::default())).collect());
        let paired = |scan: StampedScan| {
            let base_in_odom = self.base_in_odom.at(scan.stamp_s)?;
            let base_in_map = carried(&reference, &self.base_in_odom, scan.stamp_s, base_in_odom)?;
            Some(Scan {
                line: scan.number,
                stamp_s: Some(scan.stamp_s),
                ranges_m: scan.ranges_m,
                laser_in_map: base_in_map.compose(laser_in_base),
                laser_in_odom: base_in_odom.compose(laser_in_base),
            })
        };
        let scans: Vec<Scan> = self.scans.into_iter().filter_map(paired).collect();
        if scans.is_empty() {
            let spans = [("scans", &times), ("odometry", &self.base_in_odom), ("corrected poses", &self.base_in_map)];
            let spans = spans.map(|(what, track)| match track.span_s() {
                Some((first_s, last_s)) => format!("{what} from {first_s:.3} s to {last_s:.3} s"),
                None => format!("no {what}"),
            });
            let message = format!(
                "no scan was taken between two messages of the odometry and near to a corrected pose, by the stamps in \
                 their headers: {}; all three must come from one clock",
                spans.join(", ")
            );
            return Err(LogError { line: None, message });
        }
        let recording = Recording::new(self.geometry, scans)?;
        Ok(Recording { range_m: self.range_m, ..recording })
    }
}

/// Where the robot was at a time: the references before and after it, each carried to that time by the odometry, and on
/// the way from what the one says to what the other says.
fn carried(reference: &Track, odometry: &Track, stamp_s: f64, base_in_odom: Pose) -> Option<Pose> {
    let by = |(reference_s, base_in_map): (f64, Pose)| {
        let moved = base_in_odom.relative_to(odometry.at(reference_s)?);
        Some(base_in_map.compose(moved))
    };
    let Some(Between { before, after, share }) = reference.around(stamp_s) else {
        let nearest = reference.beside(stamp_s)?;
        return by(nearest).filter(|_| libm::fabs(stamp_s - nearest.0) <= LONGEST_CARRIED_S);
    };
    Some(on_the_way(by(before)?, by(after)?, share))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::wrap_angle_rad;

    /// A circle of 1 m at 1 m/s.
    fn base_in_map(stamp_s: f64) -> Pose {
        let (sin, cos) = libm::sincos(stamp_s);
        Pose::new(cos, sin, wrap_angle_rad(stamp_s + std::f64::consts::FRAC_PI_2))
    }

    /// The same in another frame.
    fn base_in_odom(stamp_s: f64) -> Pose {
        Pose::new(-7.0, 2.0, 2.5).compose(base_in_map(stamp_s))
    }

    fn track(every_s: f64, pose: fn(f64) -> Pose) -> Track {
        let stamps = (0..).map(|step| f64::from(step) * every_s).take_while(|stamp_s| *stamp_s <= 20.0);
        Track::new(stamps.map(|stamp_s| (stamp_s, pose(stamp_s))).collect())
    }

    fn drive(reference_every_s: f64) -> StampedDrive {
        let scan = |number: usize| StampedScan { number, stamp_s: number as f64 * 0.17, ranges_m: vec![1.0] };
        StampedDrive {
            geometry: ScanGeometry { readings: 1, first_rad: 0.0, step_rad: 0.1 },
            range_m: Some(3.5),
            scans: (1..=110).rev().map(scan).collect(),
            base_in_odom: track(0.02, base_in_odom),
            base_in_map: track(reference_every_s, base_in_map),
        }
    }

    #[test]
    fn a_scan_is_where_the_robot_was_at_its_stamp_however_seldom_the_reference_comes() {
        for every_s in [0.05, 0.2, 1.0, 3.0] {
            let recording = drive(every_s).paired(Pose::default()).expect("it is a drive");
            assert_eq!((recording.scans.len(), recording.range_m), (110, Some(3.5)));
            for scan in &recording.scans {
                let truth = base_in_map(scan.stamp_s.expect("a stamp"));
                let off_rad = libm::fabs(wrap_angle_rad(scan.laser_in_map.heading_rad - truth.heading_rad));
                assert!(scan.laser_in_map.distance_m(truth) < 1e-3 && off_rad < 1e-3, "{every_s}: {scan:?} {truth:?}");
            }
        }
    }

    #[test]
    fn a_reference_is_not_carried_on_for_long_and_clocks_must_agree() {
        let mut early = drive(1.0);
        let first = |(stamp_s, _): &(f64, Pose)| *stamp_s <= 5.0;
        early.base_in_map =
            Track::new((0..=20).map(f64::from).map(|stamp_s| (stamp_s, base_in_map(stamp_s))).filter(first).collect());
        let recording = early.paired(Pose::default()).expect("its beginning is a drive");
        assert_eq!(recording.scans.len(), 41, "up to 7 s");
        let mut apart = drive(1.0);
        apart.scans.iter_mut().for_each(|scan| scan.stamp_s += 1.7e9);
        let error = apart.paired(Pose::default()).expect_err("no scan has a pose").to_string();
        assert!(error.contains("odometry from 0.000 s to 20.000 s"), "{error}");
    }
}
