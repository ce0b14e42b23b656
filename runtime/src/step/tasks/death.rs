//! The end of tasks and plan calls.

use crate::state::failure::Raise;
use crate::state::line::Line;
use crate::state::machine::{Machine, SCRATCH_TASK};
use crate::state::output::Channel;
use crate::state::slab::NONE;
use crate::state::stack::Stack;
use crate::state::task::{Leaving, Naming, State, Wake};
use crate::state::value::{TaskRef, Value};
use crate::step::native::Surroundings;
use crate::step::tasks::unwind::Unwound;
use rpl_lang::code::Program;

impl Machine {
    /// No scope is left: the task ends.
    pub(crate) fn leave_task(&mut self, around: &mut Surroundings<'_>, task: u32, leaving: Leaving) -> Unwound {
        // The scratch task never dies: what is evaluated in it fails.
        if task == SCRATCH_TASK {
            return Unwound::Dead;
        }
        match leaving {
            Leaving::Evaporate => self.die(around, task, State::Evaporated, Value::Nil),
            Leaving::Fail(failure) | Leaving::FailCall { failure, .. } => {
                self.die(around, task, State::Failed, failure);
            }
            Leaving::Block { .. } | Leaving::Jump { .. } | Leaving::Swap(_) => {
                let raise = Raise::new("control-error", "the block to return from is no longer there");
                let failure = self.failure_from(raise);
                self.die(around, task, State::Failed, failure);
            }
        }
        Unwound::Dead
    }

    /// Ends a plan call's tags.
    pub(crate) fn end_call(&mut self, around: &mut Surroundings<'_>, tags: &[TaskRef]) {
        for &tag in tags {
            if let Some(index) = self.tasks.find_alive(tag)
                && self.tasks[index].state() == State::Created
                && self.tasks[index].parent == NONE
            {
                self.die(around, index, State::Evaporated, Value::Nil);
            }
        }
    }

    /// Makes a task dead and lets everybody know. What its parent decides then is a part of it.
    pub(crate) fn die(&mut self, around: &mut Surroundings<'_>, task: u32, state: State, result: Value) {
        self.as_one(around, |machine, around| machine.die_now(around, task, state, result));
        if !self.tasks[task].exposed {
            self.tasks.free(task);
        }
    }

    #[inline]
    fn die_now(&mut self, around: &mut Surroundings<'_>, task: u32, state: State, result: Value) {
        let record = &mut self.tasks[task];
        let (parent, scope) = (record.parent, record.parent_scope);
        let (has_rare, was_protected) = (record.rare.is_some(), record.is_protected());
        let (is_tag, is_hook) = (record.naming == Naming::Tag, record.named_as_hook());
        if record.state() != state {
            record.enter(state);
        }
        record.conclude(result);
        record.frames = Stack::default();
        let registers = std::mem::take(&mut record.registers);
        self.tasks.registers.free(registers);
        if has_rare {
            self.end_rare(task);
        }
        self.trace_task_end(around.program, task);
        if !self.activations.is_empty() {
            self.end_activations_of(around, task);
        }
        if has_rare {
            self.drop_links_of(around, task);
            self.update_task_fluents(around, task);
        }
        if was_protected || self.waits_for_rest > 0 || self.swaps_pending > 0 {
            self.protection_ended(around, task);
        }
        if has_rare {
            self.wake_mourners(task);
            self.hooks_ended(around, task);
        }
        if is_tag {
            self.note_finished(task);
        }
        if parent != NONE && !is_hook {
            self.child_ended(around, parent, scope, task);
        } else if parent != NONE {
            self.disown(task);
            self.begin_clean_ups_below(around, parent, task);
            self.unwind(around, parent);
        }
    }

    /// What few tasks have ends with the task, as far as nobody looks for it any more.
    fn end_rare(&mut self, task: u32) {
        self.note_status(task);
        let record = &mut self.tasks[task];
        self.swaps_pending -= u32::from(record.take_swap().is_some());
        if let Some(rare) = &mut record.rare {
            rare.leaving = None;
            rare.stop = 0;
        }
    }

    /// Wakes those who wait for the end of a task.
    fn wake_mourners(&mut self, task: u32) {
        let mourners = self.tasks[task].rare.as_ref().map_or(Line::default(), |rare| rare.mourners);
        for mourner in mourners.tasks(&self.tasks) {
            self.wake(mourner, Wake::Value(Value::Nil));
        }
    }

    /// Notes a failure that nothing can handle any more.
    pub(crate) fn warn_of_failure(&mut self, program: &Program, failure: Value, place: &str) {
        let text = self.show(program, failure);
        self.put_out(Channel::Log, format!("warning: a failure {place}: {text}"));
        self.trace_warning(&text);
    }
}
