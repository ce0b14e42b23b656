//! The parameters of the sensor model and of the odometry, estimated from a recording whose poses
//! are known.

use super::beams::BeamChoice;
use super::drive::Recording;
use crate::geometry::{Pose, wrap_angle_rad};
use crate::localization::{BINS, BeamParameters, LocalizationModel, NO_ECHO, OdometryError, ScanModel, components};

/// Readings that a fit needs at least.
const FEWEST_READINGS: u64 = 200;

/// Motions that a fit needs at least.
const FEWEST_MOTIONS: usize = 20;

/// A shorter motion says nothing about an error per metre.
const MOTION_M: f64 = 0.05;

const ITERATIONS: usize = 60;

/// No weight of the mixture becomes smaller: what a recording does not show may still happen.
const SMALLEST_WEIGHT: f64 = 0.002;

/// Why nothing can be estimated.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FitError {
    /// Too few scans were taken where the map is free.
    #[error(
        "{0} readings at poses on the map's free space are too few to fit a sensor to, {FEWEST_READINGS} are needed"
    )]
    Readings(u64),
    /// Too few motions.
    #[error("{0} motions are too few to fit the odometry to, {FEWEST_MOTIONS} are needed")]
    Motions(usize),
}

/// The sensor of a recorded drive: its first, and usually its only one.
fn laser(model: &LocalizationModel) -> &ScanModel {
    &model.sensors[0]
}

/// How often a bin was measured where another one was expected, `[expected][measured]`.
struct Pairs(Vec<[u64; BINS]>);

impl Pairs {
    fn of(model: &LocalizationModel, recording: &Recording, beams: &BeamChoice) -> Self {
        let sensor = laser(model);
        let mut pairs = vec![[0; BINS]; BINS];
        for scan in &recording.scans {
            let Some(state) = model.state_at(scan.laser_in_map) else { continue };
            if !model.is_admissible(state.column, state.row) {
                continue;
            }
            for (expected, range_m) in model.expected_scan(0, state).into_iter().zip(beams.ranges_m(scan)) {
                pairs[usize::from(expected)][usize::from(sensor.likelihood.bin(f64::from(range_m)))] += 1;
            }
        }
        Self(pairs)
    }

    fn count(&self) -> u64 {
        self.0.iter().flatten().sum()
    }

    /// Pairs that occur: expected bin, measured bin, how often.
    fn each(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        self.0.iter().enumerate().flat_map(|(expected, row)| {
            let seen = row.iter().enumerate().filter(|(_, count)| **count > 0);
            seen.map(move |(measured, &count)| (expected, measured, count as f64))
        })
    }
}

/// The mixture that explains a recording's readings best, by expectation and maximization (Thrun,
/// Burgard, Fox, *Probabilistic Robotics*, §6.3.2). Compares with the table of the model, so that
/// the deviation covers what a cell's size adds. Cost: iterations times pairs of bins.
///
/// # Deviation
/// The mean of the Gaussian lies behind the edge of the first occupied cell by a depth that is
/// fitted too. The standard deviation grows with the distance: a line through the absolute residuals, each
/// weighted by how probably it belongs to the Gaussian, and scaled by √(π/2), takes the place of the
/// one variance in the book.
///
/// # Errors
/// Too few readings at poses where the map is free.
pub fn fit_sensor(
    model: &LocalizationModel,
    recording: &Recording,
    beams: &BeamChoice,
) -> Result<BeamParameters, FitError> {
    let pairs = Pairs::of(model, recording, beams);
    if pairs.count() < FEWEST_READINGS {
        return Err(FitError::Readings(pairs.count()));
    }
    let start = laser(model).parameters.beam.clone();
    Ok((0..ITERATIONS).fold(start, |parameters, _| improved(&parameters, &pairs)))
}

/// One round of expectation and maximization.
fn improved(parameters: &BeamParameters, pairs: &Pairs) -> BeamParameters {
    let width_m = parameters.max_range_m / 255.0;
    let centre_m = |bin: usize| (bin as f64 + 0.5) * width_m;
    let densities: Vec<[Vec<f64>; 4]> = (0..BINS).map(|expected| components(parameters, expected)).collect();
    let weights = parameters.weights();
    let mut masses = [0.0; 4];
    let mut line = FittedLine::default();
    let mut short_sum_m = 0.0;
    let mut away_sum_m = 0.0;
    let mut away_weight = 0.0;
    for (expected, measured, count) in pairs.each() {
        let parts: [f64; 4] = std::array::from_fn(|part| weights[part] * densities[expected][part][measured]);
        let total: f64 = parts.iter().sum();
        if total <= 0.0 {
            continue;
        }
        let shares = parts.map(|part| count * part / total);
        masses.iter_mut().zip(shares).for_each(|(mass, share)| *mass += share);
        if expected != usize::from(NO_ECHO) {
            let away_m = centre_m(measured) - centre_m(expected);
            away_sum_m += shares[0] * away_m;
            away_weight += shares[0];
            let off_m = libm::fabs(away_m - parameters.wall_depth_m);
            line.add(centre_m(expected), off_m * libm::sqrt(std::f64::consts::FRAC_PI_2), shares[0]);
        }
        short_sum_m += shares[2] * centre_m(measured);
    }
    let total: f64 = masses.iter().sum();
    let [hit, uniform, short, missed] = masses.map(|mass| (mass / total).max(SMALLEST_WEIGHT));
    let (sigma_m, sigma_per_m) = line.fitted();
    BeamParameters {
        wall_depth_m: if away_weight > 0.0 { away_sum_m / away_weight } else { parameters.wall_depth_m },
        sigma_m: sigma_m.max(width_m / 2.0),
        sigma_per_m,
        hit,
        uniform,
        short,
        short_mean_m: if masses[2] > 0.0 { (short_sum_m / masses[2]).max(width_m) } else { parameters.short_mean_m },
        missed,
        ..parameters.clone()
    }
}

/// A weighted line through points, `y = a + b · x` with `a, b ≥ 0`.
#[derive(Default)]
struct FittedLine {
    weight: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
}

impl FittedLine {
    fn add(&mut self, x: f64, y: f64, weight: f64) {
        self.weight += weight;
        self.x += weight * x;
        self.y += weight * y;
        self.xx += weight * x * x;
        self.xy += weight * x * y;
    }

    fn fitted(&self) -> (f64, f64) {
        let determinant = self.weight * self.xx - self.x * self.x;
        let slope = (self.weight * self.xy - self.x * self.y) / determinant;
        if self.weight <= 0.0 || !slope.is_finite() || slope < 0.0 {
            return (if self.weight > 0.0 { self.y / self.weight } else { 0.0 }, 0.0);
        }
        let level = (self.y - slope * self.x) / self.weight;
        if level < 0.0 { (0.0, self.xy / self.xx) } else { (level, slope) }
    }
}

/// The errors of the odometry between successive scans: their mean squares per metre, and for the
/// heading per metre and per radian.
///
/// # Errors
/// Too few motions.
pub fn fit_odometry(recording: &Recording) -> Result<OdometryError, FitError> {
    let steps = recording.scans.windows(2).map(|pair| {
        let moved = pair[1].laser_in_odom.relative_to(pair[0].laser_in_odom);
        (moved, pair[1].laser_in_map.relative_to(pair[0].laser_in_map))
    });
    let steps: Vec<(Pose, Pose)> = steps.filter(|(moved, _)| libm::hypot(moved.x_m, moved.y_m) >= MOTION_M).collect();
    if steps.len() < FEWEST_MOTIONS {
        return Err(FitError::Motions(steps.len()));
    }
    let per_metre = |error: &dyn Fn(&Pose, &Pose) -> f64| {
        let square = |(moved, truly): &(Pose, Pose)| {
            let error = error(moved, truly);
            error * error / libm::hypot(moved.x_m, moved.y_m)
        };
        libm::sqrt(steps.iter().map(square).sum::<f64>() / steps.len() as f64)
    };
    // The variance of the heading over the way is a line over the turn per way.
    let mut line = FittedLine::default();
    for (moved, truly) in &steps {
        let way_m = libm::hypot(moved.x_m, moved.y_m);
        let error_rad = wrap_angle_rad(truly.heading_rad - moved.heading_rad);
        line.add(libm::fabs(moved.heading_rad) / way_m, error_rad * error_rad / way_m, way_m);
    }
    let (per_metre_rad2, per_radian_rad2) = line.fitted();
    Ok(OdometryError {
        forward_m: per_metre(&|moved, truly| truly.x_m - moved.x_m),
        sideward_m: per_metre(&|moved, truly| truly.y_m - moved.y_m),
        turn_per_metre_rad: libm::sqrt(per_metre_rad2),
        turn_per_radian_rad: libm::sqrt(per_radian_rad2),
        position_per_radian_m: 0.0,
    })
}
