//! What the certainty is worth: of all moments at which the robot says 0.8, it should be right in
//! 80 %.

use super::samples::Sample;
use super::statistics::Proportion;
use super::trial::MissionTrial;
use crate::terminal::page::Block;
use crate::terminal::table::Table;
use rpl_robot::localization::Calibration;
use serde::Serialize;

/// Bins of the reliability diagram, all with the same number of samples.
const BINS: usize = 10;

/// Certainties from here on are left out of the bins: there are so many that they would fill them.
const SURE: f64 = 0.99;

/// Some samples of about the same certainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bin {
    /// How many.
    pub samples: usize,
    /// Smallest and largest certainty.
    pub range: (f64, f64),
    /// Mean certainty.
    pub said: f64,
    /// Share of samples in which the estimate was right.
    pub was: f64,
    /// 95 % interval of that share, over runs: samples of one run depend on each other.
    #[serde(rename = "interval_95")]
    pub interval: (f64, f64),
}

impl Bin {
    /// How far the certainty is from the truth.
    pub fn error(&self) -> f64 {
        self.said - self.was
    }
}

/// A sample, and the run it comes from.
type Tagged = (usize, Sample);

/// The bins, from the least certain on.
pub fn bins(trials: &[&MissionTrial]) -> Vec<Bin> {
    let mut unsure: Vec<Tagged> = tagged(trials).filter(|(_, sample)| sample.certainty < SURE).collect();
    unsure.sort_by(|(_, a), (_, b)| a.certainty.total_cmp(&b.certainty));
    let size = unsure.len().div_ceil(BINS).max(1);
    unsure.chunks(size).map(bin).collect()
}

fn tagged<'t>(trials: &'t [&MissionTrial]) -> impl Iterator<Item = Tagged> + 't {
    trials.iter().enumerate().flat_map(|(run, trial)| trial.samples.iter().map(move |&sample| (run, sample)))
}

fn bin(samples: &[Tagged]) -> Bin {
    let count = samples.len() as f64;
    let certainty = |(_, sample): &Tagged| sample.certainty;
    let said = samples.iter().map(certainty).sum::<f64>() / count;
    let was = samples.iter().filter(|(_, sample)| sample.is_right).count() as f64 / count;
    let half = 1.96 * deviation_of_share(samples, was);
    let ends = |tagged: Option<&Tagged>| tagged.map_or(0.0, certainty);
    Bin {
        samples: samples.len(),
        range: (ends(samples.first()), ends(samples.last())),
        said,
        was,
        interval: ((was - half).max(0.0), (was + half).min(1.0)),
    }
}

/// Standard deviation of a share, with runs as clusters: the root of the sum over runs of squared
/// sums of residuals, by the number of samples.
fn deviation_of_share(samples: &[Tagged], share: f64) -> f64 {
    let mut by_run: Vec<(usize, f64)> =
        samples.iter().map(|&(run, sample)| (run, f64::from(sample.is_right) - share)).collect();
    by_run.sort_by_key(|&(run, _)| run);
    let squares: f64 = by_run
        .chunk_by(|a, b| a.0 == b.0)
        .map(|run| run.iter().map(|&(_, residual)| residual).sum::<f64>().powi(2))
        .sum();
    squares.sqrt() / samples.len() as f64
}

/// Samples that are counted together when a calibration is fitted.
const GROUP: usize = 100;

/// Two knots of a fitted calibration are at least so far apart, in nats of log odds.
const KNOTS_APART: f64 = 0.25;

/// Samples around one share of the belief.
#[derive(Clone, Copy)]
struct Pool {
    /// Sum of the shares.
    shares: f64,
    /// How many estimates were right.
    right: f64,
    /// How many there are.
    samples: f64,
}

impl Pool {
    fn and(self, other: Self) -> Self {
        Self {
            shares: self.shares + other.shares,
            right: self.right + other.right,
            samples: self.samples + other.samples,
        }
    }

    fn rate(self) -> f64 {
        (self.right + 0.5) / (self.samples + 1.0)
    }
}

/// The knots of the monotone calibration that fits these samples best, which were taken with `used`:
/// pools of adjacent samples that would violate the order are merged (pool adjacent violators).
pub fn fitted(trials: &[&MissionTrial], used: &Calibration) -> Vec<[f64; 2]> {
    let mut samples: Vec<(f64, bool)> =
        tagged(trials).map(|(_, sample)| (used.share(sample.certainty), sample.is_right)).collect();
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    let pools = samples.chunks(GROUP).map(|group| Pool {
        shares: group.iter().map(|&(share, _)| share).sum(),
        right: group.iter().filter(|&&(_, is_right)| is_right).count() as f64,
        samples: group.len() as f64,
    });
    let in_order = pooled(pools, |last, next| last.rate() < next.rate());
    let log_odds = |pool: Pool| (pool.rate() / (1.0 - pool.rate())).ln();
    let apart = pooled(in_order.into_iter(), |last, next| log_odds(next) - log_odds(last) >= KNOTS_APART);
    apart.into_iter().map(|pool| [pool.shares / pool.samples, pool.rate()]).collect()
}

/// Merges neighbours until all of them pass.
fn pooled(pools: impl Iterator<Item = Pool>, passes: impl Fn(Pool, Pool) -> bool) -> Vec<Pool> {
    let mut kept: Vec<Pool> = Vec::new();
    for mut next in pools {
        while let Some(last) = kept.pop_if(|last| !passes(*last, next)) {
            next = last.and(next);
        }
        kept.push(next);
    }
    kept
}

/// What the certainty was worth in some runs.
#[derive(Clone, Debug, Serialize)]
pub struct Reliability {
    /// How many runs.
    runs: usize,
    /// Moments that were looked at.
    samples: usize,
    /// From the least certain on; the sure ones are in none.
    pub bins: Vec<Bin>,
    /// The largest difference between what was said and what was right, over the bins.
    largest_error: f64,
    /// Sure moments, and how many of them were right.
    sure: Sure,
    /// Disturbed runs in which a position counted as found where it was not.
    wrong_recoveries: Proportion,
    /// How far a right estimate is off, on average.
    right_off_m: f64,
    /// How far one is off of which the robot is sure.
    tracking: Option<Tracking>,
    /// Share of the belief and how often it is right, fitted to these samples.
    fitted: Vec<[f64; 2]>,
}

/// How far right estimates are off of which the robot is sure: the middle one, and what 95 % do not
/// exceed.
#[derive(Clone, Copy, Debug, Serialize)]
struct Tracking {
    median_m: f64,
    most_m: f64,
    median_deg: f64,
    most_deg: f64,
}

impl Tracking {
    /// None if no estimate is right.
    fn of(sure: &[&Sample]) -> Option<Self> {
        let sorted = |off: fn(&Sample) -> f32| {
            let mut off: Vec<f32> = sure.iter().filter(|sample| sample.is_right).map(|sample| off(sample)).collect();
            off.sort_by(f32::total_cmp);
            off
        };
        let at = |off: &[f32], share: f64| off.get((off.len() as f64 * share) as usize).copied().map(f64::from);
        let (off_m, off_deg) = (sorted(|sample| sample.off_m), sorted(|sample| sample.off_rad.to_degrees()));
        Some(Self {
            median_m: at(&off_m, 0.5)?,
            most_m: at(&off_m, 0.95)?,
            median_deg: at(&off_deg, 0.5)?,
            most_deg: at(&off_deg, 0.95)?,
        })
    }

    fn sentence(&self) -> String {
        let Self { median_m, most_m, median_deg, most_deg } = self;
        format!(
            "at {SURE} and above a right one is off by {median_m:.3} m and {median_deg:.2}° in the median, by at most \
             {most_m:.3} m and {most_deg:.2}° in 95 %"
        )
    }
}

/// Moments at which the robot is sure; neighbours depend on each other, so there is no interval.
#[derive(Clone, Copy, Debug, Serialize)]
struct Sure {
    samples: usize,
    right: usize,
}

impl Reliability {
    /// Of some runs, whose samples were taken with `used`.
    pub fn of(trials: &[&MissionTrial], used: &Calibration) -> Self {
        let all: Vec<Sample> = tagged(trials).map(|(_, sample)| sample).collect();
        let sure: Vec<&Sample> = all.iter().filter(|sample| sample.certainty >= SURE).collect();
        let right_m: Vec<f64> =
            all.iter().filter(|sample| sample.is_right).map(|sample| f64::from(sample.off_m)).collect();
        let bins = bins(trials);
        let recovered: Vec<f64> = trials.iter().filter_map(|trial| trial.measure("wrong recoveries")).collect();
        let wrong = recovered.iter().filter(|&&count| count > 0.0).count();
        Self {
            runs: trials.len(),
            samples: all.len(),
            largest_error: bins.iter().map(|bin| bin.error().abs()).fold(0.0, f64::max),
            bins,
            sure: Sure { samples: sure.len(), right: sure.iter().filter(|sample| sample.is_right).count() },
            wrong_recoveries: Proportion::new(wrong, recovered.len()),
            tracking: Tracking::of(&sure),
            right_off_m: right_m.iter().sum::<f64>() / right_m.len().max(1) as f64,
            fitted: fitted(trials, used),
        }
    }

    /// The reliability table.
    pub fn blocks(&self) -> Vec<Block> {
        let mut table = Table::new(&["samples", "certainty", "mean", "right", "error", "95 % interval"]);
        for bin in &self.bins {
            table.row([
                bin.samples.to_string(),
                format!("{:.3}–{:.3}", bin.range.0, bin.range.1),
                format!("{:.3}", bin.said),
                format!("{:.3}", bin.was),
                format!("{:+.3}", bin.error()),
                format!("{:.3}–{:.3}", bin.interval.0, bin.interval.1),
            ]);
        }
        let Sure { samples, right } = self.sure;
        let Proportion { count, of, interval_95: (low, high), .. } = self.wrong_recoveries;
        let mut lines = vec![
            format!("largest error of a bin {:.3}", self.largest_error),
            format!(
                "at {SURE} and above: {samples} samples, right in {:.2} %",
                100.0 * right as f64 / samples.max(1) as f64
            ),
            format!(
                "runs with a wrong recovery: {count} of {of} disturbed, 95 % interval {:.1} to {:.1} %",
                100.0 * low,
                100.0 * high
            ),
            format!("a right estimate is off by {:.3} m on average", self.right_off_m),
        ];
        lines.extend(self.tracking.as_ref().map(Tracking::sentence));
        lines.push("share of the belief and how often it is right, fitted to these samples:".to_string());
        let knots: Vec<String> = self.fitted.iter().map(|[share, rate]| format!("[{share:.5}, {rate:.4}]")).collect();
        lines.extend(knots.chunks(4).map(|knots| format!("    {},", knots.join(", "))));
        let head = format!(
            "certainty: {} runs, {} samples, {} of them below {SURE}",
            self.runs,
            self.samples,
            self.samples - samples
        );
        vec![Block::Lines(head), Block::Table(table), Block::Lines(lines.join("\n"))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::samples::ErrorTrack;

    fn trial(samples: impl Iterator<Item = (f64, bool)>) -> MissionTrial {
        let samples: Vec<Sample> =
            samples.map(|(certainty, is_right)| Sample { certainty, off_m: 0.1, off_rad: 0.01, is_right }).collect();
        let error = ErrorTrack::of(&samples);
        MissionTrial { seed: 1, fault: None, unmeasured: None, measures: vec![], error, samples }
    }

    #[test]
    fn bins_have_equal_mass_and_a_robot_that_is_right_as_often_as_it_says_has_no_error() {
        // Of the samples with certainty c every (1/c)-th is wrong: 0.5 and 0.75, 400 each.
        let of = |certainty: f64, every: usize| (0..400).map(move |n| (certainty, n % every != 0));
        let mixed = trial(of(0.5, 2).chain(of(0.75, 4)).chain((0..50).map(|_| (0.999, true))));
        let bins = bins(&[&mixed]);
        assert_eq!(bins.len(), BINS);
        assert!(bins.iter().all(|bin| bin.samples == 80));
        assert!(bins.iter().all(|bin| bin.error().abs() < 1e-6), "{bins:?}");
    }

    #[test]
    fn a_robot_that_is_always_wrong_errs_by_what_it_says() {
        let wrong = trial((0..100).map(|n| (f64::from(n) / 200.0, false)));
        assert!(bins(&[&wrong]).iter().all(|bin| bin.error() == bin.said && bin.was == 0.0));
        let largest = Reliability::of(&[&wrong], &Calibration::new(&[])).largest_error;
        assert!((0.47..0.48).contains(&largest), "{largest}");
    }

    #[test]
    fn the_fit_finds_how_often_a_share_is_right_whatever_was_in_use() {
        // Shares of 0.2, 0.5 and 0.9 are right every fourth, every second and nine times in ten.
        let used = Calibration::new(&[[0.2, 0.3], [0.5, 0.7], [0.95, 0.96]]);
        let of = |share: f64, right_of_20: usize| {
            let certainty = used.certainty(share);
            (0..2000).map(move |n| (certainty, n % 20 < right_of_20))
        };
        let mixed = trial(of(0.2, 5).chain(of(0.5, 10)).chain(of(0.9, 18)));
        let knots = fitted(&[&mixed], &used);
        assert_eq!(knots.len(), 3, "{knots:?}");
        for (knot, expected) in knots.iter().zip([[0.2, 0.25], [0.5, 0.5], [0.9, 0.9]]) {
            assert!((knot[0] - expected[0]).abs() < 1e-9 && (knot[1] - expected[1]).abs() < 1e-3, "{knots:?}");
        }
    }
}
