//! Watches of `whenever`.

use crate::state::failure::Raise;
use crate::state::fluent::Watch;
use crate::state::machine::Machine;
use crate::state::memory;
use crate::state::task::Waiting;
use rpl_lang::code::Missed;

impl Machine {
    /// Starts to watch a fluent.
    pub(crate) fn start_watch(&mut self, task: u32, fluent: u32, missed: Missed, owned: bool) -> u32 {
        let is_true = self.fluents[fluent].reading().is_true() || self.fluents[fluent].failure.is_some();
        let events = u32::from(is_true);
        let number = self.next_identity;
        self.next_identity += 1;
        let entry = Watch { number, fluent, task, was_true: is_true, events, missed, owned, waits: false };
        self.heap.allocated += memory::WATCH;
        let watch = self.watches.insert(entry);
        self.fluents[fluent].watches.insert((number, watch));
        watch
    }

    /// Ends a watch.
    pub(crate) fn end_watch(&mut self, watch: u32) {
        let Some(entry) = self.watches.remove(watch) else { return };
        if let Some(fluent) = self.fluents.get_mut(entry.fluent) {
            fluent.watches.remove(&(entry.number, watch));
            if entry.owned {
                self.free_network(entry.fluent);
            }
        }
    }

    /// Takes the next event of a watch, or waits for it.
    pub(crate) fn next_event(&mut self, watch: u32) -> Result<bool, Raise> {
        let entry = self.watches[watch];
        if entry.events == 0 {
            self.watches[watch].waits = true;
            let task = entry.task;
            self.tasks[task].wait(Waiting::Watch(watch));
            self.number_wait(task);
            return Ok(false);
        }
        self.watches[watch].events = match entry.missed {
            Missed::Always => entry.events - 1,
            Missed::Once | Missed::Never => 0,
        };
        match self.fluents[entry.fluent].failure {
            Some(failure) => Err(Raise::Again(failure)),
            None => Ok(true),
        }
    }

    /// The body of a `whenever` has run.
    pub(crate) fn event_served(&mut self, watch: u32) {
        if self.watches[watch].missed == Missed::Never {
            self.watches[watch].events = 0;
        }
    }
}
