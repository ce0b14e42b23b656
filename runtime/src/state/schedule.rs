//! Other orders of what is ready at the same time.
//!
//! A run takes the first of several ready tasks, and the first of several timeouts of one instant. Under a
//! schedule it counts these turns, and takes others where the schedule says so. What follows from a plan is no
//! choice: a task that was pre-empted goes on before the others of its priority, and one that has given way comes
//! behind those that were ready then.

use crate::state::value::TaskRef;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeSet, VecDeque};

/// Another choice than that of a run by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Deviation {
    /// Which turn of the run, from 0.
    pub turn: u64,
    /// What is taken, by its place in the usual order; the usual one is 0.
    pub taken: u32,
}

/// What a run chooses of what is ready at the same time. Cost: constant a turn, but for turns that deviate and for
/// tasks that were pre-empted or have given way, which cost the logarithm of their number.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Schedule {
    /// The deviations that are still to come.
    deviations: VecDeque<Deviation>,
    /// Turns there have been.
    turns: u64,
    /// Tasks that were pre-empted and have not run since: each stands first in its line.
    preempted: BTreeSet<TaskRef>,
    /// Tasks that have given way and have not run since: those before each in its line come first.
    given_way: BTreeSet<TaskRef>,
}

impl Schedule {
    /// With these deviations, in the order of their turns; without any it is that of a run by itself.
    pub fn new(deviations: impl IntoIterator<Item = Deviation>) -> Self {
        Self { deviations: deviations.into_iter().collect(), ..Self::default() }
    }

    /// The number of the next turn.
    pub fn turns(&self) -> u64 {
        self.turns
    }

    /// The deviations that have not come to pass.
    pub fn left(&self) -> impl Iterator<Item = Deviation> {
        self.deviations.iter().copied()
    }

    /// Takes another than the first at the next turn; any deviation that was to come is forgotten.
    pub fn deviate(&mut self, taken: u32) {
        self.deviations = VecDeque::from([Deviation { turn: self.turns, taken }]);
    }

    /// Begins a turn, and tells what is to be taken in it.
    pub(crate) fn begin_turn(&mut self) -> u32 {
        let turn = self.turns;
        self.turns += 1;
        self.deviations.front().filter(|next| next.turn == turn).map_or(0, |next| next.taken)
    }

    /// Notes that the deviation of this turn has come to pass. One that takes what there is not is kept, and with it
    /// all that follow.
    pub(crate) fn has_deviated(&mut self) {
        self.deviations.pop_front();
    }

    /// Notes that a task was switched out.
    pub(crate) fn preempt(&mut self, task: TaskRef) {
        self.preempted.insert(task);
    }

    /// Notes that a task has given way to those that are ready.
    pub(crate) fn give_way(&mut self, task: TaskRef) {
        self.given_way.insert(task);
    }

    /// Notes that a task stands in the run queue no more.
    pub(crate) fn leave(&mut self, task: TaskRef) {
        self.preempted.remove(&task);
        self.given_way.remove(&task);
    }

    /// Whether a task goes on before all others of its priority.
    pub(crate) fn is_preempted(&self, task: TaskRef) -> bool {
        self.preempted.contains(&task)
    }

    /// Whether a task comes behind those before it in its line.
    pub(crate) fn has_given_way(&self, task: TaskRef) -> bool {
        self.given_way.contains(&task)
    }

    /// Of the ready tasks of one priority, in their order, those that may run next.
    pub(crate) fn eligible(&self, ready: Vec<TaskRef>) -> Vec<TaskRef> {
        let Some(&first) = ready.first() else { return ready };
        if self.is_preempted(first) {
            return vec![first];
        }
        ready.into_iter().filter(|&task| task == first || !self.has_given_way(task)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn task(index: u32) -> TaskRef {
        TaskRef { index, generation: 0 }
    }

    #[test]
    fn what_follows_from_the_plan_is_no_choice() {
        let mut schedule = Schedule::default();
        let ready = vec![task(1), task(2), task(3)];
        assert_eq!(schedule.eligible(ready.clone()), ready);
        schedule.give_way(task(3));
        assert_eq!(schedule.eligible(ready.clone()), [task(1), task(2)]);
        // Those before it have run.
        assert_eq!(schedule.eligible(vec![task(3), task(4)]), [task(3), task(4)]);
        schedule.preempt(task(1));
        assert_eq!(schedule.eligible(ready.clone()), [task(1)]);
        schedule.leave(task(1));
        schedule.leave(task(3));
        assert_eq!(schedule.eligible(ready.clone()), ready);
    }

    #[test]
    fn a_deviation_comes_in_its_turn_and_in_no_other() {
        let mut schedule = Schedule::new([Deviation { turn: 1, taken: 2 }]);
        assert_eq!([schedule.begin_turn(), schedule.begin_turn(), schedule.begin_turn()], [0, 2, 0]);
        assert_eq!(schedule.left().count(), 1, "nobody has said that it came to pass");
        schedule.has_deviated();
        assert_eq!(schedule.left().count(), 0);
    }
}
