//! Waits begun and ended.

use crate::state::line::Line;
use crate::state::machine::Machine;
use crate::state::task::{Rare, State, Waiting, Wake};

impl Machine {
    /// Wakes a blocked task with what it waited for. Only the first wake-up of a wait counts.
    pub(crate) fn wake(&mut self, task: u32, wake: Wake) {
        let number = self.waits.wrapping_add(1);
        let record = &mut self.tasks[task];
        if record.state() != State::Blocked {
            return;
        }
        if let Some(Waiting::Fluent { fluent, owned: false, timed: false }) = record.waiting() {
            record.wait_number = number;
            record.set_wake(wake);
            self.waits = number;
            self.fluents[fluent].waiters.remove(&mut self.tasks, task);
        } else {
            self.stop_waiting(task);
            self.tasks[task].set_wake(wake);
        }
        self.trace_woken(task);
        self.make_ready(task);
    }

    /// Gives a task's wait a number that no wait had before. The counter goes round, so that of two
    /// waits the earlier one is known as long as there are less than 2³¹ between them.
    pub(crate) fn number_wait(&mut self, task: u32) {
        self.waits = self.waits.wrapping_add(1);
        self.tasks[task].wait_number = self.waits;
    }

    /// Withdraws a task from whatever it waits for.
    pub(crate) fn stop_waiting(&mut self, task: u32) {
        let waiting = self.tasks[task].end_wait();
        self.number_wait(task);
        let Some(waiting) = waiting else { return };
        match waiting {
            Waiting::Fluent { fluent, owned, timed } => {
                self.leave_fluent(task, fluent, owned);
                if timed {
                    self.forget_timer();
                }
            }
            Waiting::Watch(watch) => {
                if let Some(entry) = self.watches.get_mut(watch) {
                    entry.waits = false;
                }
            }
            Waiting::Time => {
                if self.end_timed_wait(task) {
                    self.forget_timer();
                }
            }
            Waiting::Valve(valve) => self.leave_valve_line(task, valve),
            Waiting::Death(other) => self.leave_line(task, other, |rare| &mut rare.mourners),
            Waiting::Swap(other) => {
                self.leave_line(task, other, |rare| &mut rare.mourners);
                self.forget_swap(other, task);
            }
            Waiting::Rest(other) => {
                self.waits_for_rest -= 1;
                self.leave_line(task, other, |rare| &mut rare.resters);
            }
            Waiting::Children | Waiting::Spawned | Waiting::Hooks(_) | Waiting::Signal(_) | Waiting::Answer => {}
        }
    }

    /// Puts a task at the end of a line that another one keeps.
    pub(crate) fn join_line(&mut self, task: u32, other: u32, line: fn(&mut Rare) -> &mut Line) {
        let mut joined = *line(self.tasks[other].rare());
        joined.push_back(&mut self.tasks, task);
        let rare = self.tasks[other].rare();
        *line(rare) = joined;
        rare.in_lines += 1;
    }

    fn leave_line(&mut self, task: u32, other: u32, line: fn(&mut Rare) -> &mut Line) {
        let mut left = *line(self.tasks[other].rare());
        left.remove(&mut self.tasks, task);
        let rare = self.tasks[other].rare();
        *line(rare) = left;
        rare.in_lines -= 1;
    }
}
