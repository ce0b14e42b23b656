//! What ways between places cannot be shorter than, from their ways to a few landmarks (Goldberg and Harrelson
//! 2005, "Computing the Shortest Path: A* Search Meets Graph Theory").

use super::place::{PlaceId, Stretch};
use super::shortest::lengths_from;

/// Landmarks: each halves about what the bound lacks, and costs a comparison.
const LANDMARKS: usize = 16;

/// The lengths of the ways from each place to each landmark.
#[derive(Clone, Debug, PartialEq)]
pub struct LowerBounds {
    /// `to_landmark_m[place][landmark]`; infinite where there is no way.
    to_landmark_m: Vec<[f64; LANDMARKS]>,
}

impl LowerBounds {
    /// With landmarks as far from each other as can be: each is the place farthest from those before it. Cost:
    /// a search over all places for each.
    pub(super) fn new(stretches: &[Vec<Stretch>]) -> Self {
        let mut to_landmark_m = vec![[f64::INFINITY; LANDMARKS]; stretches.len()];
        let mut nearest_m = vec![f64::INFINITY; stretches.len()];
        let mut landmark = 0;
        for number in 0..LANDMARKS {
            let lengths_m = lengths_from(stretches, PlaceId(landmark as u32));
            for ((bounds_m, nearest_m), length_m) in to_landmark_m.iter_mut().zip(&mut nearest_m).zip(lengths_m) {
                bounds_m[number] = length_m;
                *nearest_m = length_m.min(*nearest_m);
            }
            // A part without a landmark is farthest of all. The first of those at the same distance.
            landmark = (0..stretches.len())
                .rev()
                .max_by(|&one, &other| nearest_m[one].total_cmp(&nearest_m[other]))
                .unwrap_or(0);
        }
        Self { to_landmark_m }
    }

    /// What the way between two places cannot be shorter than; infinite if a landmark shows that there is
    /// none. O(1).
    pub fn between_m(&self, one: PlaceId, other: PlaceId) -> f64 {
        let (one, other) = (&self.to_landmark_m[one.index()], &self.to_landmark_m[other.index()]);
        let least_m = one.iter().zip(other).map(|(one_m, other_m)| match (one_m.is_finite(), other_m.is_finite()) {
            (true, true) => (one_m - other_m).abs(),
            (false, false) => 0.0,
            _ => f64::INFINITY,
        });
        least_m.fold(0.0, f64::max)
    }
}
