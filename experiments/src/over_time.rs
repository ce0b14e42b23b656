//! How missions go over time, on the whole: how many have succeeded by when, and how far estimates are off.

use super::numbers::{Moments, Numbers};
use super::quantity::Quantity;
use super::samples::{ErrorTrack, POINT_SAMPLES, POINTS};
use super::trial::MissionTrial;

/// How missions go over time.
#[derive(Clone, Debug, Default)]
pub struct OverTime {
    /// How many were measured.
    pub runs: usize,
    /// When those ended that succeeded.
    pub succeeded_s: Numbers,
    /// When the last one of all ended.
    pub latest_s: f64,
    /// The error at each point; runs that have ended keep their last one.
    errors_m: Vec<Moments>,
    /// Samples of the longest run.
    longest: usize,
}

impl OverTime {
    /// Takes in a run that counts.
    pub fn add(&mut self, trial: &MissionTrial) {
        let time_s = trial.measure(&Quantity::Time).unwrap_or(0.0);
        self.runs += 1;
        self.latest_s = self.latest_s.max(time_s);
        if trial.succeeded() {
            self.succeeded_s.add(time_s);
        }
        let ErrorTrack { at_m, last_m, samples } = &trial.error;
        self.longest = self.longest.max(*samples);
        self.errors_m.resize(POINTS + 1, Moments::default());
        for (point, errors_m) in self.errors_m.iter_mut().enumerate() {
            if let Some(error_m) = at_m.get(point).or(last_m.as_ref()) {
                errors_m.add(f64::from(*error_m));
            }
        }
    }

    /// How many points of the error there are, besides the first; none if nothing had an estimate.
    pub fn error_points(&self) -> Option<usize> {
        (self.longest > 0).then(|| (self.longest / POINT_SAMPLES).clamp(1, POINTS))
    }

    /// The mean error at a point, and half its 95 % interval.
    pub fn error_m(&self, point: usize) -> (f64, f64) {
        self.errors_m.get(point).copied().unwrap_or_default().mean_95()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::Sample;

    #[test]
    fn an_ended_run_keeps_its_last_error() {
        let samples = |errors: &[f32]| {
            let sample = |&off_m: &f32| Sample { certainty: 1.0, off_m, off_rad: 0.0, is_right: true };
            errors.iter().map(sample).collect::<Vec<_>>()
        };
        let trial = |errors: &[f32]| MissionTrial {
            seed: 1,
            fault: None,
            unmeasured: None,
            value: None,
            measures: vec![],
            error: ErrorTrack::of(&samples(errors)),
            samples: vec![],
        };
        let mut over_time = OverTime::default();
        over_time.add(&trial(&[4.0]));
        over_time.add(&trial(&[2.0; 201]));
        assert_eq!((over_time.error_points(), over_time.error_m(2).0), (Some(2), 3.0));
    }
}
