//! The stepper's look at each instruction.

use crate::state::machine::{Machine, SCRATCH_TASK};
use crate::state::task::Frame;
use rpl_lang::code::{Op, Program};

impl Machine {
    /// Whether the stepper stops the running task before this instruction.
    pub(crate) fn stops_before(&mut self, program: &Program, op: &Op, frame: Frame) -> bool {
        let task = self.current;
        if task == SCRATCH_TASK {
            return false;
        }
        let here = (self.tasks.reference(task), frame);
        if let Some((task, frame, register)) = self.scratch.stepping.wanted
            && (task, frame) == here
        {
            let value =
                self.scratch.stack.get(frame.base as usize + usize::from(register)).copied().unwrap_or_default();
            self.scratch.stepping.wanted = None;
            self.scratch.stepping.found = Some(self.write(program, value));
        }
        if !op.is_step() && !self.scratch.stepping.is_fine {
            return false;
        }
        let stepping = &mut self.scratch.stepping;
        stepping.has_stopped = stepping.stopped != Some(here);
        stepping.stopped = stepping.has_stopped.then_some(here);
        stepping.has_stopped
    }

    /// A slice of steps ends before the instruction of a frame: when the stepper comes back it has
    /// stopped there already, if it did.
    pub(crate) fn end_slice<const STEPPING: bool>(&mut self, frame: Frame) {
        if STEPPING {
            self.scratch.stepping.stopped = Some((self.tasks.reference(self.current), frame));
        }
    }
}
