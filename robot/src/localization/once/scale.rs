//! Distances as bytes, in steps of their own error: what errs more is told by coarser steps.

use crate::localization::BeamParameters;

/// Steps for each standard deviation, where they fit into a byte.
const MOST_STEPS: f64 = 4.0;

/// The last step in range; "no echo" lies a little beyond it, so that a surface near the end of the range is nearly none.
const LAST_STEP: f64 = 248.0;

/// By how much the errors of the search are smaller than those of a belief's cells: the bounds cover the cell themselves.
const OF_CELL: f64 = 0.75;

/// The scale of a sensor: the integral of dz / σ(z), σ growing in proportion to the distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct RangeScale {
    max_range_m: f64,
    sigma_m: f64,
    per_m: f64,
    /// Steps for each standard deviation.
    pub steps: f64,
    /// Where nothing is in reach.
    pub no_echo: u8,
}

impl RangeScale {
    pub(super) fn new(beam: &BeamParameters) -> Self {
        let (sigma_m, per_m) = (OF_CELL * beam.sigma_m, (OF_CELL * beam.sigma_per_m).max(1e-3));
        let sigmas = libm::log1p(per_m * beam.max_range_m / sigma_m) / per_m;
        let steps = MOST_STEPS.min(LAST_STEP / sigmas);
        let no_echo = (libm::floor(sigmas * steps) + libm::ceil(steps)) as u8;
        Self { max_range_m: beam.max_range_m, sigma_m, per_m, steps, no_echo }
    }

    /// The step of a distance.
    pub(super) fn step(&self, range_m: f64) -> u8 {
        if range_m >= self.max_range_m {
            return self.no_echo;
        }
        let sigmas = libm::log1p(self.per_m * range_m.max(0.0) / self.sigma_m) / self.per_m;
        libm::floor(sigmas * self.steps) as u8
    }

    /// The distance in the middle of a step.
    pub(super) fn range_m(&self, step: u8) -> f64 {
        if step >= self.no_echo {
            return self.max_range_m;
        }
        let sigmas = (f64::from(step) + 0.5) / self.steps;
        (self.sigma_m * libm::expm1(sigmas * self.per_m) / self.per_m).min(self.max_range_m)
    }
}
