//! Sorts by a predicate, in which the plan asks and the heap keeps the order.

use crate::state::failure::Raise;
use crate::state::heap::SortStep;
use crate::state::machine::Machine;
use crate::state::scratch::Cursor;
use crate::step::exec::Proceed;
use crate::step::native::walk_steps;
use rpl_lang::code::Reg;

impl Machine {
    /// [`Op::MergeStep`](rpl_lang::code::Op::MergeStep) where a merge begins or ends, when it has jumped already.
    #[inline(never)]
    pub(super) fn merge_step(&mut self, place: &mut Cursor, state: Reg, ask: i32) -> Result<Proceed, Raise> {
        let at = place.frame.base as usize + usize::from(state);
        let registers = &mut self.scratch.stack[at..at + 4];
        let Some((step, moved)) = self.heap.sort_on(registers[0], registers[2]) else {
            place.frame.pc = place.frame.pc.wrapping_add_signed(-ask);
            return Err(Raise::type_error("this is not the state of a sort"));
        };
        match step {
            SortStep::Ask(first, second) => (registers[2], registers[3]) = (first, second),
            SortStep::Done => {
                // Not to ask again, and the step for it was not taken.
                place.frame.pc = place.frame.pc.wrapping_add_signed(-ask);
                place.fuel += 1;
            }
        }
        place.spend(walk_steps(moved));
        Ok(Proceed::Entered)
    }
}
