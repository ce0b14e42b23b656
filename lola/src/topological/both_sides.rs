//! What is perceived on both sides of a place.

use crate::feature::{Feature, Percept, Side};
use serde::{Deserialize, Serialize};

/// One percept of both sides; a wall is nothing perceived.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BothSides {
    /// On the left.
    pub left: Feature,
    /// On the right.
    pub right: Feature,
}

/// What is opposite each other is one place: middles no farther apart along the hallway than this.
pub const OPPOSITE_M: f64 = 1.0;

/// Percepts of both sides joined, in order along the hallway. Cost: n log n.
pub fn both_sides(percepts: &[Percept]) -> Vec<BothSides> {
    let mut sorted: Vec<&Percept> = percepts.iter().collect();
    sorted.sort_by(|a, b| a.middle_m().total_cmp(&b.middle_m()));
    let mut joined = Vec::new();
    let mut waiting: Option<&Percept> = None;
    for percept in sorted {
        match waiting.take() {
            Some(other) if other.side != percept.side && percept.middle_m() - other.middle_m() <= OPPOSITE_M => {
                joined.push(BothSides::of(&[other, percept]));
            }
            other => {
                joined.extend(other.map(|other| BothSides::of(&[other])));
                waiting = Some(percept);
            }
        }
    }
    joined.extend(waiting.map(|percept| BothSides::of(&[percept])));
    joined
}

impl BothSides {
    fn of(percepts: &[&Percept]) -> Self {
        let on = |side| percepts.iter().find(|percept| percept.side == side).map_or(Feature::Wall, |of| of.seen);
        Self { left: on(Side::Left), right: on(Side::Right) }
    }
}
