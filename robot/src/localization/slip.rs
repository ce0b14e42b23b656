//! Odometry that errs by more than the description of the robot says, as the scans tell: wheels that slip.

use super::parameters::OdometryError;
use serde::{Deserialize, Serialize};

/// What was told so many updates ago counts for a share of 1 / e.
const REMEMBERED_UPDATES: f64 = 20.0;

/// That odometry errs as its description says counts for so much, as Fisher information of the square of the factor.
const DESCRIPTION_WEIGHT: f64 = 0.2;

/// No factor is taken to be larger.
const MOST: f64 = 12.0;

/// A correction is not taken to be farther out than so many standard deviations: hands are not wheels.
const FARTHEST_SIGMAS: f64 = 5.0;

/// What the cells of a grid hide of a correction, as standard deviations.
const BLURRED_M: f64 = 0.01;
const BLURRED_RAD: f64 = 0.3 / 180.0 * std::f64::consts::PI;

/// Along one axis of the pose, how a scan has corrected what odometry had led to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Correction {
    /// By how much the mean of the belief has moved.
    pub moved: f64,
    /// Variance of the belief before the scan.
    pub before: f64,
    /// And after it.
    pub after: f64,
    /// What the motion since the last scan has added, if odometry errs as its description says.
    pub added: f64,
}

/// How many times as far as its description says odometry errs along some axes of the pose.
///
/// A belief that is worth what it says is moved by a scan with a variance of P₀ − P₁, that before the scan less that after
/// it; what odometry errs beyond that adds K² Q (s² − s₀²), with K = (P₀ − P₁) / P₀, Q what the motion adds by the
/// description, and s₀ the factor in use (innovations as the measure of a filter's noise: Mehra, "On the Identification of
/// Variances and Adaptive Kalman Filtering", 1970). s² is where Fisher's scoring leads from there: each correction counts
/// for what it can tell of s², so that scans which tell nothing change nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Factor {
    /// Σ of the information of each correction, and of that times the s² it speaks for.
    information: f64,
    told: f64,
}

impl Factor {
    fn square(&self) -> f64 {
        let square = (self.told + DESCRIPTION_WEIGHT) / (self.information + DESCRIPTION_WEIGHT);
        square.clamp(1.0, MOST * MOST)
    }

    fn learn(&mut self, corrections: &[Correction], blurred: f64) {
        let square_in_use = self.square();
        for Correction { moved, before, after, added } in corrections {
            let learned = (before - after).max(0.0);
            let gain = learned / before.max(f64::MIN_POSITIVE);
            let due = learned + blurred * blurred;
            let by_square = gain * gain * added;
            let found = (moved * moved).min(FARTHEST_SIGMAS * FARTHEST_SIGMAS * due);
            self.information += by_square * by_square / (due * due);
            self.told += by_square * (found - due + by_square * square_in_use) / (due * due);
        }
    }

    fn forget(&mut self) {
        let kept = libm::exp(-1.0 / REMEMBERED_UPDATES);
        (self.information, self.told) = (kept * self.information, kept * self.told);
    }
}

/// How many times as far as its description says odometry errs, in the position and in the heading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Slip {
    position: Factor,
    heading: Factor,
}

impl Slip {
    /// The error of odometry by its description, as the scans tell it.
    pub(super) fn error(&self, described: &OdometryError) -> OdometryError {
        let [position, heading] = [self.position, self.heading].map(|factor| libm::sqrt(factor.square()));
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
        libm::sqrt(self.position.square().max(self.heading.square()))
    }

    /// Takes in how scans have corrected x, y and the heading after a motion.
    pub(super) fn learn(&mut self, [x, y, heading]: [Correction; 3]) {
        self.position.forget();
        self.heading.forget();
        self.position.learn(&[x, y], BLURRED_M);
        self.heading.learn(&[heading], BLURRED_RAD);
    }
}
