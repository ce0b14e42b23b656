//! Shortest ways over places: Dijkstra's algorithm, informed by lower bounds (Hart, Nilsson and Raphael 1968).

use super::place::{PlaceId, Stretch};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A way over places, and the work of finding it.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// From the first to the last, both among them.
    pub places: Vec<PlaceId>,
    /// In the unit that stretches were counted in.
    pub cost: f64,
    /// Places whose stretches were looked at.
    pub expanded: usize,
}

/// The cheapest way between two places over `stretches[place]`. None if there is none. `cost` is what a stretch costs, and `least` what
/// a way between two places costs at least, 0 from a place to itself; where it is too much, the way may not be
/// the cheapest. Cost: stretches times the logarithm of places.
pub fn shortest_way(
    stretches: &[Vec<Stretch>],
    from: PlaceId,
    to: PlaceId,
    cost: impl Fn(PlaceId, &Stretch) -> f64,
    least: impl Fn(PlaceId, PlaceId) -> f64,
) -> Option<Way> {
    let mut search = Search::new(stretches.len(), from);
    let mut expanded = 0;
    while let Some(place) = search.next() {
        if place == to {
            return Some(Way { places: search.way_to(to), cost: search.costs[to.index()], expanded });
        }
        expanded += 1;
        for stretch in &stretches[place.index()] {
            search.reach(place, stretch.to, cost(place, stretch), least(stretch.to, to));
        }
    }
    None
}

/// The lengths of the shortest ways from a place to all; infinite where there is none.
pub(super) fn lengths_from(stretches: &[Vec<Stretch>], from: PlaceId) -> Vec<f64> {
    let mut search = Search::new(stretches.len(), from);
    while let Some(place) = search.next() {
        stretches[place.index()].iter().for_each(|stretch| search.reach(place, stretch.to, stretch.length_m, 0.0));
    }
    search.costs
}

/// How far a search has got.
struct Search {
    costs: Vec<f64>,
    before: Vec<Option<PlaceId>>,
    /// By estimate and place; costs are not negative, so that their bits have their order.
    open: BinaryHeap<Reverse<(u64, u32)>>,
    closed: Vec<bool>,
}

impl Search {
    fn new(count: usize, from: PlaceId) -> Self {
        let mut costs = vec![f64::INFINITY; count];
        costs[from.index()] = 0.0;
        let open = BinaryHeap::from([Reverse((0, from.0))]);
        Self { costs, before: vec![None; count], open, closed: vec![false; count] }
    }

    fn next(&mut self) -> Option<PlaceId> {
        loop {
            let Reverse((_, place)) = self.open.pop()?;
            if !std::mem::replace(&mut self.closed[place as usize], true) {
                return Some(PlaceId(place));
            }
        }
    }

    fn reach(&mut self, from: PlaceId, to: PlaceId, cost: f64, least_to_go: f64) {
        let reached = self.costs[from.index()] + cost;
        if reached < self.costs[to.index()] && !self.closed[to.index()] && least_to_go.is_finite() {
            self.costs[to.index()] = reached;
            self.before[to.index()] = Some(from);
            self.open.push(Reverse(((reached + least_to_go).to_bits(), to.0)));
        }
    }

    fn way_to(&self, to: PlaceId) -> Vec<PlaceId> {
        let mut places: Vec<PlaceId> = std::iter::successors(Some(to), |place| self.before[place.index()]).collect();
        places.reverse();
        places
    }
}
