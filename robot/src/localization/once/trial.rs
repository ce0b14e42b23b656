//! Scans to try a [`ScanLocator`](super::ScanLocator) with: from anywhere in a map, among people who stand around.

use super::answer::Located;
use super::scan::RangeBeam;
use crate::geometry::{Point, Pose, distance_m, wrap_angle_rad};
use crate::localization::ScanParameters;
use crate::occupancy::{Cell, DistanceField, OccupancyGrid};
use crate::sensors::LaserScanner;
use crate::world::Rect;
use rpl_random::Stream;
use serde::{Deserialize, Serialize};

/// A pose is right within these.
pub const RIGHT_M: f64 = 0.5;
/// The same for its heading.
pub const RIGHT_RAD: f64 = 15.0 / 180.0 * std::f64::consts::PI;

/// Radius of a person, and how far one stands off.
const PERSON_M: f64 = 0.25;
const PERSON_OFF_M: [f64; 2] = [0.6, 3.0];

/// After this many who would stand in something nobody else comes.
const MOST_PEOPLE: usize = 400;

/// A sensor that scans.
#[derive(Clone, Debug)]
pub struct TrialSensor {
    /// Where its beams look, from straight ahead to the left.
    pub bearings_rad: Vec<f64>,
    /// Full opening of a beam; 0 for a ray.
    pub cone_deg: u32,
    /// What is farther is not measured.
    pub max_range_m: f64,
    /// Standard deviation of a reading.
    pub noise_m: f64,
}

impl TrialSensor {
    /// All readings of a laser.
    pub fn laser(laser: &LaserScanner) -> Self {
        let bearings_rad = (0..laser.readings).map(|reading| laser.direction_rad(reading)).collect();
        Self { bearings_rad, cone_deg: 0, max_range_m: laser.range_m, noise_m: 0.02 }
    }

    /// The beams of a sonar.
    pub fn sonar(sonar: &ScanParameters) -> Self {
        let bearings_rad = sonar.beams_deg.iter().map(|&bearing| f64::from(bearing).to_radians()).collect();
        let (cone_deg, max_range_m) = (sonar.beam.cone_deg, sonar.beam.max_range_m);
        Self { bearings_rad, cone_deg, max_range_m, noise_m: 0.03 }
    }
}

/// A scan and where it was taken.
#[derive(Clone, Debug)]
pub struct TrialScan {
    /// Where.
    pub robot_in_map: Pose,
    /// What was measured.
    pub beams: Vec<RangeBeam>,
}

/// Where scans are taken.
#[derive(Debug)]
pub struct TrialGround {
    map: OccupancyGrid,
    distances: DistanceField,
    bounds: Rect,
    clearance_m: f64,
}

impl TrialGround {
    /// On the free cells of a map, so far from everything.
    pub fn new(map: OccupancyGrid, clearance_m: f64) -> Self {
        let (origin, edge_m) = (map.origin_in_frame, map.resolution_m);
        let end = Point::new(origin.x + map.columns as f64 * edge_m, origin.y + map.rows as f64 * edge_m);
        Self { distances: DistanceField::new(&map), bounds: Rect { min: origin, max: end }, map, clearance_m }
    }

    /// The area that can be stood in.
    pub fn area_m2(&self) -> f64 {
        let cells = (0..self.map.cells.len()).map(|at| self.map.centre(at % self.map.columns, at / self.map.columns));
        cells.filter(|&cell| self.is_free(cell, self.clearance_m)).count() as f64
            * self.map.resolution_m
            * self.map.resolution_m
    }

    fn is_free(&self, point: Point, clearance_m: f64) -> bool {
        self.map.at(point) == Cell::Free && self.distances.clearance_m(point) >= clearance_m
    }

    /// A scan from a random pose, of which at least a share of the beams end at people.
    pub fn draw(&self, sensor: &TrialSensor, share: f64, stream: &mut Stream) -> TrialScan {
        let Rect { min, max } = self.bounds;
        let robot_in_map = loop {
            let point = Point::new(stream.uniform_in(min.x, max.x), stream.uniform_in(min.y, max.y));
            if self.is_free(point, self.clearance_m) {
                break Pose::new(point.x, point.y, stream.uniform_in(-3.2, 3.2));
            }
        };
        let mut ranges_m: Vec<f64> =
            sensor.bearings_rad.iter().map(|&bearing_rad| self.range_m(sensor, robot_in_map, bearing_rad)).collect();
        self.add_people(sensor, robot_in_map, share, &mut ranges_m, stream);
        let beam = |(&bearing_rad, range_m): (&f64, f64)| {
            let range_m = range_m + sensor.noise_m * stream.normal();
            RangeBeam { bearing_rad, range_m: range_m.clamp(0.0, sensor.max_range_m) }
        };
        let beams = sensor.bearings_rad.iter().zip(ranges_m).map(beam).collect();
        TrialScan { robot_in_map, beams }
    }

    fn range_m(&self, sensor: &TrialSensor, from: Pose, bearing_rad: f64) -> f64 {
        let half = i64::from(sensor.cone_deg / 2);
        let rays = (-half..=half).map(|off_deg| from.heading_rad + bearing_rad + (off_deg as f64).to_radians());
        rays.fold(sensor.max_range_m + 1.0, |nearest_m, direction_rad| {
            let (sin, cos) = libm::sincos(direction_rad);
            f64::min(nearest_m, self.distances.surface_m(from.point(), (cos, sin), nearest_m))
        })
    }

    fn add_people(&self, sensor: &TrialSensor, robot: Pose, share: f64, ranges_m: &mut [f64], stream: &mut Stream) {
        let mut is_short = vec![false; ranges_m.len()];
        for _ in 0..MOST_PEOPLE {
            if is_short.iter().filter(|&&is_short| is_short).count() as f64 >= share * ranges_m.len() as f64 {
                break;
            }
            let (direction_rad, off_m) =
                (stream.uniform_in(-3.2, 3.2), stream.uniform_in(PERSON_OFF_M[0], PERSON_OFF_M[1]));
            let (sin, cos) = libm::sincos(robot.heading_rad + direction_rad);
            let person = Point::new(robot.x_m + cos * off_m, robot.y_m + sin * off_m);
            let is_in_sight = self.distances.surface_m(robot.point(), (cos, sin), off_m) >= off_m;
            if !is_in_sight || !self.is_free(person, PERSON_M) {
                continue;
            }
            let half_rad = libm::asin(PERSON_M / distance_m(robot.point(), person));
            let widened_rad = half_rad + f64::from(sensor.cone_deg).to_radians() / 2.0;
            for ((range_m, is_short), bearing_rad) in ranges_m.iter_mut().zip(&mut is_short).zip(&sensor.bearings_rad) {
                let aside_rad = libm::fabs(wrap_angle_rad(bearing_rad - direction_rad));
                if aside_rad > widened_rad {
                    continue;
                }
                let (sin, cos) = libm::sincos(if sensor.cone_deg == 0 { aside_rad } else { 0.0 });
                let to_m = off_m * cos - libm::sqrt(f64::max(0.0, PERSON_M * PERSON_M - off_m * off_m * sin * sin));
                if to_m < *range_m {
                    (*range_m, *is_short) = (to_m, true);
                }
            }
        }
    }
}

/// What an answer was worth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// The probability of the likeliest pose, and whether it was right.
    pub probability: f64,
    /// The same.
    pub is_right: bool,
    /// Whether the right pose is among those named.
    pub is_named: bool,
    /// How many are named.
    pub poses: usize,
    /// Of the right pose, by the answer.
    pub of_right: f64,
    /// That it is elsewhere, by the answer.
    pub elsewhere: f64,
    /// That no place explains the scan, by the answer.
    pub nowhere: f64,
}

impl Verdict {
    /// Beside the truth.
    pub fn of(located: &Located, truth: Pose) -> Self {
        let is_right = |pose: Pose| {
            let off_rad = libm::fabs(wrap_angle_rad(pose.heading_rad - truth.heading_rad));
            pose.distance_m(truth) <= RIGHT_M && off_rad <= RIGHT_RAD
        };
        let first = located.poses.first();
        let right: Vec<f64> = (located.poses.iter().filter(|likely| is_right(likely.pose_in_map)))
            .map(|likely| likely.probability)
            .collect();
        Self {
            probability: first.map_or(0.0, |likely| likely.probability),
            is_right: first.is_some_and(|likely| is_right(likely.pose_in_map)),
            is_named: !right.is_empty(),
            poses: located.poses.len(),
            of_right: right.iter().sum(),
            elsewhere: located.elsewhere,
            nowhere: located.nowhere,
        }
    }
}
