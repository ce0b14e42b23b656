//! Tasks as data: registers, frames and scopes, no stack of the machine below.
//!
//! States and legal transitions:
//!
//! | from | to |
//! | --- | --- |
//! | created | ready, evaporated |
//! | ready | running, evaporated (only before its first step), blocked (when it is parked by a suspension) |
//! | running | ready (switched out), blocked, succeeded, failed, evaporated |
//! | blocked | ready, evaporated, failed |
//! | succeeded, failed, evaporated | – |
//!
//! `suspended` is not a state of its own here but a count ([`Rare::stop`]) over any living state: a task
//! runs when its own suspensions and its ancestors' are zero.

use crate::active_time::ActiveTime;
use crate::registers::{RegisterStore, Registers};
use crate::scheduler::Line;
use crate::slab::Slab;
use crate::value::{TaskRef, Value};
use rpl_lang::code::{Reg, Rule};
use rpl_lang::source::Span;
use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// No task, no fluent.
pub const NONE: u32 = u32::MAX;

/// Where a task is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum State {
    /// Known by its tag or held back by an order; has not started.
    Created,
    /// In the run queue, or would be if it were not suspended.
    Ready,
    /// Its code is being executed.
    Running,
    /// Waits for something.
    Blocked,
    /// Ended well.
    Succeeded,
    /// Ended with a failure.
    Failed,
    /// Was ended from outside.
    Evaporated,
}

impl State {
    /// Whether it never changes again.
    pub fn is_dead(self) -> bool {
        matches!(self, State::Succeeded | State::Failed | State::Evaporated)
    }

    /// The symbol `(status T)` holds.
    pub fn name(self) -> &'static str {
        match self {
            State::Created => "created",
            State::Ready => "ready",
            State::Running => "running",
            State::Blocked => "blocked",
            State::Succeeded => "succeeded",
            State::Failed => "failed",
            State::Evaporated => "evaporated",
        }
    }

    /// The table above.
    pub fn may_become(self, next: State) -> bool {
        use State::{Blocked, Created, Evaporated, Failed, Ready, Running, Succeeded};
        match self {
            Created => matches!(next, Ready | Evaporated),
            Ready => matches!(next, Running | Evaporated | Blocked),
            Running => matches!(next, Ready | Blocked | Succeeded | Failed | Evaporated),
            Blocked => matches!(next, Ready | Evaporated | Failed),
            Succeeded | Failed | Evaporated => false,
        }
    }
}

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

/// What a blocked task waits for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Waiting {
    /// Nothing.
    #[default]
    Nothing,
    /// A fluent to be true.
    Fluent {
        /// The fluent.
        fluent: u32,
        /// Whether it dies with the wait.
        owned: bool,
        /// Whether a timer ends the wait.
        timed: bool,
    },
    /// A watched fluent to become true.
    Watch(u32),
    /// A time.
    Time,
    /// The children of its innermost construct.
    Children,
    /// Children that it spawned in the plan call that is ending.
    Spawned,
    /// A valve.
    Valve(u32),
    /// The death of another task, which it has evaporated.
    Death(u32),
    /// Another task, which it has suspended, to have no clean-up running any more.
    Rest(u32),
    /// The signal of a behaviour.
    Signal(u16),
}

/// What a task finds when it goes on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Wake {
    /// It was not woken.
    #[default]
    Nothing,
    /// A value for the register it waits with.
    Value(Value),
    /// A failure, raised where it waits.
    Raise(Value),
    /// The failure of the construct it waited for. It is fixed: an evaporation does not take its place.
    Outcome(Value),
}

/// Whether what a task finds when it goes on is a failure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Raises {
    /// No.
    #[default]
    Nothing,
    /// A failure.
    Failure,
    /// The failure of a construct.
    Outcome,
}

/// A departure from the ordinary course of a task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Leaving {
    /// Ended from outside.
    Evaporate,
    /// A failure looks for its handler.
    Fail(Value),
    /// A spawned child failed, and so does the plan call it belongs to.
    FailCall {
        /// Index of the plan call's scope.
        scope: u32,
        /// The child's failure.
        failure: Value,
    },
    /// Out of a block.
    Block {
        /// The block.
        identity: u64,
        /// The block's value.
        value: Value,
    },
    /// To an instruction, once the scopes in between are left.
    Jump {
        /// Scopes that stay.
        scopes: u32,
        /// The instruction.
        target: u32,
        /// Frames below the one it is in.
        depth: u32,
    },
}

/// What follows a clean-up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Then {
    /// The next instruction: the protected part had ended by itself.
    Continue,
    /// What cut the protected part short.
    Leave(Leaving),
}

/// A plan call: a node of the task tree.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Call {
    /// The plan.
    pub name: Symbol,
    /// How many calls of this name its surroundings had before, from 1.
    pub occurrence: u32,
    /// Where it was called.
    pub span: Option<Span>,
    /// How often each name was used in it.
    pub counters: BTreeMap<Symbol, u32>,
    /// Spawned children that live.
    pub spawned: u32,
    /// Tags that were made for it.
    pub tags: Vec<TaskRef>,
    /// How many of them there may be before they are looked through.
    pub most_tags: u32,
    /// The failure of a spawned child that came while nothing could stop the task.
    pub failure: Option<Value>,
}

/// How a construct ends, decided when one of its children does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Decision {
    /// With a value.
    Succeed(Value),
    /// With a failure.
    Fail(Value),
}

/// A child that a partial order holds back.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Held {
    /// Its place among the children.
    pub position: u16,
    /// How many constraints keep it from starting.
    pub constraints: u32,
    /// The child.
    pub task: TaskRef,
}

/// The children of a construct in progress.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Children {
    /// How the outcome is decided.
    pub rule: Rule,
    /// The construct's name.
    pub name: Symbol,
    /// How many constructs of this name its surroundings had before, from 1.
    pub occurrence: u32,
    /// The register its value goes to.
    pub result: Reg,
    /// Children that are not dead.
    pub alive: u32,
    /// All children.
    pub total: u32,
    /// Once this is set, no child runs anything but clean-ups.
    pub decided: Option<Decision>,
    /// Value of the last child by position, once it has succeeded.
    pub last_value: Value,
    /// Failures of children, in the order in which they failed.
    pub failures: Vec<Value>,
    /// For a partial order: constraints between positions, sorted.
    pub order: Vec<(u16, u16)>,
    /// For a partial order: the children that cannot start at once, by position.
    pub held: Vec<Held>,
    /// For a timeout: seconds, and the number of its timer.
    pub seconds: f64,
    /// The timer of a timeout; 0 while there is none.
    pub timer: u64,
    /// For a timeout of time worked.
    pub active: Option<ActiveTime>,
    /// When the deadline came, if the task was suspended then; it takes effect at the resume.
    pub expired_us: Option<u64>,
}

impl Children {
    /// Whether no child can be done without.
    pub fn needs_all(&self) -> bool {
        self.decided.is_some() || matches!(self.rule, Rule::Par | Rule::Plan | Rule::Single)
    }
}

/// A dynamic scope of a task, left in the reverse order of entering.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ScopeKind {
    /// A block that can be left from inside a closure.
    Block {
        /// By which a closure names it.
        identity: u64,
        /// The register of its value.
        result: Reg,
        /// The instruction behind it.
        target: u32,
    },
    /// Catches failures.
    Handler {
        /// The code whose list of clauses it has.
        code: u32,
        /// Which of that code's lists.
        index: u32,
        /// The register of the failure; the next one gets the number of the clause.
        failure: Reg,
        /// The instruction where the clauses begin.
        target: u32,
    },
    /// A clean-up that runs when the scope is left early.
    Cleanup {
        /// The instruction where it begins.
        target: u32,
    },
    /// A clean-up is running.
    InCleanup(Box<Then>),
    /// A plan call.
    Call(Box<Call>),
    /// A construct with children.
    Children(Box<Children>),
    /// A valve is held.
    Valve(u32),
    /// Runs when the subtree is interrupted.
    OnInterrupt(Value),
    /// Runs when the subtree gets its valve back.
    OnResume(Value),
    /// Another task is suspended.
    Suspended(TaskRef),
    /// A fluent is watched.
    Watch(u32),
}

/// A scope and the number of frames below the one that opened it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scope {
    /// What it is.
    pub kind: ScopeKind,
    /// Frames below its own.
    pub depth: u32,
}

/// The scopes of a task, innermost last. Where its clean-ups and its plan calls are is known without
/// looking through them, for they may be many.
#[derive(Clone, Debug, Default)]
pub struct Scopes(Option<Box<ScopeStack>>);

#[derive(Clone, Debug, Default)]
struct ScopeStack {
    all: Vec<Scope>,
    /// Which of them are clean-ups that run.
    clean_ups: Vec<u32>,
    /// Which of them are plan calls.
    calls: Vec<u32>,
}

impl Scopes {
    /// Enters a scope.
    pub fn push(&mut self, scope: Scope) {
        let stack = self.0.get_or_insert_default();
        let index = stack.all.len() as u32;
        match scope.kind {
            ScopeKind::InCleanup(_) => stack.clean_ups.push(index),
            ScopeKind::Call(_) => stack.calls.push(index),
            ScopeKind::Block { .. }
            | ScopeKind::Handler { .. }
            | ScopeKind::Cleanup { .. }
            | ScopeKind::Children(_)
            | ScopeKind::Valve(_)
            | ScopeKind::OnInterrupt(_)
            | ScopeKind::OnResume(_)
            | ScopeKind::Suspended(_)
            | ScopeKind::Watch(_) => {}
        }
        stack.all.push(scope);
    }

    /// Leaves the innermost scope.
    pub fn pop(&mut self) -> Option<Scope> {
        let stack = self.0.as_mut()?;
        let scope = stack.all.pop()?;
        match scope.kind {
            ScopeKind::InCleanup(_) => drop(stack.clean_ups.pop()),
            ScopeKind::Call(_) => drop(stack.calls.pop()),
            ScopeKind::Block { .. }
            | ScopeKind::Handler { .. }
            | ScopeKind::Cleanup { .. }
            | ScopeKind::Children(_)
            | ScopeKind::Valve(_)
            | ScopeKind::OnInterrupt(_)
            | ScopeKind::OnResume(_)
            | ScopeKind::Suspended(_)
            | ScopeKind::Watch(_) => {}
        }
        Some(scope)
    }

    /// The clean-ups that run, outermost first, with their indices and what follows them.
    pub fn clean_ups(&self) -> impl Iterator<Item = (usize, &Then)> {
        let (all, clean_ups) = self.0.as_ref().map_or((&[][..], &[][..]), |stack| (&stack.all, &stack.clean_ups));
        clean_ups.iter().filter_map(|&clean_up| match &all[clean_up as usize].kind {
            ScopeKind::InCleanup(then) => Some((clean_up as usize, &**then)),
            _ => None,
        })
    }

    /// The outermost clean-up that runs.
    pub fn first_clean_up(&self) -> Option<u32> {
        self.0.as_ref()?.clean_ups.first().copied()
    }

    /// The innermost clean-up that runs.
    pub fn last_clean_up(&self) -> Option<u32> {
        self.0.as_ref()?.clean_ups.last().copied()
    }

    /// The innermost plan call among the first scopes.
    pub fn call_within(&self, scopes: usize) -> Option<usize> {
        self.calls_within(scopes).next().map(|(index, _)| index)
    }

    /// The plan calls among the first scopes, innermost first, with their indices.
    pub fn calls_within(&self, scopes: usize) -> impl Iterator<Item = (usize, &Call)> {
        let (all, calls) = self.0.as_ref().map_or((&[][..], &[][..]), |stack| (&stack.all, &stack.calls));
        let within = calls.partition_point(|&call| (call as usize) < scopes);
        calls[..within].iter().rev().filter_map(|&call| match &all[call as usize].kind {
            ScopeKind::Call(record) => Some((call as usize, &**record)),
            _ => None,
        })
    }

    /// The innermost plan call.
    pub fn innermost_call(&mut self) -> Option<&mut Call> {
        let index = self.call_within(usize::MAX)?;
        match &mut self[index].kind {
            ScopeKind::Call(call) => Some(call),
            _ => None,
        }
    }
}

impl PartialEq for Scopes {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl std::ops::Deref for Scopes {
    type Target = [Scope];

    fn deref(&self) -> &[Scope] {
        self.0.as_ref().map_or(&[], |stack| &stack.all)
    }
}

/// What a scope is does not change while it is entered.
impl std::ops::DerefMut for Scopes {
    fn deref_mut(&mut self) -> &mut [Scope] {
        self.0.as_mut().map_or(&mut [], |stack| &mut stack.all)
    }
}

impl Serialize for Scopes {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (**self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Scopes {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut scopes = Self::default();
        Vec::<Scope>::deserialize(deserializer)?.into_iter().for_each(|scope| scopes.push(scope));
        Ok(scopes)
    }
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
    /// Suspensions of its own, which `resume` takes back.
    pub suspensions: u32,
    /// Suspensions of its own that only the scope or valve which made them takes back.
    pub holds: u32,
    /// How many stand in the next two lines.
    pub in_lines: u32,
    /// Tasks that wait until nothing below it runs any more.
    pub resters: Line,
    /// Tasks that wait for its death.
    pub mourners: Line,
    /// The priority of who waits for the clean-up or the hooks it belongs to: meanwhile it runs at
    /// least at that.
    pub boost: Option<u32>,
    /// It runs hooks for this valve.
    pub hooks_for: Option<u32>,
    /// Valves it has taken, one for each hold.
    pub held: Vec<u32>,
    /// Valves that were taken away from it or from below it, and for which it is suspended.
    pub marked: Vec<u32>,
    /// Valves that somebody cannot take before the clean-ups or hooks in its subtree have ended.
    pub claimed: Vec<u32>,
    /// Counts suspensions of its own and of its ancestors. What runs in a clean-up of an ancestor
    /// does not count those of that ancestor and above.
    pub stop: u32,
    /// It was evaporated while a clean-up, a departure or the end of a construct was under way.
    pub evaporation_pending: bool,
    /// A plan call of it keeps the failure of a spawned child until nothing is in its way.
    pub failure_pending: bool,
    /// A departure that waits for children or for the next run.
    pub leaving: Option<Leaving>,
    /// It waits for a time worked.
    pub active_wait: Option<ActiveTime>,
}

/// A stack that takes one word while it is empty.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stack<T>(
    #[expect(clippy::box_collection, reason = "a word in every task instead of three")] Option<Box<Vec<T>>>,
);

impl<T> Default for Stack<T> {
    fn default() -> Self {
        Self(None)
    }
}

impl<T> Stack<T> {
    /// Adds on top.
    pub fn push(&mut self, item: T) {
        self.0.get_or_insert_default().push(item);
    }
}

impl<T: Clone> Stack<T> {
    /// Holds these items and no others from now on.
    pub fn set(&mut self, items: &[T]) {
        match &mut self.0 {
            Some(held) => {
                held.clear();
                held.extend_from_slice(items);
            }
            None if items.is_empty() => {}
            None => self.0 = Some(Box::new(items.to_vec())),
        }
    }
}

impl<T> std::ops::Deref for Stack<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        self.0.as_ref().map_or(&[], |items| items)
    }
}

impl<T> std::ops::DerefMut for Stack<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        self.0.as_mut().map_or(&mut [], |items| items)
    }
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
    /// What it finds when it goes on, [`Value::Unbound`] if nothing; once dead, its value or failure.
    pub value: Value,
    /// Whether that is a failure, raised where it waits.
    pub raises: Raises,
    /// What few tasks have.
    pub rare: Option<Box<Rare>>,
    /// The register that gets the value it waits for.
    pub wake_register: Reg,
    /// Where it is in its life.
    pub state: State,
    /// A value names it, so its record outlives it.
    pub exposed: bool,
    /// Whether the path gives its position.
    pub named_by_construct: bool,
    /// How often it, or what it started, ran away or was deadlocked in the instant of its budget.
    pub strikes: u8,
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
    /// What it waits for.
    pub waiting: Waiting,
    /// Which wait of all it is, or was last: a late timer is recognised by it, and who began to wait
    /// first.
    pub wait_number: u32,
    /// Steps in the instant `budget_instant`.
    pub steps: u32,
    /// The instant in which `steps` were counted.
    pub budget_instant: u32,
}

// A blocked task is to cost 160 bytes: this, its generation, and a register.
const _: () = assert!(size_of::<Option<Task>>() <= 136);

impl Task {
    /// A task that has not started.
    pub fn new(code: u32, registers: Registers, name: Symbol, priority: u32) -> Self {
        Self {
            registers,
            frame: Frame { code, pc: 0, base: 0 },
            frames: Stack::default(),
            scopes: Scopes::default(),
            value: Value::Unbound,
            raises: Raises::Nothing,
            rare: None,
            wake_register: 0,
            state: State::Created,
            exposed: false,
            named_by_construct: false,
            strikes: 0,
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
            waiting: Waiting::Nothing,
            wait_number: 0,
            steps: 0,
            budget_instant: 0,
        }
    }

    /// What it finds when it goes on.
    pub fn set_wake(&mut self, wake: Wake) {
        (self.value, self.raises) = match wake {
            Wake::Nothing => (Value::Unbound, Raises::Nothing),
            Wake::Value(value) => (value, Raises::Nothing),
            Wake::Raise(failure) => (failure, Raises::Failure),
            Wake::Outcome(failure) => (failure, Raises::Outcome),
        };
    }

    /// Takes what it finds now that it goes on.
    pub fn take_wake(&mut self) -> Wake {
        match (std::mem::replace(&mut self.value, Value::Unbound), std::mem::take(&mut self.raises)) {
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

    /// Ends the departure under way.
    pub fn take_leaving(&mut self) -> Option<Leaving> {
        self.rare.as_mut()?.leaving.take()
    }

    /// Whether the construct it waits for, or waited for, is decided and has not had its effect.
    pub fn is_committed(&self) -> bool {
        let is_decided =
            |scope: &Scope| matches!(&scope.kind, ScopeKind::Children(children) if children.decided.is_some());
        self.raises == Raises::Outcome
            || self.waiting == Waiting::Children && self.scopes.last().is_some_and(is_decided)
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
}

/// All tasks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tasks {
    slots: Slab<Task>,
    generations: Vec<u32>,
    /// Registers of the tasks that do not run.
    pub registers: RegisterStore,
}

impl Tasks {
    /// Adds a task.
    pub fn insert(&mut self, task: Task) -> u32 {
        let index = self.slots.insert(task);
        if self.generations.len() <= index as usize {
            self.generations.push(0);
        }
        index
    }

    /// Frees a dead task's slot.
    pub fn free(&mut self, index: u32) {
        if let Some(task) = self.slots.remove(index) {
            self.registers.free(task.registers);
            self.generations[index as usize] += 1;
        }
    }

    /// A name for the task that outlives it.
    pub fn reference(&self, index: u32) -> TaskRef {
        TaskRef { index, generation: self.generations[index as usize] }
    }

    /// The task a name means, unless its record is gone.
    pub fn find(&self, task: TaskRef) -> Option<u32> {
        (self.generations.get(task.index as usize) == Some(&task.generation) && self.slots.get(task.index).is_some())
            .then_some(task.index)
    }

    /// Whether it is the name of a task that there was, is or can be.
    pub(crate) fn may_be_named(&self, task: TaskRef) -> bool {
        (task.index as usize) < self.generations.len() && task.generation < u32::MAX / 2
    }

    /// The living task a name means.
    pub fn find_alive(&self, task: TaskRef) -> Option<u32> {
        self.find(task).filter(|&index| !self.slots[index].state.is_dead())
    }

    /// The values of a task's registers, while it does not run.
    pub fn registers_of(&self, index: u32) -> &[Value] {
        self.registers.get(self.slots[index].registers)
    }

    /// Keeps values as a task's registers while it does not run.
    pub fn set_registers(&mut self, index: u32, values: &[Value]) {
        let task = &mut self.slots[index];
        task.registers = self.registers.set(task.registers, values);
    }

    /// All tasks, by slot.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &Task)> {
        self.slots.iter()
    }

    /// Whether every slot has a generation, and the free ones are those without a task.
    pub(crate) fn is_whole(&self) -> bool {
        self.generations.len() >= self.slots.slots()
            && self.generations.iter().all(|&generation| generation < u32::MAX / 2)
            && self.slots.is_whole()
            && self.registers.is_whole(self.slots.iter().map(|(_, task)| task.registers))
    }

    /// How many slots there are.
    pub fn slots(&self) -> usize {
        self.slots.slots()
    }

    /// Bytes of all records and registers.
    pub fn bytes(&self) -> usize {
        self.slots.slots() * size_of::<Option<Task>>()
            + self.generations.len() * size_of::<u32>()
            + self.registers.bytes()
    }

    /// Gives back what no task uses.
    pub(crate) fn shrink(&mut self, slack: usize) {
        self.slots.shrink(slack);
        let used: usize = self.slots.iter().map(|(_, task)| task.registers.values()).sum();
        if !self.registers.is_sparse(used) {
            return;
        }
        let sparse = std::mem::take(&mut self.registers);
        for task in self.slots.iter_mut() {
            task.registers = self.registers.set(Registers::default(), sparse.get(task.registers));
        }
    }

    /// The living task in a slot.
    pub fn get_alive(&self, index: u32) -> Option<&Task> {
        self.get(index).filter(|task| !task.state.is_dead())
    }

    /// The task in a slot, if it is used.
    pub fn get(&self, index: u32) -> Option<&Task> {
        self.slots.get(index)
    }

    /// The task in a slot, if it is used.
    pub fn get_mut(&mut self, index: u32) -> Option<&mut Task> {
        self.slots.get_mut(index)
    }
}

impl std::ops::Index<u32> for Tasks {
    type Output = Task;

    #[inline]
    fn index(&self, index: u32) -> &Task {
        &self.slots[index]
    }
}

impl std::ops::IndexMut<u32> for Tasks {
    #[inline]
    fn index_mut(&mut self, index: u32) -> &mut Task {
        &mut self.slots[index]
    }
}

#[cfg(test)]
mod tests {
    use super::State::{self, Blocked, Created, Evaporated, Failed, Ready, Running, Succeeded};

    #[test]
    fn the_dead_never_change() {
        let all = [Created, Ready, Running, Blocked, Succeeded, Failed, Evaporated];
        for from in all {
            for to in all {
                if from.is_dead() {
                    assert!(!from.may_become(to), "{from:?} became {to:?}");
                }
                assert!(!State::may_become(from, Created), "nothing becomes created again");
            }
        }
        assert!(!Created.may_become(Running) && !Blocked.may_become(Running));
    }
}
