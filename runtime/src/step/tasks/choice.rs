//! What a run under a schedule takes of what is ready at the same time.

use crate::state::machine::Machine;
use crate::state::timers::Timer;
use crate::state::value::TaskRef;
use crate::step::time::timers::is_current;

impl Machine {
    /// The ready tasks that may run next, in the order in which they do by themselves: all of the highest priority
    /// but those that must wait for others of it.
    pub(crate) fn eligible_tasks(&self) -> Vec<TaskRef> {
        let line = self.priorities.first_line().unwrap_or_default();
        let ready = line.tasks(&self.tasks).into_iter().map(|task| self.tasks.reference(task)).collect();
        match &self.schedule {
            Some(schedule) => schedule.eligible(ready),
            None => ready,
        }
    }

    /// Takes the task out of the run queue that the schedule has run next. Cost: constant, but in a turn that deviates
    /// the tasks of its priority.
    pub(crate) fn take_scheduled(&mut self) -> Option<u32> {
        let first = self.priorities.first_line()?.first;
        let taken = self.schedule.as_mut()?.begin_turn();
        let other = if taken == 0 { None } else { self.eligible_tasks().get(taken as usize).copied() };
        if other.is_some() {
            self.schedule.as_mut()?.has_deviated();
        }
        let task = other.map_or(first, |other| other.index);
        self.unqueue(task);
        Some(task)
    }

    /// The timeouts that end at a time if nothing else happens then, in the order in which they do by themselves.
    pub(crate) fn timeouts_at(&self, time_us: u64) -> Vec<Timer> {
        let is_due = |timer: &&Timer| timer.deadline_us <= time_us && is_current(&self.tasks, timer);
        let mut due: Vec<Timer> = self.timers.iter().filter(is_due).copied().collect();
        due.sort_unstable();
        if due.first().is_some_and(|timer| timer.alarm.is_late()) { due } else { Vec::new() }
    }

    /// Takes the timer out that the schedule has end next, where `first` does by itself.
    pub(crate) fn take_timeout(&mut self, first: Timer) -> Timer {
        let taken = self.schedule.as_mut().map_or(0, |schedule| schedule.begin_turn());
        let other = if taken == 0 { None } else { self.timeouts_at(self.now_us).get(taken as usize).copied() };
        match (other, &mut self.schedule) {
            (Some(timer), Some(schedule)) => {
                schedule.has_deviated();
                self.timers.remove(timer.number);
                timer
            }
            _ => {
                self.timers.take();
                first
            }
        }
    }

    pub(crate) fn note_preempted(&mut self, task: u32) {
        let reference = self.tasks.reference(task);
        if let Some(schedule) = &mut self.schedule {
            schedule.preempt(reference);
        }
    }

    pub(crate) fn note_given_way(&mut self, task: u32) {
        let reference = self.tasks.reference(task);
        if let Some(schedule) = &mut self.schedule {
            schedule.give_way(reference);
        }
    }

    pub(crate) fn note_left(&mut self, task: u32) {
        let reference = self.tasks.reference(task);
        if let Some(schedule) = &mut self.schedule {
            schedule.leave(reference);
        }
    }
}
