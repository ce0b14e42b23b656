//! What can be set about the filter.

use super::calibration::Calibration;
use super::error::ModelError;
use super::scan_parameters::{BeamParameters, ErrorCorrelation, ScanParameters};
use crate::description::{OdometryDrift, RobotDescription};
use crate::geometry::Pose;
use crate::sensors::RangeSensor;
use serde::{Deserialize, Serialize};

/// Everything that can be set about the filter.
///
/// # Deviation
/// The defaults depart from the papers in seven ways, each switchable, because the literal
/// equations lose a robot turned by hand: 24 overlapping cones of one scan are not independent
/// evidence, so a scan is *tempered*; an update waits for some motion, so that a standing robot
/// does not count the same evidence again; a little of the uniform distribution is *mixed* in, so
/// that no hypothesis is beyond recall; and readings clearly shorter than expected are *gated*,
/// because they are usually people and furniture outside the map; θ is lower; a coarse
/// belief of the whole map watches over the fine one; and the certainty is calibrated.
/// [`LocalizationParameters::literal`] takes them back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LocalizationParameters {
    /// Edge of a belief cell.
    pub cell_m: f64,
    /// Whole degrees between two headings; must divide 360.
    pub angle_step_deg: u32,
    /// Whether the grid is centred on the world, so that mirror poses fall on mirror cells; else it
    /// is laid from the corner of the map.
    pub centred: bool,
    /// Positions nearer than this to anything occupied carry no mass: the robot is a disc.
    pub clearance_m: f64,
    /// What measures distances, at least one, the one that tells most first.
    pub sensors: Vec<ScanParameters>,
    /// The error model of the odometry.
    pub odometry: OdometryError,
    /// How the odometry is badly wrong now and then; none expects that it never is.
    #[serde(default)]
    pub faults: Option<OdometryFaults>,
    /// Share of the uniform distribution mixed in after an update; 0 is none.
    pub mixing: f64,
    /// The watch over the whole map; none does not watch.
    pub watch: Option<Watch>,
    /// What the share of the belief around the mode is worth; none takes the share itself.
    pub calibration: Option<Calibration>,
    /// What the share is worth that dead reckoning leaves around the mode of what it holds; none takes the share itself.
    #[serde(default)]
    pub reckoning: Option<Calibration>,
    /// θ of Beetz et al. Eqs. (3)–(4) as a share of the prior probability of a cell; 0 updates
    /// every cell every time. With the papers' 1 %, one of two mirror poses can lose the edge of its
    /// peak before the other does and then falls behind; well above `mixing`, or nothing ever sleeps.
    pub activity_threshold: f64,
    /// An update is due after this distance ...
    pub update_distance_m: f64,
    /// ... or after turning by this much.
    pub update_angle_rad: f64,
    /// A robot at rest updates after this many observations ...
    pub standing_observations: u32,
    /// ... but at most this many times, until it moves or sees something new.
    pub standing_updates: u32,
}

/// Fitted in rounds, each time with the mean, in log odds, of what a table printed and what was in use before: with
/// `rpl experiment calibration --seed 5001 --runs 150`, and then in other buildings with
/// `rpl experiment buildings --seed 930001 --runs 2`. What the certainty is worth depends on when the robot takes itself for
/// lost, and so on the calibration; the mean settles where the two agree. A share as high as it gets while nothing speaks
/// against the pose is worth what such moments were.
const CALIBRATED: [[f64; 2]; 17] = [
    [0.01000, 0.0254],
    [0.02000, 0.0443],
    [0.03000, 0.0604],
    [0.05000, 0.1564],
    [0.10000, 0.1976],
    [0.25000, 0.2942],
    [0.40000, 0.3937],
    [0.50000, 0.4966],
    [0.57000, 0.5908],
    [0.84000, 0.6911],
    [0.95000, 0.7462],
    [0.99800, 0.8363],
    [0.99860, 0.8812],
    [0.99890, 0.9239],
    [0.99910, 0.9683],
    [0.99930, 0.9863],
    [0.99938, 0.9997],
];

/// The same with a laser, also in rounds: `rpl experiment calibration --robot b21-laser` with `--seed 5001`, `6001`, `7001`
/// (`--runs 40`), `22001` (`--runs 25`) and `41001` (`--runs 100`), and then `rpl experiment buildings` with `b21-laser`
/// (`--seed 930001 --runs 2`) and `turtlebot` (`--seed 930002 --runs 1`).
const CALIBRATED_LASER: [[f64; 2]; 21] = [
    [0.01000, 0.0080],
    [0.02000, 0.0248],
    [0.03000, 0.0421],
    [0.05000, 0.0808],
    [0.07000, 0.1286],
    [0.10000, 0.1698],
    [0.16000, 0.2430],
    [0.25000, 0.3042],
    [0.40000, 0.3682],
    [0.50000, 0.4623],
    [0.72000, 0.6129],
    [0.84000, 0.6945],
    [0.95000, 0.8006],
    [0.99000, 0.8606],
    [0.99650, 0.9030],
    [0.99800, 0.9229],
    [0.99860, 0.9427],
    [0.99890, 0.9642],
    [0.99910, 0.9798],
    [0.99930, 0.9922],
    [0.99938, 0.9997],
];

/// The mean, in log odds, of the share itself and of what the same tables of buildings print for the share that dead
/// reckoning leaves.
const RECKONED: [[f64; 2]; 12] = [
    [0.10, 0.031],
    [0.20, 0.091],
    [0.30, 0.174],
    [0.40, 0.330],
    [0.50, 0.566],
    [0.60, 0.697],
    [0.70, 0.802],
    [0.80, 0.860],
    [0.90, 0.922],
    [0.95, 0.951],
    [0.98, 0.983],
    [0.999, 0.9999],
];

impl Default for LocalizationParameters {
    /// Those of the papers' robot.
    fn default() -> Self {
        Self::of(&RobotDescription::papers())
    }
}

impl LocalizationParameters {
    /// Those of a robot, which localizes with the sensors it has.
    pub fn of(robot: &RobotDescription) -> Self {
        let calibrated: &[[f64; 2]] = if robot.laser.is_some() { &CALIBRATED_LASER } else { &CALIBRATED };
        Self {
            cell_m: 0.15,
            angle_step_deg: 2,
            centred: true,
            clearance_m: 0.15,
            sensors: ScanParameters::of(robot),
            odometry: OdometryError::of(&robot.odometry),
            faults: Some(OdometryFaults::of_wheels()),
            mixing: 5e-4,
            watch: Some(Watch::default()),
            calibration: Some(Calibration::new(calibrated)),
            reckoning: Some(Calibration::new(&RECKONED)),
            activity_threshold: 0.003,
            update_distance_m: 0.15,
            update_angle_rad: 10f64.to_radians(),
            standing_observations: 20,
            standing_updates: 5,
        }
    }

    /// The equations as printed: every scan counts in full, at every step, and nothing is mixed in.
    pub fn literal(self) -> Self {
        let in_full = |sensor| ScanParameters { tempering: 1.0, correlation: None, gating: None, ..sensor };
        Self {
            sensors: self.sensors.into_iter().map(in_full).collect(),
            faults: None,
            mixing: 0.0,
            watch: None,
            calibration: None,
            reckoning: None,
            activity_threshold: 0.01,
            update_distance_m: 0.0,
            update_angle_rad: 0.0,
            ..self
        }
    }

    /// Looks whether each parameter is one that a filter can work with.
    ///
    /// # Errors
    /// The first that is not.
    pub fn check(&self) -> Result<(), ModelError> {
        let odometry = &self.odometry;
        let mut ranges = vec![
            ("cell_m", self.cell_m, 0.01, 100.0),
            ("clearance_m", self.clearance_m, 0.0, 10.0),
            ("mixing", self.mixing, 0.0, 1.0),
            ("activity_threshold", self.activity_threshold, 0.0, 1.0),
            ("update_distance_m", self.update_distance_m, 0.0, 100.0),
            ("update_angle_rad", self.update_angle_rad, 0.0, 7.0),
            ("odometry.forward_m", odometry.forward_m, 0.0, 10.0),
            ("odometry.sideward_m", odometry.sideward_m, 0.0, 10.0),
            ("odometry.turn_per_metre_rad", odometry.turn_per_metre_rad, 0.0, 7.0),
            ("odometry.turn_per_radian_rad", odometry.turn_per_radian_rad, 0.0, 7.0),
            ("odometry.position_per_radian_m", odometry.position_per_radian_m, 0.0, 10.0),
        ];
        ranges.extend(self.sensors.iter().flat_map(ScanParameters::ranges));
        if let Some(faults) = &self.faults {
            ranges.extend([
                ("faults.jump", faults.jump, 0.0, 0.4),
                ("faults.most_jump_rad", faults.most_jump_rad, 0.0, 3.2),
                ("faults.reversal", faults.reversal, 0.0, 0.4),
            ]);
        }
        if let Some(watch) = &self.watch {
            ranges.extend([
                ("watch.cell_m", watch.cell_m, 0.01, 100.0),
                ("watch.mixing", watch.mixing, 0.0, 1.0),
                ("watch.near_m", watch.near_m, 0.0, 1000.0),
                ("watch.near_rad", watch.near_rad, 0.0, 7.0),
                ("watch.agreement", watch.agreement, 0.0, 1.0),
            ]);
        }
        match ranges.into_iter().find(|(_, found, least, most)| !(least..=most).contains(&found)) {
            None => Ok(()),
            Some((name, found, least, most)) => Err(ModelError::Parameter {
                name,
                least: least.to_string(),
                most: most.to_string(),
                found: found.to_string(),
            }),
        }
    }

    /// The parameters of the coarse belief that watches, if there is one.
    pub(super) fn of_watch(&self) -> Option<Self> {
        let watch = self.watch.as_ref()?;
        Some(Self {
            cell_m: watch.cell_m.max(self.cell_m),
            angle_step_deg: watch.angle_step_deg,
            sensors: self.sensors.iter().map(ScanParameters::of_watch).collect(),
            mixing: watch.mixing,
            activity_threshold: 0.0,
            watch: None,
            calibration: None,
            reckoning: None,
            ..self.clone()
        })
    }

    /// For recorded drives with a laser range finder, whose scans have these beams: rays and no cones, a
    /// finer grid, and odometry as in recorded drives; sensor and odometry are what a fit to such drives
    /// gives, rounded.
    ///
    /// # Deviation
    /// As for the sonars, but nothing watches: a recorded drive is not disturbed. A scan is tempered so that the share
    /// of the belief is right after the first one, and counts for less where the last one was near; no calibration is
    /// needed on top of that.
    pub fn recorded(beams_deg: Vec<i32>) -> Self {
        Self {
            cell_m: 0.1,
            clearance_m: 0.0,
            sensors: vec![ScanParameters {
                source: RangeSensor::Laser,
                beams_deg,
                beam: BeamParameters::laser(),
                tempering: 0.45,
                // Beside the last one a scan counts for less than half.
                correlation: Some(ErrorCorrelation { in_place: 0.385, length_m: 1.0 }),
                gating: None,
                watch_sigma_m: 0.2,
                watch_tempering: 0.2,
            }],
            odometry: OdometryError {
                forward_m: 0.14,
                sideward_m: 0.09,
                turn_per_metre_rad: 4.2f64.to_radians(),
                turn_per_radian_rad: 6.5f64.to_radians(),
                position_per_radian_m: 0.0,
            },
            faults: Some(OdometryFaults::default()),
            mixing: 1e-4,
            watch: None,
            calibration: None,
            reckoning: None,
            ..Self::default()
        }
    }

    /// Those of the papers' robot on a coarse grid, for tests and for saving often.
    pub fn coarse() -> Self {
        Self::default().coarsened()
    }

    /// The same on a coarse grid (30 cm, 6°).
    #[must_use]
    pub fn coarsened(self) -> Self {
        Self { cell_m: 0.3, angle_step_deg: 6, ..self }
    }
}

/// How far odometry strays: variances grow in proportion to the way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OdometryError {
    /// Standard deviation along the heading after one metre.
    pub forward_m: f64,
    /// Standard deviation across the heading after one metre.
    pub sideward_m: f64,
    /// Standard deviation of the heading after one metre.
    pub turn_per_metre_rad: f64,
    /// Standard deviation of the heading after turning by one radian.
    pub turn_per_radian_rad: f64,
    /// Standard deviation of the position, along each axis, after turning by one radian: wheels scrub, and no robot turns
    /// about its middle. A belief that turning left as sharp as it was would gather at a single cell, and not come back.
    #[serde(default)]
    pub position_per_radian_m: f64,
}

/// What odometry does now and then that no normal error covers: it jumps in its heading from one scan to the next,
/// by a slipping wheel or a lost message, and it counts a way backward as one forward, as that of wheels does whose
/// encoders have no sign.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OdometryFaults {
    /// Probability of a jump at an update.
    pub jump: f64,
    /// It is by at most this angle to either side, all alike.
    pub most_jump_rad: f64,
    /// Probability at an update that the way was the other one.
    pub reversal: f64,
}

impl Default for OdometryFaults {
    fn default() -> Self {
        Self { jump: 0.01, most_jump_rad: 30f64.to_radians(), reversal: 0.01 }
    }
}

impl OdometryFaults {
    /// Of a robot in a mission: hands and wheels that slip.
    fn of_wheels() -> Self {
        Self { reversal: 0.0, ..Self::default() }
    }
}

impl Default for OdometryError {
    /// That of the papers' robot.
    fn default() -> Self {
        Self::of(&RobotDescription::papers().odometry)
    }
}

/// Odometry errs by more than its description says: steps of the grid, and floors that it was not measured on.
const ODOMETRY_SLACK: f64 = 1.1;

/// A constant error is as far off after this way as a random one that is set right as often: what it adds to the
/// variance grows with the square of the way, and here it is to grow with the way.
const BIAS_WAY_M: f64 = 10.0;

/// The same for turns.
const BIAS_TURN_RAD: f64 = std::f64::consts::TAU;

/// No odometry is taken to be better than this.
const LEAST_ERROR: OdometryError = OdometryError {
    forward_m: 0.03,
    sideward_m: 0.015,
    turn_per_metre_rad: 0.8 / 180.0 * std::f64::consts::PI,
    turn_per_radian_rad: 1.5 / 180.0 * std::f64::consts::PI,
    position_per_radian_m: 0.03,
};

impl OdometryError {
    /// Variances along the heading, across it, and of the heading, after a motion.
    pub(super) fn variances(&self, motion: Pose) -> [f64; 3] {
        let square = |error: f64| error * error;
        let (way_m, turn_rad) = (libm::hypot(motion.x_m, motion.y_m), libm::fabs(motion.heading_rad));
        let scrubbed = square(self.position_per_radian_m) * turn_rad;
        let heading = square(self.turn_per_metre_rad) * way_m + square(self.turn_per_radian_rad) * turn_rad;
        [square(self.forward_m) * way_m + scrubbed, square(self.sideward_m) * way_m + scrubbed, heading]
    }

    /// What odometry of a robot strays by: its random errors, and the constant ones as if they were random.
    pub fn of(drift: &OdometryDrift) -> Self {
        let error = |noise: f64, bias: f64, way: f64| ODOMETRY_SLACK * libm::sqrt(noise * noise + bias * bias * way);
        let forward_m = error(drift.translation_noise_m_per_sqrt_m, drift.translation_bias, BIAS_WAY_M);
        let per_metre_rad = error(drift.rotation_noise_rad_per_sqrt_m, drift.heading_bias_radpm, BIAS_WAY_M);
        let per_radian_rad = error(drift.rotation_noise_rad_per_sqrt_rad, drift.rotation_bias, BIAS_TURN_RAD);
        Self {
            forward_m: forward_m.max(LEAST_ERROR.forward_m),
            sideward_m: (forward_m / 2.0).max(LEAST_ERROR.sideward_m),
            turn_per_metre_rad: per_metre_rad.max(LEAST_ERROR.turn_per_metre_rad),
            turn_per_radian_rad: per_radian_rad.max(LEAST_ERROR.turn_per_radian_rad),
            position_per_radian_m: LEAST_ERROR.position_per_radian_m,
        }
    }
}

/// A second belief over the whole map on a coarse grid, of which no part sleeps; as a whole it may, while the scans fit.
///
/// # Deviation
/// Selective computation treats whatever it does not look at as average. A wrong pose that explains
/// the scans better than the average one, as any pose in a long corridor does, is then never given
/// up, and of two mirror poses the one whose heading is being updated gains on the other. On a grid
/// of a twelfth of the states the equations are computed in full at every update. Its probability
/// of the estimated pose bounds the certainty; when it falls short of what the fine belief says,
/// the fine belief is made anew from the coarse one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Watch {
    /// Edge of a cell.
    pub cell_m: f64,
    /// Whole degrees between two headings; must divide 360.
    pub angle_step_deg: u32,
    /// Share of the uniform distribution mixed in after an update.
    pub mixing: f64,
    /// The coarse belief agrees with a pose by what it gives the poses within this distance ...
    pub near_m: f64,
    /// ... and this angle: it is to tell whether the robot is somewhere else, and it is itself too
    /// blurred to tell more.
    pub near_rad: f64,
    /// The fine belief is made anew when the coarse one gives its mode less than this share of what
    /// the fine one does.
    pub agreement: f64,
}

impl Default for Watch {
    fn default() -> Self {
        Self { cell_m: 0.3, angle_step_deg: 6, mixing: 2e-5, near_m: 1.8, near_rad: 40f64.to_radians(), agreement: 0.5 }
    }
}

/// Standard deviations of a belief around a known pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// In x and in y.
    pub position_m: f64,
    /// In the heading.
    pub heading_rad: f64,
}

impl Default for Spread {
    fn default() -> Self {
        Self { position_m: 0.15, heading_rad: 3f64.to_radians() }
    }
}
