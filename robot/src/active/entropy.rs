//! E_a[H]: the entropy expected at a target point.

use super::occupancy::is_free;
use super::parameters::ActiveParameters;
use crate::geometry::{Point, Pose};
use crate::localization::{LocalizationModel, Maximum, SONARS};

/// How likely the robot gets to a point the map shows as occupied, or the other way round.
const MAP_IS_WRONG: f64 = 0.02;

const BINS: usize = 256;

/// Computes expected entropies for one set of maxima.
///
/// # Deviation
/// Eq. (6) sums over all sensings; with few maxima the noise-free scans at the target, one for
/// each maximum, stand for them. The whole tempered scan is one sensing: entropies of single beams
/// cannot be added, they would go below 0. A target keeps the heading the robot has now: turning by
/// 15° only renames the sonars, for all maxima alike. If the target is occupied as seen from some
/// maxima and free from others, finding out whether it can be reached is a sensing as well.
pub(super) struct EntropyForecast<'m> {
    model: &'m LocalizationModel,
    parameters: &'m ActiveParameters,
    maxima: &'m [Maximum],
    /// Masses of the maxima, as shares.
    shares: Vec<f64>,
    /// `[measured][expected]` in units of the sensor model, forgiving small differences.
    costs: Vec<u8>,
}

impl<'m> EntropyForecast<'m> {
    pub fn new(model: &'m LocalizationModel, maxima: &'m [Maximum], parameters: &'m ActiveParameters) -> Self {
        let total: f64 = maxima.iter().map(|maximum| maximum.mass).sum();
        let tolerance = usize::from(model.sensor.bin(parameters.tolerance_m));
        Self {
            model,
            parameters,
            maxima,
            shares: maxima.iter().map(|maximum| maximum.mass / total).collect(),
            costs: forgiving_costs(model, tolerance),
        }
    }

    /// Entropy of the shares now.
    pub fn current(&self) -> f64 {
        entropy(&self.shares)
    }

    /// Entropy of the shares expected after moving to a point and sensing there. At most the
    /// logarithm of the number of maxima, at least 0.
    pub fn expected(&self, target_in_base: Point) -> f64 {
        let scans: Vec<Option<[u8; SONARS]>> =
            self.maxima.iter().map(|maximum| self.scan(maximum.pose_in_map, target_in_base)).collect();
        let mut weighted = vec![0.0; scans.len()];
        let mut expected = 0.0;
        for (truth, share) in self.shares.iter().enumerate() {
            for (hypothesis, weight) in weighted.iter_mut().enumerate() {
                *weight = self.shares[hypothesis] * self.likelihood(scans[truth].as_ref(), scans[hypothesis].as_ref());
            }
            let evidence: f64 = weighted.iter().sum();
            weighted.iter_mut().for_each(|weight| *weight /= evidence);
            expected += share * entropy(&weighted);
        }
        expected
    }

    /// The noise-free scan at a target as seen from a maximum; none if the target is occupied.
    fn scan(&self, robot_in_map: Pose, target_in_base: Point) -> Option<[u8; SONARS]> {
        let target_in_map = robot_in_map.transform(target_in_base);
        let pose = Pose::new(target_in_map.x, target_in_map.y, robot_in_map.heading_rad);
        let state = self.model.state_at(pose).filter(|_| is_free(self.model, target_in_map, self.parameters))?;
        Some(self.model.expected_scan(state))
    }

    fn likelihood(&self, sensed: Option<&[u8; SONARS]>, expected: Option<&[u8; SONARS]>) -> f64 {
        match (sensed, expected) {
            (None, None) => 1.0,
            (None, Some(_)) | (Some(_), None) => MAP_IS_WRONG,
            (Some(sensed), Some(expected)) => {
                let cost = |(s, o): (&u8, &u8)| usize::from(self.costs[usize::from(*s) * BINS + usize::from(*o)]);
                let sum: usize = sensed.iter().zip(expected).map(cost).sum();
                let once = self.model.sensor.weight(sum);
                (1..self.parameters.scans).fold(once, |product, _| product * once)
            }
        }
    }
}

/// The sensor model's costs, each the least within `tolerance` bins of the expected one, less what
/// measuring exactly the expected distance costs.
fn forgiving_costs(model: &LocalizationModel, tolerance: usize) -> Vec<u8> {
    let mut costs = vec![0; BINS * BINS];
    for (measured, row) in costs.chunks_exact_mut(BINS).enumerate() {
        let exact = model.sensor.costs(measured as u8);
        for (expected, cost) in row.iter_mut().enumerate() {
            let window = &exact[expected.saturating_sub(tolerance)..=(expected + tolerance).min(BINS - 1)];
            *cost = window.iter().copied().fold(u8::MAX, u8::min);
        }
    }
    costs
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
    }
}
