//! The stepper: executes register code of one task until it blocks, ends or is switched out.
//!
//! Switching to a task copies its registers to a scratch stack, where it runs until it blocks.
//!
//! The loop (`instructions`) does arithmetic, data, jumps and calls. It hands every other instruction over
//! (`about_plans`) to a function in `plan_instructions`, and is told how to go on. Entries of tables and steps of a
//! sort are done beside the loop where that takes a moment, and handed over where it takes more (`about_tables`,
//! `about_sorting`).

mod about_plans;
mod about_sorting;
mod about_tables;
mod arithmetic;
pub(crate) mod budget;
mod calls;
mod evaluation;
mod instructions;
mod plan_instructions;
mod raising;
pub(crate) mod turn;

use crate::state::machine::{Machine, SCRATCH_TASK};
use crate::state::projected::Asked;
use crate::state::scratch::Cursor;
use crate::state::value::Value;
use crate::step::native::Surroundings;
use rpl_lang::code::Reg;

/// How far the window of one frame reaches.
pub(crate) const WINDOW: usize = 256;

/// Registers within reach of the current frame: its own, those of any frame it calls, and a few
/// that are cleared along with them.
pub(crate) const REACH: usize = 2 * WINDOW + 4;

/// Why the stepper came back.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Exit {
    /// The outermost frame has ended with a value.
    Returned(Value),
    /// The task waits.
    Blocked,
    /// A more important task is ready, or the task is suspended.
    Switched,
    /// Somebody is to look at the task before the next instruction: the stepper, or the caller
    /// because a slice of steps is over.
    Paused,
    /// The task is dead.
    Dead,
    /// Something is asked of the whole run; the answer goes to the register.
    Ask(Asked, Reg),
}

/// How the loop goes on after an instruction that it has handed over.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Proceed {
    /// With the next instruction.
    On,
    /// With the next instruction, unless a more important task has become ready.
    Switch,
    /// As after [`Proceed::Switch`], unless the task has begun to depart.
    Leave,
    /// In the frame that runs now, as after [`Proceed::Leave`].
    Entered,
    /// Not now: the task waits or departs.
    Blocked,
    /// Not now: somebody is to look at the task first.
    Pause,
    /// When the whole run has answered; the answer goes to the register.
    Ask(Asked, Reg),
}

impl Machine {
    #[inline]
    fn execute(&mut self, around: &mut Surroundings<'_>, place: &mut Cursor, entry: usize) -> Exit {
        loop {
            // Where a departure ends, what was protected until then is stopped before it goes on.
            if self.scratch.switch && self.current != SCRATCH_TASK {
                self.scratch.switch = false;
                if self.must_switch() {
                    return Exit::Switched;
                }
            }
            let exit = match self.scratch.stepping.is_on {
                false => self.instructions::<false>(around, place, entry),
                true => self.instructions::<true>(around, place, entry),
            };
            let raise = match exit {
                Ok(Exit::Blocked) if self.is_leaving() => {
                    if self.unwind_running(around, place) {
                        continue;
                    }
                    return if self.is_alive() { Exit::Blocked } else { Exit::Dead };
                }
                Ok(exit) => return exit,
                Err(raise) => raise,
            };
            if let Some(exit) = self.raise(around, place, raise) {
                return exit;
            }
        }
    }

    fn is_leaving(&self) -> bool {
        self.tasks.get(self.current).is_some_and(|task| task.is_leaving())
    }

    fn is_alive(&self) -> bool {
        self.tasks.get(self.current).is_some_and(|task| !task.state().is_dead())
    }

    /// Whether the running task must give way: something more important is ready, or it is
    /// suspended itself.
    fn must_switch(&self) -> bool {
        let record = &self.tasks[self.current];
        record.is_held() || self.is_output_full() || self.priorities.has_higher(self.effective_priority(self.current))
    }
}
