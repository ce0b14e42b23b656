//! What is expected of hallways, percepts and instructions before anything was seen.

use super::spots::Sighting;
use crate::feature::Feature;
use crate::state_set::{Matrix, USUAL_DISTANCE_M};
use serde::{Deserialize, Serialize};

/// What judgements start from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Expectation {
    /// How likely each percept is for each feature.
    pub matrix: Matrix,
    /// How likely one instruction is wrong.
    pub wrong: f64,
    /// How likely another look sees the same as the first, right or wrong, because there is a reason for it:
    /// a box before a door, a leaf flush with the wall.
    pub same_again: f64,
    /// Openings for each metre of a hallway's side.
    pub openings_per_m: f64,
}

/// Of the things beside a hallway, how many are of each kind, in the order of [`Feature::ALL`]; walls, of
/// which there is a stretch before each of them, have no share.
pub(super) const SHARES: [f64; 5] = [0.0, 0.33, 0.34, 0.28, 0.05];

/// How likely an opening that is partly hidden looks as narrow as one of the next kind: what is left of it may have
/// any width.
const LOOKS_NARROWER: f64 = 0.3;

impl Expectation {
    /// In an event in which one of two lists has an error, in one of two or three instructions that count.
    #[must_use]
    pub fn of_event(matrix: Matrix) -> Self {
        Self { matrix, wrong: 0.2, same_again: 0.5, openings_per_m: 1.0 / USUAL_DISTANCE_M }
    }

    /// How likely an instruction is wrong that asks for a feature where one look saw nothing (Bayes): else it was
    /// missed.
    #[must_use]
    pub fn wrong_if_unseen(&self, feature: Feature) -> f64 {
        let missed = (1.0 - self.wrong) * self.matrix.certainty(Feature::Wall, feature);
        self.wrong / (self.wrong + missed)
    }

    /// C(what all looks saw | feature). Each look after the first sees with the chance `same_again` what that saw, and
    /// else for itself; so a second look is worth less than a first one, for misses as for confusions. A look that did
    /// not come there says nothing.
    pub(super) fn certainty(&self, seen: &[Option<Sighting>], feature: Feature) -> f64 {
        let mut looks = seen.iter().flatten();
        let Some(&first) = looks.next() else { return 1.0 };
        let later = |&seen: &Sighting| {
            let again = if seen.kind == first.kind { self.same_again } else { 0.0 };
            again + (1.0 - self.same_again) * self.of_sighting(seen, feature)
        };
        self.of_sighting(first, feature) * looks.map(later).product::<f64>()
    }

    /// C(sighting | feature): an opening of which a part was hidden is of its kind, or of a wider one.
    fn of_sighting(&self, sighting: Sighting, feature: Feature) -> f64 {
        let wider = Feature::ALL.into_iter().filter(|&kind| sighting.is_partial && kind > sighting.kind);
        let hidden: f64 = wider.map(|kind| self.matrix.certainty(kind, feature)).sum();
        self.matrix.certainty(sighting.kind, feature) + LOOKS_NARROWER * hidden
    }
}
