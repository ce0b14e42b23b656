//! Timers of waits.

use crate::state::machine::Machine;
use crate::state::memory;
use crate::state::task::{ScopeKind, State};
use crate::state::tasks::Tasks;
use crate::state::timers::Alarm;
use crate::state::timers::Timer;

/// Whether a timer still has something to do.
pub(crate) fn is_current(tasks: &Tasks, timer: &Timer) -> bool {
    let Some(task) = tasks.find_alive(timer.task) else { return false };
    let record = &tasks[task];
    match timer.alarm {
        Alarm::Wake(number) => record.state() == State::Blocked && record.wait_number == number,
        Alarm::Deadline => record.scopes.iter().rev().any(|scope| {
            matches!(&scope.kind, ScopeKind::Children(children)
                if children.timer == timer.number && children.decided.is_none())
        }),
    }
}

impl Machine {
    /// Sets the timer that ends the current wait of a task.
    pub(crate) fn set_wake_timer(&mut self, task: u32, due_us: u64) {
        let number = self.tasks[task].wait_number;
        let reference = self.tasks.reference(task);
        // A wait for time worked that goes on has been told before.
        if self.trace.enabled && task == self.current {
            self.scratch.wake_at = Some(due_us);
        }
        self.heap.allocated += memory::TIMER;
        self.timers.set(due_us, reference, Alarm::Wake(number));
    }

    pub(crate) fn forget_timer(&mut self) {
        let tasks = &self.tasks;
        self.timers.note_cancelled(|timer| is_current(tasks, timer));
    }
}
