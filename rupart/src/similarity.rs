//! How similar two situations are: a weighted sum of distances, one for each feature.

use crate::case::Kind;
use crate::situation::{Feature, Situation, Value};
use rpl_robot::geometry::{distance_m, wrap_angle_rad};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// What each feature's distance counts, in the order of [`Feature::ALL`].
pub type Weights = [f64; Feature::COUNT];

/// How a feature is compared with that of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Comparison {
    /// By its distance; in full if it is missing on one side, not if on both.
    Distance,
    /// Only by whether it is missing on one side.
    Presence,
    /// Not: the kind of case is not indexed by it.
    Foreign,
}

/// Differences that count as 1; greater ones do not count more.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scales {
    /// Between places: the diagonal of the building.
    pub location_m: f64,
    /// Between ranges, which are taken for this if they are greater: the range of the sonars.
    pub sonar_m: f64,
    /// Between speeds ahead.
    pub translation_mps: f64,
    /// Between speeds of turning.
    pub rotation_radps: f64,
    /// Between distances to the short-term goal.
    pub goal_distance_m: f64,
    /// Between times.
    pub time_s: f64,
}

impl Default for Scales {
    /// Those of a Pioneer 2 DX in a building of a hundred metres.
    fn default() -> Self {
        Self {
            location_m: 100.0,
            sonar_m: 5.0,
            translation_mps: 1.0,
            rotation_radps: 2.0,
            goal_distance_m: 15.0,
            time_s: 3600.0,
        }
    }
}

/// How cases are compared with a situation.
///
/// # Deviation
/// The paper leaves open what a missing feature counts. Counted in full, and with features that a kind is not
/// indexed by left out, the kind that comes back is the one that is needed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Similarity {
    /// What each feature's distance counts.
    pub weights: Weights,
    /// What is as different as can be.
    pub scales: Scales,
    /// For each kind, in the order of [`Kind::ALL`], how each feature is compared.
    pub comparisons: [[Comparison; Feature::COUNT]; Kind::ALL.len()],
    /// What each feature counts that is missing on one side.
    pub missing: Weights,
}

impl Similarity {
    /// Every feature counts 1.
    pub const UNIT_WEIGHTS: Weights = [1.0; Feature::COUNT];

    /// A feature that only one side has costs so much that the presence of a short-term goal, a long-term goal and a
    /// place decides the kind: each of these, in this order, counts more than all that come after it together.
    pub const CERTAIN: Weights = [1.0, 1.0, 1.0, 1.0, 4.0, 32.0, 8.0, 1.0, 1.0, 1.0, 1.0];

    /// Places do not count for how to drive: absolute positions in behaviour cases make retrieval worse.
    /// There the short-term goal is seen from the robot, and only whether there is one counts besides. Nor
    /// does what the robot senses count for where to go.
    pub const COMPARISONS: [[Comparison; Feature::COUNT]; Kind::ALL.len()] = {
        use Comparison::{Distance as D, Foreign as F, Presence as P};
        [
            [D, D, D, D, F, P, F, D, D, F, F],
            [F, F, F, F, D, D, D, P, P, F, F],
            [F, F, F, F, D, P, P, P, P, D, D],
            [F, F, F, F, D, P, D, D, D, F, F],
        ]
    };

    /// With these scales: every distance counts 1, and what is missing makes the kind certain.
    pub fn new(scales: Scales) -> Self {
        Self { weights: Self::UNIT_WEIGHTS, scales, comparisons: Self::COMPARISONS, missing: Self::CERTAIN }
    }

    /// How a feature of a kind is compared.
    pub fn comparison(&self, kind: Kind, feature: Feature) -> Comparison {
        self.comparisons[kind as usize][feature as usize]
    }

    /// What each feature adds to the distance of a case, weighted.
    pub fn contributions(&self, asked: &Situation, kind: Kind, index: &Situation) -> [f64; Feature::COUNT] {
        Feature::ALL.map(|feature| match self.distance_of(feature, asked, kind, index) {
            Some(distance) => self.weights[feature as usize] * distance,
            None => self.missing[feature as usize],
        })
    }

    /// The distance of a case: its contributions, summed in the order of the features.
    pub fn distance(&self, asked: &Situation, kind: Kind, index: &Situation) -> f64 {
        self.contributions(asked, kind, index).iter().sum()
    }

    /// The distance by one feature, 0 to 1; none if it is missing on one side, as sonars of another ring are.
    fn distance_of(&self, feature: Feature, asked: &Situation, kind: Kind, index: &Situation) -> Option<f64> {
        let values = (asked.value(feature), index.value(feature));
        match (self.comparison(kind, feature), values) {
            (Comparison::Foreign, _) | (_, (Value::Missing, Value::Missing)) => Some(0.0),
            (_, (Value::Missing, _) | (_, Value::Missing)) => None,
            (Comparison::Presence, _) => Some(0.0),
            (Comparison::Distance, (Value::Ranges(one), Value::Ranges(other))) => {
                (one.len() == other.len()).then(|| self.of_ranges(one, other))
            }
            (Comparison::Distance, (Value::Point(one), Value::Point(other))) => {
                Some((distance_m(one, other) / self.scales.location_m).min(1.0))
            }
            (Comparison::Distance, (Value::Number(one), Value::Number(other))) => {
                Some(self.of_numbers(feature, one, other))
            }
            (Comparison::Distance, _) => None,
        }
    }

    /// The mean of the differences, each range taken for the scale if it is greater.
    fn of_ranges(&self, one_m: &[f64], other_m: &[f64]) -> f64 {
        let most_m = self.scales.sonar_m;
        let differences_m = one_m.iter().zip(other_m).map(|(one, other)| (one.min(most_m) - other.min(most_m)).abs());
        differences_m.sum::<f64>() / (one_m.len() as f64 * most_m)
    }

    fn of_numbers(&self, feature: Feature, one: f64, other: f64) -> f64 {
        let difference = match feature {
            Feature::ShortTermGoalBearing => wrap_angle_rad(one - other),
            _ => one - other,
        };
        (difference.abs() / self.scales.of_number(feature)).min(1.0)
    }
}

impl Scales {
    /// The difference that counts as 1 for a feature that is a number.
    pub(crate) fn of_number(&self, feature: Feature) -> f64 {
        match feature {
            Feature::Translation => self.translation_mps,
            Feature::Rotation => self.rotation_radps,
            Feature::ShortTermGoalDistance => self.goal_distance_m,
            Feature::ShortTermGoalBearing => PI,
            Feature::Priority => 1.0,
            Feature::Time => self.time_s,
            Feature::Sonars | Feature::MeanSonars => self.sonar_m,
            Feature::Place | Feature::ShortTermGoal | Feature::LongTermGoal => self.location_m,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_robot::geometry::Point;

    fn similarity() -> Similarity {
        Similarity { missing: Similarity::UNIT_WEIGHTS, ..Similarity::new(Scales::default()) }
    }

    #[test]
    fn missing_on_one_side_counts_in_full_and_on_both_nothing() {
        let at = |place: Option<Point>| Situation { place_in_map: place, ..Situation::default() };
        let (here, nowhere) = (at(Some(Point::new(3.0, 4.0))), at(None));
        let similarity = similarity();
        assert_eq!(similarity.distance(&here, Kind::Route, &nowhere), 1.0);
        assert_eq!(similarity.distance(&nowhere, Kind::Route, &here), 1.0);
        assert_eq!(similarity.distance(&nowhere, Kind::Route, &nowhere), 0.0);
        assert_eq!(similarity.distance(&here, Kind::Behaviour, &nowhere), 0.0, "foreign to behaviours");
        let ignoring = Similarity { missing: [0.0; Feature::COUNT], ..similarity };
        assert_eq!(ignoring.distance(&here, Kind::Route, &nowhere), 0.0);
    }

    #[test]
    fn each_distance_is_scaled_and_no_greater_than_one() {
        let similarity = similarity();
        let origin = Situation::of_route(Point::origin(), Point::origin());
        let ten_metres_off = Situation::of_route(Point::new(6.0, 8.0), Point::new(1e6, 0.0));
        assert_eq!(similarity.distance(&origin, Kind::Route, &ten_metres_off), 0.1 + 1.0);
        let hears = |ranges_m: &[f64]| Situation { sonars_m: Some(ranges_m.to_vec()), ..Situation::default() };
        let distance = |one: &[f64], other: &[f64]| similarity.distance(&hears(one), Kind::Behaviour, &hears(other));
        assert_eq!(distance(&[0.0, 2.0], &[5.0, 2.0]), 0.5);
        assert_eq!(distance(&[9.0], &[5.0]), 0.0, "beyond the range of the sonars");
        assert_eq!(distance(&[1.0], &[1.0, 1.0]), 1.0, "another ring");
    }

    #[test]
    fn bearings_are_compared_around_the_circle() {
        let bears =
            |bearing_rad: f64| Situation { short_term_goal_bearing_rad: Some(bearing_rad), ..Situation::default() };
        let distance = similarity().distance(&bears(3.0), Kind::Behaviour, &bears(-3.0));
        assert!((distance - (2.0 * PI - 6.0) / PI).abs() < 1e-12);
    }

    #[test]
    fn what_is_missing_outweighs_all_that_may_differ() {
        let counts = |feature: Feature| Similarity::CERTAIN[feature as usize];
        let of_others = |decided: &[Feature]| -> f64 {
            Feature::ALL.into_iter().filter(|feature| !decided.contains(feature)).map(counts).sum()
        };
        assert!(counts(Feature::ShortTermGoal) > of_others(&[Feature::ShortTermGoal]));
        // Without a short-term goal neither routes nor goals are compared by what the robot senses.
        assert!(counts(Feature::LongTermGoal) > counts(Feature::Place) + 3.0);
        assert!(counts(Feature::Place) > 3.0);
    }
}
