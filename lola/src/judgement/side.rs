//! What stands along one side of a hallway, given all looks: the openings there are, aligned in all ways with
//! what was seen.

use super::expectation::{Expectation, SHARES};
use super::spots::{Look, Sighting, Spot, spots};
use crate::feature::{Feature, Percept, Side};

/// Which opening is the nth on a side, over all ways in which openings can have been seen, missed, or
/// imagined. All masses together sum to 1.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Nth {
    /// That it is of a kind, by [`Feature::OPENINGS`].
    pub kinds: [f64; 3],
    /// That the hallway ends before it.
    pub none: f64,
    /// That it is still ahead, where no look has come.
    pub ahead: f64,
    /// That it is at a spot, and of a kind there; what is left of `kinds` was missed.
    pub spots: Vec<(Percept, [f64; 3])>,
}

impl Nth {
    /// That it is of a kind.
    pub fn of_kind(&self, kind: Feature) -> f64 {
        by_kind(&self.kinds, kind)
    }

    /// Where it most likely is, if it is of a kind and was seen, and how likely that is.
    pub fn at(&self, kind: Feature) -> Option<(Percept, f64)> {
        let likely = self.spots.iter().map(|(percept, kinds)| (*percept, by_kind(kinds, kind)));
        likely.reduce(|best, other| if other.1 > best.1 { other } else { best })
    }

    /// What it most likely is, if there is one.
    pub fn likeliest_kind(&self) -> Feature {
        let more = |best: Feature, other: Feature| if self.of_kind(other) > self.of_kind(best) { other } else { best };
        Feature::OPENINGS.into_iter().fold(Feature::OPENINGS[0], more)
    }

    /// That there is one.
    pub fn some(&self) -> f64 {
        self.kinds.iter().sum()
    }
}

fn by_kind(kinds: &[f64; 3], kind: Feature) -> f64 {
    Feature::OPENINGS.iter().zip(kinds).find(|(opening, _)| **opening == kind).map_or(0.0, |(_, mass)| *mass)
}

/// A side of a hallway with what is known of it.
pub(super) struct SideOfHallway<'a> {
    expectation: &'a Expectation,
    looks: &'a [Look],
    end_m: Option<f64>,
    side: Side,
    pub spots: Vec<Spot>,
}

impl<'a> SideOfHallway<'a> {
    /// `end_m` is where the hallway ends, if that is known.
    pub fn new(expectation: &'a Expectation, looks: &'a [Look], end_m: Option<f64>, side: Side) -> Self {
        Self { expectation, looks, end_m, side, spots: spots(looks, side) }
    }

    /// Which opening is the nth, counted from 1. Cost: spots times the square of the ordinal.
    pub fn nth(&self, ordinal: usize) -> Nth {
        let mut alignment = Alignment::start(ordinal);
        let mut from_m = self.begin_m();
        for spot in &self.spots {
            alignment.miss(&self.missed_between(from_m, spot.percept.from_m));
            alignment.see(spot, &self.weights(spot));
            from_m = spot.percept.to_m;
        }
        alignment.miss(&self.missed_between(from_m, self.known_to_m()));
        alignment.end(self.end_m.is_some())
    }

    /// The same before anything was seen, for a side of this length.
    pub fn nth_unseen(&self, ordinal: usize) -> Nth {
        let openings = self.expectation.openings_per_m * (self.known_to_m() - self.begin_m()).max(0.0);
        let mut alignment = Alignment::start(ordinal);
        alignment.miss(&Feature::OPENINGS.map(|kind| openings * SHARES[kind as usize]));
        alignment.end(self.end_m.is_some())
    }

    /// How likely a spot is of each kind, by itself; in the order of [`Feature::ALL`].
    pub fn weights(&self, spot: &Spot) -> [f64; 5] {
        Feature::ALL.map(|feature| {
            // A false alarm for each stretch of wall; there are as many as openings.
            let share = if feature == Feature::Wall { 1.0 } else { SHARES[feature as usize] };
            share * self.expectation.certainty(&spot.seen, feature)
        })
    }

    fn begin_m(&self) -> f64 {
        self.looks.iter().map(|look| look.from_m).reduce(f64::min).unwrap_or(0.0)
    }

    /// The end of the hallway, or of what was seen of it.
    fn known_to_m(&self) -> f64 {
        self.end_m.unwrap_or_else(|| self.looks.iter().map(|look| look.to_m).fold(self.begin_m(), f64::max))
    }

    /// How many openings of each kind are to be expected in a part where nothing was seen.
    fn missed_between(&self, from_m: f64, to_m: f64) -> [f64; 3] {
        // Where looks begin and end, and where something stands, the number of looks changes.
        let of_look = |look: &'a Look| {
            let hidden = look.hidden_on(self.side).flat_map(|wall| [wall.from_m, wall.to_m]);
            [look.from_m, look.to_m].into_iter().chain(hidden)
        };
        let bounds = self.looks.iter().flat_map(of_look);
        let mut places: Vec<f64> = bounds.filter(|&at_m| from_m < at_m && at_m < to_m).collect();
        places.extend([from_m, to_m]);
        places.sort_by(f64::total_cmp);
        let mut expected = [0.0; 3];
        for part in places.windows(2) {
            let middle_m = (part[0] + part[1]) / 2.0;
            let openings = self.expectation.openings_per_m * (part[1] - part[0]).max(0.0);
            for (expected, kind) in expected.iter_mut().zip(Feature::OPENINGS) {
                let shown = |look: &Look| look.shows(kind, self.side, middle_m).then_some(Sighting::NOTHING);
                let nothing: Vec<_> = self.looks.iter().map(shown).collect();
                *expected += openings * SHARES[kind as usize] * self.expectation.certainty(&nothing, kind);
            }
        }
        expected
    }
}

/// The sums over all alignments up to a place.
struct Alignment {
    /// For each number of openings, that as many came before.
    counts: Vec<f64>,
    /// That the wanted one has come: of each kind, missed, or at each spot so far.
    unseen: [f64; 3],
    seen: Vec<(Percept, [f64; 3])>,
}

impl Alignment {
    fn start(ordinal: usize) -> Self {
        let mut counts = vec![0.0; ordinal.max(1)];
        counts[0] = 1.0;
        Self { counts, unseen: [0.0; 3], seen: Vec::new() }
    }

    /// Goes on along a part with the expected number of unseen openings of each kind; their number has a
    /// Poisson distribution, because openings that are missed thin those that are there.
    fn miss(&mut self, expected: &[f64; 3]) {
        let mean: f64 = expected.iter().sum();
        if mean <= 0.0 {
            return;
        }
        let earlier = std::mem::take(&mut self.counts);
        let none = libm::exp(-mean);
        self.counts = vec![0.0; earlier.len()];
        for (count, certainty) in earlier.iter().enumerate() {
            let mut chance = none;
            let mut left = 1.0;
            for missed in 0..earlier.len() - count {
                self.counts[count + missed] += certainty * chance;
                left -= chance;
                chance *= mean / (missed + 1) as f64;
            }
            for (unseen, expected) in self.unseen.iter_mut().zip(expected) {
                *unseen += certainty * left.max(0.0) * expected / mean;
            }
        }
    }

    /// Goes past a spot.
    fn see(&mut self, spot: &Spot, weights: &[f64; 5]) {
        let uncounted = weights[Feature::Wall as usize] + weights[Feature::Foyer as usize];
        let kinds = Feature::OPENINGS.map(|kind| weights[kind as usize]);
        let counted: f64 = kinds.iter().sum();
        let before = *self.counts.last().unwrap_or(&0.0);
        for count in (0..self.counts.len()).rev() {
            let arriving = if count == 0 { 0.0 } else { self.counts[count - 1] * counted };
            self.counts[count] = self.counts[count] * uncounted + arriving;
        }
        let passed = |certainty: &mut f64| *certainty *= uncounted + counted;
        self.unseen.iter_mut().for_each(passed);
        self.seen.iter_mut().flat_map(|(_, kinds)| kinds).for_each(passed);
        self.seen.push((spot.percept, kinds.map(|kind| kind * before)));
        self.normalise();
    }

    fn normalise(&mut self) {
        let seen = self.seen.iter_mut().flat_map(|(_, kinds)| kinds);
        let all = self.counts.iter_mut().chain(&mut self.unseen).chain(seen);
        let mut masses: Vec<&mut f64> = all.collect();
        let sum: f64 = masses.iter().map(|mass| **mass).sum();
        if sum > 0.0 {
            masses.iter_mut().for_each(|mass| **mass /= sum);
        }
    }

    fn end(mut self, at_end: bool) -> Nth {
        self.normalise();
        let before: f64 = self.counts.iter().sum();
        let (none, ahead) = if at_end { (before, 0.0) } else { (0.0, before) };
        let mut kinds = self.unseen;
        for (_, of_spot) in &self.seen {
            kinds.iter_mut().zip(of_spot).for_each(|(sum, kind)| *sum += kind);
        }
        Nth { kinds, none, ahead, spots: self.seen }
    }
}
