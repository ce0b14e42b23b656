//! A drive of the abstract robot.

use super::drive_times::DriveTimes;
use super::models::TimedDrive;
use super::ways::Way;
use crate::geometry::{Pose, wrap_angle_rad};
use std::sync::Arc;

/// A drive under way: where it is at which time.
#[derive(Clone, Debug)]
pub(super) struct Drive {
    pub way: Arc<Way>,
    /// When each stretch begins; at the end of the last one it turns to its heading.
    pub begins_us: Vec<u64>,
    pub start_in_map: Pose,
    pub targets: usize,
    /// How long it should take and takes, beside what doors cost.
    pub timed: TimedDrive,
    /// Doors on the way that the run first comes to: how many are open then, and how many are closed.
    pub doors_open: u32,
    pub doors_closed: u32,
}

impl Drive {
    /// When it comes to its next target.
    pub fn next_target_us(&self, now_us: u64) -> Option<u64> {
        let next = |&&at: &&usize| self.begins_us.get(at).is_some_and(|&begins_us| begins_us > now_us);
        self.way.targets_at.iter().find(next).and_then(|&at| self.begins_us.get(at).copied())
    }

    /// Targets that are not reached yet.
    pub fn remaining_targets(&self, now_us: u64) -> usize {
        let is_reached = |&&at: &&usize| self.begins_us.get(at).is_some_and(|&begins_us| begins_us <= now_us);
        self.targets - self.way.targets_at.iter().filter(is_reached).count().min(self.targets)
    }

    /// Where it has led to until now; none before it has set off.
    pub fn pose_in_map(&self, now_us: u64, times: &DriveTimes) -> Option<Pose> {
        let begun = self.begins_us.partition_point(|&begins_us| begins_us <= now_us);
        let last = begun.checked_sub(1)?;
        let point_before = |at: usize| match at.checked_sub(1) {
            Some(before) => self.way.stretches[before].to_in_map,
            None => self.start_in_map.point(),
        };
        let from = point_before(last);
        let Some(stretch) = self.way.stretches.get(last) else {
            return Some(Pose::new(from.x, from.y, self.way.last_heading_rad));
        };
        let ahead = stretch.to_in_map - from;
        let begins_us = self.begins_us[last];
        let takes_us = microseconds(times.metre_s(stretch.mode) * stretch.length_m).max(1);
        let share = ((now_us - begins_us) as f64 / takes_us as f64).min(1.0);
        let at = from + ahead * share;
        Some(Pose::new(at.x, at.y, wrap_angle_rad(libm::atan2(ahead.y, ahead.x))))
    }
}

pub(super) fn microseconds(seconds: f64) -> u64 {
    libm::round(seconds.max(0.0) * 1e6) as u64
}
