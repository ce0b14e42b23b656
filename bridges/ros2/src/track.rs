//! Where the robot was, by the stamps of its odometry: a scan belongs to the place where it was taken, however late it
//! comes.

use rpl_robot::geometry::{Pose, wrap_angle_rad};
use rpl_ros_messages::messages::Time;
use std::collections::VecDeque;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Clocks that differ by more are not the same clock.
pub const SAME_CLOCK: Duration = Duration::from_secs(1);

/// What is remembered of the past; twice the above, because odometry itself may come late.
const REMEMBERED_NS: i64 = 2 * nanoseconds(SAME_CLOCK);

const SECOND_NS: i64 = 1_000_000_000;

/// Nanoseconds of a short time.
pub const fn nanoseconds(time: Duration) -> i64 {
    time.as_nanos() as i64
}

/// The nanoseconds of a stamp; none if nothing was stamped.
pub fn stamp_ns(stamp: &Time) -> Option<i64> {
    let is_none = stamp.sec == 0 && stamp.nanosec == 0;
    (!is_none).then(|| i64::from(stamp.sec) * SECOND_NS + i64::from(stamp.nanosec))
}

/// The stamp of a time.
pub fn stamp(time_ns: i64) -> Time {
    let sec = i32::try_from(time_ns.div_euclid(SECOND_NS)).unwrap_or(i32::MAX);
    Time { sec, nanosec: time_ns.rem_euclid(SECOND_NS) as u32 }
}

/// What the clock of this machine says.
pub fn machine_ns() -> i64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, nanoseconds)
}

/// Where the robot was at some time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// There.
    Known(Pose),
    /// Odometry has not come so far yet.
    NotYet,
    /// Nothing is remembered of that time.
    Forgotten,
    /// The time is of another clock, which is ahead of that of the odometry by so much, or behind it.
    OtherClock(i64),
    /// Odometry has no stamps.
    NoClock,
}

/// The places of the last seconds.
#[derive(Clone, Debug, Default)]
pub struct Track {
    /// Stamps in nanoseconds, the newest last, and where the robot was then.
    past: VecDeque<(i64, Pose)>,
    /// When the newest came.
    came: Option<Instant>,
}

impl Track {
    /// The robot was somewhere, as it is heard at `now`. What comes in the wrong order is passed over; a clock that was
    /// set back begins anew.
    pub fn add(&mut self, stamp_ns: i64, base_in_odom: Pose, now: Instant) {
        if let Some(&(newest_ns, _)) = self.past.back()
            && stamp_ns <= newest_ns
        {
            if newest_ns - stamp_ns <= nanoseconds(SAME_CLOCK) {
                return;
            }
            self.past.clear();
        }
        self.past.push_back((stamp_ns, base_in_odom));
        self.came = Some(now);
        while self.past.front().is_some_and(|(old_ns, _)| stamp_ns - old_ns > REMEMBERED_NS) {
            self.past.pop_front();
        }
    }

    /// What the clock of the odometry says, as far as can be told from here.
    pub fn clock_ns(&self, now: Instant) -> Option<i64> {
        let (&(newest_ns, _), came) = self.past.back().zip(self.came)?;
        Some(newest_ns + nanoseconds(now.saturating_duration_since(came)))
    }

    /// Where the robot was at the time of a stamp, as it is asked at `now`. Cost: log n.
    pub fn at(&self, stamp_ns: i64, now: Instant) -> Place {
        let Some(clock_ns) = self.clock_ns(now) else { return Place::NoClock };
        let ahead_ns = stamp_ns - clock_ns;
        if ahead_ns.abs() > nanoseconds(SAME_CLOCK) {
            return Place::OtherClock(ahead_ns);
        }
        let after = self.past.partition_point(|(past_ns, _)| *past_ns < stamp_ns);
        match (after.checked_sub(1).and_then(|before| self.past.get(before)), self.past.get(after)) {
            (_, None) => Place::NotYet,
            (_, Some(&(after_ns, pose))) if after_ns == stamp_ns => Place::Known(pose),
            (None, Some(_)) => Place::Forgotten,
            (Some(&(before_ns, before)), Some(&(after_ns, after))) => {
                let share = (stamp_ns - before_ns) as f64 / (after_ns - before_ns) as f64;
                Place::Known(between(before, after, share))
            }
        }
    }
}

/// A pose on the way from one to another, which turns the short way round.
fn between(from: Pose, to: Pose, share: f64) -> Pose {
    let part = |from: f64, to: f64| from + share * (to - from);
    let turn_rad = wrap_angle_rad(to.heading_rad - from.heading_rad);
    let heading_rad = wrap_angle_rad(from.heading_rad + share * turn_rad);
    Pose::new(part(from.x_m, to.x_m), part(from.y_m, to.y_m), heading_rad)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    fn turning(began: Instant) -> Track {
        let mut track = Track::default();
        for step in 0..100_i64 {
            let (time_ns, heading_rad) = (SECOND_NS + step * 50 * MS, wrap_angle_rad(3.0 + 0.05 * step as f64));
            track.add(time_ns, Pose::new(0.01 * step as f64, 0.0, heading_rad), began);
        }
        track
    }

    #[test]
    fn a_place_is_interpolated_and_headings_turn_the_short_way() {
        let now = Instant::now();
        let track = turning(now);
        // The newest is of 5.95 s.
        let Place::Known(pose) = track.at(SECOND_NS + 4_925 * MS, now) else { panic!("it was there") };
        let off_rad = wrap_angle_rad(pose.heading_rad - (3.0 + 0.05 * 98.5));
        assert!((pose.x_m - 0.985).abs() < 1e-9 && off_rad.abs() < 1e-9, "{pose:?}");
        let mut track = Track::default();
        track.add(SECOND_NS, Pose::new(0.0, 0.0, 3.0), now);
        track.add(SECOND_NS + 100 * MS, Pose::new(0.0, 0.0, -3.0), now);
        let Place::Known(pose) = track.at(SECOND_NS + 50 * MS, now) else { panic!("it was there") };
        assert!(wrap_angle_rad(pose.heading_rad - std::f64::consts::PI).abs() < 1e-9, "{pose:?}");
    }

    #[test]
    fn what_is_to_come_what_is_forgotten_and_other_clocks_are_told_apart() {
        let now = Instant::now();
        let track = turning(now);
        let newest_ns = SECOND_NS + 4_950 * MS;
        assert_eq!(track.at(newest_ns + MS, now), Place::NotYet);
        assert_eq!(track.at(newest_ns + 1_500 * MS, now), Place::OtherClock(1_500 * MS));
        assert_eq!(track.at(newest_ns - 1_500 * MS, now), Place::OtherClock(-1_500 * MS));
        assert!(track.past.len() <= 41, "two seconds are remembered: {}", track.past.len());
        let mut track = Track::default();
        assert_eq!(track.at(SECOND_NS, now), Place::NoClock);
        track.add(SECOND_NS, Pose::default(), now);
        assert_eq!(track.at(SECOND_NS - MS, now), Place::Forgotten);
    }

    #[test]
    fn disorder_is_passed_over_and_a_clock_that_is_set_back_begins_anew() {
        let now = Instant::now();
        let mut track = turning(now);
        let newest_ns = SECOND_NS + 4_950 * MS;
        track.add(newest_ns - 75 * MS, Pose::new(9.0, 9.0, 0.0), now);
        assert_eq!(track.clock_ns(now), Some(newest_ns));
        track.add(SECOND_NS, Pose::new(9.0, 9.0, 0.0), now);
        assert_eq!((track.clock_ns(now), track.past.len()), (Some(SECOND_NS), 1));
    }

    #[test]
    fn stamps_are_nanoseconds_and_none_is_none() {
        let time = Time { sec: 7, nanosec: 9 };
        assert_eq!(stamp_ns(&time), Some(7_000_000_009));
        assert_eq!((stamp(7_000_000_009), stamp_ns(&Time::default())), (time, None));
    }
}
