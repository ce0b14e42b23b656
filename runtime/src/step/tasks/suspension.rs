//! Suspensions: counts over living states, and who waits for a subtree to be at rest.

use crate::state::line::Line;
use crate::state::machine::Machine;
use crate::state::slab::NONE;
use crate::state::task::{Rare, Waiting, Wake};
use crate::state::value::{TaskRef, Value};
use crate::step::native::Surroundings;

impl Machine {
    /// Suspends a task and what is below it, once more, until `resume` takes it back; `by` is the
    /// task that wants it, if one does.
    pub(crate) fn suspend(&mut self, around: &mut Surroundings<'_>, task: u32, by: u32) {
        self.tasks[task].rare().suspensions += 1;
        self.add_stop(around, task, by);
    }

    /// Takes one suspension back; a surplus one does nothing.
    pub(crate) fn resume(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let rare: &mut Rare = self.tasks[task].rare();
        if rare.suspensions > 0 {
            rare.suspensions -= 1;
            self.remove_stop(around, task);
        }
    }

    /// Suspends a task and what is below it for a valve.
    pub(crate) fn hold(&mut self, around: &mut Surroundings<'_>, task: u32) {
        self.tasks[task].rare().holds += 1;
        self.add_stop(around, task, NONE);
    }

    /// Suspends a task and what is below it for a scope of the running task; gives the task, if it is alive.
    pub(crate) fn hold_for_scope(&mut self, around: &mut Surroundings<'_>, task: TaskRef) -> Option<u32> {
        let by = self.current;
        let reference = self.tasks.reference(by);
        self.tasks[by].rare().suspends += 1;
        let task = self.tasks.find_alive(task)?;
        let rare = self.tasks[task].rare();
        rare.suspended_by.push(reference);
        rare.holds += 1;
        self.add_stop(around, task, by);
        Some(task)
    }

    /// Ends what [`Machine::hold_for_scope`] began.
    pub(crate) fn unhold_for_scope(&mut self, around: &mut Surroundings<'_>, task: TaskRef, by: u32) {
        let reference = self.tasks.reference(by);
        self.tasks[by].rare().suspends -= 1;
        let Some(task) = self.tasks.find_alive(task) else { return };
        let suspended_by = &mut self.tasks[task].rare().suspended_by;
        if let Some(at) = suspended_by.iter().rposition(|&known| known == reference) {
            suspended_by.swap_remove(at);
        }
        self.unhold(around, task);
    }

    /// Ends what [`Machine::hold`] began.
    pub(crate) fn unhold(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let rare: &mut Rare = self.tasks[task].rare();
        assert!(rare.holds > 0, "a hold ends once");
        rare.holds -= 1;
        self.remove_stop(around, task);
    }

    /// Tasks that a suspension of this one reaches: all children but those of its clean-ups and
    /// hooks.
    pub(crate) fn suspended_with(&self, task: u32) -> Vec<u32> {
        let record = &self.tasks[task];
        let cleans_up = record.is_cleaning_up();
        let mut children = self.children(task);
        children.retain(|&child| {
            let child = &self.tasks[child];
            !(child.named_as_hook() || cleans_up && record.is_within_clean_up(child.parent_scope))
        });
        children
    }

    /// The task around one whose suspensions reach it; none if it belongs to a clean-up of that, or runs its hooks.
    pub(crate) fn suspends_with_it(&self, task: u32) -> Option<u32> {
        let record = &self.tasks[task];
        let around = self.tasks.get(record.parent)?;
        let is_reached = !record.named_as_hook() && !around.is_within_clean_up(record.parent_scope);
        is_reached.then_some(record.parent)
    }

    fn add_stop(&mut self, around: &mut Surroundings<'_>, root: u32, by: u32) {
        let mut waiting = vec![root];
        while let Some(task) = waiting.pop() {
            let was_queued = self.is_queued(task);
            self.change_line(task, |machine| machine.tasks[task].rare().stop += 1);
            if self.tasks[task].stop() == 1 {
                self.trace_suspended(task, by);
            }
            if was_queued && !self.is_queued(task) {
                let priority = self.effective_priority(task);
                self.priorities.withdraw(&mut self.tasks, task, priority);
                self.note_left(task);
            }
            if task == self.current {
                self.scratch.switch = true;
            }
            self.turn_clocks(task);
            self.note_status(task);
            waiting.extend(self.suspended_with(task).into_iter().rev());
        }
        self.serve_valves(around);
    }

    fn remove_stop(&mut self, around: &mut Surroundings<'_>, root: u32) {
        let mut waiting = vec![root];
        let mut resumed = Vec::new();
        while let Some(task) = waiting.pop() {
            let was_queued = self.is_queued(task);
            self.change_line(task, |machine| machine.tasks[task].rare().stop -= 1);
            if !was_queued && self.is_queued(task) {
                self.number_wait(task);
                self.queue(task, false);
            }
            self.turn_clocks(task);
            if self.tasks[task].stop() == 0 {
                self.trace_resumed(task);
                resumed.push(task);
            }
            self.note_status(task);
            waiting.extend(self.suspended_with(task).into_iter().rev());
        }
        self.take_up_deadlines(around, &resumed);
        self.serve_valves(around);
    }

    /// Whether no task of a subtree runs a clean-up, so that a suspension has reached all of it.
    pub(crate) fn is_at_rest(&self, root: u32) -> bool {
        let mut waiting = vec![root];
        while let Some(task) = waiting.pop() {
            let record = &self.tasks[task];
            if record.is_protected() {
                return false;
            }
            waiting.extend(self.children(task));
        }
        true
    }

    /// Lets the current task wait until a subtree it has suspended is at rest; tells whether it
    /// must.
    pub(crate) fn wait_for_rest(&mut self, other: u32) -> bool {
        let current = self.current;
        if self.is_within(current, other) || self.is_at_rest(other) {
            return false;
        }
        self.join_line(current, other, |rare| &mut rare.resters);
        self.tasks[current].wait(Waiting::Rest(other));
        self.waits_for_rest += 1;
        true
    }

    /// A clean-up or departure of a task has ended: what waited for that goes on.
    pub(crate) fn protection_ended(&mut self, around: &mut Surroundings<'_>, task: u32) {
        if !self.tasks[task].state().is_dead() {
            self.turn_clocks(task);
        }
        let mut at = task;
        while self.waits_for_rest > 0 && at != NONE {
            let resters = self.tasks[at].rare.as_ref().map_or(Line::default(), |rare| rare.resters);
            if resters != Line::default() && (self.tasks[at].state().is_dead() || self.is_at_rest(at)) {
                for rester in resters.tasks(&self.tasks) {
                    self.wake(rester, Wake::Value(Value::Nil));
                }
            }
            at = self.tasks[at].parent;
        }
        self.take_up_swaps(around, task);
        self.stir_claims_above(around, task);
    }
}
