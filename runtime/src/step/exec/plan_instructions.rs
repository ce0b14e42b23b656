//! Instructions about tasks, scopes, valves, watches and waits, one function each.

use crate::state::failure::Raise;
use crate::state::fluent::{Fluent, Origin};
use crate::state::machine::{Machine, SCRATCH_TASK};
use crate::state::memory;
use crate::state::registers::Registers;
use crate::state::scratch::Cursor;
use crate::state::slab::{NONE, Slab};
use crate::state::task::{Leaving, PlanCall, Scope, ScopeKind, State, Task, Then, Waiting, Wake};
use crate::state::value::{TaskRef, Value};
use crate::step::exec::Proceed;
use crate::step::native::Surroundings;
use rpl_lang::code::{Construct, Missed, NO_REG, Program, Reg};
use rpl_lang::kind::Kind;

/// The instruction that lies so far from the next one.
fn target(place: &Cursor, distance: i32) -> u32 {
    (i64::from(place.frame.pc) + i64::from(distance)) as u32
}

/// Assigns `nil` or `t` to a fluent nothing is computed from: the common signal, for which nothing but
/// waiters needs to be looked at. Tells whether there are any that it wakes; nothing, and does nothing,
/// if the fluent is not so simple.
#[inline]
pub(super) fn signal_plainly(fluents: &mut Slab<Fluent>, fluent: u32, truth: Value) -> Option<bool> {
    let entry = fluents.get_mut(fluent).filter(|entry| entry.is_plain())?;
    let is_old = entry.value.is_true() == truth.is_true() && matches!(entry.value, Value::Nil | Value::True);
    if is_old {
        return Some(false);
    }
    entry.value = truth;
    Some(truth.is_true() && entry.waiters.first != NONE)
}

impl Machine {
    fn register(&self, place: &Cursor, register: Reg) -> Value {
        self.scratch.stack[place.frame.base as usize + usize::from(register)]
    }

    fn set_register(&mut self, place: &Cursor, register: Reg, value: Value) {
        self.scratch.stack[place.frame.base as usize + usize::from(register)] = value;
    }

    /// The running task waits; the register gets what it finds then.
    fn block_for(&mut self, register: Reg) -> Proceed {
        let task = self.current;
        self.tasks[task].wake_register = register;
        Proceed::Blocked
    }

    /// The running task waits, and then comes to its instruction once more.
    fn block_and_repeat(&mut self, place: &mut Cursor) -> Proceed {
        place.frame.pc -= 1;
        self.block_for(NO_REG)
    }

    /// Begins a plan call, whose code the frame has just entered.
    pub(super) fn enter_plan(&mut self, program: &Program, place: &Cursor) -> Result<Proceed, Raise> {
        self.refuse_in_network("a plan cannot be called")?;
        let task = self.current;
        let name = program.codes[place.frame.code as usize].name;
        let span = self.scratch.frames.last().and_then(|frame| {
            program.codes[frame.code as usize].spans.get((frame.pc as usize).saturating_sub(1)).copied()
        });
        let occurrence = self.count_use(task, name);
        self.push_scope(ScopeKind::Call(Box::new(PlanCall::new(name, occurrence, span))));
        self.trace_call(program, task, place);
        self.collect_if_full()?;
        Ok(Proceed::On)
    }

    /// Ends a plan call, once what it spawned is dead.
    pub(super) fn leave_plan(
        &mut self,
        around: &mut Surroundings<'_>,
        place: &mut Cursor,
        value: Reg,
    ) -> Result<Proceed, Raise> {
        let value = self.register(place, value);
        if self.end_spawned(around, place) {
            return Ok(Proceed::Blocked);
        }
        let task = self.current;
        self.trace_return(around.program, task, value);
        if let Some(Scope { kind: ScopeKind::Call(call), .. }) = self.tasks[task].scopes.pop() {
            self.end_call(around, &call.tags);
        }
        Ok(Proceed::Switch)
    }

    /// Evaporates what the innermost plan call spawned; tells whether the task must wait for some of
    /// it. The instruction runs again when it is dead.
    pub(super) fn end_spawned(&mut self, around: &mut Surroundings<'_>, place: &mut Cursor) -> bool {
        let task = self.current;
        let Some(index) = self.tasks[task].scopes.call_within(usize::MAX) else { return false };
        if self.evaporate_children(around, task, index as u32) == 0 {
            return false;
        }
        self.tasks[task].wait(Waiting::Spawned);
        self.block_and_repeat(place);
        true
    }

    /// Makes a tag: a task that others can name before it starts.
    pub(super) fn new_tag(&mut self, place: &Cursor, to: Reg, name: u32) -> Result<Proceed, Raise> {
        if let Value::Symbol(name) = self.constants[name as usize] {
            let task = self.current;
            let priority = self.tasks[task].priority;
            self.heap.allocated += memory::TASK;
            let index = self.tasks.insert(Task::new(0, Registers::default(), name, priority));
            let value = self.expose(index);
            let reference = self.tasks.reference(index);
            if let Some((owner, call)) = self.plan_call_around(task) {
                self.note_tag(owner, call, reference);
            }
            self.set_register(place, to, value);
        }
        self.collect_if_full()?;
        Ok(Proceed::On)
    }

    /// Notes a tag of a plan call. Those that were reached need nothing at its end and are dropped.
    fn note_tag(&mut self, task: u32, scope: usize, tag: TaskRef) {
        let ScopeKind::Call(call) = &mut self.tasks[task].scopes[scope].kind else { return };
        let (mut tags, mut most) = (std::mem::take(&mut call.tags), call.most_tags);
        if tags.len() >= most as usize {
            let tasks = &self.tasks;
            tags.retain(|&tag| tasks.find(tag).is_some_and(|tag| tasks[tag].state() == State::Created));
            most = (2 * tags.len() as u32).max(4);
        }
        tags.push(tag);
        if let ScopeKind::Call(call) = &mut self.tasks[task].scopes[scope].kind {
            (call.tags, call.most_tags) = (tags, most);
        }
    }

    /// Starts the children of a construct.
    pub(super) fn start_parallel(
        &mut self,
        around: &mut Surroundings<'_>,
        place: &Cursor,
        to: Reg,
        construct: u32,
    ) -> Result<Proceed, Raise> {
        self.refuse_in_network("a task cannot be started")?;
        let program = around.program;
        let construct = &program.codes[place.frame.code as usize].constructs[construct as usize];
        self.make_room(self.scratch.top, construct.children.len() * memory::TASK)?;
        self.start_children(around, place, construct, None, to)
    }

    /// Starts a child for each item of a list.
    pub(super) fn start_parallel_map(
        &mut self,
        around: &mut Surroundings<'_>,
        place: &Cursor,
        to: Reg,
        list: Reg,
        construct: u32,
    ) -> Result<Proceed, Raise> {
        let list = self.register(place, list);
        self.refuse_in_network("a task cannot be started")?;
        let Ok(count) = self.heap.length(list) else {
            return Err(self.wrong_type("what is mapped over", Kind::List.noun(), list));
        };
        let program = around.program;
        let construct = &program.codes[place.frame.code as usize].constructs[construct as usize];
        self.make_room(self.scratch.top, count * memory::TASK)?;
        self.start_children(around, place, construct, Some(list), to)
    }

    fn start_children(
        &mut self,
        around: &mut Surroundings<'_>,
        place: &Cursor,
        construct: &Construct,
        list: Option<Value>,
        to: Reg,
    ) -> Result<Proceed, Raise> {
        self.collect_if_full()?;
        match self.start_construct(around, construct, list, to, place.frame.base as usize)? {
            Some(value) => {
                self.set_register(place, to, value);
                Ok(Proceed::On)
            }
            None => {
                let task = self.current;
                self.tasks[task].wait(Waiting::Children);
                Ok(self.block_for(to))
            }
        }
    }

    /// Starts a task beside the running one.
    pub(super) fn spawn(
        &mut self,
        around: &mut Surroundings<'_>,
        place: &Cursor,
        to: Reg,
        construct: u32,
    ) -> Result<Proceed, Raise> {
        self.refuse_in_network("a task cannot be started")?;
        self.collect_if_full()?;
        let program = around.program;
        let construct = &program.codes[place.frame.code as usize].constructs[construct as usize];
        let value = self.start_spawned(around, construct, place.frame.base as usize)?;
        self.set_register(place, to, value);
        Ok(Proceed::Switch)
    }

    pub(super) fn push_block(&mut self, place: &Cursor, to: Reg, result: Reg, distance: i32) -> Result<Proceed, Raise> {
        let identity = self.next_identity;
        self.next_identity += 1;
        self.set_register(place, to, Value::Int(identity as i64));
        self.open_scope(ScopeKind::Block { identity, result, target: target(place, distance) })
    }

    /// Leaves a block of the running task with a value.
    pub(super) fn return_from(&mut self, place: &Cursor, block: Reg, value: Reg) -> Result<Proceed, Raise> {
        let (identity, value) = (self.register(place, block), self.register(place, value));
        let identity = if let Value::Int(identity) = identity { identity as u64 } else { u64::MAX };
        let task = self.current;
        let is_block =
            |scope: &Scope| matches!(scope.kind, ScopeKind::Block { identity: known, .. } if known == identity);
        if !self.tasks[task].scopes.iter().rev().any(is_block) {
            return Err(Raise::new(
                "control-error",
                "the block to return from is not around this any more, or belongs to another task",
            ));
        }
        self.tasks[task].leave(Leaving::Block { identity, value });
        Ok(Proceed::Blocked)
    }

    pub(super) fn push_handler(
        &mut self,
        place: &Cursor,
        failure: Reg,
        clauses: u16,
        distance: i32,
    ) -> Result<Proceed, Raise> {
        let target = target(place, distance);
        self.open_scope(ScopeKind::Handler { code: place.frame.code, index: u32::from(clauses), failure, target })
    }

    pub(super) fn push_cleanup(&mut self, place: &Cursor, distance: i32) -> Result<Proceed, Raise> {
        self.open_scope(ScopeKind::Cleanup { target: target(place, distance) })
    }

    /// The protected part has ended by itself: its clean-up runs.
    pub(super) fn begin_cleanup(&mut self) -> Result<Proceed, Raise> {
        let task = self.current;
        self.tasks[task].scopes.pop();
        self.push_scope(ScopeKind::InCleanup(Box::new(Then::Continue)));
        self.note_in_the_way(task);
        self.refresh_boost(task);
        Ok(Proceed::On)
    }

    /// A clean-up has ended: what cut the protected part short goes on, or what came meanwhile.
    pub(super) fn end_cleanup(&mut self, around: &mut Surroundings<'_>) -> Result<Proceed, Raise> {
        let task = self.current;
        let Some(Scope { kind: ScopeKind::InCleanup(then), .. }) = self.tasks[task].scopes.pop() else {
            return Ok(Proceed::On);
        };
        Ok(match *then {
            Then::Leave(leaving) => {
                self.tasks[task].leave(leaving);
                Proceed::Blocked
            }
            Then::Continue if self.take_up_pending(around, task) => Proceed::Blocked,
            Then::Continue => Proceed::Switch,
        })
    }

    /// Makes a fluent with an initial value, or takes one that is given, and names it if it has no name.
    pub(super) fn define_fluent(
        &mut self,
        program: &Program,
        place: &Cursor,
        initial: Reg,
        global: u32,
    ) -> Result<Proceed, Raise> {
        self.refuse_in_network("a fluent cannot be defined")?;
        let name = program.globals[global as usize].name;
        let fluent = match self.register(place, initial) {
            given @ Value::Fluent(_) => given,
            value => self.create_fluent(Fluent::new(Some(name), value, Origin::Plan)),
        };
        if let Value::Fluent(index) = fluent {
            self.fluents[index].name.get_or_insert(name);
        }
        self.globals[global as usize] = fluent;
        self.set_register(place, initial, fluent);
        Ok(Proceed::On)
    }

    pub(super) fn push_valve(
        &mut self,
        around: &mut Surroundings<'_>,
        place: &Cursor,
        valve: Reg,
        seconds: Reg,
    ) -> Result<Proceed, Raise> {
        let value = self.register(place, valve);
        self.refuse_in_network("a valve cannot be requested")?;
        let Value::Valve(valve) = value else {
            return Err(self.wrong_type("what is held", Kind::Valve.noun(), value));
        };
        let due_us = match seconds {
            NO_REG => None,
            seconds => {
                let seconds = self.register(place, seconds);
                Some(self.instant_after(seconds, || "`:timeout` of `with-valve`".into())?)
            }
        };
        let task = self.current;
        let granted = self.request_valve(around, task, valve)?;
        if let (false, Some(due_us)) = (granted, due_us) {
            self.set_request_timer(task, due_us);
        }
        // The scope is entered when the valve is there: it is pushed now, and a release of what is
        // not held does nothing.
        self.push_scope(ScopeKind::Valve(valve));
        Ok(if granted { Proceed::Switch } else { self.block_for(NO_REG) })
    }

    pub(super) fn push_on_interrupt(&mut self, place: &Cursor, hook: Reg) -> Result<Proceed, Raise> {
        self.open_scope(ScopeKind::OnInterrupt(self.register(place, hook)))
    }

    pub(super) fn push_on_resume(&mut self, place: &Cursor, hook: Reg) -> Result<Proceed, Raise> {
        self.open_scope(ScopeKind::OnResume(self.register(place, hook)))
    }

    /// Suspends another task, and waits until its clean-ups have ended.
    pub(super) fn push_suspended(
        &mut self,
        around: &mut Surroundings<'_>,
        place: &Cursor,
        other: Reg,
    ) -> Result<Proceed, Raise> {
        let value = self.register(place, other);
        self.refuse_in_network("a task cannot be suspended")?;
        let Value::Task(other) = value else {
            return Err(self.wrong_type("what is suspended", Kind::Task.noun(), value));
        };
        self.push_scope(ScopeKind::Suspended(other));
        if let Some(other) = self.hold_for_scope(around, other)
            && self.wait_for_rest(other)
        {
            return Ok(self.block_for(NO_REG));
        }
        Ok(Proceed::Switch)
    }

    /// Keeps the tasks around from being given other plans.
    pub(super) fn push_fence(&mut self) -> Result<Proceed, Raise> {
        self.refuse_in_network("`no-revision` cannot be entered")?;
        let proceed = self.open_scope(ScopeKind::Fence);
        self.note_in_the_way(self.current);
        proceed
    }

    pub(super) fn push_watch(
        &mut self,
        place: &Cursor,
        fluent: Reg,
        missed: Missed,
        owned: bool,
    ) -> Result<Proceed, Raise> {
        let value = self.register(place, fluent);
        self.refuse_in_network("a fluent cannot be watched")?;
        let Value::Fluent(watched) = value else {
            return Err(self.wrong_type("the condition of `whenever`", Kind::Fluent.noun(), value));
        };
        if owned {
            // It dies with the watch; nothing names it then.
            self.set_register(place, fluent, Value::Nil);
        }
        let watch = self.start_watch(self.current, watched, missed, owned);
        self.open_scope(ScopeKind::Watch(watch))
    }

    /// Waits for the next event of the innermost watch.
    pub(super) fn wait_for_event(&mut self, place: &mut Cursor) -> Result<Proceed, Raise> {
        let watch = self.innermost_watch(self.current);
        Ok(if self.next_event(watch)? { Proceed::On } else { self.block_and_repeat(place) })
    }

    /// An event of the innermost watch has been served.
    pub(super) fn end_event_service(&mut self) -> Result<Proceed, Raise> {
        let watch = self.innermost_watch(self.current);
        self.event_served(watch);
        Ok(Proceed::On)
    }

    fn innermost_watch(&self, task: u32) -> u32 {
        self.tasks[task]
            .scopes
            .iter()
            .rev()
            .find_map(|scope| match scope.kind {
                ScopeKind::Watch(watch) => Some(watch),
                _ => None,
            })
            .unwrap_or_else(|| unreachable!("the compiler opens a watch around its waits"))
    }

    /// Leaves scopes whose bodies have ended by themselves.
    pub(super) fn pop_scopes(&mut self, around: &mut Surroundings<'_>, count: u8) -> Result<Proceed, Raise> {
        for _ in 0..count {
            self.pop_ended_scope(around);
        }
        Ok(Proceed::Leave)
    }

    /// Leaves the innermost scope, whose body has ended by itself.
    fn pop_ended_scope(&mut self, around: &mut Surroundings<'_>) {
        let task = self.current;
        match self.tasks[task].scopes.pop().map(|scope| scope.kind) {
            Some(ScopeKind::Valve(valve)) => self.release_valve(around, task, valve),
            Some(ScopeKind::Suspended(other)) => self.unhold_for_scope(around, other, task),
            Some(ScopeKind::Watch(watch)) => self.end_watch(watch),
            Some(ScopeKind::Fence) => self.protection_ended(around, task),
            _ => {}
        }
    }

    /// Goes to an instruction outside scopes that are to be left first.
    pub(super) fn leave_scopes(&mut self, place: &Cursor, count: u8, distance: i32) -> Result<Proceed, Raise> {
        let task = self.current;
        let scopes = self.tasks[task].scopes.len() as u32 - u32::from(count);
        let depth = self.scratch.frames.len() as u32;
        self.tasks[task].leave(Leaving::Jump { scopes, target: target(place, distance), depth });
        Ok(Proceed::Blocked)
    }

    /// Makes a fluent that is computed from others.
    pub(super) fn make_network(
        &mut self,
        around: &mut Surroundings<'_>,
        place: &mut Cursor,
        to: Reg,
        code: u32,
    ) -> Result<Proceed, Raise> {
        let captures = &around.program.codes[code as usize].captures;
        let captured = captures.iter().map(|&register| self.register(place, register)).collect();
        let fluent = self.create_network(around, code, captured);
        place.spend(std::mem::take(&mut self.scratch.burned) as usize);
        self.set_register(place, to, fluent);
        self.collect_if_full()?;
        Ok(Proceed::On)
    }

    /// Waits for a fluent to be true. Its condition and the time have been taken out of their registers:
    /// they are of no use to anybody else, and a task that waits keeps fewer registers without them.
    pub(super) fn wait_for(
        &mut self,
        place: &Cursor,
        to: Reg,
        condition: Value,
        seconds: Option<Value>,
        owned: bool,
    ) -> Result<Proceed, Raise> {
        self.refuse_in_network("nothing can be waited for")?;
        let Value::Fluent(fluent) = condition else {
            return Err(self.wrong_type("the condition of `wait-for`", Kind::Fluent.noun(), condition));
        };
        let due_us = match seconds {
            Some(seconds) => Some(self.instant_after(seconds, || "`:timeout` of `wait-for`".into())?),
            None => None,
        };
        let entry = &mut self.fluents[fluent];
        if let Some(failure) = entry.failure {
            return Err(Raise::Again(failure));
        }
        if entry.is_true() {
            let value = *entry.reading();
            if owned {
                self.free_network(fluent);
            }
            self.set_register(place, to, value);
            return Ok(Proceed::On);
        }
        let task = self.current;
        self.number_wait(task);
        self.fluents[fluent].waiters.push_back(&mut self.tasks, task);
        let record = &mut self.tasks[task];
        record.wait(Waiting::Fluent { fluent, owned, timed: due_us.is_some() });
        record.wake_register = to;
        if let Some(due_us) = due_us {
            self.set_wake_timer(task, due_us);
        }
        Ok(Proceed::Blocked)
    }

    /// Reads a slot of what is no record of the kind, or ends before the slot.
    pub(super) fn absent_slot(
        &mut self,
        program: &Program,
        place: &Cursor,
        to: Reg,
        record: Reg,
        kind: u32,
    ) -> Result<Proceed, Raise> {
        self.check_record(program, self.register(place, record), self.constants[kind as usize])?;
        self.set_register(place, to, Value::Nil);
        Ok(Proceed::On)
    }

    /// Assigns one.
    pub(super) fn set_absent_slot(
        &self,
        program: &Program,
        place: &Cursor,
        record: Reg,
        slot: u8,
        kind: u32,
    ) -> Result<Proceed, Raise> {
        let (record, kind) = (self.register(place, record), self.constants[kind as usize]);
        Err(self.no_slot_to_set(program, record, kind, slot.into()))
    }

    /// Assigns a fluent.
    pub(super) fn assign_instruction(
        &mut self,
        around: &mut Surroundings<'_>,
        place: &mut Cursor,
        fluent: Value,
        value: Value,
    ) -> Result<Proceed, Raise> {
        self.refuse_in_network("a fluent cannot be assigned")?;
        self.assign_fluent(around, fluent, value)?;
        place.spend(std::mem::take(&mut self.scratch.burned) as usize);
        self.collect_if_full()?;
        Ok(Proceed::Switch)
    }

    /// Wakes who waits for a fluent that has been signalled.
    #[inline]
    pub(super) fn serve_signal(&mut self, fluent: u32) -> Result<Proceed, Raise> {
        self.wake_waiters(fluent, Wake::Value(Value::True));
        Ok(Proceed::Switch)
    }

    fn open_scope(&mut self, kind: ScopeKind) -> Result<Proceed, Raise> {
        self.push_scope(kind);
        self.collect_if_full()?;
        Ok(Proceed::On)
    }

    pub(crate) fn push_scope(&mut self, kind: ScopeKind) {
        let depth = self.scratch.frames.len() as u32;
        let task = self.current;
        let is_first = self.tasks[task].scopes.is_empty();
        self.heap.allocated += memory::scope(&kind) + if is_first { memory::SCOPE_STACK } else { 0 };
        self.tasks[task].scopes.push(Scope { kind, depth });
    }

    /// Refuses what a network or a macro may not do.
    pub(crate) fn refuse_in_network(&self, what: &str) -> Result<(), Raise> {
        if self.current == SCRATCH_TASK {
            return Err(in_network(what));
        }
        Ok(())
    }
}

/// The error for what a network or a macro must not do.
#[cold]
pub(crate) fn in_network(what: &str) -> Raise {
    Raise::new("network-error", format!("{what} while a fluent network or a macro is evaluated"))
}
