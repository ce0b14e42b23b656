//! E_a[H]: the entropy expected at a target point.

use super::parameters::ActiveParameters;
use crate::geometry::{Point, Pose};
use crate::localization::{LocalizationModel, Maximum, ScanModel};

/// How likely the robot gets to a point the map shows as occupied, or the other way round.
const MAP_IS_WRONG: f64 = 0.02;

const BINS: usize = 256;

/// Computes expected entropies for one set of hypotheses, usually the maxima.
///
/// # Deviation
/// Eq. (6) sums over all sensings; with few maxima the noise-free scans at the target, one for
/// each maximum, stand for them. The whole tempered scan is one sensing: entropies of single beams
/// cannot be added, they would go below 0. Sensors all around are read at the heading the robot has now:
/// turning by 15° only renames the sonars, for all maxima alike. Those that look ahead are read as the
/// robot arrives, looking the way it came from where it is now. If the target is occupied as seen from some
/// maxima and free from others, finding out whether it can be reached is a sensing as well.
pub(super) struct EntropyForecast<'m> {
    model: &'m LocalizationModel,
    parameters: &'m ActiveParameters,
    /// What is thought possible.
    hypotheses: &'m [Maximum],
    /// Masses of the hypotheses, as shares.
    shares: Vec<f64>,
    /// Those of whose sensings the expectation is taken ...
    truths: &'m [Maximum],
    /// ... and their shares.
    truth_shares: Vec<f64>,
    /// Whether each sensor looks all around.
    look_around: Vec<bool>,
    /// For each sensor `[measured][expected]` in units of its model, forgiving small differences.
    costs: Vec<Vec<u8>>,
}

impl<'m> EntropyForecast<'m> {
    /// With maxima as hypotheses; poses are known no better than the tolerance.
    pub fn new(model: &'m LocalizationModel, maxima: &'m [Maximum], parameters: &'m ActiveParameters) -> Self {
        let costs = model.sensors.iter().map(|sensor| forgiving_costs(sensor, parameters.tolerance_m)).collect();
        Self { costs, ..Self::over(model, maxima, maxima, parameters) }
    }

    /// With any hypotheses, and sensings of some of them.
    pub fn over(
        model: &'m LocalizationModel,
        hypotheses: &'m [Maximum],
        truths: &'m [Maximum],
        parameters: &'m ActiveParameters,
    ) -> Self {
        Self {
            model,
            parameters,
            hypotheses,
            shares: shares(hypotheses),
            truths,
            truth_shares: shares(truths),
            look_around: model.sensors.iter().map(|sensor| sensor.parameters.looks_around()).collect(),
            costs: model.sensors.iter().map(|sensor| forgiving_costs(sensor, 0.0)).collect(),
        }
    }

    /// Entropy of the shares now.
    pub fn current(&self) -> f64 {
        entropy(&self.shares)
    }

    /// Entropy of the shares expected after moving to a point and sensing there. At most the
    /// logarithm of the number of maxima, at least 0.
    pub fn expected(&self, target_in_base: Point) -> f64 {
        let view = |hypothesis: &Maximum| self.view(hypothesis.pose_in_map, target_in_base);
        let views: Vec<View> = self.hypotheses.iter().map(view).collect();
        let unreached =
            posterior_entropy(self.shares.iter().zip(&views).map(|(share, view)| share * (1.0 - view.reach)));
        let after = |truth: &Maximum| {
            let truth = view(truth);
            let weights = self.shares.iter().zip(&views).map(|(share, view)| {
                share * view.reach * self.likelihood(truth.scans.as_deref(), view.scans.as_deref())
            });
            truth.reach * posterior_entropy(weights) + (1.0 - truth.reach) * unreached
        };
        self.truths.iter().zip(&self.truth_shares).map(|(truth, share)| share * after(truth)).sum()
    }

    /// The target as seen from a maximum.
    fn view(&self, robot_in_map: Pose, target_in_base: Point) -> View {
        let target_in_map = robot_in_map.transform(target_in_base);
        let radius_m = self.parameters.robot_radius_m;
        let clearance_m = self.model.distances.clearance_m(target_in_map);
        let reach = (0.5 + (clearance_m - radius_m) / (2.0 * self.parameters.tolerance_m))
            .clamp(MAP_IS_WRONG, 1.0 - MAP_IS_WRONG);
        let on_arrival_rad = libm::atan2(target_in_base.y, target_in_base.x);
        let scan = |sensor: usize| {
            let turned_rad = if self.look_around[sensor] { 0.0 } else { on_arrival_rad };
            let pose = Pose::new(target_in_map.x, target_in_map.y, robot_in_map.heading_rad + turned_rad);
            let state = self.model.state_at(pose).filter(|state| self.model.is_admissible(state.column, state.row));
            state.map(|state| self.model.expected_scan(sensor, state))
        };
        View { reach, scans: (0..self.model.sensors.len()).map(scan).collect() }
    }

    /// How likely scans of all sensors are where others are expected; a place without scans tells nothing.
    fn likelihood(&self, sensed: Option<&[Vec<u8>]>, expected: Option<&[Vec<u8>]>) -> f64 {
        let (Some(sensed), Some(expected)) = (sensed, expected) else { return 1.0 };
        let weights = self.model.sensors.iter().zip(&self.costs).zip(sensed.iter().zip(expected));
        let weights = weights.map(|((sensor, costs), (sensed, expected))| {
            let cost = |(s, o): (&u8, &u8)| usize::from(costs[usize::from(*s) * BINS + usize::from(*o)]);
            sensor.likelihood.weight(sensed.iter().zip(expected).map(cost).sum())
        });
        let once: f64 = weights.product();
        (1..self.parameters.scans).fold(once, |product, _| product * once)
    }
}

/// Masses, brought to the sum 1.
fn shares(hypotheses: &[Maximum]) -> Vec<f64> {
    let total: f64 = hypotheses.iter().map(|hypothesis| hypothesis.mass).sum();
    hypotheses.iter().map(|hypothesis| hypothesis.mass / total).collect()
}

/// What a target would be, were the robot at one of the maxima.
struct View {
    /// How probably the robot gets there: maxima are known to the tolerance, and so is the clearance.
    reach: f64,
    /// The noise-free scan of each sensor there; none where the robot cannot stand.
    scans: Option<Vec<Vec<u8>>>,
}

/// The costs of a sensor's readings, each the least within a tolerance of the expected one.
fn forgiving_costs(sensor: &ScanModel, tolerance_m: f64) -> Vec<u8> {
    let tolerance = usize::from(sensor.likelihood.bin(tolerance_m));
    let mut costs = vec![u8::MAX; BINS * BINS];
    for (measured, row) in costs.chunks_exact_mut(BINS).enumerate() {
        let exact = sensor.likelihood.costs(measured as u8);
        // One distance after the other, which vector instructions do for many bins at once.
        for apart in 0..=tolerance.min(BINS - 1) {
            row.iter_mut().zip(&exact[apart..]).for_each(|(cost, &farther)| *cost = (*cost).min(farther));
            row[apart..].iter_mut().zip(exact).for_each(|(cost, &nearer)| *cost = (*cost).min(nearer));
        }
    }
    costs
}

/// Entropy of weights, once normalized: ln W − (Σ w ln w) / W.
fn posterior_entropy(weights: impl Iterator<Item = f64>) -> f64 {
    let (mut total, mut sum) = (0.0, 0.0);
    for weight in weights.filter(|&weight| weight > 0.0) {
        total += weight;
        sum += weight * libm::log(weight);
    }
    if total > 0.0 { (libm::log(total) - sum / total).max(0.0) } else { 0.0 }
}

/// −Σ p ln p, in nats.
fn entropy(shares: &[f64]) -> f64 {
    shares.iter().filter(|&&share| share > 0.0).map(|&share| -share * libm::log(share)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entropy_of_equal_shares_is_the_logarithm_of_their_number() {
        for count in [1usize, 2, 7] {
            let shares = vec![1.0 / count as f64; count];
            assert!((entropy(&shares) - libm::log(count as f64)).abs() < 1e-12);
        }
        assert_eq!(entropy(&[1.0, 0.0]), 0.0);
        let weights = [0.2, 0.6, 0.0];
        let exact = entropy(&[0.25, 0.75]);
        assert!((posterior_entropy(weights.into_iter()) - exact).abs() < 1e-12);
    }
}
