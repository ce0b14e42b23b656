//! Where a drive was by dead reckoning: as its scans say, or as messages between them do.

use super::drive::{LogError, Scan};
use super::track::Track;
use crate::geometry::{Pose, wrap_angle_rad};

/// Poses nearer than this, in each of their numbers, are one pose that was written down with more or fewer digits.
const SAME_M: f64 = 1e-3;
const SAME_RAD: f64 = 1e-3;

/// A scan as a log has it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Reckoned {
    /// Its line.
    pub line: usize,
    /// From right to left.
    pub ranges_m: Vec<f32>,
    /// The corrected pose.
    pub laser_in_map: Pose,
    /// The odometry it came with.
    pub robot_in_odom: Pose,
    /// When it was taken, if that is known.
    pub stamp_s: Option<f64>,
}

/// Whether two poses are one.
fn is_same(one: Pose, other: Pose) -> bool {
    let near = |a_m: f64, b_m: f64| libm::fabs(a_m - b_m) <= SAME_M;
    let turned_rad = libm::fabs(wrap_angle_rad(one.heading_rad - other.heading_rad));
    near(one.x_m, other.x_m) && near(one.y_m, other.y_m) && turned_rad <= SAME_RAD
}

/// The odometry of messages between the scans.
#[derive(Debug, Default)]
pub(super) struct DeadReckoning {
    /// Time and pose, as they stand in the log; only those with a time.
    poses: Vec<(f64, Pose)>,
}

impl DeadReckoning {
    /// Takes in a message.
    pub(super) fn add(&mut self, stamp_s: Option<f64>, robot_in_odom: Pose) {
        self.poses.extend(stamp_s.map(|stamp_s| (stamp_s, robot_in_odom)));
    }

    /// The scans with their odometry: their own, or that of the messages if their own is nothing but the corrected
    /// poses again. O((scans + messages) log messages).
    ///
    /// # Errors
    /// There are no messages where they are needed, or none at the time of two scans.
    pub(super) fn scans(self, read: Vec<Reckoned>, laser_in_base: Pose) -> Result<Vec<Scan>, LogError> {
        let first_line = read.first().map(|scan| scan.line);
        let is_own = !read.iter().all(|scan| is_same(scan.robot_in_odom, scan.laser_in_map));
        if !is_own && self.poses.is_empty() {
            return Err(LogError {
                line: first_line,
                message:
                    "the odometry of this scan, as of all others, is the corrected pose once more: the filter would \
                          be told what it is to find; a log is needed whose second poses are raw odometry, or one with \
                          ODOM messages and times"
                        .to_string(),
            });
        }
        let messages = Track::new(self.poses);
        let scan = |scan: Reckoned| {
            let robot_in_odom = if is_own { Some(scan.robot_in_odom) } else { messages.at(scan.stamp_s?) };
            Some(Scan {
                line: scan.line,
                stamp_s: scan.stamp_s,
                ranges_m: scan.ranges_m,
                laser_in_map: scan.laser_in_map,
                laser_in_odom: robot_in_odom?.compose(laser_in_base),
            })
        };
        let scans: Vec<Scan> = read.into_iter().filter_map(scan).collect();
        match scans.len() {
            0 | 1 if !is_own => Err(LogError {
                line: first_line,
                message: "the odometry of all scans is the corrected pose once more, and the ODOM messages were not \
                          sent while they were taken, by their times"
                    .to_string(),
            }),
            _ => Ok(scans),
        }
    }
}
