//! Where something was at times, and between them.

use crate::geometry::{Pose, wrap_angle_rad};

/// Poses at times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Track {
    /// In order of time.
    poses: Vec<(f64, Pose)>,
}

/// Two neighbours of a track, and a time between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Between {
    /// The one before, or at the time itself.
    pub before: (f64, Pose),
    /// The one after, or at the time itself.
    pub after: (f64, Pose),
    /// How much of the way between them has gone by.
    pub share: f64,
}

impl Track {
    /// A track of poses in any order; those without a finite time are left out.
    pub fn new(mut poses: Vec<(f64, Pose)>) -> Self {
        poses.retain(|(stamp_s, _)| stamp_s.is_finite());
        poses.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { poses }
    }

    /// Whether there is no pose.
    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    /// The first and the last time.
    pub fn span_s(&self) -> Option<(f64, f64)> {
        Some((self.poses.first()?.0, self.poses.last()?.0))
    }

    /// The pose at a time, on the way between those before and after it; headings take the short way round. None before
    /// the first and after the last. O(log poses).
    pub fn at(&self, stamp_s: f64) -> Option<Pose> {
        let Between { before: (_, before), after: (_, after), share } = self.around(stamp_s)?;
        Some(on_the_way(before, after, share))
    }

    /// The neighbours of a time.
    pub(super) fn around(&self, stamp_s: f64) -> Option<Between> {
        let at = self.poses.partition_point(|(time_s, _)| *time_s < stamp_s);
        let after = *self.poses.get(at)?;
        if after.0 == stamp_s {
            return Some(Between { before: after, after, share: 0.0 });
        }
        let before = *self.poses.get(at.checked_sub(1)?)?;
        Some(Between { before, after, share: (stamp_s - before.0) / (after.0 - before.0) })
    }

    /// The pose that is nearest to a time before the first or after the last one.
    pub(super) fn beside(&self, stamp_s: f64) -> Option<(f64, Pose)> {
        let (first, last) = (*self.poses.first()?, *self.poses.last()?);
        Some(if stamp_s < first.0 { first } else { last })
    }

    /// What is left of it within the times of another one.
    pub(super) fn within(&self, other: &Self) -> Self {
        let Some((first_s, last_s)) = other.span_s() else { return Self::default() };
        let inside = |(stamp_s, _): &&(f64, Pose)| (first_s..=last_s).contains(stamp_s);
        Self { poses: self.poses.iter().filter(inside).copied().collect() }
    }
}

/// A pose on the way from one to another; the heading takes the short way round.
pub(super) fn on_the_way(from: Pose, to: Pose, share: f64) -> Pose {
    if share == 0.0 {
        return from;
    }
    let between = |from: f64, to: f64| from + share * (to - from);
    let turn_rad = wrap_angle_rad(to.heading_rad - from.heading_rad);
    Pose::new(between(from.x_m, to.x_m), between(from.y_m, to.y_m), from.heading_rad + share * turn_rad)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn between_two_poses_the_heading_takes_the_short_way_round() {
        let track = Track::new(vec![(2.0, Pose::new(2.0, 4.0, -3.0)), (1.0, Pose::new(1.0, 2.0, 3.0))]);
        let half = track.at(1.5).expect("it is between them");
        assert_eq!((half.x_m, half.y_m), (1.5, 3.0));
        assert!(libm::fabs(wrap_angle_rad(half.heading_rad - PI)) < 1e-12, "{half:?}");
        assert_eq!(track.at(2.0), Some(Pose::new(2.0, 4.0, -3.0)));
        assert_eq!((track.at(0.9), track.at(2.1)), (None, None));
    }
}
