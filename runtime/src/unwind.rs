//! Leaving early: evaporation, failures on their way to a handler, and exits from blocks.
//!
//! A departure pops scopes, innermost first. It pauses while children die or a clean-up runs, and
//! its outcome is fixed when it starts: what happens meanwhile is attached to it.

use crate::failure::Raise;
use crate::machine::{Machine, Output, SCRATCH_TASK, Surroundings};
use crate::task::{Leaving, Scope, ScopeKind, State, Then, Waiting, Wake};
use crate::value::Value;
use rpl_lang::code::{Program, Reg};

/// Where a departure goes on in code.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Landing {
    /// Frames below the one to go on in.
    pub(crate) depth: u32,
    /// The instruction.
    pub(crate) target: u32,
    /// Registers to set first.
    pub(crate) writes: [(Reg, Value); 2],
}

/// How far a departure got.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Unwound {
    /// Code must run: a clean-up, a handler, what follows a block.
    Land(Landing),
    /// It waits for children to die.
    Waiting,
    /// The task is dead.
    Dead,
}

impl Machine {
    /// Ends a task from outside. It is dead at once if it has nothing to clean up.
    pub(crate) fn evaporate(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let record = &self.tasks[task];
        if record.state.is_dead() {
            return;
        }
        let has_begun = record.frame.pc > 0 || !record.frames.is_empty() || !record.scopes.is_empty();
        if record.state == State::Created || (record.state == State::Ready && !has_begun) {
            self.unqueue(task);
            self.die(around, task, State::Evaporated, Value::Nil);
        } else if record.is_protected() {
            self.tasks[task].evaporation_pending = true;
        } else {
            self.depart(around, task, Leaving::Evaporate);
        }
    }

    /// Starts a departure of a task that is not running; the running one is told to leave.
    pub(crate) fn depart(&mut self, around: &mut Surroundings<'_>, task: u32, leaving: Leaving) {
        if task == self.current {
            self.tasks[task].leaving = Some(Box::new(leaving));
            return;
        }
        match self.tasks[task].state {
            State::Ready => self.unqueue(task),
            _ => {
                self.stop_waiting(task);
                self.tasks[task].state = State::Ready;
            }
        }
        self.tasks[task].wake = Wake::Nothing;
        self.defer_stop(task);
        self.tasks[task].leaving = Some(Box::new(leaving));
        self.unwind(around, task);
    }

    /// Goes on with the departure of a task that is not running, as far as that needs no code.
    pub(crate) fn unwind(&mut self, around: &mut Surroundings<'_>, task: u32) {
        // Not blocked meanwhile: the death of a child on the way must not start this again.
        self.tasks[task].state = State::Running;
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || match self.unwind_step(around, task, false) {
            Unwound::Land(_) => self.make_ready(task),
            Unwound::Waiting | Unwound::Dead => {}
        });
    }

    /// Pops scopes until something must run, be waited for, or nothing is left. Unless `may_run`,
    /// it stops before what needs code and answers [`Unwound::Land`] without having popped it.
    pub(crate) fn unwind_step(&mut self, around: &mut Surroundings<'_>, task: u32, may_run: bool) -> Unwound {
        loop {
            self.take_up_evaporation(around, task);
            let Some(leaving) = self.tasks[task].leaving.as_deref().cloned() else {
                return Unwound::Dead;
            };
            let count = self.tasks[task].scopes.len();
            if let Leaving::Jump { scopes, target, depth } = leaving
                && count == scopes as usize
            {
                return self.land(task, Landing { depth, target, writes: [(0, Value::Unbound); 2] });
            }
            let Some(scope) = self.tasks[task].scopes.last().cloned() else {
                // Who evaluates a network or macro takes its failure; the scratch task lives on.
                if task == SCRATCH_TASK {
                    return Unwound::Dead;
                }
                return self.leave_task(around, task, leaving);
            };
            if let Some(landing) = self.landing(around.program, &scope, &leaving) {
                if !may_run {
                    return Unwound::Land(landing);
                }
                return self.land_in(task, scope, leaving, landing);
            }
            match self.pop_scope(around, task, scope, leaving) {
                Popped::On => {}
                Popped::Wait(waiting) => {
                    self.tasks[task].waiting = waiting;
                    if self.tasks[task].state == State::Running {
                        self.set_state(task, State::Blocked);
                    }
                    return Unwound::Waiting;
                }
            }
        }
    }

    /// An evaporation that came during a clean-up takes effect after it, unless the task is
    /// already on its way out.
    fn take_up_evaporation(&mut self, around: &Surroundings<'_>, task: u32) {
        let record = &self.tasks[task];
        if !record.evaporation_pending || record.is_cleaning_up() {
            return;
        }
        let is_terminal = match record.leaving.as_deref() {
            Some(Leaving::Evaporate) => true,
            Some(Leaving::Fail(failure)) => !self.is_handled(around.program, task, *failure),
            _ => false,
        };
        if !is_terminal {
            self.tasks[task].leaving = Some(Box::new(Leaving::Evaporate));
        }
        self.tasks[task].evaporation_pending = false;
    }

    fn is_handled(&self, program: &Program, task: u32, failure: Value) -> bool {
        let leaving = Leaving::Fail(failure);
        self.tasks[task].scopes.iter().any(|scope| {
            matches!(scope.kind, ScopeKind::Handler { .. }) && self.landing(program, scope, &leaving).is_some()
        })
    }

    /// Where code goes on if this scope stops the departure, or has a clean-up to run.
    fn landing(&self, program: &Program, scope: &Scope, leaving: &Leaving) -> Option<Landing> {
        let nothing = (0, Value::Unbound);
        match (&scope.kind, leaving) {
            (ScopeKind::Block { identity, result, target }, Leaving::Block { identity: wanted, value })
                if identity == wanted =>
            {
                Some(Landing { depth: scope.depth, target: *target, writes: [(*result, *value), nothing] })
            }
            (ScopeKind::Handler { code, index, failure, target }, Leaving::Fail(Value::Failure(raised))) => {
                let class = self.heap.failures[*raised].class;
                let clauses = &program.codes[*code as usize].handlers[*index as usize];
                let clause = clauses
                    .iter()
                    .position(|classes| classes.iter().any(|&handled| program.is_failure_subclass(class, handled)))?;
                let writes = [(*failure, Value::Failure(*raised)), (*failure + 1, Value::Int(clause as i64))];
                Some(Landing { depth: scope.depth, target: *target, writes })
            }
            (ScopeKind::Cleanup { target }, _) => {
                Some(Landing { depth: scope.depth, target: *target, writes: [nothing, nothing] })
            }
            _ => None,
        }
    }

    fn land(&mut self, task: u32, landing: Landing) -> Unwound {
        self.tasks[task].leaving = None;
        Unwound::Land(landing)
    }

    fn land_in(&mut self, task: u32, scope: Scope, leaving: Leaving, landing: Landing) -> Unwound {
        self.tasks[task].scopes.pop();
        if let ScopeKind::Cleanup { .. } = scope.kind {
            let then = Box::new(Then::Leave(leaving));
            self.defer_stop(task);
            self.tasks[task].scopes.push(Scope { kind: ScopeKind::InCleanup(then), depth: scope.depth });
        } else {
            self.trace_handled(task, &leaving);
        }
        self.land(task, landing)
    }

    /// Leaves one scope without running code.
    fn pop_scope(&mut self, around: &mut Surroundings<'_>, task: u32, scope: Scope, leaving: Leaving) -> Popped {
        let index = self.tasks[task].scopes.len() as u32 - 1;
        match scope.kind {
            ScopeKind::Children(_) => {
                if let ScopeKind::Children(children) = &mut self.tasks[task].scopes[index as usize].kind
                    && children.decided.is_none()
                {
                    // No child decides anything any more.
                    children.decided = Some(crate::task::Decision::Succeed(Value::Nil));
                }
                for child in self.children_of_scope(task, index) {
                    self.evaporate(around, child);
                }
                if !self.children_of_scope(task, index).is_empty() {
                    return Popped::Wait(Waiting::Children);
                }
                self.tasks[task].scopes.pop();
            }
            ScopeKind::Call(call) => {
                for child in self.children_of_scope(task, index) {
                    self.evaporate(around, child);
                }
                if !self.children_of_scope(task, index).is_empty() {
                    return Popped::Wait(Waiting::Spawned);
                }
                self.end_call(around, task, &call.tags);
                self.trace_call_end(task, &leaving);
                self.tasks[task].scopes.pop();
                if let Leaving::FailCall { scope, failure } = leaving
                    && scope == index
                {
                    self.tasks[task].leaving = Some(Box::new(Leaving::Fail(failure)));
                }
            }
            ScopeKind::InCleanup(then) => {
                self.tasks[task].scopes.pop();
                self.leave_clean_up(around, task, *then, leaving);
            }
            ScopeKind::Valve(valve) => {
                self.tasks[task].scopes.pop();
                self.release_valve(around, task, valve);
            }
            ScopeKind::Suspended(other) => {
                self.tasks[task].scopes.pop();
                if let Some(other) = self.tasks.find_alive(other) {
                    self.resume(other);
                    self.update_task_fluents(around, other);
                }
            }
            ScopeKind::Watch(watch) => {
                self.tasks[task].scopes.pop();
                self.end_watch(watch);
            }
            ScopeKind::Block { .. }
            | ScopeKind::Handler { .. }
            | ScopeKind::Cleanup { .. }
            | ScopeKind::OnInterrupt(_)
            | ScopeKind::OnResume(_) => {
                self.tasks[task].scopes.pop();
            }
        }
        Popped::On
    }

    /// A departure leaves a clean-up before its end.
    fn leave_clean_up(&mut self, around: &Surroundings<'_>, task: u32, then: Then, leaving: Leaving) {
        let next = match (then, leaving) {
            (Then::Continue, leaving) => leaving,
            (Then::Leave(Leaving::Fail(failure)), Leaving::Fail(later)) => {
                if let (Value::Failure(index), true) = (failure, failure != later) {
                    self.heap.failures[index].while_cleaning_up.push(later);
                }
                Leaving::Fail(failure)
            }
            (Then::Leave(Leaving::FailCall { scope, failure }), Leaving::Fail(later)) => {
                if let Value::Failure(index) = failure {
                    self.heap.failures[index].while_cleaning_up.push(later);
                }
                Leaving::FailCall { scope, failure }
            }
            (Then::Leave(Leaving::Evaporate), Leaving::Fail(later)) => {
                self.warn_of_failure(around.program, later, "in a clean-up during evaporation");
                Leaving::Evaporate
            }
            (Then::Leave(Leaving::Block { .. } | Leaving::Jump { .. }), Leaving::Fail(later)) => Leaving::Fail(later),
            // A departure under way cannot be turned aside by an exit from its clean-up.
            (Then::Leave(before), _) => before,
        };
        self.tasks[task].leaving = Some(Box::new(next));
    }

    /// No scope is left: the task ends.
    fn leave_task(&mut self, around: &mut Surroundings<'_>, task: u32, leaving: Leaving) -> Unwound {
        match leaving {
            Leaving::Evaporate => self.die(around, task, State::Evaporated, Value::Nil),
            Leaving::Fail(failure) | Leaving::FailCall { failure, .. } => {
                self.die(around, task, State::Failed, failure);
            }
            Leaving::Block { .. } | Leaving::Jump { .. } => {
                let raise = Raise::new("control-error", "the block to return from is no longer there");
                let failure = self.failure_from(around.program, raise);
                self.die(around, task, State::Failed, failure);
            }
        }
        Unwound::Dead
    }

    /// Ends a plan call's tags.
    pub(crate) fn end_call(&mut self, around: &mut Surroundings<'_>, task: u32, tags: &[crate::value::TaskRef]) {
        let _ = task;
        for &tag in tags {
            if let Some(index) = self.tasks.find_alive(tag)
                && self.tasks[index].state == State::Created
                && self.tasks[index].parent == crate::task::NONE
            {
                self.die(around, index, State::Evaporated, Value::Nil);
            }
        }
    }

    /// Makes a task dead and lets everybody know.
    pub(crate) fn die(&mut self, around: &mut Surroundings<'_>, task: u32, state: State, result: Value) {
        if matches!(self.tasks[task].state, State::Created | State::Ready | State::Blocked)
            && state != State::Evaporated
        {
            // It was on its way out while not running.
            self.tasks[task].state = State::Running;
        }
        self.set_state(task, state);
        let record = &mut self.tasks[task];
        record.result = result;
        record.registers = Box::default();
        record.frames = Box::default();
        record.leaving = None;
        record.wake = Wake::Nothing;
        record.waiting = Waiting::Nothing;
        record.stop = 0;
        self.trace_task_end(around.program, task);
        self.end_activations_of(around, task);
        self.drop_holds_of(around, task);
        self.update_task_fluents(around, task);
        if let Some(rare) = &mut self.tasks[task].rare {
            for mourner in std::mem::take(&mut rare.mourners) {
                if let Some(mourner) = self.tasks.find_alive(mourner) {
                    self.wake(mourner, Wake::Value(Value::Nil));
                }
            }
        }
        self.hooks_ended(around, task);
        let (parent, scope) = (self.tasks[task].parent, self.tasks[task].parent_scope);
        if parent != crate::task::NONE && !self.tasks[task].named_as_hook() {
            self.child_ended(around, parent, scope, task);
        } else if parent != crate::task::NONE {
            self.disown(task);
        }
        if !self.tasks[task].exposed {
            self.tasks.free(task);
        }
    }

    /// Notes a failure that nothing can handle any more.
    pub(crate) fn warn_of_failure(&mut self, program: &Program, failure: Value, place: &str) {
        let text = self.show(program, failure);
        self.output.push(Output::Log(format!("warning: a failure {place}: {text}")));
        self.trace_warning(&text);
    }
}

enum Popped {
    On,
    Wait(Waiting),
}
