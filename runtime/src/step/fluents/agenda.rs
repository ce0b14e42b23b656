//! Networks to be brought up to date, each in its turn.

use std::collections::BTreeSet;

/// When a network is brought up to date: its height, its number; and its slot.
pub(super) type Turn = (u32, u64, u32);

/// A set of turns that is taken from the first on. Most are known when it is made, and stand in a row.
#[derive(Debug)]
pub(super) struct Agenda {
    /// In order, each once.
    row: Vec<Turn>,
    /// How many of them are taken out.
    taken: usize,
    /// Those that came later, and are not in the row.
    later: BTreeSet<Turn>,
}

impl Agenda {
    pub(super) fn new(mut turns: Vec<Turn>) -> Self {
        // Networks are mostly made one after the other, and then the readers of one fluent are in order.
        if !turns.is_sorted_by(|left, right| left < right) {
            turns.sort_unstable();
            turns.dedup();
        }
        Self { row: turns, taken: 0, later: BTreeSet::new() }
    }

    pub(super) fn contains(&self, turn: Turn) -> bool {
        self.row[self.taken..].binary_search(&turn).is_ok() || self.later.contains(&turn)
    }

    pub(super) fn insert(&mut self, turn: Turn) {
        if !self.contains(turn) {
            self.later.insert(turn);
        }
    }

    /// Takes the first turn out.
    #[inline]
    pub(super) fn pop_first(&mut self) -> Option<Turn> {
        let next = self.row.get(self.taken).copied();
        if !self.later.is_empty() && next.is_none_or(|next| self.later.first().is_some_and(|&later| later < next)) {
            return self.later.pop_first();
        }
        self.taken += usize::from(next.is_some());
        next
    }

    /// The networks whose turn it will be, in order.
    pub(super) fn networks(mut self) -> impl Iterator<Item = u32> {
        std::iter::from_fn(move || self.pop_first().map(|(_, _, network)| network))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_taken_in_order_whenever_they_came() {
        let turn = |number: u32| (number % 3, u64::from(number % 7), number % 11);
        let first: Vec<Turn> = (0..40).map(|number| turn(number * 5)).collect();
        let mut expected: BTreeSet<Turn> = first.iter().copied().collect();
        let mut agenda = Agenda::new(first);
        for number in 0..400 {
            if number % 3 == 0 {
                agenda.insert(turn(number));
                expected.insert(turn(number));
            } else {
                assert_eq!(agenda.pop_first(), expected.pop_first());
            }
            let asked = turn(number + 1);
            assert_eq!(agenda.contains(asked), expected.contains(&asked));
        }
        assert!(agenda.networks().eq(expected.into_iter().map(|(_, _, network)| network)));
    }
}
