//! Where to go when more than one state remains.

use super::both_sides::BothSides;
use super::map::{State, TopologicalMap, Turn};
use crate::feature::Side;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeSet, VecDeque};

/// What a robot does at a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Action {
    /// Drives on to the next node.
    GoOn,
    /// Turns, to go on along another hallway.
    Turn(Turn),
}

impl Action {
    const ALL: [Action; 4] =
        [Action::GoOn, Action::Turn(Turn::Left), Action::Turn(Turn::Right), Action::Turn(Turn::Around)];
}

/// States that are kept apart; with more of them, the least certain are not planned for.
const MOST_STATES: usize = 6;

/// Sets of states that are looked at.
const MOST_LOOKED_AT: usize = 5_000;

/// The first action on the shortest way that takes every remaining state, the likeliest first, to the goal;
/// if there is none, on the shortest way after which two of them perceive different things. Each action on
/// such a way is possible from all states, whichever is the true one. None if there is neither, or if all are
/// at the goal. Cost: bounded.
pub fn next_action(map: &TopologicalMap, remaining: &[State], goal: Option<usize>) -> Option<Action> {
    let states = &remaining[..remaining.len().min(MOST_STATES)];
    let is_there = |states: &[State]| goal.is_some_and(|goal| states.iter().all(|state| state.node == goal));
    if states.is_empty() || is_there(states) {
        return None;
    }
    let to_goal =
        goal.and_then(|_| search(map, states, |before, after| after.len() == before.len() && is_there(after)));
    to_goal.or_else(|| search(map, states, |before, after| after.len() < before.len() || differ(map, after)))
}

/// Breadth first over sets of states; answers the first action of the first way on which some step is wanted.
fn search(map: &TopologicalMap, states: &[State], wanted: impl Fn(&[State], &[State]) -> bool) -> Option<Action> {
    let mut known = BTreeSet::from([states.to_vec()]);
    let mut open: VecDeque<(Vec<State>, Option<Action>)> = VecDeque::from([(states.to_vec(), None)]);
    while let Some((before, first)) = open.pop_front() {
        for action in Action::ALL {
            let after = after(map, &before, action);
            let possible_for_all = after.len() == before.len();
            let is_told_apart = action == Action::GoOn && !after.is_empty();
            if (possible_for_all || is_told_apart) && wanted(&before, &after) {
                return first.or(Some(action));
            }
            if possible_for_all && known.len() < MOST_LOOKED_AT && known.insert(after.clone()) {
                open.push_back((after, first.or(Some(action))));
            }
        }
    }
    None
}

/// The states after an action, without those from which it is not possible.
fn after(map: &TopologicalMap, states: &[State], action: Action) -> Vec<State> {
    let of_state = |&state: &State| match action {
        Action::GoOn => map.ahead(state),
        Action::Turn(turn) => map.turned(state, turn),
    };
    states.iter().filter_map(of_state).collect()
}

/// Whether what is perceived tells two of the states apart.
fn differ(map: &TopologicalMap, states: &[State]) -> bool {
    let expected =
        |state: State| BothSides { left: map.feature(state, Side::Left), right: map.feature(state, Side::Right) };
    states.windows(2).any(|two| expected(two[0]) != expected(two[1]))
}
