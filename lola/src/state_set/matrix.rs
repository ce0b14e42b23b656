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
    /// Of the sonars alone, measured in hallways of arenas driven along and back, one half of them calm, the other
    /// with boxes and six people; of doors that nothing hid, for what is hidden is told to the state set by itself.
    pub const SONAR: Matrix = Matrix {
        certainties: [
            [0.995, 0.004, 0.025, 0.010, 0.012],
            [0.002, 0.990, 0.007, 0.001, 0.001],
            [0.001, 0.004, 0.966, 0.003, 0.001],
            [0.001, 0.001, 0.001, 0.980, 0.006],
            [0.001, 0.001, 0.001, 0.006, 0.980],
        ],
    };

    /// Of sonars and camera, where doors have markers: measured in the same way, in 60 calm and 60 crowded drives
    /// past 2,718 features; each count is raised by a half, and nothing is less likely than one in a thousand.
    pub const MARKED: Matrix = Matrix {
        certainties: [
            [0.996, 0.010, 0.006, 0.005, 0.005],
            [0.001, 0.984, 0.006, 0.001, 0.005],
            [0.001, 0.003, 0.986, 0.005, 0.005],
            [0.001, 0.001, 0.001, 0.985, 0.005],
            [0.001, 0.002, 0.001, 0.004, 0.980],
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

    /// From the rows of an experiment, `rows[feature][percept]` (see
    /// [`Confusion::certainties`](crate::features::score::Confusion::certainties)).
    #[must_use]
    pub fn measured(rows: &[[f64; 5]; 5]) -> Self {
        let mut certainties = [[0.0; 5]; 5];
        for (feature, row) in rows.iter().enumerate() {
            for (percept, certainty) in row.iter().enumerate() {
                certainties[percept][feature] = *certainty;
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
    use crate::features::score::Confusion;

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
        let mut confusion = Confusion { driven_m: 100.0, ..Confusion::default() };
        confusion.taken[Feature::ClosedDoor as usize][Feature::Wall as usize] = 10;
        confusion.taken[Feature::ClosedDoor as usize][Feature::ClosedDoor as usize] = 90;
        confusion.false_alarms[Feature::OpenDoor as usize] = 1;
        let measured = Matrix::measured(&confusion.certainties(0.0, 4.0));
        assert_eq!(measured.missed(Feature::ClosedDoor), 0.1);
        assert_eq!(measured.certainty(Feature::ClosedDoor, Feature::ClosedDoor), 0.9);
        assert_eq!(measured.certainty(Feature::OpenDoor, Feature::Wall), 0.02);
    }
}
