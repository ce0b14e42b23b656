//! P(s | o): how likely a reading is where a distance is expected, as byte tables.

use super::kernel;
use super::scan_parameters::BeamParameters;

/// The bin of a reading, or an expected distance, without an echo in range.
pub const NO_ECHO: u8 = 255;

/// Distance bins: 255 for distances in range, and [`NO_ECHO`].
pub(crate) const BINS: usize = 256;

/// Negative log-likelihoods are stored in units of 1/32 nat: rounding errs by at most 1/64 nat a
/// beam, and the clip at 255 is 8 nats, beyond what the uniform part of the mixture allows.
const UNITS_PER_NAT: f64 = 32.0;

/// The bins of one scan, beam by beam; none for a reading that is missing or left out.
pub(super) type BinnedScan = Vec<Option<u8>>;

/// The sensor model, quantised.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorModel {
    max_range_m: f64,
    /// `[measured][expected]`: −ln P(measured | expected), less its smallest value over expected.
    costs: Vec<[u8; BINS]>,
    /// `[expected]`: the mean over what is measured of −ln P, less its smallest value over expected, in nats.
    mean_nats: Vec<f64>,
    /// Binary logarithm of the weight a unit of cost amounts to, tempered.
    log2_per_cost: f32,
}

impl SensorModel {
    /// Tables for a mixture; `tempering` is the exponent of a scan's likelihood.
    pub fn new(parameters: &BeamParameters, tempering: f64) -> Self {
        let likelihood: Vec<Vec<f64>> = (0..BINS).map(|expected| mixture(parameters, expected)).collect();
        let costs: Vec<[u8; BINS]> = (0..BINS)
            .map(|measured| {
                let nats: [f64; BINS] = std::array::from_fn(|expected| -libm::log(likelihood[expected][measured]));
                let best = nats.iter().copied().fold(f64::INFINITY, f64::min);
                std::array::from_fn(|expected| {
                    libm::round((nats[expected] - best) * UNITS_PER_NAT).min(f64::from(u8::MAX)) as u8
                })
            })
            .collect();
        let mean_nats = (likelihood.iter().enumerate())
            .map(|(expected, given)| {
                let nats = given.iter().zip(&costs).map(|(share, costs)| share * f64::from(costs[expected]));
                nats.sum::<f64>() / UNITS_PER_NAT
            })
            .collect();
        let log2_per_cost = (-tempering / UNITS_PER_NAT * std::f64::consts::LOG2_E) as f32;
        Self { max_range_m: parameters.max_range_m, costs, mean_nats, log2_per_cost }
    }

    /// The bin of a distance.
    pub fn bin(&self, range_m: f64) -> u8 {
        bin(range_m, self.max_range_m)
    }

    /// The bins of a scan in metres; readings that are not finite are missing.
    pub(super) fn scan(&self, ranges_m: &[f32]) -> BinnedScan {
        let bin = |range_m: &f32| range_m.is_finite().then(|| self.bin(f64::from(*range_m)));
        ranges_m.iter().map(bin).collect()
    }

    /// The middle of a bin, in metres; the maximal range for [`NO_ECHO`].
    pub fn range_m(&self, bin: u8) -> f64 {
        if bin == NO_ECHO { self.max_range_m } else { (f64::from(bin) + 0.5) * self.max_range_m / 255.0 }
    }

    /// Costs of one measured bin, by expected bin, in 1/32 nat.
    pub fn costs(&self, measured: u8) -> &[u8; BINS] {
        &self.costs[usize::from(measured)]
    }

    /// −ln P(measured | expected) of one reading in full, less its smallest value over all that may be expected.
    pub(super) fn nats(&self, measured: u8, expected: u8) -> f64 {
        f64::from(self.costs(measured)[usize::from(expected)]) / UNITS_PER_NAT
    }

    /// The mean of [`SensorModel::nats`] over all readings of an expected distance, by the mixture.
    pub(super) fn mean_nats(&self, expected: u8) -> f64 {
        self.mean_nats[usize::from(expected)]
    }

    /// Binary logarithm of the weight a unit of cost amounts to, if weights are raised to a power.
    pub(super) fn log2_per_cost(&self, power: f64) -> f32 {
        (f64::from(self.log2_per_cost) * power) as f32
    }

    /// Tempered weight of a scan whose costs have this sum.
    pub fn weight(&self, sum: usize) -> f64 {
        f64::from(kernel::exp2(sum as f32 * self.log2_per_cost))
    }
}

/// The bin of a distance under a maximal range.
pub(super) fn bin(range_m: f64, max_range_m: f64) -> u8 {
    if range_m >= max_range_m { NO_ECHO } else { (range_m.max(0.0) / max_range_m * 255.0) as u8 }
}

/// P(measured | expected) over the measured bins; sums to 1.
pub(super) fn mixture(parameters: &BeamParameters, expected: usize) -> Vec<f64> {
    let mut density = vec![0.0; BINS];
    for (part, weight) in components(parameters, expected).iter().zip(parameters.weights()) {
        for (sum, value) in density.iter_mut().zip(part) {
            *sum += weight * value;
        }
    }
    let total: f64 = density.iter().sum();
    density.iter().map(|value| value / total).collect()
}

/// The densities of the mixture over the measured bins, in the order of
/// [`BeamParameters::weights`]: the expected surface, anything, something before it, no echo.
/// Each sums to 1, or is 0 where there is no room for it.
pub(crate) fn components(parameters: &BeamParameters, expected: usize) -> [Vec<f64>; 4] {
    let width_m = parameters.max_range_m / 255.0;
    let centre_m = |bin: usize| (bin as f64 + 0.5) * width_m;
    let no_echo = usize::from(NO_ECHO);
    let mut silence = vec![0.0; BINS];
    silence[no_echo] = 1.0;
    let hit = if expected == no_echo {
        silence.clone()
    } else {
        let sigma_m = parameters.sigma_m + parameters.sigma_per_m * centre_m(expected);
        let density = |bin: usize| {
            let away = (centre_m(bin) - centre_m(expected) - parameters.wall_depth_m) / sigma_m;
            libm::exp(-0.5 * away * away)
        };
        let mut hit = normalized((0..no_echo).map(density));
        if parameters.fades {
            let within: f64 = (0..no_echo).map(density).sum();
            let beyond: f64 = (no_echo..2 * no_echo).map(density).sum();
            let share = beyond / (within + beyond);
            hit.iter_mut().for_each(|value| *value *= 1.0 - share);
            hit[no_echo] = share;
        }
        hit
    };
    let short = normalized((0..expected).map(|bin| libm::exp(-centre_m(bin) / parameters.short_mean_m)));
    [hit, vec![1.0 / BINS as f64; BINS], short, silence]
}

/// The values brought to the sum 1 and filled up to all bins with 0.
fn normalized(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut part: Vec<f64> = values.collect();
    let total: f64 = part.iter().sum();
    if total > 0.0 {
        part.iter_mut().for_each(|value| *value /= total);
    }
    part.resize(BINS, 0.0);
    part
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_expected_distance_gives_a_distribution_with_its_peak_there() {
        let parameters = BeamParameters { missed: 0.01, ..BeamParameters::default() };
        for expected in [20, 100, 200] {
            let density = mixture(&parameters, expected);
            assert!((density.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let peak = (0..255).max_by(|&a, &b| density[a].total_cmp(&density[b]));
            assert!(peak.is_some_and(|peak| peak.abs_diff(expected) <= 1));
        }
    }

    #[test]
    fn half_of_what_lies_at_the_end_of_a_range_that_fades_is_not_seen() {
        let parameters = BeamParameters { fades: true, ..BeamParameters::default() };
        let [hit, ..] = components(&parameters, 254);
        assert!((hit.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!((0.4..0.6).contains(&hit[usize::from(NO_ECHO)]), "{}", hit[usize::from(NO_ECHO)]);
        let [hit, ..] = components(&parameters, 100);
        assert!(hit[usize::from(NO_ECHO)] < 1e-9);
    }

    #[test]
    fn a_short_reading_is_likelier_than_a_long_one() {
        let density = mixture(&BeamParameters::default(), 128);
        assert!(density[64] > density[192]);
    }

    #[test]
    fn bytes_err_by_at_most_half_a_unit() {
        let parameters = BeamParameters::default();
        let model = SensorModel::new(&parameters, 1.0);
        for measured in [0u8, 77, 254, 255] {
            let exact: Vec<f64> =
                (0..BINS).map(|o| -libm::log(mixture(&parameters, o)[usize::from(measured)])).collect();
            let best = exact.iter().copied().fold(f64::INFINITY, f64::min);
            for (nats, &cost) in exact.iter().zip(model.costs(measured)) {
                assert!(((nats - best) - f64::from(cost) / 32.0).abs() <= 1.0 / 64.0 + 1e-12);
            }
        }
    }

    #[test]
    fn bins_cover_the_range_in_order() {
        let model = SensorModel::new(&BeamParameters::default(), 0.1);
        assert_eq!(model.bin(5.0), NO_ECHO);
        assert_eq!(model.bin(-0.1), 0);
        for bin in 0..NO_ECHO {
            assert_eq!(model.bin(model.range_m(bin)), bin);
        }
    }
}
