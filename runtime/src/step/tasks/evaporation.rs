//! Departures from outside: evaporation, and failures that others cause.

use crate::state::machine::Machine;
use crate::state::scratch::Departure;
use crate::state::task::{Leaving, Raises, ScopeKind, State, Waiting, Wake};
use crate::state::value::Value;
use crate::step::native::Surroundings;
use crate::step::tasks::path::form_in_plan;
use rpl_lang::code::NO_REG;

impl Machine {
    /// Ends a task from outside. It is dead at once if it has nothing to clean up.
    pub(crate) fn evaporate(&mut self, around: &mut Surroundings<'_>, task: u32) {
        self.evaporate_all(around, &[task]);
    }

    /// Ends tasks from outside, in this order.
    pub(crate) fn evaporate_all(&mut self, around: &mut Surroundings<'_>, tasks: &[u32]) {
        for &task in tasks.iter().rev() {
            self.scratch.departures.push(Departure::Evaporate(self.tasks.reference(task)));
        }
        self.look_at_departures(around);
    }

    /// Goes on with departures until none is left. A stack instead of recursion: a tree may be
    /// deeper than the machine's own stack, and the tasks below one are looked at before the next.
    pub(crate) fn look_at_departures(&mut self, around: &mut Surroundings<'_>) {
        if self.scratch.is_departing {
            return;
        }
        self.scratch.is_departing = true;
        while let Some(departure) = self.scratch.departures.pop() {
            match departure {
                Departure::Evaporate(task) => {
                    if let Some(task) = self.tasks.find_alive(task) {
                        self.evaporate_now(around, task);
                    }
                }
                Departure::GoOn(task) => {
                    if let Some(task) = self.tasks.find_alive(task) {
                        self.go_on_leaving(around, task);
                    }
                }
            }
        }
        self.scratch.is_departing = false;
        self.serve_valves(around);
    }

    /// Runs `act` as one decision: departures it causes are looked at when it is over.
    #[inline]
    pub(crate) fn as_one(&mut self, around: &mut Surroundings<'_>, act: impl FnOnce(&mut Self, &mut Surroundings<'_>)) {
        let outer = std::mem::replace(&mut self.scratch.is_departing, true);
        act(self, around);
        self.scratch.is_departing = outer;
        if !self.scratch.departures.is_empty() || !self.scratch.restless.is_empty() {
            self.look_at_departures(around);
        }
    }

    fn evaporate_now(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let record = &self.tasks[task];
        let has_begun = record.frame.pc > 0 || !record.frames.is_empty() || !record.scopes.is_empty();
        if record.state() == State::Created || (record.state() == State::Ready && !has_begun) {
            self.unqueue(task);
            self.die(around, task, State::Evaporated, Value::Nil);
        } else if record.is_protected() || record.is_committed() {
            let outcome = (record.raises == Raises::Outcome && !record.is_protected()).then_some(*record.value());
            self.tasks[task].rare().evaporation_pending = true;
            if let Some(failure) = outcome {
                self.depart_failing(around, task, failure);
            }
        } else {
            self.depart(around, task, Leaving::Evaporate);
        }
    }

    /// Starts a departure of a task that is not running; the running one is told to leave.
    pub(crate) fn depart(&mut self, around: &mut Surroundings<'_>, task: u32, leaving: Leaving) {
        if task == self.current {
            self.tasks[task].leave(leaving);
            return;
        }
        match self.tasks[task].state() {
            State::Ready => {
                self.unqueue(task);
                self.tasks[task].enter(State::Blocked);
            }
            _ => {
                // A valve's scope is entered before the valve is there: it is left with the wait.
                let record = &mut self.tasks[task];
                if let (Some(Waiting::Valve(valve)), NO_REG) = (record.waiting(), record.wake_register)
                    && record.scopes.last().is_some_and(|scope| scope.kind == ScopeKind::Valve(valve))
                {
                    record.scopes.pop();
                }
                self.stop_waiting(task);
            }
        }
        self.tasks[task].set_wake(Wake::Nothing);
        self.tasks[task].leave(leaving);
        self.note_hooks_before(around, task);
        self.unwind(around, task);
    }

    /// Starts the departure of a task that is not running with the failure of its construct.
    pub(crate) fn depart_failing(&mut self, around: &mut Surroundings<'_>, task: u32, failure: Value) {
        let record = &self.tasks[task];
        let span = form_in_plan(around.program, record.frame, &record.frames);
        if let Value::Failure(index) = failure {
            let known = &mut self.heap.failures[index].span;
            *known = known.or(span);
        }
        self.trace_failed(around.program, task, failure);
        self.depart(around, task, Leaving::Fail(failure));
    }

    /// Ends the children of one scope; gives how many still clean up.
    pub(crate) fn evaporate_children(&mut self, around: &mut Surroundings<'_>, task: u32, scope: u32) -> u32 {
        let alive = |machine: &Self| match &machine.tasks[task].scopes[scope as usize].kind {
            ScopeKind::Children(children) => children.alive,
            ScopeKind::Call(call) => call.spawned,
            _ => 0,
        };
        if alive(self) == 0 {
            return 0;
        }
        let (children, looked_at) = self.look_for_children(task, scope);
        self.scratch.work += looked_at;
        self.evaporate_all(around, &children);
        alive(self)
    }
}
