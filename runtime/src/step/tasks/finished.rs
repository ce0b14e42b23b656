//! The ledger of tags: whether the last run of each has succeeded, for plans that go on where others
//! have left off.

use crate::state::machine::Machine;
use crate::state::memory;
use crate::state::slab::NONE;
use crate::state::task::{Naming, State};
use rpl_lang::symbol::Symbol;

impl Machine {
    /// The task of a tag has died: that of the tag around it, or main, notes how.
    pub(crate) fn note_finished(&mut self, task: u32) {
        let record = &self.tasks[task];
        if record.parent == NONE {
            return;
        }
        let (name, succeeded) = (record.name, record.state() == State::Succeeded);
        let mut keeper = record.parent;
        while self.tasks[keeper].naming != Naming::Tag && self.tasks[keeper].parent != NONE {
            self.scratch.work += 1;
            keeper = self.tasks[keeper].parent;
        }
        let finished = &mut self.tasks[keeper].rare().finished;
        let known = finished.len();
        finished.insert(name, succeeded);
        if finished.len() > known {
            self.heap.allocated += memory::counters(known + 1) - memory::counters(known);
        }
    }

    /// Whether the last run of the tag of this name succeeded, as the next task at or above this one that
    /// knows of any tells.
    pub(crate) fn has_finished(&self, task: u32, name: Symbol) -> bool {
        let mut at = task;
        while at != NONE {
            let record = &self.tasks[at];
            if let Some(&succeeded) = record.rare.as_ref().and_then(|rare| rare.finished.get(&name)) {
                return succeeded;
            }
            at = record.parent;
        }
        false
    }
}
