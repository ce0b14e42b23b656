//! From instant to instant: timers and the robot's steps.

use crate::robot::Outside;
use crate::run::system::{Outcome, Progress, System};
use crate::state::limits::Spent;
use crate::state::machine::Machine;
use crate::state::task::Wake;
use crate::state::timers::{Alarm, Timer};
use crate::state::value::Value;
use crate::step::time::timers::is_current;

impl<O: Outside> System<O> {
    /// Goes on to the end of the next instant.
    pub fn advance(&mut self) -> Progress {
        self.settle();
        if self.outcome().is_some() {
            return Progress::Ended;
        }
        self.next_instant();
        self.settle();
        if self.outcome().is_some() { Progress::Ended } else { Progress::Running }
    }

    /// Moves the clock to the next timer or robot step and lets that take effect, while all tasks
    /// are blocked; no task runs yet. If nothing can come any more, the main task fails.
    pub fn next_instant(&mut self) {
        match self.next_instant_us() {
            Some(next_us) => self.enter_instant(next_us),
            None => self.with_machine(Machine::fail_deadlocked),
        }
    }

    /// Goes through all instants up to a time, as long as the main task lives.
    pub fn advance_to(&mut self, time_us: u64) {
        self.settle();
        while self.outcome().is_none()
            && let Some(next_us) = self.next_instant_us()
            && next_us <= time_us
        {
            self.enter_instant(next_us);
            self.settle();
        }
    }

    /// When something happens next: a timer is due, or the robot makes a step.
    pub fn next_instant_us(&mut self) -> Option<u64> {
        let tasks = &self.machine.tasks;
        let timer = self.machine.timers.next(|timer| is_current(tasks, timer)).map(|timer| timer.deadline_us);
        let step = self.outside.next_event_us(self.stepped_us);
        [timer, step].into_iter().flatten().min()
    }

    fn enter_instant(&mut self, time_us: u64) {
        // Budgets are counted in one point of time, however often it is gone to.
        if self.machine.now_us < time_us {
            self.machine.instant = self.machine.instant.wrapping_add(1);
            self.machine.spent = Spent::default();
            self.machine.now_us = time_us;
        }
        if self.outside.steps_at(self.stepped_us, time_us) {
            let lost = self.step_robot();
            self.end_without_robot(lost);
        }
        self.fire_timers();
        self.with_machine(Machine::flush_status);
    }

    /// Fires the timers that are due: all waits that end now, or, when nothing is left to run, the
    /// first timeout.
    fn fire_timers(&mut self) {
        let now = self.machine.now_us;
        let mut is_quiet = true;
        loop {
            let tasks = &self.machine.tasks;
            let Some(timer) = self.machine.timers.next(|timer| is_current(tasks, timer)) else { return };
            if timer.deadline_us > now {
                return;
            }
            match timer.alarm {
                Alarm::Wake(_) => {
                    self.machine.timers.take();
                    self.machine.wake(timer.task.index, Wake::Value(Value::Nil));
                    is_quiet = false;
                }
                Alarm::Request { .. } | Alarm::Deadline if is_quiet && self.machine.is_idle() => {
                    let timer = self.machine.take_timeout(timer);
                    return self.end_in_time(timer);
                }
                // What is ready may be done in time: the timeout is looked at when it has run.
                Alarm::Request { .. } | Alarm::Deadline => return,
            }
        }
    }

    /// A timeout takes effect. Its timer is taken already.
    fn end_in_time(&mut self, timer: Timer) {
        let task = timer.task.index;
        match timer.alarm {
            Alarm::Wake(_) => {}
            Alarm::Request { asked_us, .. } => {
                let seconds = (timer.deadline_us - asked_us) as f64 / 1e6;
                // Whoever it kept waiting is served.
                self.with_machine(|machine, around| {
                    machine.request_ended(task, seconds);
                    machine.serve_valves(around);
                });
            }
            Alarm::Deadline => self.with_machine(|machine, around| machine.deadline(around, task, timer.number)),
        }
    }

    /// Runs to the end, or to a time. Tells how it ended, if it did.
    pub fn run_until(&mut self, until_us: u64) -> Option<Outcome> {
        while self.machine.now_us < until_us {
            if self.advance() == Progress::Ended {
                return self.outcome();
            }
        }
        self.outcome()
    }
}
