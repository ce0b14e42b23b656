//! How likely each percept is for each feature.

use crate::feature::Feature;
use rpl_random::Stream;
use serde::{Deserialize, Serialize};

/// C(percept | feature) (Gutierrez-Osuna and Luo, note 2). A percept of `Wall` is nothing perceived; the
/// column of `Wall` is about one stretch of wall between two openings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Matrix {
    /// `certainties[percept][feature]`, both in the order of [`Feature::ALL`]. Each column sums to about 1.
    pub certainties: [[f64; 5]; 5],
}

impl Matrix {
    /// Of the sonars alone.
    pub const SONAR: Matrix = Matrix {
        certainties: [
            [0.980, 0.040, 0.010, 0.003, 0.005],
            [0.012, 0.930, 0.020, 0.002, 0.002],
            [0.004, 0.022, 0.950, 0.020, 0.010],
            [0.002, 0.005, 0.018, 0.955, 0.080],
            [0.002, 0.003, 0.002, 0.020, 0.903],
        ],
    };

    /// Of sonars and camera, where doors have markers.
    pub const MARKED: Matrix = Matrix {
        certainties: [
            [0.994, 0.006, 0.002, 0.002, 0.003],
            [0.003, 0.985, 0.006, 0.001, 0.001],
            [0.001, 0.006, 0.988, 0.002, 0.001],
            [0.001, 0.002, 0.003, 0.985, 0.045],
            [0.001, 0.001, 0.001, 0.010, 0.950],
        ],
    };

    /// DERVISH's (Siegwart and Nourbakhsh, Table 5.1).
    ///
    /// # Deviation
    /// DERVISH perceives no foyers: what our detection takes for one counts there as a hallway.
    pub const DERVISH: Matrix = Matrix {
        certainties: [
            [0.70, 0.40, 0.05, 0.001, 0.30],
            [0.30, 0.60, 0.0, 0.0, 0.05],
            [0.0, 0.0, 0.90, 0.10, 0.15],
            [0.0, 0.0, 0.001, 0.90, 0.50],
            [0.0, 0.0, 0.001, 0.90, 0.50],
        ],
    };

    /// From an experiment: `counts[percept][feature]`, the column of `Wall` by stretches between openings.
    /// To each feature as many further looks are added as `prior_looks` says, spread as `prior` has them, so
    /// that what was not seen in some hundred looks does not count as impossible.
    #[must_use]
    pub fn measured(counts: &[[u32; 5]; 5], prior: &Matrix, prior_looks: f64) -> Self {
        let mut certainties = [[0.0; 5]; 5];
        for feature in 0..5 {
            let looks: f64 = counts.iter().map(|row| f64::from(row[feature])).sum::<f64>() + prior_looks;
            for percept in 0..5 {
                let seen = f64::from(counts[percept][feature]) + prior_looks * prior.certainties[percept][feature];
                certainties[percept][feature] = if looks > 0.0 { seen / looks } else { 0.0 };
            }
        }
        Self { certainties }
    }

    /// C(percept | feature).
    pub fn certainty(&self, percept: Feature, feature: Feature) -> f64 {
        self.certainties[percept as usize][feature as usize]
    }

    /// C(nothing perceived | feature).
    pub fn missed(&self, feature: Feature) -> f64 {
        self.certainty(Feature::Wall, feature)
    }

    /// A percept of a feature, drawn by these certainties.
    pub fn draw(&self, feature: Feature, stream: &mut Stream) -> Feature {
        let sum: f64 = Feature::ALL.iter().map(|&percept| self.certainty(percept, feature)).sum();
        let mut left = stream.uniform() * sum;
        let is_it = |percept: &Feature| {
            left -= self.certainty(*percept, feature);
            left < 0.0
        };
        // Rounding may leave nothing.
        Feature::ALL.into_iter().find(is_it).unwrap_or(feature)
    }

    /// C(percept | one of these features, each as likely as the others): a mean, where Eq. (3) has a sum.
    ///
    /// # Deviation
    /// With sums a node of three features weighs three times a node of one, and certainty runs away from
    /// the goal, which is a node of one feature.
    pub fn mean(&self, percept: Feature, features: &[Feature]) -> f64 {
        let sum: f64 = features.iter().map(|&feature| self.certainty(percept, feature)).sum();
        sum / features.len().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_feature_is_perceived_as_something() {
        for matrix in [Matrix::SONAR, Matrix::MARKED] {
            for feature in Feature::ALL {
                let sum: f64 = Feature::ALL.iter().map(|&percept| matrix.certainty(percept, feature)).sum();
                assert!((sum - 1.0).abs() < 1e-9, "{feature:?}: {sum}");
            }
        }
    }

    #[test]
    fn a_measured_matrix_has_the_shares_of_its_counts() {
        let mut counts = [[0; 5]; 5];
        counts[Feature::Wall as usize][Feature::ClosedDoor as usize] = 10;
        counts[Feature::ClosedDoor as usize][Feature::ClosedDoor as usize] = 90;
        let measured = Matrix::measured(&counts, &Matrix::SONAR, 0.0);
        assert_eq!(measured.missed(Feature::ClosedDoor), 0.1);
        assert_eq!(measured.certainty(Feature::ClosedDoor, Feature::ClosedDoor), 0.9);
        let with_prior = Matrix::measured(&counts, &Matrix::SONAR, 1.0);
        assert!(with_prior.certainty(Feature::Hallway, Feature::ClosedDoor) > 0.0);
        let sum: f64 = Feature::ALL.iter().map(|&percept| with_prior.certainty(percept, Feature::ClosedDoor)).sum();
        assert!((sum - 1.0).abs() < 1e-9);
    }
}
