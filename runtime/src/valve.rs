//! Valves: pre-emptible semaphores that guard effectors.
//!
//! A valve's holds form a stack. The first is its owner's; a hold above it was *borrowed* by a
//! descendant of the one below, or *pre-empts* it, in which case the subtree it interrupts is
//! suspended. The top of the stack holds the valve now.

use crate::failure::Raise;
use crate::machine::{Machine, Surroundings};
use crate::registers::Registers;
use crate::task::{NONE, ScopeKind, State, Task, Waiting, Wake};
use crate::value::{TaskRef, Value};
use rpl_lang::code::Program;
use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};

/// What a hold is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Purpose {
    /// `with-valve` or `request-valve`.
    Plan,
    /// A behaviour drives with it.
    Activation(u16),
}

/// One hold of a valve.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hold {
    /// Who holds it.
    pub task: TaskRef,
    /// How often it took it.
    pub count: u32,
    /// What for.
    pub purpose: Purpose,
    /// The subtree that is suspended because this hold pre-empted it.
    pub interrupted: Option<TaskRef>,
}

/// What a valve is being prepared for while hooks run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Handover {
    /// Hooks of the interrupted subtree run; then the requester gets the valve.
    Lend {
        /// The requester.
        to: TaskRef,
        /// The root of the interrupted subtree.
        interrupted: TaskRef,
    },
    /// Hooks run before the interrupted subtree goes on.
    GiveBack {
        /// The root of that subtree.
        to: TaskRef,
    },
}

/// A valve.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Valve {
    /// Its name.
    pub name: Symbol,
    /// Holds, the current one last.
    pub holds: Vec<Hold>,
    /// Tasks that wait for it, in the order in which they asked.
    pub line: Vec<TaskRef>,
    /// Hooks under way.
    pub handover: Option<Handover>,
}

impl Valve {
    /// A valve nobody holds.
    pub fn new(name: Symbol) -> Self {
        Self { name, holds: Vec::new(), line: Vec::new(), handover: None }
    }
}

impl Task {
    /// Whether the task runs hooks of its parent and is no child of a construct.
    pub(crate) fn named_as_hook(&self) -> bool {
        self.rare.as_ref().is_some_and(|rare| rare.hooks_for.is_some())
    }
}

impl Machine {
    /// Asks for a valve; tells whether the task has it now. If not, it waits in line.
    pub(crate) fn request_valve(
        &mut self,
        around: &mut Surroundings<'_>,
        task: u32,
        valve: u32,
    ) -> Result<bool, Raise> {
        let me = self.tasks.reference(task);
        if self.may_take(task, valve) {
            self.take(task, valve, Purpose::Plan, None);
            return Ok(true);
        }
        if let Some(holder) = self.valves[valve as usize].holds.last().and_then(|hold| self.tasks.find_alive(hold.task))
        {
            self.check_circle(around.program, task, holder, Waiting::Valve(valve))?;
        }
        self.trace_valve(task, valve, "requested");
        self.tasks[task].waiting = Waiting::Valve(valve);
        self.valves[valve as usize].line.push(me);
        self.serve_line(around, valve);
        if self.tasks[task].waiting != Waiting::Valve(valve) {
            return Ok(true);
        }
        self.boost_blocking(task, valve);
        Ok(false)
    }

    pub(crate) fn valve_name(&self, valve: u32) -> &str {
        self.symbols.name(self.valves[valve as usize].name)
    }

    /// Gives the valve to a task that waits for it.
    fn grant(&mut self, task: u32, valve: u32, interrupted: Option<TaskRef>) {
        self.leave_valve_line(task, valve);
        self.take(task, valve, Purpose::Plan, interrupted);
        if task == self.current {
            self.tasks[task].waiting = Waiting::Nothing;
        } else {
            self.wake(task, Wake::Value(Value::Nil));
        }
    }

    /// Whether a task can have the valve without waiting: it is free, or lent to the task or to
    /// somebody above it.
    fn may_take(&self, task: u32, valve: u32) -> bool {
        let entry = &self.valves[valve as usize];
        let runs_hooks = self.runs_hooks_for(task, valve);
        let Some(top) = entry.holds.last() else { return entry.handover.is_none() };
        if entry.handover.is_some() && !runs_hooks {
            return false;
        }
        if runs_hooks {
            return true;
        }
        self.tasks.find(top.task).is_some_and(|holder| self.is_within(task, holder))
    }

    /// Whether a task belongs to hooks that run while this valve changes hands.
    fn runs_hooks_for(&self, task: u32, valve: u32) -> bool {
        let mut at = task;
        while at != NONE {
            if self.tasks[at].rare.as_ref().is_some_and(|rare| rare.hooks_for == Some(valve)) {
                return true;
            }
            at = self.tasks[at].parent;
        }
        false
    }

    fn take(&mut self, task: u32, valve: u32, purpose: Purpose, interrupted: Option<TaskRef>) {
        let me = self.tasks.reference(task);
        let holds = &mut self.valves[valve as usize].holds;
        match holds.last_mut() {
            Some(top) if top.task == me && top.purpose == purpose && interrupted.is_none() => top.count += 1,
            _ => {
                holds.push(Hold { task: me, count: 1, purpose, interrupted });
                self.trace_valve(task, valve, "granted");
            }
        }
    }

    /// Whether a task, or one above it, holds the valve now.
    pub fn holds_valve(&self, task: u32, valve: u32) -> bool {
        let entry = &self.valves[valve as usize];
        entry.holds.last().is_some_and(|top| {
            self.tasks.find(top.task).is_some_and(|holder| self.is_within(task, holder))
                || self.runs_hooks_for(task, valve)
        }) && (entry.handover.is_none() || self.runs_hooks_for(task, valve))
    }

    /// The subtree that would be suspended if the task pre-empted the holder: none if it may not.
    fn preemptible_root(&self, task: u32, valve: u32) -> Option<u32> {
        let holds = &self.valves[valve as usize].holds;
        let holder = self.tasks.find(holds.last()?.task)?;
        if !self.priorities.is_higher(self.effective_priority(task), self.effective_priority(holder)) {
            return None;
        }
        // The owner: the lowest of the holds on top that contain one another.
        let mut owner = holder;
        for hold in holds.iter().rev() {
            match self.tasks.find(hold.task) {
                Some(below) if self.is_within(owner, below) => owner = below,
                _ => break,
            }
        }
        if !self.is_within(task, owner) {
            return Some(owner);
        }
        // From inside: the branch below the nearest common ancestor that holds the borrower.
        let mut branch = holder;
        while self.tasks[branch].parent != NONE && !self.is_within(task, self.tasks[branch].parent) {
            branch = self.tasks[branch].parent;
        }
        (branch != owner && !self.is_within(task, branch)).then_some(branch)
    }

    fn preempt(&mut self, around: &mut Surroundings<'_>, requester: TaskRef, valve: u32, root: u32) {
        let interrupted = self.tasks.reference(root);
        self.trace_valve(root, valve, "pre-empted");
        let hooks = self.hooks_of(root, true);
        self.hold(root);
        self.valves[valve as usize].handover = Some(Handover::Lend { to: requester, interrupted });
        if hooks.is_empty() {
            self.complete_handover(around, valve);
        } else {
            self.start_hooks(around, root, valve, hooks, requester);
        }
    }

    /// Closures of the active hooks of a subtree, innermost first.
    fn hooks_of(&self, root: u32, on_interrupt: bool) -> Vec<Value> {
        let mut hooks = Vec::new();
        let mut waiting = vec![(root, false)];
        while let Some((task, children_done)) = waiting.pop() {
            if !children_done {
                waiting.push((task, true));
                waiting.extend(self.children(task).into_iter().rev().map(|child| (child, false)));
                continue;
            }
            hooks.extend(self.tasks[task].scopes.iter().rev().filter_map(|scope| match scope.kind {
                ScopeKind::OnInterrupt(hook) if on_interrupt => Some(hook),
                ScopeKind::OnResume(hook) if !on_interrupt => Some(hook),
                _ => None,
            }));
        }
        hooks
    }

    /// Runs hooks in a task of their own below the subtree's root, at the requester's priority.
    fn start_hooks(
        &mut self,
        around: &mut Surroundings<'_>,
        root: u32,
        valve: u32,
        hooks: Vec<Value>,
        requester: TaskRef,
    ) {
        let runner = self.symbols.find("%run-hooks").and_then(|name| around.program.names.get(&name));
        let Some(Value::Function(code)) = runner.map(|&global| self.globals[global as usize]) else {
            self.complete_handover(around, valve);
            return;
        };
        let list = self.heap.list(&hooks);
        let name = self.symbols.intern("hooks");
        let requester = self.tasks.find(requester).unwrap_or(root);
        let registers = self.tasks.registers.set(Registers::default(), &[list]);
        let mut task = Task::new(code, registers, name, self.effective_priority(requester));
        task.priority_depth = self.tasks[requester].priority_depth;
        task.rare().hooks_for = Some(valve);
        task.occurrence = self.count_use(root, name);
        let index = self.tasks.insert(task);
        self.adopt(root, self.tasks[root].scopes.len() as u32, index);
        self.make_ready(index);
        self.trace_task_begin(index);
    }

    /// If the task ran hooks, the valve changes hands now.
    pub(crate) fn hooks_ended(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let Some(valve) = self.tasks[task].rare.as_ref().and_then(|rare| rare.hooks_for) else { return };
        if self.tasks[task].state == State::Failed {
            let failure = self.tasks[task].value;
            self.warn_of_failure(around.program, failure, "in a hook");
        }
        self.complete_handover(around, valve);
    }

    fn complete_handover(&mut self, around: &mut Surroundings<'_>, valve: u32) {
        match self.valves[valve as usize].handover.take() {
            Some(Handover::Lend { to, interrupted }) => {
                let requester = self.tasks.find_alive(to);
                match requester.filter(|&task| self.tasks[task].waiting == Waiting::Valve(valve)) {
                    Some(requester) => {
                        self.interrupt_activations(around, valve);
                        self.grant(requester, valve, Some(interrupted));
                        self.serve_line(around, valve);
                    }
                    None => self.give_back(around, valve, interrupted),
                }
            }
            Some(Handover::GiveBack { to }) => {
                if let Some(root) = self.tasks.find_alive(to) {
                    self.trace_valve(root, valve, "returned");
                    self.unhold(around, root);
                }
                self.serve_line(around, valve);
            }
            None => {}
        }
    }

    fn give_back(&mut self, around: &mut Surroundings<'_>, valve: u32, interrupted: TaskRef) {
        let Some(root) = self.tasks.find_alive(interrupted) else {
            self.serve_line(around, valve);
            return;
        };
        let hooks = self.hooks_of(root, false);
        self.valves[valve as usize].handover = Some(Handover::GiveBack { to: interrupted });
        if hooks.is_empty() || self.tasks[root].is_protected() {
            self.complete_handover(around, valve);
        } else {
            self.start_hooks(around, root, valve, hooks, interrupted);
        }
    }

    /// Gives one hold of a task back.
    pub(crate) fn release_valve(&mut self, around: &mut Surroundings<'_>, task: u32, valve: u32) {
        let me = self.tasks.reference(task);
        let holds = &mut self.valves[valve as usize].holds;
        let Some(at) = holds.iter().rposition(|hold| hold.task == me && hold.purpose == Purpose::Plan) else { return };
        holds[at].count -= 1;
        if holds[at].count == 0 {
            self.remove_hold(around, valve, at);
        }
    }

    fn trace_release(&mut self, hold: &Hold, valve: u32) {
        if let Some(task) = self.tasks.find(hold.task) {
            self.trace_valve(task, valve, "released");
        }
    }

    /// Takes a hold out of the stack. The valve moves on only if it was the current one.
    fn remove_hold(&mut self, around: &mut Surroundings<'_>, valve: u32, at: usize) {
        let entry = &mut self.valves[valve as usize];
        let was_current = at + 1 == entry.holds.len();
        let hold = entry.holds.remove(at);
        self.trace_release(&hold, valve);
        let entry = &mut self.valves[valve as usize];
        if !was_current {
            // What it had interrupted stays interrupted by the hold above it.
            if let (Some(interrupted), Some(next)) = (hold.interrupted, entry.holds.get_mut(at))
                && next.interrupted.is_none()
            {
                next.interrupted = Some(interrupted);
            }
            return;
        }
        if entry.handover.is_some() {
            return;
        }
        match hold.interrupted {
            Some(interrupted) => self.pass_on(around, valve, interrupted),
            None => self.serve_line(around, valve),
        }
    }

    /// A pre-emption has ended: the best of those in line and of the interrupted goes on, the
    /// interrupted first among equals.
    fn pass_on(&mut self, around: &mut Surroundings<'_>, valve: u32, interrupted: TaskRef) {
        let below = self.valves[valve as usize].holds.last().and_then(|hold| self.tasks.find(hold.task));
        let best = self.best_in_line(valve);
        if let (Some(best), Some(root)) = (best, self.tasks.find_alive(interrupted)) {
            let holder = below.unwrap_or(root);
            if self.priorities.is_higher(self.effective_priority(best), self.effective_priority(holder))
                && !self.is_within(best, root)
            {
                self.grant(best, valve, Some(interrupted));
                return;
            }
        }
        self.give_back(around, valve, interrupted);
    }

    /// The task in line that would get the valve: highest priority, then the order of asking;
    /// suspended ones wait.
    fn best_in_line(&self, valve: u32) -> Option<u32> {
        let mut best: Option<u32> = None;
        for &waiter in &self.valves[valve as usize].line {
            let Some(task) = self.tasks.find_alive(waiter) else { continue };
            if self.tasks[task].is_held() {
                continue;
            }
            let is_better = best.is_none_or(|best| match (self.is_heir(task, valve), self.is_heir(best, valve)) {
                (true, false) => true,
                (false, true) => false,
                _ => self.priorities.is_higher(self.effective_priority(task), self.effective_priority(best)),
            });
            if is_better {
                best = Some(task);
            }
        }
        best
    }

    /// Whether a task cleans up in a subtree that was pre-empted: it stands at the head of the line.
    fn is_heir(&self, task: u32, valve: u32) -> bool {
        let holds = &self.valves[valve as usize].holds;
        holds.iter().any(|hold| self.tasks.find_alive(hold.task).is_some_and(|holder| self.is_within(task, holder)))
    }

    /// Grants the valve to whoever may have it now.
    pub(crate) fn serve_line(&mut self, around: &mut Surroundings<'_>, valve: u32) {
        if self.valves[valve as usize].handover.is_some() {
            return;
        }
        let Some(task) = self.best_in_line(valve) else { return };
        if self.may_take(task, valve) {
            self.grant(task, valve, None);
            return;
        }
        // Clean-ups are not interrupted; when the last one has ended, the line is served again.
        if let Some(root) = self.preemptible_root(task, valve)
            && self.is_at_rest(root)
        {
            let me = self.tasks.reference(task);
            self.preempt(around, me, valve, root);
        }
    }

    /// Serves every valve somebody waits for.
    pub(crate) fn serve_lines(&mut self, around: &mut Surroundings<'_>) {
        for valve in 0..self.valves.len() as u32 {
            if !self.valves[valve as usize].line.is_empty() {
                self.serve_line(around, valve);
            }
        }
    }

    pub(crate) fn leave_valve_line(&mut self, task: u32, valve: u32) {
        let me = self.tasks.reference(task);
        self.valves[valve as usize].line.retain(|&waiter| waiter != me);
    }

    /// A dead task holds nothing.
    pub(crate) fn drop_holds_of(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let me = self.tasks.reference(task);
        for valve in 0..self.valves.len() as u32 {
            self.leave_valve_line(task, valve);
            while let Some(at) = self.valves[valve as usize].holds.iter().position(|hold| hold.task == me) {
                self.remove_hold(around, valve, at);
            }
        }
    }

    /// A borrowed hold for a behaviour.
    pub(crate) fn hold_for_activation(&mut self, task: u32, valve: u32, behaviour: u16) {
        self.take(task, valve, Purpose::Activation(behaviour), None);
    }

    /// The behaviour has ended: its hold is given back.
    pub(crate) fn release_activation(&mut self, around: &mut Surroundings<'_>, behaviour: u16) {
        for valve in 0..self.valves.len() as u32 {
            let held = self.valves[valve as usize]
                .holds
                .iter()
                .rposition(|hold| hold.purpose == Purpose::Activation(behaviour));
            if let Some(at) = held {
                self.remove_hold(around, valve, at);
            }
        }
    }

    /// Behaviours that drive with a valve that is being lent are interrupted.
    fn interrupt_activations(&mut self, around: &mut Surroundings<'_>, valve: u32) {
        let driving: Vec<u16> = self.valves[valve as usize]
            .holds
            .iter()
            .filter_map(|hold| match hold.purpose {
                Purpose::Activation(behaviour) => Some(behaviour),
                Purpose::Plan => None,
            })
            .collect();
        let holds = std::mem::take(&mut self.valves[valve as usize].holds);
        let (kept, ended): (Vec<Hold>, Vec<Hold>) = holds.into_iter().partition(|hold| hold.purpose == Purpose::Plan);
        self.valves[valve as usize].holds = kept;
        ended.iter().for_each(|hold| self.trace_release(hold, valve));
        for behaviour in driving {
            self.interrupt_behaviour(around, behaviour);
        }
    }

    /// Clean-ups and hooks of the holder that keep a requester waiting run at its priority.
    fn boost_blocking(&mut self, requester: u32, valve: u32) {
        let priority = self.effective_priority(requester);
        let root = match &self.valves[valve as usize].handover {
            Some(Handover::Lend { interrupted, .. } | Handover::GiveBack { to: interrupted }) => {
                self.tasks.find_alive(*interrupted)
            }
            None => self.preemptible_root(requester, valve),
        };
        let Some(root) = root else { return };
        let mut waiting = vec![root];
        while let Some(task) = waiting.pop() {
            waiting.extend(self.children(task));
            let blocks = self.tasks[task].is_protected() || self.runs_hooks_for(task, valve) || self.cleans_up(task);
            if blocks && self.priorities.is_higher(priority, self.effective_priority(task)) {
                self.boost(task, priority);
            }
        }
    }

    /// Whether a task belongs to the clean-up of a task above it.
    fn cleans_up(&self, task: u32) -> bool {
        let (mut at, mut scope) = (self.tasks[task].parent, self.tasks[task].parent_scope);
        while at != NONE {
            if self.tasks[at].is_within_clean_up(scope) {
                return true;
            }
            (at, scope) = (self.tasks[at].parent, self.tasks[at].parent_scope);
        }
        false
    }

    /// A wait of `task` for `first` that would close a circle of waiting is a `deadlock`.
    pub(crate) fn check_circle(&self, program: &Program, task: u32, first: u32, what: Waiting) -> Result<(), Raise> {
        let mut came_from = std::collections::BTreeMap::from([(first, NONE)]);
        let mut waiting = vec![first];
        while let Some(at) = waiting.pop() {
            if at == task {
                return Err(Raise::new("deadlock", self.describe_circle(program, task, what, &came_from)));
            }
            for next in self.must_happen_first(at).into_iter().rev() {
                came_from.entry(next).or_insert_with(|| {
                    waiting.push(next);
                    at
                });
            }
        }
        Ok(())
    }

    fn describe_circle(
        &self,
        program: &Program,
        task: u32,
        what: Waiting,
        came_from: &std::collections::BTreeMap<u32, u32>,
    ) -> String {
        let mut parts = Vec::new();
        let mut at = came_from[&task];
        while at != NONE {
            parts.push(format!("{} waits for {}", self.path(at), self.describe(program, self.tasks[at].waiting)));
            at = came_from[&at];
        }
        parts.push(format!("{} waits for {}", self.path(task), self.describe(program, what)));
        parts.reverse();
        format!("this would close a circle of waiting: {}", parts.join("; "))
    }

    /// The tasks without whose going on this one cannot go on.
    fn must_happen_first(&self, task: u32) -> Vec<u32> {
        let record = &self.tasks[task];
        match record.waiting {
            Waiting::Valve(valve) => {
                let holder = self.valves[valve as usize].holds.last();
                holder.and_then(|hold| self.tasks.find_alive(hold.task)).into_iter().collect()
            }
            Waiting::Death(other) | Waiting::Rest(other) => {
                self.tasks.get_alive(other).map(|_| other).into_iter().collect()
            }
            Waiting::Spawned => self.children(task),
            Waiting::Children => match record.scopes.last().map(|scope| &scope.kind) {
                Some(ScopeKind::Children(children)) if children.needs_all() || record.is_leaving() => {
                    self.children_of_scope(task, record.scopes.len() as u32 - 1)
                }
                _ => Vec::new(),
            },
            Waiting::Nothing | Waiting::Fluent { .. } | Waiting::Watch(_) | Waiting::Time | Waiting::Signal(_) => {
                Vec::new()
            }
        }
    }
}
