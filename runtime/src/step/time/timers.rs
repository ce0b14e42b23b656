//! Timers of waits.

use crate::state::machine::Machine;
use crate::state::memory;
use crate::state::task::{ScopeKind, State, Waiting, Wake};
use crate::state::tasks::Tasks;
use crate::state::timers::Alarm;
use crate::state::timers::Timer;
use crate::state::value::Value;

/// Whether a timer still has something to do.
pub(crate) fn is_current(tasks: &Tasks, timer: &Timer) -> bool {
    let Some(task) = tasks.find_alive(timer.task) else { return false };
    let record = &tasks[task];
    match timer.alarm {
        Alarm::Wake(number) | Alarm::Request { wait: number, .. } => {
            record.state() == State::Blocked && record.wait_number == number
        }
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

    /// Sets the timer that ends the request of a valve by the running task.
    pub(crate) fn set_request_timer(&mut self, task: u32, due_us: u64) {
        self.number_wait(task);
        let alarm = Alarm::Request { wait: self.tasks[task].wait_number, asked_us: self.now_us };
        if self.trace.enabled {
            self.scratch.wake_at = Some(due_us);
        }
        self.heap.allocated += memory::TIMER;
        self.timers.set(due_us, self.tasks.reference(task), alarm);
    }

    /// The valve that a task has asked for was not given in time.
    pub(crate) fn request_ended(&mut self, task: u32, seconds: f64) {
        let Some(Waiting::Valve(valve)) = self.tasks[task].waiting() else { return };
        // Its scope was entered before the valve was there.
        self.tasks[task].scopes.pop();
        let message = format!("the valve `{}` was not given within {seconds} s", self.valve_name(valve));
        let (class, slot) = (self.symbols.intern("timeout"), self.symbols.intern("seconds"));
        let failure = self.new_failure(task, class, message, vec![(slot, Value::Float(seconds))]);
        self.wake(task, Wake::Raise(failure));
    }

    pub(crate) fn forget_timer(&mut self) {
        let tasks = &self.tasks;
        self.timers.note_cancelled(|timer| is_current(tasks, timer));
    }
}
