//! Time worked: its waits and deadlines stand still while their task is suspended.

use crate::state::active_time::ActiveTime;
use crate::state::machine::Machine;
use crate::state::slab::NONE;
use crate::state::task::{ScopeKind, Waiting};
use crate::state::timers::Alarm;

impl Machine {
    /// Lets the wait of a task end when it has not been suspended for as long as up to an instant.
    pub(crate) fn wait_active(&mut self, task: u32, due_us: u64) {
        self.tasks[task].rare().active_wait = Some(ActiveTime::Due(due_us));
        self.set_wake_timer(task, due_us);
    }

    /// A task was suspended, or is not any more: what counts its time worked stands still, or goes on.
    pub(crate) fn turn_clocks(&mut self, task: u32) {
        let is_held = self.tasks[task].is_held();
        self.turn_wait(task, is_held);
        self.turn_deadline(task, is_held);
    }

    fn turn_wait(&mut self, task: u32, is_held: bool) {
        let record = &mut self.tasks[task];
        let Some(clock) = record.rare.as_mut().and_then(|rare| rare.active_wait.as_mut()) else { return };
        match (*clock, is_held) {
            (ActiveTime::Due(due_us), true) => {
                *clock = ActiveTime::Left(due_us.saturating_sub(self.now_us));
                // The timer is one of a wait that is over.
                self.number_wait(task);
                self.forget_timer();
            }
            (ActiveTime::Left(left_us), false) => {
                let due_us = self.now_us.saturating_add(left_us);
                *clock = ActiveTime::Due(due_us);
                self.set_wake_timer(task, due_us);
            }
            (ActiveTime::Due(_), false) | (ActiveTime::Left(_), true) => {}
        }
    }

    /// The deadline of the construct that a task is the body of.
    fn turn_deadline(&mut self, body: u32, is_held: bool) {
        let (parent, scope) = (self.tasks[body].parent, self.tasks[body].parent_scope);
        if parent == NONE {
            return;
        }
        let owner = self.tasks.reference(parent);
        let Some(scope) = self.tasks[parent].scopes.get_mut(scope as usize) else { return };
        let ScopeKind::Children(children) = &mut scope.kind else { return };
        if children.decided.is_some() {
            return;
        }
        match (children.active, is_held) {
            (Some(ActiveTime::Due(due_us)), true) => {
                children.active = Some(ActiveTime::Left(due_us.saturating_sub(self.now_us)));
                children.timer = 0;
                self.forget_timer();
            }
            (Some(ActiveTime::Left(left_us)), false) => {
                let due_us = self.now_us.saturating_add(left_us);
                children.active = Some(ActiveTime::Due(due_us));
                children.timer = self.timers.set(due_us, owner, Alarm::Deadline);
            }
            (None | Some(ActiveTime::Due(_)), false) | (None | Some(ActiveTime::Left(_)), true) => {}
        }
    }

    /// A wait for a time has ended: tells whether its timer is still set.
    pub(crate) fn end_timed_wait(&mut self, task: u32) -> bool {
        let clock = self.tasks[task].rare.as_mut().and_then(|rare| rare.active_wait.take());
        !matches!(clock, Some(ActiveTime::Left(_)))
    }

    /// Whether what counts time worked stands still in suspended tasks, and only there.
    pub(crate) fn clocks_are_right(&self, task: u32) -> bool {
        let record = &self.tasks[task];
        let wait = record.rare.as_ref().and_then(|rare| rare.active_wait);
        let is_right = |clock: ActiveTime, is_held: bool| matches!(clock, ActiveTime::Left(_)) == is_held;
        let deadline = self.tasks.get(record.parent).and_then(|parent| parent.scopes.get(record.parent_scope as usize));
        let deadline = deadline.and_then(|scope| match &scope.kind {
            ScopeKind::Children(children) if children.decided.is_none() => children.active,
            _ => None,
        });
        wait.is_none_or(|clock| record.waiting() == Some(Waiting::Time) && is_right(clock, record.is_held()))
            // The body may leave while it is suspended: then it comes to nothing.
            && deadline.is_none_or(|clock| is_right(clock, record.is_held()) || record.is_protected())
    }
}
