//! The complete topological map of an arena.

use super::hallway::{Hallway, LeadsTo, SideFeature};
use super::interval::Millimetres;
use crate::arena::Arena;
use crate::feature::{Feature, Side};
use crate::topological::{Direction, Node, OPPOSITE_M, TopologicalMap};
use rpl_robot::world::Axis;
use std::collections::BTreeMap;

/// What is at one place of a hallway, on its left and right for who walks in the direction of its axis.
struct Place {
    at_mm: Millimetres,
    features: [Feature; 2],
    /// The hallway that crosses there, if one does.
    crosses: Option<usize>,
}

impl Arena {
    /// Its complete topological map: a node where there is something on a side, where hallways meet, and at blind
    /// ends. What is opposite each other is one node.
    pub fn topological_map(&self) -> TopologicalMap {
        let mut nodes: Vec<Node> = Vec::new();
        let mut edges = Vec::new();
        let mut crossings: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        for (index, hallway) in self.hallways.iter().enumerate() {
            let mut last = None;
            for place in places(hallway) {
                let crossing = place.crosses.map(|other| (index.min(other), index.max(other)));
                let known = crossing.and_then(|crossing| crossings.get(&crossing).copied());
                let node = known.unwrap_or_else(|| {
                    nodes.push(Node { features: [Feature::Wall; 4] });
                    nodes.len() - 1
                });
                crossings.extend(crossing.map(|crossing| (crossing, node)));
                let heading = direction(hallway.axis);
                for side in Side::ALL {
                    nodes[node].features[heading.side(side) as usize] = place.features[side as usize];
                }
                edges.extend(last.map(|last| (last, heading, node)));
                last = Some(node);
            }
        }
        match TopologicalMap::new(nodes, &edges) {
            Ok(map) => map,
            Err(fault) => unreachable!("hallways along two axes make a map: {fault}"),
        }
    }
}

fn direction(axis: Axis) -> Direction {
    match axis {
        Axis::X => Direction::East,
        Axis::Y => Direction::North,
    }
}

/// The places of a hallway in the direction of its axis, its blind ends included.
fn places(hallway: &Hallway) -> Vec<Place> {
    let on = |side| hallway.side(side).iter().map(move |found| (side, *found));
    let mut features: Vec<(Side, SideFeature)> = Side::ALL.into_iter().flat_map(on).collect();
    features.sort_by_key(|(side, found)| (found.middle_mm(), *side));
    let mut places: Vec<Place> = Vec::new();
    for (side, found) in features {
        let apart_m = |place: &Place| (found.middle_mm() - place.at_mm) as f64 / 1000.0;
        let opposite = places
            .last_mut()
            .filter(|place| place.features[side as usize] == Feature::Wall && apart_m(place) <= OPPOSITE_M);
        let crosses = match found.leads_to {
            LeadsTo::Hallway(other) => Some(other),
            LeadsTo::Room(_) => None,
        };
        match opposite {
            Some(place) => {
                place.features[side as usize] = found.feature;
                place.crosses = place.crosses.or(crosses);
            }
            None => {
                let mut features = [Feature::Wall; 2];
                features[side as usize] = found.feature;
                places.push(Place { at_mm: found.middle_mm(), features, crosses });
            }
        }
    }
    with_blind_ends(hallway, places)
}

/// A hallway ends where another meets it, or blind: there the last place is no crossing.
fn with_blind_ends(hallway: &Hallway, mut places: Vec<Place>) -> Vec<Place> {
    let blind = |at_mm| Place { at_mm, features: [Feature::Wall; 2], crosses: None };
    let (from_mm, to_mm) = hallway.along_mm;
    if places.first().is_none_or(|first| !first.is_at_end(hallway, from_mm)) {
        places.insert(0, blind(from_mm));
    }
    if places.last().is_none_or(|last| !last.is_at_end(hallway, to_mm)) {
        places.push(blind(to_mm));
    }
    places
}

impl Place {
    /// Whether it is a crossing at this end of the hallway.
    fn is_at_end(&self, hallway: &Hallway, end_mm: Millimetres) -> bool {
        let at_end = |found: &SideFeature| (found.from_mm..=found.to_mm).contains(&end_mm);
        self.crosses.is_some()
            && hallway
                .sides
                .iter()
                .flatten()
                .any(|found| found.feature == Feature::Hallway && found.middle_mm() == self.at_mm && at_end(found))
    }
}
