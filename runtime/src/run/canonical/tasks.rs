//! Living tasks: place, registers, scopes, what they wait for, and what few have.

use super::{Object, Writer};
use crate::state::active_time::ActiveTime;
use crate::state::slab::NONE;
use crate::state::task::{
    Children, Decision, Frame, Leaving, PlanCall, Rare, ScopeKind, State, Swap, Task, Then, Waiting,
};
use crate::state::value::Value;

impl Writer<'_> {
    pub(super) fn living_task(&mut self, index: u32) {
        let machine = self.machine;
        let record = &machine.tasks[index];
        let has_begun = record.state() != State::Created;
        self.plain(&(record.naming, record.name, record.position, record.parent_scope));
        if self.visible.names {
            self.number(u64::from(record.occurrence));
        }
        self.task(record.parent);
        self.plain(&machine.priorities.list(record.priority));
        self.number(u64::from(record.stop()));
        self.frames(record, has_begun);
        self.values(machine.tasks.registers_of(index));
        self.plain(&(record.raises, record.wake_register));
        match record.waiting() {
            Some(waiting) => self.waiting(waiting),
            None => {
                self.byte(0xff);
                self.value(*record.value());
            }
        }
        self.wake_timers(index);
        self.number(record.scopes.len() as u64);
        for scope in record.scopes.iter() {
            self.number(u64::from(scope.depth));
            self.scope(&scope.kind);
        }
        self.byte(u8::from(record.rare.is_some()));
        if let Some(rare) = &record.rare {
            self.rare(rare);
        }
        let mut child = record.first_child;
        while child != NONE {
            self.task(child);
            child = machine.tasks[child].next_sibling;
        }
        self.byte(0);
    }

    fn frames(&mut self, record: &Task, has_begun: bool) {
        self.number(record.frames.len() as u64);
        let frame = |writer: &mut Self, frame: &Frame| {
            [frame.code, frame.pc, frame.base].iter().for_each(|&part| writer.number(u64::from(part)));
        };
        for below in record.frames.iter() {
            frame(self, below);
        }
        self.byte(u8::from(has_begun));
        frame(self, &record.frame);
    }

    fn waiting(&mut self, waiting: Waiting) {
        match waiting {
            Waiting::Fluent { fluent, owned, timed } => {
                self.byte(0);
                self.object(Object::Fluent(fluent));
                self.plain(&(owned, timed));
            }
            Waiting::Watch(watch) => {
                self.byte(1);
                self.watch(watch);
            }
            Waiting::Time => self.byte(2),
            Waiting::Children => self.byte(3),
            Waiting::Spawned => self.byte(4),
            Waiting::Valve(valve) => {
                self.byte(5);
                self.number(u64::from(valve));
            }
            Waiting::Death(task) => self.waiting_for(6, task),
            Waiting::Rest(task) => self.waiting_for(7, task),
            Waiting::Swap(task) => self.waiting_for(8, task),
            Waiting::Hooks(task) => self.waiting_for(9, task),
            Waiting::Signal(behaviour) => {
                self.byte(10);
                self.number(u64::from(behaviour));
            }
            Waiting::Answer => self.byte(11),
        }
    }

    fn waiting_for(&mut self, tag: u8, task: u32) {
        self.byte(tag);
        self.task(task);
    }

    fn scope(&mut self, kind: &ScopeKind) {
        match kind {
            ScopeKind::Block { identity, result, target } => {
                self.byte(0);
                self.object(Object::Block(*identity));
                self.plain(&(result, target));
            }
            ScopeKind::Handler { code, index, failure, target } => {
                self.byte(1);
                self.plain(&(code, index, failure, target));
            }
            ScopeKind::Cleanup { target } => {
                self.byte(2);
                self.plain(target);
            }
            ScopeKind::InCleanup(then) => {
                self.byte(3);
                match &**then {
                    Then::Continue => self.byte(0),
                    Then::Leave(leaving) => {
                        self.byte(1);
                        self.leaving(leaving);
                    }
                }
            }
            ScopeKind::Call(call) => {
                self.byte(4);
                self.call(call);
            }
            ScopeKind::Children(children) => {
                self.byte(5);
                self.children(children);
            }
            ScopeKind::Valve(place) => {
                self.byte(6);
                self.number(u64::from(*place));
            }
            ScopeKind::OnInterrupt(hook) => {
                self.byte(7);
                self.value(*hook);
            }
            ScopeKind::OnResume(hook) => {
                self.byte(8);
                self.value(*hook);
            }
            ScopeKind::Suspended(task) => {
                self.byte(9);
                self.reference(*task);
            }
            ScopeKind::Watch(watch) => {
                self.byte(10);
                self.watch(*watch);
            }
            ScopeKind::Fence => self.byte(11),
        }
    }

    fn call(&mut self, call: &PlanCall) {
        self.plain(&call.name);
        if self.visible.names {
            self.plain(&(call.occurrence, &call.counters));
        }
        self.number(call.tags.len() as u64);
        call.tags.iter().for_each(|&tag| self.reference(tag));
        self.optional_value(call.failure);
    }

    fn children(&mut self, children: &Children) {
        self.plain(&(children.quorum, children.name, children.result, children.alive, children.total));
        if self.visible.names {
            self.number(u64::from(children.occurrence));
        }
        match children.decided {
            None => self.byte(0),
            Some(Decision::Succeed(value)) => {
                self.byte(1);
                self.value(value);
            }
            Some(Decision::Fail(failure)) => {
                self.byte(2);
                self.value(failure);
            }
        }
        self.value(children.last_value);
        self.values(&children.values);
        self.values(&children.failures);
        self.plain(&children.order);
        for held in &children.held {
            self.plain(&(held.position, held.constraints));
            self.reference(held.task);
        }
        self.byte(0xff);
        self.number(children.later.len() as u64);
        children.later.iter().for_each(|&task| self.reference(task));
        self.plain(&children.seconds);
        self.active(children.active);
        self.byte(u8::from(children.expired_us.is_some()));
        let deadline =
            self.timers.values().flatten().find(|timer| children.timer != 0 && timer.number == children.timer).copied();
        self.byte(u8::from(deadline.is_some()));
        if let Some(timer) = deadline {
            self.time_left(timer.deadline_us);
        }
    }

    fn active(&mut self, active: Option<ActiveTime>) {
        match active {
            None => self.byte(0),
            Some(ActiveTime::Due(due_us)) => {
                self.byte(1);
                self.time_left(due_us);
            }
            Some(ActiveTime::Left(left_us)) => {
                self.byte(2);
                self.number(left_us);
            }
        }
    }

    fn optional_value(&mut self, value: Option<Value>) {
        self.byte(u8::from(value.is_some()));
        if let Some(value) = value {
            self.value(value);
        }
    }

    fn leaving(&mut self, leaving: &Leaving) {
        match leaving {
            Leaving::Evaporate => self.byte(0),
            Leaving::Fail(failure) => {
                self.byte(1);
                self.value(*failure);
            }
            Leaving::FailCall { scope, failure } => {
                self.byte(2);
                self.number(u64::from(*scope));
                self.value(*failure);
            }
            Leaving::Block { identity, value } => {
                self.byte(3);
                self.object(Object::Block(*identity));
                self.value(*value);
            }
            Leaving::Jump { scopes, target, depth } => {
                self.byte(4);
                self.plain(&(scopes, target, depth));
            }
            Leaving::Swap(swap) => {
                self.byte(5);
                self.swap(swap);
            }
        }
    }

    fn swap(&mut self, swap: &Swap) {
        self.plain(&(swap.code, &swap.kept));
        self.optional_task(swap.by);
    }

    /// Boosts, claims and lines follow from the tasks and valves.
    fn rare(&mut self, rare: &Rare) {
        self.plain(&(rare.suspensions, rare.holds, rare.evaporation_pending, rare.failure_pending));
        self.plain(&(rare.hooks_for, &rare.held, &rare.marked, &rare.finished));
        if self.visible.names {
            self.plain(&rare.counters);
        }
        self.number(rare.suspended_by.len() as u64);
        rare.suspended_by.iter().for_each(|&task| self.reference(task));
        self.byte(u8::from(rare.swap_pending.is_some()));
        if let Some(swap) = &rare.swap_pending {
            self.swap(swap);
        }
        self.optional_task(rare.hooks_before);
        self.byte(u8::from(rare.leaving.is_some()));
        if let Some(leaving) = &rare.leaving {
            self.leaving(leaving);
        }
        self.active(rare.active_wait);
    }
}
