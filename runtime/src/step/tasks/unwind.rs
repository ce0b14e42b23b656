//! Leaving early: evaporation, failures on their way to a handler, and exits from blocks.
//!
//! A departure pops scopes, innermost first. It pauses while children die or a clean-up runs, and
//! its outcome is fixed when it starts: what happens meanwhile is attached to it.

use crate::state::machine::{Machine, SCRATCH_TASK};
use crate::state::scratch::Departure;
use crate::state::slab::NONE;
use crate::state::task::{Decision, Leaving, Raises, Scope, ScopeKind, State, Then, Waiting};
use crate::state::value::{TaskRef, Value};
use crate::step::native::Surroundings;
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
    /// It is in another plan, at whose first instruction it goes on.
    Swapped {
        /// The task that gave it the plan, if one did.
        by: Option<TaskRef>,
    },
}

enum Popped {
    On,
    Wait(Waiting),
}

impl Machine {
    /// Goes on with the departure of a task that is not running, as far as that needs no code.
    pub(crate) fn unwind(&mut self, around: &mut Surroundings<'_>, task: u32) {
        self.scratch.departures.push(Departure::GoOn(self.tasks.reference(task)));
        self.look_at_departures(around);
    }

    pub(crate) fn go_on_leaving(&mut self, around: &mut Surroundings<'_>, task: u32) {
        if self.tasks[task].state() != State::Blocked || !self.tasks[task].is_leaving() {
            return;
        }
        self.tasks[task].end_wait();
        self.number_wait(task);
        match self.unwind_step(around, task, false) {
            Unwound::Land(_) => self.make_ready(task),
            Unwound::Swapped { by } => {
                if self.take_up_pending(around, task) {
                    self.unwind(around, task);
                } else {
                    self.make_ready(task);
                }
                self.tell_swapped(by, task);
            }
            Unwound::Waiting | Unwound::Dead => {}
        }
    }

    /// Pops scopes until something must run, be waited for, or nothing is left. Unless `may_run`,
    /// it stops before what needs code and answers [`Unwound::Land`] without having popped it.
    pub(crate) fn unwind_step(&mut self, around: &mut Surroundings<'_>, task: u32, may_run: bool) -> Unwound {
        loop {
            self.take_up_evaporation(around, task);
            let Some(leaving) = self.tasks[task].leaving().cloned() else {
                return Unwound::Dead;
            };
            let count = self.tasks[task].scopes.len();
            if let Leaving::Jump { scopes, target, depth } = leaving
                && count == scopes as usize
            {
                return self.land(task, Landing { depth, target, writes: [(0, Value::Unbound); 2] });
            }
            let Some(scope) = self.tasks[task].scopes.last().cloned() else {
                // Only hooks are left.
                let hooks = self.children(task);
                self.evaporate_all(around, &hooks);
                if self.tasks[task].first_child != NONE {
                    return self.wait_to_leave(task, Waiting::Children);
                }
                return match leaving {
                    Leaving::Swap(swap) => self.begin_plan(around, task, &swap),
                    leaving => self.leave_task(around, task, leaving),
                };
            };
            if let Some(landing) = self.landing(around.program, task, &scope, &leaving) {
                if let (ScopeKind::Cleanup { .. }, Some(hooks)) = (&scope.kind, self.hooks_before(task)) {
                    return self.wait_to_leave(task, Waiting::Hooks(hooks));
                }
                if !may_run {
                    return Unwound::Land(landing);
                }
                return self.land_in(task, scope, leaving, landing);
            }
            match self.pop_scope(around, task, scope, leaving) {
                Popped::On => {}
                Popped::Wait(waiting) => return self.wait_to_leave(task, waiting),
            }
        }
    }

    fn wait_to_leave(&mut self, task: u32, waiting: Waiting) -> Unwound {
        self.tasks[task].wait(waiting);
        if self.tasks[task].state() == State::Running {
            self.set_state(task, State::Blocked);
        }
        Unwound::Waiting
    }

    /// Hooks that run for the interruption a task is in when it begins to leave: they and its clean-ups would use the
    /// same things. If they run for it and what is below it, they are ended; others are waited for, unless they end the
    /// task themselves.
    pub(crate) fn note_hooks_before(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let Some((root, hooks)) = self.hooks_around(task) else { return };
        if self.current != NONE && self.is_within(self.current, hooks) {
            return;
        }
        self.tasks[task].rare().hooks_before = Some(self.tasks.reference(hooks));
        if root == task {
            self.evaporate(around, hooks);
        }
    }

    /// Hooks that still run and that the clean-ups of a task wait for.
    fn hooks_before(&self, task: u32) -> Option<u32> {
        self.tasks.find_alive(self.tasks[task].rare.as_ref()?.hooks_before?)
    }

    /// Hooks have ended, and `root` was interrupted: clean-ups below it that waited for that begin.
    pub(crate) fn begin_clean_ups_below(&mut self, around: &mut Surroundings<'_>, root: u32, hooks: u32) {
        let mut waiting = vec![root];
        while let Some(task) = waiting.pop() {
            if self.tasks[task].waiting() == Some(Waiting::Hooks(hooks)) {
                self.unwind(around, task);
            }
            waiting.extend(self.children(task).into_iter().rev());
        }
    }

    /// The root of an interruption that a task is in, and the task that runs hooks for it now.
    pub(crate) fn hooks_around(&self, task: u32) -> Option<(u32, u32)> {
        let mut reaches = Some(task);
        while let Some(at) = reaches.filter(|&at| self.tasks[at].stop() > 0) {
            let record = &self.tasks[at];
            for &place in record.rare.iter().flat_map(|rare| &rare.marked) {
                let entry = &self.places[place as usize];
                let hooks = entry.handover.and(entry.top_hold()).and_then(|(_, hold)| self.tasks.find_alive(hold.task));
                if let Some(hooks) = hooks.filter(|&hooks| self.tasks[hooks].parent == at) {
                    return Some((at, hooks));
                }
            }
            reaches = self.suspends_with_it(at);
        }
        None
    }

    /// An evaporation that came during a clean-up takes effect after it, unless the task is
    /// already on its way out.
    fn take_up_evaporation(&mut self, around: &Surroundings<'_>, task: u32) {
        let record = &self.tasks[task];
        if !record.is_evaporation_pending() || record.is_cleaning_up() {
            return;
        }
        let is_terminal = match record.leaving() {
            Some(Leaving::Evaporate) => true,
            Some(leaving) => self.unhandled(around.program, task, leaving, record.scopes.len()).is_some(),
            None => false,
        };
        if !is_terminal {
            self.tasks[task].leave(Leaving::Evaporate);
        }
        self.tasks[task].rare().evaporation_pending = false;
    }

    /// The failure a task will end with, whatever comes: that of a departure or of a decided construct
    /// which nothing in it handles.
    pub(crate) fn fixed_failure(&self, around: &Surroundings<'_>, task: u32) -> Option<Value> {
        let (program, record) = (around.program, &self.tasks[task]);
        let cut_short = record.scopes.clean_ups().find_map(|(index, then)| match then {
            Then::Leave(leaving) => Some((index, leaving)),
            Then::Continue => None,
        });
        if let Some((index, leaving)) = cut_short {
            return self.unhandled(program, task, leaving, index);
        }
        // A construct in progress is the innermost scope.
        if let Some(Scope { kind: ScopeKind::Children(children), .. }) = record.scopes.last()
            && let Some(Decision::Fail(failure)) = children.decided
            && !record.is_leaving()
        {
            return self.unhandled(program, task, &Leaving::Fail(failure), record.scopes.len() - 1);
        }
        let outcome = (record.raises == Raises::Outcome).then_some(Leaving::Fail(*record.value()));
        let leaving = record.leaving().or(outcome.as_ref())?;
        self.unhandled(program, task, leaving, record.scopes.len())
    }

    /// The failure of a departure, unless one of the first scopes handles it.
    fn unhandled(&self, program: &Program, task: u32, leaving: &Leaving, within: usize) -> Option<Value> {
        let (failure, within) = match leaving {
            Leaving::Fail(failure) => (*failure, within),
            Leaving::FailCall { scope, failure } => (*failure, within.min(*scope as usize)),
            Leaving::Evaporate | Leaving::Block { .. } | Leaving::Jump { .. } | Leaving::Swap(_) => return None,
        };
        (!self.is_handled(program, task, failure, within)).then_some(failure)
    }

    fn is_handled(&self, program: &Program, task: u32, failure: Value, within: usize) -> bool {
        let leaving = Leaving::Fail(failure);
        self.tasks[task].scopes[..within].iter().any(|scope| {
            matches!(scope.kind, ScopeKind::Handler { .. }) && self.landing(program, task, scope, &leaving).is_some()
        })
    }

    /// Where code goes on if this scope stops the departure, or has a clean-up to run.
    fn landing(&self, program: &Program, task: u32, scope: &Scope, leaving: &Leaving) -> Option<Landing> {
        let nothing = (0, Value::Unbound);
        match (&scope.kind, leaving) {
            (ScopeKind::Block { identity, result, target }, Leaving::Block { identity: wanted, value })
                if identity == wanted =>
            {
                Some(Landing { depth: scope.depth, target: *target, writes: [(*result, *value), nothing] })
            }
            (ScopeKind::Handler { code, index, failure, target }, Leaving::Fail(Value::Failure(raised))) => {
                if self.passes_handlers(task, *raised) {
                    return None;
                }
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

    /// The second time that a limit is reached in one instant, or in one evaluation, nothing handles that.
    fn passes_handlers(&self, task: u32, failure: u32) -> bool {
        let times = if task == SCRATCH_TASK { self.scratch.overdrawn } else { self.spent.times };
        self.heap.failures[failure].is_runaway && times >= 2
    }

    /// What waited for the end of a clean-up takes effect: tells whether the task leaves.
    pub(crate) fn take_up_pending(&mut self, around: &mut Surroundings<'_>, task: u32) -> bool {
        let record = &mut self.tasks[task];
        if record.is_leaving() {
            return true;
        }
        if record.is_cleaning_up() {
            return false;
        }
        if record.is_evaporation_pending() {
            record.rare().evaporation_pending = false;
            record.leave(Leaving::Evaporate);
            return true;
        }
        if let Some((scope, failure)) = record.take_call_failure() {
            record.leave(Leaving::FailCall { scope, failure });
            return true;
        }
        self.refresh_boost(task);
        self.note_status(task);
        self.protection_ended(around, task);
        self.scratch.switch |= self.tasks[task].is_held();
        self.tasks[task].is_leaving()
    }

    fn land(&mut self, task: u32, landing: Landing) -> Unwound {
        self.tasks[task].take_leaving();
        // Whoever has become ready meanwhile and is more important goes first.
        self.scratch.switch = true;
        Unwound::Land(landing)
    }

    fn land_in(&mut self, task: u32, scope: Scope, leaving: Leaving, landing: Landing) -> Unwound {
        self.tasks[task].scopes.pop();
        let landed = self.land(task, landing);
        if let ScopeKind::Cleanup { .. } = scope.kind {
            let then = Box::new(Then::Leave(leaving));
            self.tasks[task].scopes.push(Scope { kind: ScopeKind::InCleanup(then), depth: scope.depth });
            self.note_in_the_way(task);
            self.refresh_boost(task);
            // It goes on leaving: what it gave back on its way does not keep it from its clean-ups.
            self.scratch.switch = false;
        } else {
            self.trace_handled(task, &leaving);
        }
        landed
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
                    children.decided = Some(Decision::Succeed(Value::Nil));
                }
                if self.evaporate_children(around, task, index) > 0 {
                    return Popped::Wait(Waiting::Children);
                }
                self.tasks[task].scopes.pop();
            }
            ScopeKind::Call(call) => {
                if self.evaporate_children(around, task, index) > 0 {
                    return Popped::Wait(Waiting::Spawned);
                }
                let late = match &mut self.tasks[task].scopes[index as usize].kind {
                    ScopeKind::Call(call) => call.failure.take(),
                    _ => None,
                };
                if let Some(failure) = late {
                    self.attach_late(around, &leaving, failure);
                }
                self.end_call(around, &call.tags);
                self.trace_call_end(task, &leaving);
                self.tasks[task].scopes.pop();
                if let Leaving::FailCall { scope, failure } = leaving
                    && scope == index
                {
                    self.tasks[task].leave(Leaving::Fail(failure));
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
                self.unhold_for_scope(around, other, task);
            }
            ScopeKind::Watch(watch) => {
                self.tasks[task].scopes.pop();
                self.end_watch(watch);
            }
            ScopeKind::Block { .. }
            | ScopeKind::Handler { .. }
            | ScopeKind::Cleanup { .. }
            | ScopeKind::OnInterrupt(_)
            | ScopeKind::OnResume(_)
            // Who waits for the end of a fence is told when the departure is over.
            | ScopeKind::Fence => {
                self.tasks[task].scopes.pop();
            }
        }
        Popped::On
    }

    /// A failure that comes after an outcome is fixed is kept beside it.
    fn attach_late(&mut self, around: &Surroundings<'_>, leaving: &Leaving, failure: Value) {
        match leaving {
            Leaving::Fail(Value::Failure(first)) | Leaving::FailCall { failure: Value::Failure(first), .. } => {
                if Value::Failure(*first) != failure {
                    self.heap.failures[*first].while_cleaning_up.push(failure);
                }
            }
            _ => self.warn_of_failure(around.program, failure, "of a spawned task while its plan was ending"),
        }
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
            (Then::Leave(Leaving::Swap(swap)), Leaving::Fail(later)) => {
                self.warn_of_failure(around.program, later, "in a clean-up before another plan");
                Leaving::Swap(swap)
            }
            (Then::Leave(Leaving::Block { .. } | Leaving::Jump { .. }), Leaving::Fail(later)) => Leaving::Fail(later),
            // A departure under way cannot be turned aside by an exit from its clean-up.
            (Then::Leave(before), _) => before,
        };
        self.tasks[task].leave(next);
    }
}
