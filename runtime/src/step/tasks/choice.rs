//! What a run under a schedule takes of what is ready at the same time.

use crate::state::machine::Machine;
use crate::state::timers::Timer;
use crate::state::value::TaskRef;
use crate::step::time::timers::is_current;

impl Machine {
    /// The ready tasks that may run next, in the order in which they do by themselves: all of the highest priority
    /// but those that a promise keeps back.
    pub(crate) fn eligible_tasks(&self) -> Vec<TaskRef> {
        let ready = self.first_in_line();
        match &self.schedule {
            Some(schedule) if ready.len() > 1 => schedule.eligible(&ready),
            _ => ready,
        }
    }

    fn first_in_line(&self) -> Vec<TaskRef> {
        let line = self.priorities.first_line().unwrap_or_default();
        line.tasks(&self.tasks).into_iter().map(|task| self.tasks.reference(task)).collect()
    }

    /// Takes the task out of the run queue that the schedule has run next. Cost: the tasks of its priority.
    pub(crate) fn take_scheduled(&mut self) -> Option<u32> {
        let eligible = self.eligible_tasks();
        let schedule = self.schedule.as_mut()?;
        let taken = if eligible.len() > 1 { schedule.choose(eligible.len()) } else { 0 };
        let task = eligible.get(taken)?.index;
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
        if self.schedule.is_none() {
            self.timers.take();
            return first;
        }
        let due = self.timeouts_at(self.now_us);
        let taken = match &mut self.schedule {
            Some(schedule) if due.len() > 1 => schedule.choose(due.len()),
            _ => 0,
        };
        let timer = due.get(taken).copied().unwrap_or(first);
        self.timers.remove(timer.number);
        timer
    }

    pub(crate) fn note_preempted(&mut self, task: u32) {
        let reference = self.tasks.reference(task);
        if let Some(schedule) = &mut self.schedule {
            schedule.preempt(reference);
        }
    }

    /// Notes that a task, which is not ready yet, comes behind those of its priority that are.
    pub(crate) fn note_given_way(&mut self, task: u32) {
        if self.schedule.is_none() {
            return;
        }
        let priority = self.effective_priority(task);
        let ready = self.priorities.line_of(priority).tasks(&self.tasks);
        let ready = ready.into_iter().map(|other| self.tasks.reference(other)).collect();
        let reference = self.tasks.reference(task);
        if let Some(schedule) = &mut self.schedule {
            schedule.give_way(reference, ready);
        }
    }

    pub(crate) fn note_left(&mut self, task: u32) {
        let reference = self.tasks.reference(task);
        if let Some(schedule) = &mut self.schedule {
            schedule.leave(reference);
        }
    }
}
