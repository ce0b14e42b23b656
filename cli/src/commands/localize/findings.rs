//! What the trials showed together.

use super::windows::Timed;
use rpl_experiments::reliability::{self, Bin, Judged, SURE};
use rpl_experiments::statistics::{Proportion, quantile};
use rpl_robot::localization::Calibration;
use rpl_robot::recording::PoseError;
use serde::Serialize;
use std::collections::BTreeMap;

/// What some trials showed, in any windows of one drive.
///
/// Windows that overlap tell of the same scans, so intervals are those of the stretches of the drive that are as long
/// as a window, with all windows that begin in one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Findings {
    /// In how many windows the robot was found.
    pub found: Proportion,
    /// The same for each phase.
    pub phases: Vec<Phase>,
    /// Scans of all windows.
    pub scans: usize,
    /// How far the estimate was off while it was right.
    pub while_found: Option<Errors>,
    /// How often it was wrong while the filter was sure of it.
    pub wrong_while_sure: Proportion,
    /// What the certainty is worth.
    pub certainty: Certainty,
}

/// The windows of one phase.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Phase {
    /// The share of the way to the next window.
    pub phase: f64,
    /// In how many windows the robot was found.
    pub found: usize,
    /// Of how many.
    pub of: usize,
}

/// The errors while the estimate was right.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// Scans at which it was.
    pub scans: usize,
    /// Of the position.
    pub position_m: Spread,
    /// Of the heading.
    pub heading_deg: Spread,
}

/// What some errors are like.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Arithmetic mean.
    pub mean: f64,
    /// Half of them are no larger.
    pub median: f64,
    /// Of a hundred of them 95 are no larger.
    pub percentile_95: f64,
    /// The largest.
    pub max: f64,
}

/// How often the estimate is right, by the certainty.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Certainty {
    /// Scans with a certainty below 0.99, from the least certain on.
    pub bins: Vec<Bin>,
    /// The largest difference between what was said and what was right, over the bins.
    pub largest_error: f64,
    /// How often the estimate was right after the other scans.
    pub right_at_099: Proportion,
    /// Share of the belief and how often it is right, fitted to these scans.
    pub fitted: Vec<[f64; 2]>,
}

impl Findings {
    /// Of some trials, whose certainties were told with `used`.
    pub fn of(trials: &[Timed], used: &Calibration) -> Self {
        let in_stretches = |tally: &dyn Fn(&Timed) -> (usize, usize)| {
            Proportion::in_groups(&summed(trials.iter().map(|timed| (stretch(timed), tally(timed)))))
        };
        let judged: Vec<Judged> = trials.iter().flat_map(judged).collect();
        let bins = reliability::bins(judged.iter().copied());
        Self {
            found: in_stretches(&|timed| (usize::from(timed.trial.succeeded), 1)),
            phases: phases(trials),
            scans: judged.len(),
            while_found: Errors::of(trials),
            wrong_while_sure: in_stretches(&|timed| {
                let (sure, wrong) = timed.trial.sure_and_wrong();
                (wrong, sure)
            }),
            certainty: Certainty {
                largest_error: reliability::largest_error(&bins),
                bins,
                right_at_099: in_stretches(&|timed| {
                    let certain = || timed.trial.errors.iter().filter(|error| error.certainty >= SURE);
                    (certain().filter(|error| error.is_right()).count(), certain().count())
                }),
                fitted: reliability::fitted(judged, used),
            },
        }
    }
}

/// The stretch of the drive in which a window begins.
fn stretch(timed: &Timed) -> usize {
    (timed.window.start_m / timed.window.length_m) as usize
}

/// The sums of the groups, in their order.
fn summed(tallies: impl Iterator<Item = (usize, (usize, usize))>) -> Vec<(usize, usize)> {
    // A drive that leaps has stretches as far apart as its numbers go.
    let mut sums: BTreeMap<usize, (usize, usize)> = BTreeMap::new();
    for (group, (count, of)) in tallies {
        let sum = sums.entry(group).or_default();
        sum.0 += count;
        sum.1 += of;
    }
    sums.into_values().filter(|sum| sum.1 > 0).collect()
}

fn judged(timed: &Timed) -> impl Iterator<Item = Judged> {
    let group = stretch(timed);
    let judged = move |error: &PoseError| Judged { group, certainty: error.certainty, is_right: error.is_right() };
    timed.trial.errors.iter().map(judged)
}

fn phases(trials: &[Timed]) -> Vec<Phase> {
    let of_phase = |trials: &[Timed]| Phase {
        phase: trials[0].phase,
        found: trials.iter().filter(|timed| timed.trial.succeeded).count(),
        of: trials.len(),
    };
    trials.chunk_by(|one, next| one.phase == next.phase).map(of_phase).collect()
}

impl Errors {
    /// None if the estimate was never right until the end.
    fn of(trials: &[Timed]) -> Option<Self> {
        let found: Vec<&PoseError> = trials.iter().flat_map(|timed| timed.trial.errors_once_found()).collect();
        let spread = |of: &dyn Fn(&PoseError) -> f64| Spread::of(found.iter().map(|error| of(error)).collect());
        Some(Self {
            scans: found.len(),
            position_m: spread(&PoseError::position_m)?,
            heading_deg: spread(&|error| error.heading_rad().to_degrees())?,
        })
    }
}

impl Spread {
    /// None of nothing.
    fn of(mut numbers: Vec<f64>) -> Option<Self> {
        numbers.sort_by(f64::total_cmp);
        Some(Self {
            mean: numbers.iter().sum::<f64>() / numbers.len() as f64,
            median: quantile(&numbers, 0.5)?,
            percentile_95: quantile(&numbers, 0.95)?,
            max: quantile(&numbers, 1.0)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_begins_in_one_stretch_is_counted_together() {
        let tallies = [(0, (1, 1)), (3, (0, 1)), (0, (0, 1)), (3, (1, 1))];
        assert_eq!(summed(tallies.into_iter()), [(1, 2), (1, 2)]);
        // A log may say that the robot is anywhere.
        let leap = [(usize::MAX, (1, 1)), (1 << 60, (0, 0)), (0, (0, 1))];
        assert_eq!(summed(leap.into_iter()), [(0, 1), (1, 1)]);
    }
}
