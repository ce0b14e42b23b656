//! What a run can do next, for those who try more than what the language takes first.

use crate::robot::Outside;
use crate::run::canonical::Visible;
use crate::run::system::System;
use crate::state::value::TaskRef;

impl<O: Outside> System<O> {
    /// The ready tasks that may run next, in the order in which they do by themselves. With one there is no choice.
    pub fn eligible_tasks(&self) -> Vec<TaskRef> {
        self.machine.eligible_tasks()
    }

    /// Tasks whose timeouts may end next, in the order in which they do by themselves: none while a task is ready or
    /// if anything else happens in the next instant, for a timeout is looked at when nothing else is left to do.
    pub fn eligible_timeouts(&mut self) -> Vec<TaskRef> {
        if !self.machine.is_idle() {
            return Vec::new();
        }
        match self.next_instant_us() {
            Some(next_us) if !self.outside.steps_at(self.stepped_us, next_us) => {
                self.machine.timeouts_at(next_us).iter().map(|timer| timer.task).collect()
            }
            _ => Vec::new(),
        }
    }

    /// The canonical state of the run without its robot, as bytes: equal bytes, equal futures. Cost: linear in what
    /// the run can still reach.
    pub fn canonical_bytes(&self, visible: Visible) -> Vec<u8> {
        self.machine.canonical_bytes(&self.program, visible)
    }
}
