//! Failures raised where the current task stands, and where its departures land.

use crate::state::failure::Raise;
use crate::state::limits::Spent;
use crate::state::machine::{Machine, SCRATCH_TASK};
use crate::state::scratch::Cursor;
use crate::state::task::Leaving;
use crate::state::value::Value;
use crate::step::exec::Exit;
use crate::step::native::Surroundings;
use crate::step::tasks::path::form_in_plan;
use crate::step::tasks::unwind::{Landing, Unwound};
use rpl_lang::code::Program;

impl Machine {
    /// Raises a failure where the current task stands; answers how it left, if it did.
    pub(crate) fn raise(&mut self, around: &mut Surroundings<'_>, place: &mut Cursor, raise: Raise) -> Option<Exit> {
        // What fails again and again in one instant would otherwise take minutes to spend its steps.
        place.spend(Spent::A_FAILURE as usize);
        let failure = self.failure_from(raise);
        let failure =
            if self.current == SCRATCH_TASK { failure } else { self.failure_of_reader(self.current, failure) };
        if let Value::Failure(index) = failure
            && self.heap.failures[index].span.is_none()
        {
            self.heap.failures[index].span = form_in_plan(around.program, place.frame, &self.scratch.frames);
        }
        let task = self.current;
        if task != SCRATCH_TASK {
            self.trace_failed(around.program, task, failure);
        }
        if !self.tasks[task].is_leaving() {
            self.tasks[task].leave(Leaving::Fail(failure));
        }
        if self.unwind_running(around, place) {
            return None;
        }
        Some(if self.is_alive() { Exit::Blocked } else { Exit::Dead })
    }

    /// Goes on with the current task's departure; tells whether code is to run now.
    pub(crate) fn unwind_running(&mut self, around: &mut Surroundings<'_>, place: &mut Cursor) -> bool {
        let task = self.current;
        let registers = usize::from(around.program.codes[place.frame.code as usize].registers);
        self.scratch.top = place.frame.base as usize + registers;
        loop {
            match self.unwind_step(around, task, true) {
                Unwound::Land(landing) => self.land_at(place, landing),
                Unwound::Swapped { by } => {
                    self.enter_plan_anew(around.program, place);
                    self.tell_swapped(by, task);
                }
                Unwound::Waiting | Unwound::Dead => return false,
            }
            if !self.take_up_pending(around, task) {
                return true;
            }
        }
    }

    /// The running task goes on in the plan it was given, with nothing of what it did before.
    fn enter_plan_anew(&mut self, program: &Program, place: &mut Cursor) {
        place.frame = self.tasks[self.current].frame;
        self.scratch.frames.clear();
        self.clear_frame(&program.codes[place.frame.code as usize], 0);
    }

    fn land_at(&mut self, place: &mut Cursor, landing: Landing) {
        if let Some(&frame) = self.scratch.frames.get(landing.depth as usize) {
            place.frame = frame;
            self.scratch.frames.truncate(landing.depth as usize);
        }
        place.frame.pc = landing.target;
        for (register, value) in landing.writes {
            if value != Value::Unbound {
                self.scratch.stack[place.frame.base as usize + usize::from(register)] = value;
            }
        }
    }
}
