//! How far the estimate of a run was off, moment by moment.

use serde::{Deserialize, Serialize};

/// Seconds between two points of the error over time.
pub const EVERY_S: usize = 10;

/// Samples of a trial in a second.
const SAMPLES_PER_S: usize = 10;

/// Samples from one point of the error over time to the next.
pub const POINT_SAMPLES: usize = EVERY_S * SAMPLES_PER_S;

/// Points of a line at most, besides the first.
pub const POINTS: usize = 30;

/// How far the estimate of a run was off from the truth, as charts need it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorTrack {
    /// At the beginning, and every ten seconds for as long as charts reach.
    pub at_m: Vec<f32>,
    /// At the end.
    pub last_m: Option<f32>,
    /// How many samples there were.
    pub samples: usize,
}

impl ErrorTrack {
    /// Of the samples of a run.
    pub fn of(samples: &[Sample]) -> Self {
        let points = samples.iter().step_by(POINT_SAMPLES).take(POINTS + 1);
        Self {
            at_m: points.map(|sample| sample.off_m).collect(),
            last_m: samples.last().map(|sample| sample.off_m),
            samples: samples.len(),
        }
    }
}

/// The estimate and the truth at a moment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// What the robot says.
    pub certainty: f64,
    /// Distance from the estimate to the truth.
    pub off_m: f32,
    /// Angle between the estimated and the true heading, at least 0.
    pub off_rad: f32,
    /// Whether the estimate was right.
    pub is_right: bool,
}
