//! Requests of concurrent parts that can wait for each other.

use super::request::{SeenValve, ValveConflict, ValveRequest};
use crate::check::known::Check;
use crate::compile::ir::ConstructIr;
use std::cmp::Ordering;
use std::collections::BTreeSet;

/// Pairs of requests of two tasks that can wait for each other. What is held below `base` is held
/// by the task around both, which lends it. Of a valve with more places each of the two can have one.
pub(super) fn conflicts_between<'r>(
    check: &'r Check<'_>,
    first: &'r [ValveRequest],
    second: &'r [ValveRequest],
    base: usize,
) -> impl Iterator<Item = ValveConflict> + 'r {
    first.iter().flat_map(move |one| {
        second
            .iter()
            .filter(move |other| can_wait_for_each_other(check, one, other, base))
            .map(|other| ValveConflict { first: one.clone(), second: other.clone() })
    })
}

fn can_wait_for_each_other(check: &Check<'_>, one: &ValveRequest, other: &ValveRequest, base: usize) -> bool {
    let (Some(held), Some(other_held)) = (one.held.get(base..), other.held.get(base..)) else { return false };
    let is_exclusive = |valve: SeenValve| match valve {
        SeenValve::Global(global) => check.is_exclusive(global),
        SeenValve::Parameter(_) => true,
    };
    let is_opposite = held.contains(&other.valve) && other_held.contains(&one.valve);
    let is_opposite = is_opposite && is_exclusive(one.valve) && is_exclusive(other.valve);
    let is_guarded = held.iter().any(|&valve| other_held.contains(&valve) && is_exclusive(valve));
    let is_own = held.contains(&one.valve) || other_held.contains(&other.valve);
    if !is_opposite || is_guarded || is_own || one.after_task || other.after_task {
        return false;
    }
    let (Some(priority), Some(other_priority)) = (&one.priority, &other.priority) else { return false };
    // The more important takes the valve away, unless nothing may interrupt who holds it.
    match compare(priority, other_priority) {
        Ordering::Less => one.protected,
        Ordering::Equal => true,
        Ordering::Greater => other.protected,
    }
}

/// Priorities are compared from the left, missing numbers counting 0.
fn compare(one: &[i64], other: &[i64]) -> Ordering {
    let length = one.len().max(other.len());
    let at = |list: &[i64], place: usize| list.get(place).copied().unwrap_or(0);
    (0..length)
        .map(|place| at(one, place).cmp(&at(other, place)))
        .find(|order| order.is_ne())
        .unwrap_or(Ordering::Equal)
}

/// Whether one of two steps waits for the other.
pub(super) fn is_ordered(construct: &ConstructIr, first: usize, second: usize) -> bool {
    let leads = |from: usize, to: usize| {
        let (mut waiting, mut seen) = (vec![from], BTreeSet::new());
        while let Some(step) = waiting.pop() {
            if step == to {
                return true;
            }
            if seen.insert(step) {
                let next = construct.order.iter().filter(|&&(before, _)| usize::from(before) == step);
                waiting.extend(next.map(|&(_, after)| usize::from(after)));
            }
        }
        false
    };
    leads(first, second) || leads(second, first)
}
