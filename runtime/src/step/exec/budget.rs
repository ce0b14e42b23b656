//! Budgets of steps, and what becomes of tasks that overdraw them.

use crate::state::failure::Raise;
use crate::state::limits::Spent;
use crate::state::machine::{Machine, SCRATCH_TASK};
use crate::state::scratch::Cursor;
use crate::state::task::Frame;
use crate::step::exec::Proceed;
use crate::step::native::Surroundings;

/// A network or a macro gets this part of the budget of a task.
pub(crate) const EVALUATION_SHARE: u32 = 10;

impl Machine {
    /// Steps that what runs now may take in one instant.
    pub(crate) fn budget(&self) -> u32 {
        if self.current == SCRATCH_TASK { self.limits.steps / EVALUATION_SHARE } else { self.limits.steps }
    }

    /// The place of a task that has spent its budget and gets it once more, but for what its turn counts: that is handed
    /// back when a slice ends. What is evaluated without a task is not cut.
    pub(crate) fn budget_anew(&self, around: &Surroundings<'_>, frame: Frame) -> Cursor {
        match self.current == SCRATCH_TASK {
            true => Cursor::new(frame, self.budget(), u32::MAX),
            false => Cursor::new(frame, self.budget().saturating_sub(Spent::A_TURN), around.slice_steps),
        }
    }

    /// The running task has spent its slice, and goes on with the same instruction in the next one; or there is none, and
    /// it begins a new budget with a failure.
    #[cold]
    #[inline(never)]
    pub(super) fn spent<const STEPPING: bool>(
        &mut self,
        around: &Surroundings<'_>,
        place: &mut Cursor,
    ) -> Result<Proceed, Raise> {
        if place.reserve > 0 {
            place.frame.pc -= 1;
            self.end_slice::<STEPPING>(place.frame);
            return Ok(Proceed::Pause);
        }
        *place = self.budget_anew(around, place.frame);
        Err(self.runaway())
    }

    /// The running task has spent its budget, and begins a new one.
    #[cold]
    #[inline(never)]
    pub(crate) fn runaway(&mut self) -> Raise {
        if self.current == SCRATCH_TASK {
            self.scratch.burned = self.scratch.burned.saturating_add(self.budget());
        }
        let times = if self.current == SCRATCH_TASK { &mut self.scratch.overdrawn } else { &mut self.spent.times };
        *times = times.saturating_add(1);
        Raise::new(
            "runaway",
            format!(
                "{} steps in one instant; let it wait, as with `(wait-time 0.1)`, or end it, as with `until`",
                self.budget()
            ),
        )
    }
}
