//! How badly a reading fits what is expected, with many people about.

use crate::localization::BeamParameters;

/// What a reading costs at the most that is shorter than what is expected, in nats.
///
/// # Deviation
/// Of independent beams somebody would cost as many nats as he covers beams, each as much as −ln of his density there is
/// above that of a wall: a few people would speak for any place where walls stand as they do. But one who stands there covers
/// all of these beams at once.
const SHORT_NATS: f64 = 1.5;

/// One that is longer: what is expected would have to be gone.
const UNEXPLAINED_NATS: f64 = 4.0;

/// The errors of a beam, and the range of its sensor.
#[derive(Clone, Debug)]
pub(super) struct Likelihood {
    max_range_m: f64,
    sigma_m: f64,
    per_m: f64,
    missed_nats: f64,
}

/// −ln of the likelihood of a reading by what is expected, less what it is where exactly this is expected: a Gaussian's,
/// and at the most what it takes that it has another reason.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReadingCost {
    range_m: f64,
    per_sigma: f64,
    /// What it costs at the most where something farther is expected, ...
    before_nats: f64,
    /// ... and something nearer.
    beyond_nats: f64,
}

impl Likelihood {
    pub(super) fn new(beam: &BeamParameters, sigma_m: f64, per_m: f64) -> Self {
        let missed_nats = libm::log((beam.hit + beam.missed) / beam.missed).min(UNEXPLAINED_NATS);
        Self { max_range_m: beam.max_range_m, sigma_m, per_m, missed_nats }
    }

    /// Of one reading.
    pub(super) fn of(&self, range_m: f64) -> ReadingCost {
        let range_m = range_m.min(self.max_range_m);
        let per_sigma = 1.0 / (self.sigma_m + self.per_m * range_m);
        let beyond_nats = if range_m >= self.max_range_m { self.missed_nats } else { UNEXPLAINED_NATS };
        ReadingCost { range_m, per_sigma, before_nats: SHORT_NATS, beyond_nats }
    }
}

impl ReadingCost {
    /// What it costs where this distance is expected.
    #[inline(always)]
    pub(super) fn nats(&self, expected_m: f64) -> f64 {
        let away = (self.range_m - expected_m) * self.per_sigma;
        let most = if away < 0.0 { self.before_nats } else { self.beyond_nats };
        f64::min(0.5 * away * away, most)
    }
}
