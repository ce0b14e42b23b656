//! State-set progression over the states of a map.

use super::both_sides::BothSides;
use super::map::{State, TopologicalMap, Turn};
use crate::feature::{Feature, Side};
use crate::state_set::Matrix;
use serde::{Deserialize, Serialize};

/// How certain each state is. A plain value; the certainties sum to 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TopologicalLocalization {
    /// `certainties[4 · node + heading]`.
    certainties: Vec<f64>,
}

/// More nodes in a row are not missed: the chance of it is nothing beside that of any other explanation.
const MOST_MISSED: usize = 6;

/// Ends of hallways that are none, and turns into what is no hallway: so rare, but not impossible, so that a
/// state set that was led astray comes back.
const RARE: f64 = 0.01;

impl TopologicalLocalization {
    /// Anywhere.
    #[must_use]
    pub fn start(map: &TopologicalMap) -> Self {
        let mut certainties = vec![0.0; 4 * map.nodes.len()];
        map.states().for_each(|state| certainties[place(state)] = 1.0);
        Self { certainties }.normalised()
    }

    /// How certain a state is.
    pub fn certainty(&self, state: State) -> f64 {
        self.certainties[place(state)]
    }

    /// The likeliest state and its certainty; the first of equals. None on a map without hallways.
    pub fn best(&self, map: &TopologicalMap) -> Option<(State, f64)> {
        let certain = map.states().map(|state| (state, self.certainty(state)));
        certain.reduce(|best, other| if other.1 > best.1 { other } else { best })
    }

    /// States of at least this certainty, the likeliest first.
    pub fn remaining(&self, map: &TopologicalMap, least: f64) -> Vec<State> {
        let mut states: Vec<State> = map.states().filter(|&state| self.certainty(state) >= least).collect();
        states.sort_by(|&a, &b| self.certainty(b).total_cmp(&self.certainty(a)));
        states
    }

    /// Eqs. (1) and (2) on the edges of the map, for a percept while driving on. Cost: linear in the states.
    ///
    /// # Deviation
    /// A state may stay, when walls were perceived as something.
    pub fn perceive(&mut self, map: &TopologicalMap, matrix: &Matrix, seen: BothSides) {
        let walls = matrix.certainty(seen.left, Feature::Wall) * matrix.certainty(seen.right, Feature::Wall);
        let nothing = BothSides { left: Feature::Wall, right: Feature::Wall };
        self.progress(map, |state, certainty, progressed| {
            progressed[place(state)] += certainty * walls;
            let mut reaching = certainty;
            for passed in ahead(map, state) {
                progressed[place(passed)] += reaching * likelihood(map, matrix, passed, seen);
                reaching *= likelihood(map, matrix, passed, nothing);
            }
        });
    }

    /// The end of the hallway was reached.
    pub fn perceive_end(&mut self, map: &TopologicalMap, matrix: &Matrix) {
        let nothing = BothSides { left: Feature::Wall, right: Feature::Wall };
        self.progress(map, |state, certainty, progressed| {
            let (mut at, mut reaching) = (state, certainty);
            for passed in ahead(map, state) {
                reaching *= likelihood(map, matrix, passed, nothing);
                at = passed;
            }
            let is_end = map.ahead(at).is_none();
            progressed[place(if is_end { at } else { state })] += if is_end { reaching } else { certainty * RARE };
        });
    }

    /// The robot has turned, and goes on along the hallway that leads there.
    pub fn turn(&mut self, map: &TopologicalMap, turn: Turn) {
        self.progress(map, |state, certainty, progressed| match map.turned(state, turn) {
            Some(turned) => progressed[place(turned)] += certainty,
            None => progressed[place(state)] += certainty * RARE,
        });
    }

    fn progress(&mut self, map: &TopologicalMap, mut each: impl FnMut(State, f64, &mut [f64])) {
        let mut progressed = vec![0.0; self.certainties.len()];
        for state in map.states() {
            let certainty = self.certainty(state);
            if certainty > 0.0 {
                each(state, certainty, &mut progressed);
            }
        }
        *self = Self { certainties: progressed }.normalised_or(self);
    }

    fn normalised(mut self) -> Self {
        let sum: f64 = self.certainties.iter().sum();
        if sum > 0.0 {
            self.certainties.iter_mut().for_each(|certainty| *certainty /= sum);
        }
        self
    }

    /// What no state explains changes nothing.
    fn normalised_or(self, before: &Self) -> Self {
        if self.certainties.iter().sum::<f64>() > 0.0 { self.normalised() } else { before.clone() }
    }
}

fn place(state: State) -> usize {
    4 * state.node + state.heading as usize
}

/// The states one comes to driving on, the nearest first.
fn ahead(map: &TopologicalMap, state: State) -> impl Iterator<Item = State> + '_ {
    std::iter::successors(map.ahead(state), |&passed| map.ahead(passed)).take(MOST_MISSED + 1)
}

fn likelihood(map: &TopologicalMap, matrix: &Matrix, passed: State, seen: BothSides) -> f64 {
    matrix.certainty(seen.left, map.feature(passed, Side::Left))
        * matrix.certainty(seen.right, map.feature(passed, Side::Right))
}
