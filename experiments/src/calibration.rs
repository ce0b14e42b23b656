//! What the certainty of missions is worth, and how far their estimates are off.

use super::quantity::Quantity;
use super::reliability::{self, Bin, Judged, SURE};
use super::samples::Sample;
use super::statistics::Proportion;
use super::trial::MissionTrial;
use rpl_robot::localization::Calibration;
use rpl_shell::terminal::page::Block;
use serde::Serialize;

/// The samples of some runs.
fn judged<'t>(trials: &'t [&MissionTrial]) -> impl Iterator<Item = Judged> + 't {
    let of_run = |(run, trial): (usize, &'t &MissionTrial)| {
        let judged = move |&Sample { certainty, is_right, .. }: &Sample| Judged { group: run, certainty, is_right };
        trial.samples.iter().map(judged)
    };
    trials.iter().enumerate().flat_map(of_run)
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
        let all: Vec<Sample> = trials.iter().flat_map(|trial| trial.samples.iter().copied()).collect();
        let sure: Vec<&Sample> = all.iter().filter(|sample| sample.certainty >= SURE).collect();
        let right_m: Vec<f64> =
            all.iter().filter(|sample| sample.is_right).map(|sample| f64::from(sample.off_m)).collect();
        let bins = reliability::bins(judged(trials));
        let recovered: Vec<f64> = trials.iter().filter_map(|trial| trial.measure(&Quantity::WrongRecoveries)).collect();
        let wrong = recovered.iter().filter(|&&count| count > 0.0).count();
        Self {
            runs: trials.len(),
            samples: all.len(),
            largest_error: reliability::largest_error(&bins),
            bins,
            sure: Sure { samples: sure.len(), right: sure.iter().filter(|sample| sample.is_right).count() },
            wrong_recoveries: Proportion::new(wrong, recovered.len()),
            tracking: Tracking::of(&sure),
            right_off_m: right_m.iter().sum::<f64>() / right_m.len().max(1) as f64,
            fitted: reliability::fitted(judged(trials), used),
        }
    }

    /// The reliability table.
    pub fn blocks(&self) -> Vec<Block> {
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
        lines.push(reliability::knots_text(&self.fitted));
        let head = format!(
            "certainty: {} runs, {} samples, {} of them below {SURE}",
            self.runs,
            self.samples,
            self.samples - samples
        );
        vec![Block::Lines(head), Block::Table(reliability::table(&self.bins)), Block::Lines(lines.join("\n"))]
    }
}
