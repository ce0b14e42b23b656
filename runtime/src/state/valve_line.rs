//! Those who wait for a valve, in the order in which they are served: the highest priority first,
//! among equals who asked first.

use crate::state::priorities::Priorities;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// When somebody in a line is served.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Turn {
    /// The priority asked with.
    pub priority: u32,
    /// The number of the request among those of the valve.
    pub asked: u64,
}

impl Turn {
    /// Whether this turn comes before another.
    pub fn is_before(self, other: Self, priorities: &Priorities) -> bool {
        match self.priority == other.priority {
            true => self.asked < other.asked,
            false => priorities.is_higher(self.priority, other.priority),
        }
    }
}

/// Those of one priority, by the order of asking.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Equals {
    priority: u32,
    waiters: BTreeMap<u64, u32>,
}

/// A line. Entering, leaving and finding the first cost the logarithm of its length and of the
/// number of priorities in it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ValveLine {
    /// The highest priority first, none of them empty.
    equals: Vec<Equals>,
}

impl ValveLine {
    fn find(&self, priorities: &Priorities, priority: u32) -> Result<usize, usize> {
        self.equals.binary_search_by(|equals| {
            if equals.priority == priority {
                Ordering::Equal
            } else if priorities.is_higher(equals.priority, priority) {
                Ordering::Less
            } else {
                Ordering::Greater
            }
        })
    }

    /// A task takes its turn.
    pub fn enter(&mut self, priorities: &Priorities, turn: Turn, task: u32) {
        let at = self.find(priorities, turn.priority).unwrap_or_else(|at| {
            self.equals.insert(at, Equals { priority: turn.priority, waiters: BTreeMap::new() });
            at
        });
        self.equals[at].waiters.insert(turn.asked, task);
    }

    /// A task leaves its turn.
    pub fn leave(&mut self, priorities: &Priorities, turn: Turn) {
        let Ok(at) = self.find(priorities, turn.priority) else { return };
        self.equals[at].waiters.remove(&turn.asked);
        if self.equals[at].waiters.is_empty() {
            self.equals.remove(at);
        }
    }

    /// Whoever is served first.
    pub fn first(&self) -> Option<(Turn, u32)> {
        self.iter().next()
    }

    /// All, in the order in which they are served.
    pub fn iter(&self) -> impl Iterator<Item = (Turn, u32)> {
        self.equals.iter().flat_map(|equals| {
            let Equals { priority, ref waiters } = *equals;
            waiters.iter().map(move |(&asked, &task)| (Turn { priority, asked }, task))
        })
    }

    /// How many stand in it.
    pub fn len(&self) -> usize {
        self.equals.iter().map(|equals| equals.waiters.len()).sum()
    }

    /// Whether nobody does.
    pub fn is_empty(&self) -> bool {
        self.equals.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_highest_priority_comes_first_and_then_the_order_of_asking() {
        let mut priorities = Priorities::default();
        let (high, low) = (priorities.appended(0, 0, 2), priorities.appended(0, 0, -1));
        let middle = priorities.appended(0, 0, 1);
        let mut line = ValveLine::default();
        for (asked, priority) in [(1, low), (2, middle), (3, high), (4, middle), (5, 0)] {
            line.enter(&priorities, Turn { priority, asked }, asked as u32);
        }
        let served = |line: &ValveLine| line.iter().map(|(_, task)| task).collect::<Vec<_>>();
        assert_eq!(served(&line), [3, 2, 4, 5, 1]);
        line.leave(&priorities, Turn { priority: high, asked: 3 });
        assert_eq!(served(&line), [2, 4, 5, 1]);
    }
}
