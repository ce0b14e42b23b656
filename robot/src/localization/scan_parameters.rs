//! What can be set about a range sensor: where its beams look, what they measure, and how a scan is taken.

use crate::description::{RobotDescription, Sonar};
use crate::sensors::{LaserScanner, RangeSensor, SonarMount};
use serde::{Deserialize, Serialize};

/// A sensor that measures distances along several beams at a time, and how its scans are taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScanParameters {
    /// Whose readings they are.
    pub source: RangeSensor,
    /// Bearings of the beams of one scan, from straight ahead to the left, in whole degrees.
    pub beams_deg: Vec<i32>,
    /// The model of one beam.
    pub beam: BeamParameters,
    /// Exponent of a scan's likelihood; 1 takes the beams as independent.
    pub tempering: f64,
    /// How the errors of a scan go on in the next one, which then counts for less; with none each scan counts alike.
    #[serde(default)]
    pub correlation: Option<ErrorCorrelation>,
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
            gating: Some(Gating::Short(ShortReadings::of_beams(beams_deg.len()))),
            beams_deg,
            beam: BeamParameters::sonar(sonar),
            tempering: 0.15,
            correlation: None,
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
            gating: Some(Gating::Short(ShortReadings::of_beams(beams_deg.len()))),
            beams_deg,
            beam: BeamParameters { max_range_m: laser.range_m, ..MISSION_RAY },
            // Rays side by side meet the same wall, and what is missing in the map.
            tempering: 0.08,
            correlation: None,
            // Far along a corridor rays meet its walls at small angles, and the coarse headings are 6° apart:
            // a narrower Gaussian gives up right poses there.
            watch_sigma_m: 0.35,
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

    /// The model of one beam where people stand around.
    pub(super) fn crowd_beam(&self) -> Option<BeamParameters> {
        match &self.gating {
            Some(Gating::Short(short)) => Some(BeamParameters { short: short.crowd_short, ..self.beam.clone() }),
            Some(Gating::Entropy | Gating::Novelty { .. }) | None => None,
        }
    }

    /// As the coarse belief reads it.
    pub(super) fn of_watch(&self) -> Self {
        Self {
            beam: BeamParameters { sigma_m: self.watch_sigma_m, ..self.beam.clone() },
            tempering: self.watch_tempering,
            ..self.clone()
        }
    }

    /// Each number with its name, and the least and the most it may be.
    pub(super) fn ranges(&self) -> Vec<(&'static str, f64, f64, f64)> {
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
        if let Some(correlation) = &self.correlation {
            ranges.extend([
                ("sensors.correlation.in_place", correlation.in_place, 0.0, 1.0),
                ("sensors.correlation.length_m", correlation.length_m, 1e-3, 1000.0),
            ]);
        }
        match &self.gating {
            Some(Gating::Short(short)) => ranges.extend([
                ("sensors.gating.short.margin_m", short.margin_m, 0.0, 1000.0),
                ("sensors.gating.short.crowd_margin_m", short.crowd_margin_m, 0.0, 1000.0),
                ("sensors.gating.short.crowd_short", short.crowd_short, 0.0, 10.0),
                ("sensors.gating.short.min_certainty", short.min_certainty, 0.0, 1.0),
            ]),
            Some(Gating::Novelty { most_probable }) => {
                ranges.push(("sensors.gating.novelty.most_probable", *most_probable, 0.0, 1.0));
            }
            Some(Gating::Entropy) | None => {}
        }
        ranges
    }
}

/// How alike the errors of two scans are: what the map lacks near a place, and a wall drawn beside where it is, mislead
/// all scans from there. The correlation falls off exponentially with the way between the scans.
///
/// # Deviation
/// The papers take all scans as independent. With one exponent for all of them, as low as scans side by side need it, a
/// robot that has heard its first scan is far less certain than it is right, because no scan was before that one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ErrorCorrelation {
    /// Correlation of the errors of two scans from one place; not 1, because some errors are those of the scan alone.
    pub in_place: f64,
    /// After this way it is lower by a factor of e.
    pub length_m: f64,
}

impl ErrorCorrelation {
    /// What a scan tells beyond the last one, so far away, as a share of what it would tell alone: (1 − ρ) / (1 + ρ).
    /// n observations with errors that are a first-order autoregressive process are worth 1 + (n − 1)(1 − ρ) / (1 + ρ)
    /// independent ones, 1ᵀR⁻¹1 for the matrix R of their correlations (on such numbers Bayley and Hammersley, "The
    /// 'effective' number of independent observations in an autocorrelated time series", 1946).
    pub(super) fn beyond_last(&self, way_m: f64) -> f64 {
        let correlation = self.in_place * libm::exp(-way_m / self.length_m);
        (1.0 - correlation) / (1.0 + correlation)
    }
}

/// P(s | o) of one beam, a sonar's cone or a laser's ray: a mixture of a Gaussian around the expected
/// distance, a uniform and a geometric density (Fox, Burgard, Thrun §3.2), and the echo that never
/// comes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
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

/// Which readings of a scan to leave out: what they measured may be in no map, people and furniture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Gating {
    /// Those clearly shorter than the estimated pose explains.
    Short(ShortReadings),
    /// Those that alone would raise the entropy of the belief: the entropy filter of Fox, Burgard, Thrun, Cremers,
    /// "Position Estimation for Mobile Robots in Dynamic Environments", 1998.
    Entropy,
    /// Those that are shorter than what the map shows, with more than a probability over the whole belief: the novelty
    /// filter there.
    Novelty {
        /// That probability; 0.99 in the paper.
        most_probable: f64,
    },
}

/// Readings clearly shorter than the estimated pose explains, which are left out as long as they are few. Many of them
/// are left out where people stand around: where the other readings have fitted the pose from scan to scan, and few
/// echoes have come from farther.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShortReadings {
    /// By how much a reading must fall short.
    pub margin_m: f64,
    /// More short readings than this are all kept, unless it is a crowd.
    pub max_readings: usize,
    /// By how much a reading must fall short in a crowd, where somebody may stand close before a wall.
    pub crowd_margin_m: f64,
    /// A scan of a crowd with fewer readings than this that are not short says nothing.
    pub crowd_least: usize,
    /// Weight of the geometric density in a crowd, beside the weights of [`BeamParameters`]: there the coarse belief
    /// hears the whole scan, so that a pose that explains all of it gains on one where most of it must be people.
    pub crowd_short: f64,
    /// Below this certainty nothing is left out, unless it is a crowd.
    pub min_certainty: f64,
}

impl Default for ShortReadings {
    fn default() -> Self {
        Self {
            margin_m: 0.4,
            max_readings: 8,
            crowd_margin_m: 0.25,
            crowd_least: 6,
            crowd_short: 2.5,
            min_certainty: 0.5,
        }
    }
}

/// Beams that the counts of [`ShortReadings::default`] are for.
const GATED_BEAMS: usize = 24;

impl ShortReadings {
    /// For scans of this number of beams: the same shares of them.
    pub fn of_beams(beams: usize) -> Self {
        let usual = Self::default();
        let of_these = |count: usize| (count * beams + GATED_BEAMS / 2) / GATED_BEAMS;
        Self { max_readings: of_these(usual.max_readings), crowd_least: of_these(usual.crowd_least), ..usual }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sensors(robot: &str) -> Vec<ScanParameters> {
        ScanParameters::of(&RobotDescription::builtin(robot).expect("built in"))
    }

    #[test]
    fn a_robot_has_the_sensors_of_its_description_the_laser_first() {
        let sources = |robot: &str| sensors(robot).iter().map(|sensor| sensor.source).collect::<Vec<_>>();
        assert_eq!(sources("b21"), [RangeSensor::Sonar]);
        assert_eq!(sources("b21-laser"), [RangeSensor::Laser, RangeSensor::Sonar]);
        assert_eq!(sources("turtlebot"), [RangeSensor::Laser]);
        let beams = |robot: &str| sensors(robot).iter().map(|sensor| sensor.beams_deg.len()).collect::<Vec<_>>();
        assert_eq!((beams("b21-laser"), beams("nomad-200"), beams("pioneer-front")), (vec![31, 24], vec![16], vec![8]));
    }

    #[test]
    fn rings_look_around_and_what_looks_ahead_does_not() {
        for (robot, looks_around) in
            [("b21", true), ("b21-laser", false), ("nomad-200", true), ("pioneer-front", false), ("turtlebot", true)]
        {
            assert_eq!(sensors(robot)[0].looks_around(), looks_around, "{robot}");
        }
    }

    #[test]
    fn scans_along_a_way_count_as_much_as_the_inverse_of_their_correlations_says() {
        let correlation = ErrorCorrelation { in_place: 1.0, length_m: 0.7 };
        let places_m: [f64; 6] = [0.0, 0.1, 0.35, 0.9, 1.0, 3.5];
        let between = |row: usize, column: usize| libm::exp(-(places_m[row] - places_m[column]).abs() / 0.7);
        let inverse = nalgebra::SMatrix::<f64, 6, 6>::from_fn(between).try_inverse().expect("it is definite");
        let told: f64 = places_m.windows(2).map(|pair| correlation.beyond_last(pair[1] - pair[0])).sum();
        assert!((1.0 + told - inverse.sum()).abs() < 1e-9, "{told}");
        let partly = ErrorCorrelation { in_place: 0.4, length_m: 0.7 };
        assert!((partly.beyond_last(0.0) - 0.6 / 1.4).abs() < 1e-12);
    }

    #[test]
    fn gating_takes_the_same_share_of_any_number_of_beams() {
        assert_eq!(ShortReadings::of_beams(24), ShortReadings::default());
        let eight = ShortReadings::of_beams(8);
        assert_eq!((eight.max_readings, eight.crowd_least), (3, 2));
    }
}
