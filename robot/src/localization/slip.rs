//! Odometry that errs by more than the description of the robot says, as the scans tell: wheels that slip.

use super::parameters::{OdometryError, Spread};
use super::scan_match::Fix;
use crate::geometry::{Pose, wrap_angle_rad};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Odometry is compared with where the scans find the robot after this way, or after this turn.
const COMPARED_M: f64 = 1.0;
const COMPARED_RAD: f64 = 1.0;

/// After this way without knowing well where it is, a robot compares anew.
const LONGEST_M: f64 = 5.0;

/// How well scans find the pose at either end.
const FOUND: Spread = Spread { position_m: 0.06, heading_rad: 2.0 / 180.0 * std::f64::consts::PI };

/// Ways that are remembered.
const WAYS: usize = 20;

/// The description of the odometry's errors counts for this many ways.
const DESCRIPTION_WAYS: f64 = 1.0;

/// No factor is taken to be larger.
const MOST: f64 = 12.0;

/// An error is not taken to be farther out than this many standard deviations: hands are not wheels.
const FARTHEST_SIGMAS: f64 = 3.0;

/// Rounds of scoring: each is near to the next one then.
const ROUNDS: usize = 8;

/// What one way tells of odometry, along some axes of the pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct WayError {
    /// The square of the error.
    squared: f64,
    /// Its variance by the description, Q ...
    described: f64,
    /// ... and that of where scans find the robot at both ends, R.
    found: f64,
}

/// How many times as far as its description says odometry errs along some axes of the pose.
///
/// The square of what it is found to err by is s² Q + R on the average (covariance matching: Mehra, "Approaches to Adaptive
/// Filtering", 1972). s² is found by Fisher's scoring: each way counts for what it can tell of s², so that short ones
/// hardly do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Factor {
    /// The oldest first.
    ways: VecDeque<WayError>,
    /// s².
    square: f64,
}

impl Default for Factor {
    fn default() -> Self {
        Self { ways: VecDeque::new(), square: 1.0 }
    }
}

impl Factor {
    fn learn(&mut self, way: WayError) {
        if self.ways.len() == WAYS {
            self.ways.pop_front();
        }
        self.ways.push_back(way);
        for _ in 0..ROUNDS {
            self.square = self.scored().clamp(1.0, MOST * MOST);
        }
    }

    /// s² by the ways, weighed as if it were as large as it is now.
    fn scored(&self) -> f64 {
        let (mut told, mut information) = (0.0, 0.0);
        for &WayError { squared, described, found } in &self.ways {
            let due = self.square * described + found;
            let squared = squared.min(FARTHEST_SIGMAS * FARTHEST_SIGMAS * due);
            told += described * (squared - found) / (due * due);
            information += described * described / (due * due);
        }
        let description = DESCRIPTION_WAYS * information / self.ways.len() as f64;
        (told + description) / (information + description).max(f64::MIN_POSITIVE)
    }
}

/// How many times as far as its description says odometry errs, in the position and in the heading.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Slip {
    position: Factor,
    heading: Factor,
    /// Since when odometry is compared.
    since: Option<Way>,
}

/// A way by odometry alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Way {
    /// Where it has led, and how well that is known by the description.
    reckoned: Fix,
    way_m: f64,
    turned_rad: f64,
}

impl Slip {
    /// The error of odometry by its description, as the scans tell it.
    pub(super) fn error(&self, described: &OdometryError) -> OdometryError {
        let [position, heading] = [&self.position, &self.heading].map(|factor| libm::sqrt(factor.square));
        OdometryError {
            forward_m: position * described.forward_m,
            sideward_m: position * described.sideward_m,
            turn_per_metre_rad: heading * described.turn_per_metre_rad,
            turn_per_radian_rad: heading * described.turn_per_radian_rad,
            position_per_radian_m: position * described.position_per_radian_m,
        }
    }

    /// The larger one of both factors, at least 1.
    pub(super) fn factor(&self) -> f64 {
        libm::sqrt(self.position.square.max(self.heading.square))
    }

    /// Takes in a motion.
    pub(super) fn advance(&mut self, motion: Pose, described: &OdometryError) {
        let way = |Way { reckoned, way_m, turned_rad }: Way| Way {
            reckoned: reckoned.advanced(motion, described),
            way_m: way_m + libm::hypot(motion.x_m, motion.y_m),
            turned_rad: turned_rad + libm::fabs(motion.heading_rad),
        };
        self.since = self.since.map(way).filter(|way| way.way_m <= LONGEST_M);
    }

    /// Takes in where the scans have found the robot, for sure.
    pub(super) fn learn(&mut self, found_in_map: Pose) {
        if let Some(Way { reckoned, way_m, turned_rad }) = self.since {
            if way_m < COMPARED_M && turned_rad < COMPARED_RAD {
                return;
            }
            let [position, heading] = reckoned.variances();
            let square = |error: f64| error * error;
            let off_m = found_in_map.distance_m(reckoned.pose_in_map);
            let off_rad = wrap_angle_rad(found_in_map.heading_rad - reckoned.pose_in_map.heading_rad);
            // Both ends, and the position along two axes.
            let (found_m, found_rad) = (4.0 * square(FOUND.position_m), 2.0 * square(FOUND.heading_rad));
            self.position.learn(WayError { squared: square(off_m), described: position, found: found_m });
            self.heading.learn(WayError { squared: square(off_rad), described: heading, found: found_rad });
        }
        let reckoned = Fix::around(found_in_map, Spread { position_m: 0.0, heading_rad: 0.0 });
        self.since = Some(Way { reckoned, way_m: 0.0, turned_rad: 0.0 });
    }

    /// Somebody else may have moved the robot.
    pub(super) fn begin_anew(&mut self) {
        self.since = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_random::Stream;

    /// What is learned on some ways of a metre by odometry that errs `times` times as far as described, and once
    /// somebody has turned the robot.
    fn learned(times: f64, ways: usize, turned_rad: f64) -> f64 {
        let (described, mut stream) = (OdometryError::default(), Stream::new(10_440, "slip"));
        let (mut slip, mut found) = (Slip::default(), Pose::default());
        slip.learn(found);
        for way in 0..ways {
            for _ in 0..5 {
                let motion = Pose::new(0.2, 0.0, 0.05);
                slip.advance(motion, &described);
                let [forward, sideward, heading] =
                    described.variances(motion).map(|variance| times * libm::sqrt(variance) * stream.normal());
                found = found.compose(motion).compose(Pose::new(forward, sideward, heading));
            }
            if way == ways / 2 {
                found.heading_rad += turned_rad;
            }
            let seen = |off: f64, stream: &mut Stream| off * stream.normal();
            let off = [seen(0.05, &mut stream), seen(0.05, &mut stream), seen(0.03, &mut stream)];
            slip.learn(Pose::new(found.x_m + off[0], found.y_m + off[1], found.heading_rad + off[2]));
        }
        slip.factor()
    }

    #[test]
    fn odometry_is_taken_for_as_bad_as_it_is() {
        assert!(learned(1.0, 30, 0.0) < 1.6, "{}", learned(1.0, 30, 0.0));
        let found = learned(10.0, 30, 0.0);
        assert!((6.0..=12.0).contains(&found), "{found}");
        let soon = learned(10.0, 4, 0.0);
        assert!(soon > 3.0, "{soon}");
        let [few, more] = [3.0, 6.0].map(|times| learned(times, 30, 0.0));
        assert!(few < more && (1.5..=5.0).contains(&few), "{few} {more}");
    }

    #[test]
    fn a_robot_that_was_turned_by_hand_does_not_slip_from_then_on() {
        assert!(learned(1.0, 40, 1.5) < 2.5, "{}", learned(1.0, 40, 1.5));
    }

    #[test]
    fn what_is_described_is_multiplied_and_never_made_smaller() {
        let described = OdometryError::default();
        assert_eq!(Slip::default().error(&described), described);
        let mut slip = Slip::default();
        slip.learn(Pose::default());
        for _ in 0..5 {
            slip.advance(Pose::new(0.2, 0.0, 0.0), &described);
        }
        slip.learn(Pose::new(1.5, 0.0, 0.0));
        let error = slip.error(&described);
        assert!(error.forward_m > 2.0 * described.forward_m, "{error:?}");
        assert_eq!(error.turn_per_metre_rad, described.turn_per_metre_rad);
    }
}
