//! Tasks as data: registers, frames and scopes, no stack of the machine below.
//!
//! A task is a record in a slab. It has no Rust stack, closure, future or thread; so a run can be cloned between any
//! two instructions. The registers of all tasks that do not run lie in one store (`registers`).

mod children;
mod leaving;
mod life;
mod scope;
mod waiting;

pub use children::{Children, Decision, Held};
pub use leaving::{Leaving, Swap, Then};
pub use life::State;
pub use scope::{PlanCall, Scope, ScopeKind, Scopes};
use waiting::Prospect;
pub use waiting::{Raises, Waiting, Wake};

use crate::state::active_time::ActiveTime;
use crate::state::line::Line;
use crate::state::registers::Registers;
use crate::state::slab::NONE;
use crate::state::stack::Stack;
use crate::state::value::{TaskRef, Value};
use rpl_lang::code::Reg;
use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A call in progress: which code, where in it, and where its registers start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Frame {
    /// The code.
    pub code: u32,
    /// The next instruction.
    pub pc: u32,
    /// The first register, counted from the task's own first one.
    pub base: u32,
}

/// What the name of a task is that of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Naming {
    /// Its construct, whose only child it is, or what spawned it.
    #[default]
    Whole,
    /// Its construct, in which its path gives its position.
    Position,
    /// A tag or a process.
    Tag,
}

/// Fluents about a task, made when they are asked for.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TaskFluents {
    /// Its state.
    pub status: Option<u32>,
    /// Its value or failure.
    pub result: Option<u32>,
    /// Whether it has begun.
    pub begin: Option<u32>,
    /// Whether it is dead.
    pub end: Option<u32>,
}

/// What few tasks have.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rare {
    /// Fluents about it.
    pub fluents: TaskFluents,
    /// How often each name was used directly in it.
    pub counters: BTreeMap<Symbol, u32>,
    /// Whether the last run of each tag below it, and below no other tag, succeeded.
    pub finished: BTreeMap<Symbol, bool>,
    /// Suspensions of its own, which `resume` takes back.
    pub suspensions: u32,
    /// Suspensions of its own that only the scope or valve which made them takes back.
    pub holds: u32,
    /// Tasks whose forms suspend it, once for each form.
    pub suspended_by: Vec<TaskRef>,
    /// How many of its forms suspend a task.
    pub suspends: u32,
    /// How many stand in the next two lines.
    pub in_lines: u32,
    /// Tasks that wait until nothing below it runs any more.
    pub resters: Line,
    /// Tasks that wait for its death.
    pub mourners: Line,
    /// The priority of who waits for the clean-up or the hooks it belongs to: meanwhile it runs at
    /// least at that.
    pub boost: Option<u32>,
    /// It runs hooks for this place of a valve.
    pub hooks_for: Option<u32>,
    /// Places of valves it has taken, one for each hold.
    pub held: Vec<u32>,
    /// Places of valves that were taken away from it or from below it, and for which it is suspended.
    pub marked: Vec<u32>,
    /// Places of valves that somebody cannot take before the clean-ups or hooks in its subtree have ended.
    pub claimed: Vec<u32>,
    /// Counts suspensions of its own and of its ancestors. What runs in a clean-up of an ancestor
    /// does not count those of that ancestor and above.
    pub stop: u32,
    /// It was evaporated while a clean-up, a departure or the end of a construct was under way.
    pub evaporation_pending: bool,
    /// The plan it is to be given as soon as nothing is in the way.
    pub swap_pending: Option<Box<Swap>>,
    /// A plan call of it keeps the failure of a spawned child until nothing is in its way.
    pub failure_pending: bool,
    /// Hooks of the interruption it is in, which its clean-ups wait for.
    pub hooks_before: Option<TaskRef>,
    /// A departure that waits for children or for the next run.
    pub leaving: Option<Leaving>,
    /// It waits for a time worked.
    pub active_wait: Option<ActiveTime>,
}

/// A task. There may be millions: what few have is in [`Rare`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// Registers of all its frames, while it does not run.
    pub registers: Registers,
    /// The current frame, while it does not run.
    pub frame: Frame,
    /// The frames below the current one, while it does not run.
    pub frames: Stack<Frame>,
    /// Scopes, innermost last.
    pub scopes: Scopes,
    /// What it waits for, finds, or has come to.
    prospect: Prospect,
    /// Whether what it finds is a failure, raised where it waits.
    pub raises: Raises,
    /// What few tasks have.
    pub rare: Option<Box<Rare>>,
    /// The register that gets the value it waits for.
    pub wake_register: Reg,
    /// Where it is in its life. Written in [`Task::enter`] alone, so that no transition is made that is
    /// not in the table.
    state: State,
    /// A value names it, so its record outlives it.
    pub exposed: bool,
    /// What its name is that of.
    pub naming: Naming,
    /// How many numbers its priority has, trailing zeros included.
    pub priority_depth: u16,
    /// Its priority, by number in the table of priorities.
    pub priority: u32,
    /// The task around it.
    pub parent: u32,
    /// Index of the scope of the parent it belongs to.
    pub parent_scope: u32,
    /// Its place among the children of its construct.
    pub position: u32,
    /// The name in its path: of a tag, a process, or its construct.
    pub name: Symbol,
    /// How often the name was used before, from 1.
    pub occurrence: u32,
    /// Children, all constructs together, in order of creation.
    pub first_child: u32,
    /// The last child.
    pub last_child: u32,
    /// Siblings.
    pub next_sibling: u32,
    /// Siblings.
    pub previous_sibling: u32,
    /// The line it stands in: run queue, waiters of a fluent or of a task.
    pub next: u32,
    /// The line it stands in.
    pub previous: u32,
    /// Which wait of all it is, or, once it is ready, which end of a wait: a late timer is recognised by it, and who
    /// began to wait, or became ready, first.
    pub wait_number: u32,
}

// A blocked task is to cost 150 bytes: this, its generation, and a register.
const _: () = assert!(size_of::<Option<Task>>() <= 128);

impl Task {
    /// A task that has not started.
    pub fn new(code: u32, registers: Registers, name: Symbol, priority: u32) -> Self {
        Self {
            registers,
            frame: Frame { code, pc: 0, base: 0 },
            frames: Stack::default(),
            scopes: Scopes::default(),
            prospect: Prospect::Value(Value::Unbound),
            raises: Raises::Nothing,
            rare: None,
            wake_register: 0,
            state: State::Created,
            exposed: false,
            naming: Naming::Whole,
            priority_depth: 0,
            priority,
            parent: NONE,
            parent_scope: 0,
            position: 0,
            name,
            occurrence: 1,
            first_child: NONE,
            last_child: NONE,
            next_sibling: NONE,
            previous_sibling: NONE,
            next: NONE,
            previous: NONE,
            wait_number: 0,
        }
    }

    /// Where it is in its life.
    #[inline]
    pub fn state(&self) -> State {
        self.state
    }

    /// Goes on to another state of its life.
    ///
    /// # Panics
    /// If the table of transitions, [`State::may_become`], does not have this one.
    #[inline]
    pub(crate) fn enter(&mut self, state: State) {
        if !self.state.may_become(state) {
            refuse_transition(self.state, state);
        }
        self.state = state;
    }

    /// What it waits for, if it does.
    #[inline]
    pub fn waiting(&self) -> Option<Waiting> {
        match self.prospect {
            Prospect::Wait(waiting) => Some(waiting),
            Prospect::Value(_) => None,
        }
    }

    /// What it finds when it goes on, [`Value::Unbound`] if nothing or if it waits; once dead, its value or failure.
    #[inline]
    pub fn value(&self) -> &Value {
        match &self.prospect {
            Prospect::Wait(_) => &Value::Unbound,
            Prospect::Value(value) => value,
        }
    }

    /// Begins a wait. What it had found is gone.
    #[inline]
    pub(crate) fn wait(&mut self, waiting: Waiting) {
        (self.prospect, self.raises) = (Prospect::Wait(waiting), Raises::Nothing);
    }

    /// Ends its wait, if it does.
    pub(crate) fn end_wait(&mut self) -> Option<Waiting> {
        let waiting = self.waiting()?;
        self.prospect = Prospect::Value(Value::Unbound);
        Some(waiting)
    }

    /// Comes to a value or failure, at its end.
    pub(crate) fn conclude(&mut self, result: Value) {
        (self.prospect, self.raises) = (Prospect::Value(result), Raises::Nothing);
    }

    /// What it finds when it goes on. Its wait, if it had one, is over.
    #[inline]
    pub fn set_wake(&mut self, wake: Wake) {
        let (value, raises) = match wake {
            Wake::Nothing => (Value::Unbound, Raises::Nothing),
            Wake::Value(value) => (value, Raises::Nothing),
            Wake::Raise(failure) => (failure, Raises::Failure),
            Wake::Outcome(failure) => (failure, Raises::Outcome),
        };
        (self.prospect, self.raises) = (Prospect::Value(value), raises);
    }

    /// Takes what it finds now that it goes on.
    pub fn take_wake(&mut self) -> Wake {
        let value = *self.value();
        self.prospect = Prospect::Value(Value::Unbound);
        match (value, std::mem::take(&mut self.raises)) {
            (Value::Unbound, _) => Wake::Nothing,
            (value, Raises::Nothing) => Wake::Value(value),
            (failure, Raises::Failure) => Wake::Raise(failure),
            (failure, Raises::Outcome) => Wake::Outcome(failure),
        }
    }

    /// The departure under way.
    pub fn leaving(&self) -> Option<&Leaving> {
        self.rare.as_ref()?.leaving.as_ref()
    }

    /// Whether a departure is under way.
    pub fn is_leaving(&self) -> bool {
        self.leaving().is_some()
    }

    /// Begins a departure, or turns the one under way into another.
    pub fn leave(&mut self, leaving: Leaving) {
        self.rare().leaving = Some(leaving);
    }

    /// The failure of a spawned child that one of its plan calls keeps, with the index of the call.
    pub fn take_call_failure(&mut self) -> Option<(u32, Value)> {
        let rare = self.rare.as_mut().filter(|rare| rare.failure_pending)?;
        let failed = self.scopes.iter_mut().enumerate().rev().find_map(|(index, scope)| match &mut scope.kind {
            ScopeKind::Call(call) => call.failure.take().map(|failure| (index as u32, failure)),
            _ => None,
        });
        rare.failure_pending = failed.is_some();
        failed
    }

    /// Takes the plan out that it is to be given.
    pub(crate) fn take_swap(&mut self) -> Option<Box<Swap>> {
        self.rare.as_mut()?.swap_pending.take()
    }

    /// Ends the departure under way.
    pub fn take_leaving(&mut self) -> Option<Leaving> {
        self.rare.as_mut()?.leaving.take()
    }

    /// Whether the construct it waits for, or waited for, is decided and has not had its effect.
    pub fn is_committed(&self) -> bool {
        let is_decided =
            |scope: &Scope| matches!(&scope.kind, ScopeKind::Children(children) if children.decided.is_some());
        self.raises == Raises::Outcome
            || self.waiting() == Some(Waiting::Children) && self.scopes.last().is_some_and(is_decided)
    }

    /// Whether it was evaporated while a clean-up or a departure was under way.
    pub fn is_evaporation_pending(&self) -> bool {
        self.rare.as_ref().is_some_and(|rare| rare.evaporation_pending)
    }

    /// Suspensions of its own and of its ancestors.
    pub fn stop(&self) -> u32 {
        self.rare.as_ref().map_or(0, |rare| rare.stop)
    }

    /// What few tasks have, made if need be.
    pub fn rare(&mut self) -> &mut Rare {
        self.rare.get_or_insert_default()
    }

    /// Whether it runs a clean-up, which nothing from outside stops.
    pub fn is_cleaning_up(&self) -> bool {
        self.scopes.last_clean_up().is_some()
    }

    /// Whether a suspension keeps it from running.
    pub fn is_held(&self) -> bool {
        self.stop() > 0 && !self.is_protected()
    }

    /// Whether a scope belongs to a clean-up.
    pub fn is_within_clean_up(&self, scope: u32) -> bool {
        self.scopes.first_clean_up().is_some_and(|clean_up| clean_up < scope)
    }

    /// Suspensions of its own.
    pub fn own_stops(&self) -> u32 {
        self.rare.as_ref().map_or(0, |rare| rare.suspensions + rare.holds)
    }

    /// Whether nothing from outside may stop it now: a clean-up runs or is about to.
    pub fn is_protected(&self) -> bool {
        self.is_leaving() || self.is_cleaning_up()
    }

    /// Whether the task runs hooks of its parent and is no child of a construct.
    pub(crate) fn named_as_hook(&self) -> bool {
        self.rare.as_ref().is_some_and(|rare| rare.hooks_for.is_some())
    }

    /// Places of valves it has holds of, one for each hold.
    pub(crate) fn held(&self) -> &[u32] {
        self.rare.as_ref().map_or(&[], |rare| &rare.held)
    }
}

#[cold]
fn refuse_transition(from: State, to: State) -> ! {
    panic!("a task cannot become {} after {}", to.name(), from.name())
}
