//! What can happen to a run from outside its plan, between two steps.

use crate::robot::Outside;
use crate::run::system::System;
use crate::state::failure::Raise;
use crate::state::slab::NONE;
use crate::state::task::{State, Waiting, Wake};
use crate::state::value::{TaskRef, Value};

/// Something that happens to a task or a fluent although no plan asked for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Disturbance {
    /// A task is ended; its clean-ups run.
    Evaporate(TaskRef),
    /// A task and what is below it is suspended once more.
    Suspend(TaskRef),
    /// One suspension of a task is taken back.
    Resume(TaskRef),
    /// What a blocked task waits for ends with a failure. Nothing happens to a task that waits for
    /// other tasks, or does not wait.
    Fail(TaskRef),
    /// A task is given the plan of a code to run, now or as soon as nothing is in the way. Nothing happens
    /// to a task that cannot be revised.
    Swap(TaskRef, u32),
    /// A fluent gets a value; one that is computed or set by the robot keeps its own.
    Assign(u32, Value),
    /// A fluent is pulsed; one that is computed is not.
    Pulse(u32),
}

impl<O: Outside> System<O> {
    /// Lets something happen between two steps. What is dead or gone is not touched.
    pub fn disturb(&mut self, disturbance: Disturbance) {
        self.with_machine(|machine, around| match disturbance {
            Disturbance::Evaporate(task) => {
                if let Some(task) = machine.tasks.find_alive(task) {
                    machine.evaporate(around, task);
                }
            }
            Disturbance::Suspend(task) => {
                if let Some(task) = machine.tasks.find_alive(task) {
                    machine.suspend(around, task, NONE);
                }
            }
            Disturbance::Resume(task) => {
                if let Some(task) = machine.tasks.find_alive(task) {
                    machine.resume(around, task);
                }
            }
            Disturbance::Fail(task) => {
                let Some(task) = machine.tasks.find_alive(task) else { return };
                let record = &machine.tasks[task];
                let waits = matches!(
                    record.waiting(),
                    Some(
                        Waiting::Fluent { .. }
                            | Waiting::Watch(_)
                            | Waiting::Time
                            | Waiting::Signal(_)
                            | Waiting::Hooks(_)
                            | Waiting::Answer
                    )
                );
                if record.state() == State::Blocked && waits {
                    let failure = machine.failure_from(Raise::new("plan-failure", "disturbed from outside"));
                    machine.wake(task, Wake::Raise(failure));
                }
            }
            Disturbance::Swap(task, code) => machine.revise(around, task, code),
            Disturbance::Assign(fluent, value) => {
                if machine.fluents.get(fluent).is_some() {
                    // What a plan may not assign stays as it is.
                    let _refused = machine.assign_fluent(around, Value::Fluent(fluent), value);
                }
            }
            Disturbance::Pulse(fluent) => {
                if machine.fluents.get(fluent).is_some() {
                    let _refused = machine.pulse_fluent(around, fluent);
                }
            }
        });
    }
}
