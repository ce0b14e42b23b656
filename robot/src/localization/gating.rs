//! Readings that are left out of a scan, because what they measured may be in no map.

use super::belief::Belief;
use super::expected::{Cones, bin_at};
use super::model::LocalizationModel;
use super::scan::ScanModel;
use super::scan_parameters::ShortReadings;
use super::sensor::{BINS, BinnedScan};
use serde::{Deserialize, Serialize};

/// How much likelier a reading that is not short is at the right pose than elsewhere, as a logarithm, if it fits, comes
/// from farther, or is missed: as if of such readings 70, 6 and 24 % were so at the right pose, and 30, 40 and 30 %
/// elsewhere. What stands before a wall never makes a reading longer. Chosen, not fitted.
const LOG_RATIOS: [f64; 3] = [0.85, -1.9, -0.2];

/// The most that readings count for, in nats: thus a robot that was carried elsewhere forgets in a scan or two that its
/// pose was right.
const MOST_SUPPORT: f64 = 1.2;

/// The most that readings count for among people: few readings are not short there, and the sum of some scans can be
/// against the right pose.
const MOST_SUPPORT_IN_CROWD: f64 = 2.4;

/// A scan that speaks against the pose by more than this, in nats, counts in full, however well the scans before it fitted.
const MOST_AGAINST: f64 = 0.3;

/// The same among people: nearly three echoes from farther.
const MOST_AGAINST_IN_CROWD: f64 = 0.8;

/// Once this many scans more have told of people than have not, people stand around, whatever the next scan tells of
/// the pose: nobody is gone from one scan to the next.
const LEAST_CROWD_SCANS: u32 = 5;

/// And no more are counted than this, so that they are known to be gone after some two metres.
const MOST_CROWD_SCANS: u32 = 20;

/// With less of the belief at the mode than this, nothing is left out even in a crowd: less than a relocalization leaves
/// of what was believed, so that a false alarm heals in place.
const LEAST_IN_CROWD: f64 = 0.05;

/// What scan after scan has told of people around the robot.
///
/// Whether they are there is one question, and whether the pose is right another one: a scan that speaks against the pose
/// does not tell that the people are gone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Crowd {
    /// How far the readings that are not short have borne the pose out, in nats, tempered.
    pub support_nats: f64,
    /// Scans that told of people, less those since that did not.
    scans: u32,
}

impl Crowd {
    fn is_around(&self) -> bool {
        self.scans >= LEAST_CROWD_SCANS
    }

    /// Takes in whether a scan tells of people.
    fn count(&mut self, tells: bool) {
        self.scans = if tells { (self.scans + 1).min(MOST_CROWD_SCANS) } else { self.scans.saturating_sub(1) };
    }
}

/// Whose readings a scan has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Company {
    /// Nobody's, or of a few.
    Few,
    /// Those of people around the robot, which were left out, because the other ones bear the pose out.
    LeftOut,
    /// Those of people around the robot, which count like all others, because those do not.
    Counted,
}

impl Company {
    /// Whether people stand around.
    pub(super) fn is_crowd(self) -> bool {
        match self {
            Self::Few => false,
            Self::LeftOut | Self::Counted => true,
        }
    }
}

/// Leaves out readings that are clearly shorter than expected at the estimated pose: while they are few, and where
/// people stand around. Many short readings speak against a pose and not for people, unless the other ones have borne
/// it out, scan by scan (Wald's sequential ratio of likelihoods, bounded): that is its support. `certainty` is the share
/// of the belief at the pose.
pub(super) fn leave_out_short(
    short: &ShortReadings,
    sensor: &ScanModel,
    expected: &[u8],
    ranges_m: &[f32],
    certainty: f64,
    crowd: &mut Crowd,
    scan: &mut BinnedScan,
) -> Company {
    let was_around = crowd.is_around();
    let (most_support, most_against) = match was_around {
        true => (MOST_SUPPORT_IN_CROWD, MOST_AGAINST_IN_CROWD),
        false => (MOST_SUPPORT, MOST_AGAINST),
    };
    let read: Vec<usize> = (0..scan.len()).filter(|&beam| scan[beam].is_some()).collect();
    let beyond_m = |beam: usize| f64::from(ranges_m[beam]) - sensor.likelihood.range_m(expected[beam]);
    let short_by_m = |margin_m: f64| read.iter().copied().filter(move |&beam| beyond_m(beam) < -margin_m);
    let is_echo = |beam: usize| f64::from(ranges_m[beam]) < sensor.parameters.beam.max_range_m;
    let others = read.iter().filter(|&&beam| beyond_m(beam) >= -short.margin_m);
    let ratios = others.map(|&beam| match beyond_m(beam) > short.margin_m {
        false => LOG_RATIOS[0],
        true if is_echo(beam) => LOG_RATIOS[1],
        true => LOG_RATIOS[2],
    });
    let gained = ratios.sum::<f64>() * sensor.parameters.tempering;
    crowd.support_nats = (crowd.support_nats + gained).clamp(-MOST_SUPPORT, most_support);
    let count = short_by_m(short.margin_m).count();
    let is_borne_out = certainty >= LEAST_IN_CROWD && crowd.support_nats > 0.0 && gained > -most_against;
    let tells = count > short.max_readings && is_borne_out;
    crowd.count(tells);
    if tells {
        if read.len() - count < short.crowd_least {
            scan.fill(None);
        }
        short_by_m(short.crowd_margin_m).for_each(|beam| scan[beam] = None);
        return Company::LeftOut;
    }
    if crowd.is_around() {
        return Company::Counted;
    }
    if count <= short.max_readings && certainty >= short.min_certainty {
        short_by_m(short.margin_m).for_each(|beam| scan[beam] = None);
    }
    Company::Few
}

/// Leaves out each reading that alone would raise the entropy of the belief (Fox, Burgard, Thrun, Cremers, "Position
/// Estimation for Mobile Robots in Dynamic Environments", 1998, the entropy filter).
///
/// # Deviation
/// Only cells that are awake count. A reading counts in full here, however much the scan is tempered.
pub(super) fn leave_out_confusing(belief: &Belief, model: &LocalizationModel, sensor: usize, scan: &mut BinnedScan) {
    let likelihood = &model.sensors[sensor].likelihood;
    leave_out(belief, model, sensor, scan, |shares, measured| {
        shares.entropy(|_| 0.0) < shares.entropy(|expected| -likelihood.nats(measured, expected))
    });
}

/// Leaves out each reading that is shorter than what the map shows with more than a probability (the same, the novelty
/// filter: the mean over the belief of what the Gaussian of the beam has beyond the reading).
///
/// # Deviation
/// Only cells that are awake count.
pub(super) fn leave_out_novel(
    most_probable: f64,
    belief: &Belief,
    model: &LocalizationModel,
    sensor: usize,
    scan: &mut BinnedScan,
) {
    let tables = &model.sensors[sensor];
    leave_out(belief, model, sensor, scan, |shares, measured| {
        shares.mean(|expected| tables.beyond(expected, measured)) > most_probable
    });
}

/// Leaves out the readings of which it is so, by what a belief expects of their beams.
fn leave_out(
    belief: &Belief,
    model: &LocalizationModel,
    sensor: usize,
    scan: &mut BinnedScan,
    is_out: impl Fn(&ExpectedShares, u8) -> bool,
) {
    let beams: Vec<usize> = (0..scan.len()).filter(|&beam| scan[beam].is_some()).collect();
    let expected = expected_shares(belief, model, sensor, &beams);
    for (beam, shares) in beams.into_iter().zip(&expected) {
        if scan[beam].is_some_and(|measured| shares.mass() > 0.0 && is_out(shares, measured)) {
            scan[beam] = None;
        }
    }
}

/// What a belief has where one beam is expected to measure a bin, by bin.
#[derive(Clone)]
struct ExpectedShares {
    /// Σ p.
    shares: [f64; BINS],
    /// Σ p ln p.
    logs: [f64; BINS],
}

impl ExpectedShares {
    fn mass(&self) -> f64 {
        self.shares.iter().sum()
    }

    /// The mean of something known for each bin.
    fn mean(&self, of: impl Fn(u8) -> f64) -> f64 {
        let weighed = self.shares.iter().zip(0..=u8::MAX).filter(|(share, _)| **share > 0.0);
        weighed.map(|(share, bin)| share * of(bin)).sum::<f64>() / self.mass()
    }

    /// Entropy in nats, after each state has been multiplied by a weight whose logarithm is known for its bin.
    fn entropy(&self, log_weight: impl Fn(u8) -> f64) -> f64 {
        let (mut mass, mut logs) = (0.0, 0.0);
        for ((share, log), bin) in self.shares.iter().zip(&self.logs).zip(0..=u8::MAX) {
            let log_weight = log_weight(bin);
            let weight = libm::exp(log_weight);
            mass += weight * share;
            logs += weight * (log + log_weight * share);
        }
        libm::log(mass) - logs / mass
    }
}

/// What a belief expects of some beams. O(states that are awake · beams).
fn expected_shares(belief: &Belief, model: &LocalizationModel, sensor: usize, beams: &[usize]) -> Vec<ExpectedShares> {
    let tables = &model.sensors[sensor];
    let mut expected = vec![ExpectedShares { shares: [0.0; BINS], logs: [0.0; BINS] }; beams.len()];
    for (heading, plane) in belief.planes().iter().enumerate() {
        for tile in plane.tiles.iter() {
            let Some(ground) = model.ground.tile(tile.number) else { continue };
            let bins = tables.expected().tile(tile.number);
            let cones: Vec<Cones> = beams.iter().map(|&beam| tables.cones(heading, beam)).collect();
            for cell in ground.free() {
                let share = belief.value(tile.cells[cell]);
                if share <= 0.0 {
                    continue;
                }
                let log = share * libm::log(share);
                for (of_beam, &cones) in expected.iter_mut().zip(&cones) {
                    let bin = usize::from(bin_at(bins, cones, cell));
                    of_beam.shares[bin] += share;
                    of_beam.logs[bin] += log;
                }
            }
        }
    }
    expected
}
