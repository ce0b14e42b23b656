//! What can be set about the filter.

use super::calibration::Calibration;
use super::error::ModelError;
use crate::description::{RobotDescription, Sonar};
use crate::sensors::{LaserScanner, RangeSensor, SonarMount};
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
/// belief in which nothing sleeps watches over the fine one; and the certainty is calibrated.
/// [`LocalizationParameters::literal`] takes them back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// Share of the uniform distribution mixed in after an update; 0 is none.
    pub mixing: f64,
    /// The watch over the whole map; none does not watch.
    pub watch: Option<Watch>,
    /// What the share of the belief around the mode is worth; none takes the share itself.
    pub calibration: Option<Calibration>,
    /// θ of Beetz et al. Eqs. (3)–(4) as a share of the prior probability of a cell; 0 updates
    /// every cell every time. With the papers' 1 %, one of two mirror poses can lose the edge of its
    /// peak before the other does and then falls behind; well above `mixing`, or nothing ever sleeps.
    pub activity_threshold: f64,
    /// An update is due after this distance ...
    pub update_distance_m: f64,
    /// ... or after turning by this much.
    pub update_angle_rad: f64,
    /// A robot at rest updates after so many observations ...
    pub standing_observations: u32,
    /// ... but at most so many times, until it moves or sees something new.
    pub standing_updates: u32,
}

/// Fitted by `rpl experiment calibration --seed 5001 --runs 150`, which prints such a list.
const CALIBRATED: [[f64; 2]; 17] = [
    [0.00175, 0.0210],
    [0.03216, 0.0840],
    [0.05364, 0.2110],
    [0.15609, 0.3107],
    [0.39773, 0.5066],
    [0.50201, 0.6577],
    [0.57011, 0.7769],
    [0.90536, 0.8187],
    [0.99716, 0.8636],
    [0.99816, 0.9206],
    [0.99872, 0.9587],
    [0.99886, 0.9702],
    [0.99893, 0.9776],
    [0.99898, 0.9850],
    [0.99901, 0.9918],
    [0.99912, 0.9947],
    [0.99938, 0.9997],
];

/// The same with the laser: `rpl experiment calibration --robot b21-laser --seed 5001 --runs 60`.
const CALIBRATED_LASER: [[f64; 2]; 17] = [
    [0.05493, 0.0323],
    [0.06941, 0.0545],
    [0.09853, 0.1246],
    [0.12599, 0.2723],
    [0.42479, 0.4979],
    [0.73618, 0.6198],
    [0.83135, 0.7076],
    [0.97110, 0.7934],
    [0.99768, 0.8804],
    [0.99854, 0.9238],
    [0.99875, 0.9585],
    [0.99879, 0.9726],
    [0.99884, 0.9788],
    [0.99896, 0.9840],
    [0.99909, 0.9897],
    [0.99917, 0.9932],
    [0.99937, 1.0000],
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
            odometry: OdometryError::default(),
            mixing: 5e-4,
            watch: Some(Watch::default()),
            calibration: Some(Calibration::new(calibrated)),
            activity_threshold: 0.003,
            update_distance_m: 0.15,
            update_angle_rad: 10f64.to_radians(),
            standing_observations: 20,
            standing_updates: 5,
        }
    }

    /// The equations as printed: every scan counts in full, at every step, and nothing is mixed in.
    pub fn literal(self) -> Self {
        let in_full = |sensor| ScanParameters { tempering: 1.0, gating: None, ..sensor };
        Self {
            sensors: self.sensors.into_iter().map(in_full).collect(),
            mixing: 0.0,
            watch: None,
            calibration: None,
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
        ];
        ranges.extend(self.sensors.iter().flat_map(ScanParameters::ranges));
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
            ..self.clone()
        })
    }

    /// For recorded drives with a laser range finder, whose scans have these beams: rays and no cones, a
    /// finer grid, and odometry as in recorded drives; sensor and odometry are what a fit to such drives
    /// gives, rounded.
    ///
    /// # Deviation
    /// As for the sonars, but nothing watches: a recorded drive is not disturbed. The certainty is the
    /// share of the belief; there are too few drives to calibrate it.
    pub fn recorded(beams_deg: Vec<i32>) -> Self {
        Self {
            cell_m: 0.1,
            clearance_m: 0.0,
            sensors: vec![ScanParameters {
                source: RangeSensor::Laser,
                beams_deg,
                beam: BeamParameters::laser(),
                tempering: 0.2,
                gating: None,
                watch_sigma_m: 0.2,
                watch_tempering: 0.2,
            }],
            odometry: OdometryError {
                forward_m: 0.14,
                sideward_m: 0.09,
                turn_per_metre_rad: 4.2f64.to_radians(),
                turn_per_radian_rad: 6.5f64.to_radians(),
            },
            mixing: 1e-4,
            watch: None,
            calibration: None,
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

/// A sensor that measures distances along several beams at a time, and how its scans are taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScanParameters {
    /// Whose readings they are.
    pub source: RangeSensor,
    /// Bearings of the beams of one scan, from straight ahead to the left, in whole degrees.
    pub beams_deg: Vec<i32>,
    /// The model of one beam.
    pub beam: BeamParameters,
    /// Exponent of a scan's likelihood; 1 takes the beams as independent.
    pub tempering: f64,
    /// Readings to leave out; none leaves out none.
    pub gating: Option<Gating>,
    /// Standard deviation of the Gaussian where the coarse belief reads it: it must cover half a coarse
    /// cell.
    pub watch_sigma_m: f64,
    /// Exponent of a scan's likelihood in the coarse belief.
    pub watch_tempering: f64,
}

impl Default for ScanParameters {
    /// The sonars of the papers' robot.
    fn default() -> Self {
        Self::of(&RobotDescription::papers()).swap_remove(0)
    }
}

/// Readings of a laser that the filter is given, about.
const LASER_BEAMS: usize = 30;

impl ScanParameters {
    /// How the sensors of a robot are read: its laser, then its sonars.
    pub fn of(robot: &RobotDescription) -> Vec<Self> {
        let laser = robot.laser.map(|laser| Self::laser(&laser.scanner));
        laser.into_iter().chain(robot.sonar.as_ref().map(Self::sonars)).collect()
    }

    /// Sonars: each is a beam.
    pub fn sonars(sonar: &Sonar) -> Self {
        let bearing_deg = |mount: &SonarMount| libm::round(mount.heading_rad.to_degrees()) as i32;
        let beams_deg: Vec<i32> = sonar.layout.mounts().iter().map(bearing_deg).collect();
        Self {
            source: RangeSensor::Sonar,
            gating: Some(Gating::of_beams(beams_deg.len())),
            beams_deg,
            beam: BeamParameters::sonar(sonar),
            tempering: 0.15,
            watch_sigma_m: 0.2,
            watch_tempering: 0.2,
        }
    }

    /// A laser range finder in a mission: some [`LASER_BEAMS`] of its readings, evenly spread.
    pub fn laser(laser: &LaserScanner) -> Self {
        let bearing_deg = |reading: usize| libm::round(laser.direction_rad(reading).to_degrees()) as i32;
        let stride = (laser.readings / LASER_BEAMS).max(1);
        let beams_deg: Vec<i32> = (0..laser.readings).step_by(stride).map(bearing_deg).collect();
        Self {
            source: RangeSensor::Laser,
            gating: Some(Gating::of_beams(beams_deg.len())),
            beams_deg,
            beam: BeamParameters { max_range_m: laser.range_m, ..MISSION_RAY },
            // Rays side by side meet the same wall, and what is missing in the map.
            tempering: 0.08,
            watch_sigma_m: 0.2,
            watch_tempering: 0.2,
        }
    }

    /// Whether no neighbouring beams are a quarter of a turn apart or more.
    pub fn looks_around(&self) -> bool {
        let mut beams_deg: Vec<i32> = self.beams_deg.iter().map(|bearing| bearing.rem_euclid(360)).collect();
        beams_deg.sort_unstable();
        beams_deg.extend(beams_deg.first().map(|first| first + 360));
        beams_deg.windows(2).all(|pair| pair[1] - pair[0] < 90)
    }

    /// As the coarse belief reads it.
    fn of_watch(&self) -> Self {
        Self {
            beam: BeamParameters { sigma_m: self.watch_sigma_m, ..self.beam.clone() },
            tempering: self.watch_tempering,
            ..self.clone()
        }
    }

    /// Each number with its name, and the least and the most it may be.
    fn ranges(&self) -> Vec<(&'static str, f64, f64, f64)> {
        let beam = &self.beam;
        let mut ranges = vec![
            ("sensors.beam.max_range_m", beam.max_range_m, 0.1, 1000.0),
            ("sensors.beam.mount_radius_m", beam.mount_radius_m, 0.0, 10.0),
            ("sensors.beam.cone_deg", f64::from(beam.cone_deg), 0.0, 180.0),
            ("sensors.beam.wall_depth_m", beam.wall_depth_m, -10.0, 10.0),
            ("sensors.beam.sigma_m", beam.sigma_m, 1e-4, 100.0),
            ("sensors.beam.sigma_per_m", beam.sigma_per_m, 0.0, 10.0),
            ("sensors.beam.hit", beam.hit, 0.0, 1.0),
            ("sensors.beam.uniform", beam.uniform, 1e-6, 1.0),
            ("sensors.beam.short", beam.short, 0.0, 1.0),
            ("sensors.beam.short_mean_m", beam.short_mean_m, 1e-3, 1000.0),
            ("sensors.beam.missed", beam.missed, 1e-6, 1.0),
            ("sensors.tempering", self.tempering, 1e-6, 1.0),
            ("sensors.watch_sigma_m", self.watch_sigma_m, 1e-4, 100.0),
            ("sensors.watch_tempering", self.watch_tempering, 1e-6, 1.0),
        ];
        if let Some(gating) = &self.gating {
            ranges.push(("sensors.gating.margin_m", gating.margin_m, 0.0, 1000.0));
            ranges.push(("sensors.gating.min_certainty", gating.min_certainty, 0.0, 1.0));
        }
        ranges
    }
}

/// P(s | o) of one beam, a sonar's cone or a laser's ray: a mixture of a Gaussian around the expected
/// distance, a uniform and a geometric density (Fox, Burgard, Thrun §3.2), and the echo that never
/// comes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BeamParameters {
    /// Readings at or beyond this are "no echo".
    pub max_range_m: f64,
    /// Readings are measured from this far in front of the robot's middle.
    pub mount_radius_m: f64,
    /// Full opening angle of the cone; the nearest surface in it is expected.
    pub cone_deg: u32,
    /// Readings are on average longer by this than the way to the first occupied cell: in a map made
    /// of scans, cells before the surface are occupied as well.
    pub wall_depth_m: f64,
    /// Standard deviation of the Gaussian, which must cover half a belief cell.
    pub sigma_m: f64,
    /// What the standard deviation grows by per metre of distance.
    pub sigma_per_m: f64,
    /// Weight of the Gaussian.
    pub hit: f64,
    /// Weight of the uniform density.
    pub uniform: f64,
    /// Weight of the geometric density: something unmapped stands before the expected surface.
    pub short: f64,
    /// Mean distance of what is unmapped.
    pub short_mean_m: f64,
    /// Weight of "no echo": the surface turned the sound away.
    pub missed: f64,
    /// Whether what the Gaussian puts beyond the range counts as "no echo"; else a surface within the
    /// range is taken for one that is never beyond it.
    pub fades: bool,
}

impl Default for BeamParameters {
    /// A sonar of the papers' robot.
    fn default() -> Self {
        ScanParameters::default().beam
    }
}

impl BeamParameters {
    /// The beam of a sonar: range and opening are its own, the rest is fitted to the papers' robot; of its
    /// errors the map and the cells make the most.
    pub fn sonar(sonar: &Sonar) -> Self {
        let ahead_m = sonar.layout.mounts().iter().map(SonarMount::ahead_m).fold(0.0, f64::max);
        Self {
            max_range_m: sonar.range_m + ahead_m,
            mount_radius_m: 0.0,
            cone_deg: libm::round(sonar.cone_rad.to_degrees()) as u32,
            wall_depth_m: 0.0,
            sigma_m: 0.12,
            sigma_per_m: 0.02,
            hit: 0.55,
            uniform: 0.08,
            short: 0.12,
            short_mean_m: 2.0,
            missed: 0.25,
            fades: false,
        }
    }

    /// The beam of a laser range finder.
    pub fn laser() -> Self {
        Self {
            max_range_m: 12.0,
            mount_radius_m: 0.0,
            cone_deg: 0,
            wall_depth_m: 0.08,
            sigma_m: 0.077,
            sigma_per_m: 0.0045,
            hit: 0.78,
            uniform: 0.19,
            short: 0.002,
            short_mean_m: 1.4,
            missed: 0.03,
            fades: false,
        }
    }

    /// Weights of the Gaussian, the uniform, the geometric density and "no echo".
    pub fn weights(&self) -> [f64; 4] {
        [self.hit, self.uniform, self.short, self.missed]
    }
}

/// What half a belief cell and half an angle step add to a laser's errors where missions drive.
const MISSION_RAY: BeamParameters = BeamParameters {
    max_range_m: 8.0,
    mount_radius_m: 0.0,
    cone_deg: 0,
    wall_depth_m: 0.0,
    sigma_m: 0.08,
    sigma_per_m: 0.02,
    hit: 0.75,
    uniform: 0.1,
    short: 0.1,
    short_mean_m: 2.0,
    missed: 0.05,
    fades: true,
};

/// How far odometry strays: variances grow in proportion to the way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OdometryError {
    /// Standard deviation along the heading after one metre.
    pub forward_m: f64,
    /// Standard deviation across the heading after one metre.
    pub sideward_m: f64,
    /// Standard deviation of the heading after one metre.
    pub turn_per_metre_rad: f64,
    /// Standard deviation of the heading after turning by one radian.
    pub turn_per_radian_rad: f64,
}

impl Default for OdometryError {
    fn default() -> Self {
        Self {
            forward_m: 0.06,
            sideward_m: 0.03,
            turn_per_metre_rad: 1.5f64.to_radians(),
            turn_per_radian_rad: 3f64.to_radians(),
        }
    }
}

/// Which readings to leave out: those clearly shorter than the estimated pose explains, as long as
/// they are few. Many short readings speak against the pose and not for furniture – unless the others
/// fit it: then people stand around. What stands before a wall never makes a reading longer, and a
/// wrong pose explains little: among twenty people, with the pose right, 93 % of the scans with more
/// than eight short readings pass as a crowd; with the pose wrong, one in 34.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Gating {
    /// By how much a reading must fall short.
    pub margin_m: f64,
    /// More short readings than this are all kept, unless it is a crowd.
    pub max_readings: usize,
    /// In a crowd at least so many readings are as long as expected, to the margin ...
    pub crowd_fitting: usize,
    /// ... and at most so many echoes come from farther.
    pub crowd_farther: usize,
    /// Below this certainty nothing is left out.
    pub min_certainty: f64,
}

impl Default for Gating {
    fn default() -> Self {
        Self { margin_m: 0.4, max_readings: 8, crowd_fitting: 6, crowd_farther: 2, min_certainty: 0.5 }
    }
}

/// Beams that the counts of [`Gating::default`] are for.
const GATED_BEAMS: usize = 24;

impl Gating {
    /// For scans of so many beams: the same shares of them.
    pub fn of_beams(beams: usize) -> Self {
        let usual = Self::default();
        let of_these = |count: usize| (count * beams + GATED_BEAMS / 2) / GATED_BEAMS;
        Self {
            max_readings: of_these(usual.max_readings),
            crowd_fitting: of_these(usual.crowd_fitting),
            crowd_farther: of_these(usual.crowd_farther),
            ..usual
        }
    }

    /// Whether the readings that are not short tell of people around a robot whose pose is right.
    pub(super) fn is_crowd(&self, fitting: usize, farther: usize) -> bool {
        fitting >= self.crowd_fitting && farther <= self.crowd_farther
    }
}

/// A second belief over the whole map on a coarse grid, in which nothing sleeps.
///
/// # Deviation
/// Selective computation treats whatever it does not look at as average. A wrong pose that explains
/// the scans better than the average one, as any pose in a long corridor does, is then never given
/// up, and of two mirror poses the one whose heading is being updated gains on the other. On a grid
/// of a twelfth of the states the equations are computed in full at every update. Its probability
/// of the estimated pose bounds the certainty; when it falls short of what the fine belief says,
/// the fine belief is made anew from the coarse one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
        Self { cell_m: 0.3, angle_step_deg: 6, mixing: 5e-4, near_m: 1.2, near_rad: 40f64.to_radians(), agreement: 0.5 }
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
