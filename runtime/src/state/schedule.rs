//! Other orders of what is ready at the same time.
//!
//! A run takes the first of several ready tasks, and the first of several timeouts of one instant. Under a
//! schedule it counts these choices, and takes others where the schedule says so. What follows from a plan is no
//! choice: a task that was pre-empted goes on before the others of its priority, and one that has given way comes
//! behind those that were ready then.

use crate::state::value::TaskRef;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Another choice than that of a run by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Deviation {
    /// Which choice of the run, from 0.
    pub choice: u64,
    /// What is taken, by its place in the usual order; the usual one is 0.
    pub taken: u32,
}

/// What a run chooses where the order is not promised.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Schedule {
    /// The deviations that are still to come.
    deviations: VecDeque<Deviation>,
    /// Choices there have been.
    choices: u64,
    /// Tasks that were pre-empted and have not run since.
    preempted: BTreeSet<TaskRef>,
    /// Tasks that have given way, and those behind which each comes.
    behind: BTreeMap<TaskRef, Vec<TaskRef>>,
}

impl Schedule {
    /// With these deviations, in the order of their choices; without any it is that of a run by itself.
    pub fn new(deviations: impl IntoIterator<Item = Deviation>) -> Self {
        Self { deviations: deviations.into_iter().collect(), ..Self::default() }
    }

    /// The number of the next choice.
    pub fn choices(&self) -> u64 {
        self.choices
    }

    /// The deviations that have not come to pass.
    pub fn left(&self) -> impl Iterator<Item = Deviation> {
        self.deviations.iter().copied()
    }

    /// Takes another than the first at the next choice; any deviation that was to come is forgotten.
    pub fn deviate(&mut self, taken: u32) {
        self.deviations = VecDeque::from([Deviation { choice: self.choices, taken }]);
    }

    /// What is taken at a choice among so many. A deviation that takes what there is not is kept: it is told as one
    /// that has not come to pass.
    pub(crate) fn choose(&mut self, among: usize) -> usize {
        let choice = self.choices;
        self.choices += 1;
        match self.deviations.front() {
            Some(next) if next.choice == choice && (next.taken as usize) < among => {
                let taken = next.taken;
                self.deviations.pop_front();
                taken as usize
            }
            _ => 0,
        }
    }

    /// Notes that a task was switched out.
    pub(crate) fn preempt(&mut self, task: TaskRef) {
        self.preempted.insert(task);
    }

    /// Notes that a task has given way to those that are ready.
    pub(crate) fn give_way(&mut self, task: TaskRef, to: Vec<TaskRef>) {
        self.behind.insert(task, to);
    }

    /// Notes that a task stands in the run queue no more.
    pub(crate) fn leave(&mut self, task: TaskRef) {
        self.preempted.remove(&task);
        self.behind.remove(&task);
        self.behind.values_mut().for_each(|before| before.retain(|&other| other != task));
        self.behind.retain(|_, before| !before.is_empty());
    }

    /// Of the ready tasks of one priority, in their order, those that may run next.
    pub(crate) fn eligible(&self, ready: &[TaskRef]) -> Vec<TaskRef> {
        if let Some(&task) = ready.iter().find(|task| self.preempted.contains(task)) {
            return vec![task];
        }
        let waits = |task: &TaskRef| {
            self.behind.get(task).is_some_and(|before| before.iter().any(|other| ready.contains(other)))
        };
        ready.iter().copied().filter(|task| !waits(task)).collect()
    }

    /// The promises that hold now: tasks that were pre-empted, and pairs of a task and one that comes before it.
    pub(crate) fn promises(&self) -> (impl Iterator<Item = TaskRef>, impl Iterator<Item = (TaskRef, TaskRef)>) {
        let pairs = self.behind.iter().flat_map(|(&task, before)| before.iter().map(move |&other| (task, other)));
        (self.preempted.iter().copied(), pairs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn task(index: u32) -> TaskRef {
        TaskRef { index, generation: 0 }
    }

    #[test]
    fn what_is_promised_is_no_choice() {
        let mut schedule = Schedule::default();
        let ready = [task(1), task(2), task(3)];
        assert_eq!(schedule.eligible(&ready), ready);
        schedule.give_way(task(3), vec![task(1), task(2)]);
        assert_eq!(schedule.eligible(&ready), [task(1), task(2)]);
        schedule.leave(task(1));
        schedule.leave(task(2));
        assert_eq!(schedule.eligible(&ready), ready);
        schedule.preempt(task(2));
        assert_eq!(schedule.eligible(&ready), [task(2)]);
    }

    #[test]
    fn a_deviation_that_is_not_there_is_left() {
        let mut schedule = Schedule::new([Deviation { choice: 1, taken: 2 }, Deviation { choice: 2, taken: 1 }]);
        assert_eq!([schedule.choose(2), schedule.choose(2), schedule.choose(2)], [0, 0, 0]);
        assert_eq!(schedule.left().count(), 2);
        let mut schedule = Schedule::new([Deviation { choice: 1, taken: 2 }]);
        assert_eq!([schedule.choose(2), schedule.choose(3), schedule.choose(3)], [0, 2, 0]);
        assert_eq!(schedule.left().count(), 0);
    }
}
