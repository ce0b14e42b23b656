//! Deadlines of timeouts.

use crate::state::machine::Machine;
use crate::state::memory;
use crate::state::task::{Decision, Scope, ScopeKind};
use crate::state::timers::Alarm;
use crate::state::value::Value;
use crate::step::native::Surroundings;

impl Machine {
    pub(crate) fn set_deadline(&mut self, parent: u32, scope: u32, due_us: u64) {
        self.heap.allocated += memory::TIMER;
        let timer = self.timers.set(due_us, self.tasks.reference(parent), Alarm::Deadline);
        if let ScopeKind::Children(children) = &mut self.tasks[parent].scopes[scope as usize].kind {
            children.timer = timer;
        }
    }

    /// The deadline of a timeout has come. While the task is suspended it waits for the resume.
    pub(crate) fn deadline(&mut self, around: &mut Surroundings<'_>, task: u32, timer: u64) {
        let Some(scope) = self.scope_of_deadline(task, timer) else { return };
        let now_us = self.now_us;
        let is_held = self.tasks[task].is_held();
        let fixed = self.children_of_scope(task, scope).into_iter().find_map(|child| self.fixed_failure(around, child));
        let waits = is_held && fixed.is_none();
        if let Some(children) = self.children_mut(task, scope) {
            children.expired_us = waits.then_some(now_us);
        }
        if waits {
            return;
        }
        let failure = self.timeout_failure(task, scope);
        if let Some(first) = fixed {
            self.attach_failure(around, Decision::Fail(first), failure);
            return;
        }
        self.as_one(around, |machine, around| {
            machine.decide(around, task, scope, Decision::Fail(failure));
            machine.finish_if_done(around, task, scope);
        });
    }

    fn scope_of_deadline(&self, task: u32, timer: u64) -> Option<u32> {
        let scopes = self.tasks[task].scopes.iter();
        let is_meant = |scope: &Scope| matches!(&scope.kind, ScopeKind::Children(children) if children.timer == timer && children.decided.is_none());
        scopes.enumerate().rev().find(|(_, scope)| is_meant(scope)).map(|(index, _)| index as u32)
    }

    pub(crate) fn timeout_failure(&mut self, task: u32, scope: u32) -> Value {
        let seconds = self.children_mut(task, scope).map_or(0.0, |children| children.seconds);
        let slot = self.symbols.intern("seconds");
        let class = self.symbols.intern("timeout");
        self.new_failure(task, class, format!("not done within {seconds} s"), vec![(slot, Value::Float(seconds))])
    }

    /// Deadlines that came while tasks were suspended take effect, in the order in which they came.
    pub(crate) fn take_up_deadlines(&mut self, around: &mut Surroundings<'_>, resumed: &[u32]) {
        let mut expired = Vec::new();
        for &task in resumed {
            for scope in self.tasks[task].scopes.iter() {
                if let ScopeKind::Children(children) = &scope.kind
                    && let Some(expired_us) = children.expired_us
                {
                    expired.push((expired_us, children.timer, self.tasks.reference(task)));
                }
            }
        }
        expired.sort_unstable_by_key(|&(expired_us, timer, _)| (expired_us, timer));
        for (_, timer, task) in expired {
            if let Some(task) = self.tasks.find_alive(task) {
                self.deadline(around, task, timer);
            }
        }
    }
}
