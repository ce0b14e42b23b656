//! A robot that is driven along a map: how soon it knows where it is.

use super::both_sides::BothSides;
use super::localization::TopologicalLocalization;
use super::map::{State, TopologicalMap, Turn};
use super::plan::{Action, next_action};
use crate::feature::{Feature, Side};
use crate::state_set::Matrix;
use rpl_random::Stream;

/// How things stood after a percept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Where the robot was.
    pub truth: State,
    /// Where it most likely thought to be.
    pub believed: State,
    /// How certain it was of that.
    pub certainty: f64,
}

/// States that are less certain are not planned for.
const REMAINING: f64 = 0.05;

/// Drives along a map from a state drawn from the seed, which the robot does not know, until a number of percepts
/// have come; they are drawn from a matrix. At each node the robot does what tells the remaining states apart,
/// and turns where the hallway ends. Answers fewer steps only if the robot can go nowhere.
pub fn drive(map: &TopologicalMap, truth: &Matrix, matrix: &Matrix, seed: u64, percepts: usize) -> Vec<Step> {
    let mut stream = Stream::new(seed, "topological drive");
    let states: Vec<State> = map.states().collect();
    if states.is_empty() {
        return Vec::new();
    }
    let mut at = states[stream.index(states.len())];
    let mut localization = TopologicalLocalization::start(map);
    let mut steps = Vec::new();
    // Nodes of which nothing is perceived make no step.
    for _ in 0..percepts.saturating_mul(100) {
        if steps.len() == percepts {
            break;
        }
        let turned = turn(map, &localization, at, &mut stream);
        if let Some(turn) = turned {
            at = map.turned(at, turn).unwrap_or(at);
            localization.turn(map, turn);
        }
        let passed = map.ahead(at);
        let seen = seen(map, truth, passed, &mut stream);
        at = passed.unwrap_or(at);
        let is_perceived = seen.left != Feature::Wall || seen.right != Feature::Wall;
        if is_perceived {
            localization.perceive(map, matrix, seen);
        }
        if map.ahead(at).is_none() {
            localization.perceive_end(map, matrix);
        }
        if let (true, Some((believed, certainty))) = (is_perceived, localization.best(map)) {
            steps.push(Step { truth: at, believed, certainty });
        }
    }
    steps
}

/// How the robot turns before it goes on: as is planned for the states that remain, if that can be done where
/// it is; at the end of a hallway, wherever one leads on.
fn turn(map: &TopologicalMap, localization: &TopologicalLocalization, at: State, stream: &mut Stream) -> Option<Turn> {
    let planned = match next_action(map, &localization.remaining(map, REMAINING), None) {
        Some(Action::Turn(turn)) => Some(turn),
        Some(Action::GoOn) | None => None,
    };
    let possible: Vec<Turn> = Turn::ALL.into_iter().filter(|&turn| map.turned(at, turn).is_some()).collect();
    let is_possible = planned.is_some_and(|turn| possible.contains(&turn));
    match map.ahead(at) {
        _ if is_possible => planned,
        None if !possible.is_empty() => Some(possible[stream.index(possible.len())]),
        _ => None,
    }
}

/// What is perceived of the node that is passed.
fn seen(map: &TopologicalMap, truth: &Matrix, passed: Option<State>, stream: &mut Stream) -> BothSides {
    let mut on = |side| {
        let feature = passed.map_or(Feature::Wall, |state| map.feature(state, side));
        truth.draw(feature, stream)
    };
    BothSides { left: on(Side::Left), right: on(Side::Right) }
}
