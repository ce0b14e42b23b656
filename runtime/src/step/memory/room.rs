//! The room that a run has left.
//!
//! Whatever is made adds its bytes to a counter; a collection measures what is alive. Their sum is at
//! least what the run takes, whatever was given back meanwhile. All of it is a function of the state,
//! of lengths and never of capacities, so that a copy runs out of memory where the original does.

use crate::state::block::block;
use crate::state::failure::Raise;
use crate::state::fluent::{Fluent, Watch};
use crate::state::machine::{Machine, SCRATCH_TASK};
use crate::state::memory::{LINK, MIN_THRESHOLD, TIMER, WAITER};
use crate::state::output::Output;
use crate::state::task::{Frame, Task, Waiting};
use crate::state::trace::Event;
use crate::state::value::Value;

/// A share of the limit that is not used up: collections never come closer.
const RESERVE: usize = 64;

/// Copies of a run that there are beside the one in which a plan is projected: the run itself, the one that is kept
/// with the question, and the one that the forks are made of. Each question that is not answered yet keeps one more.
const COPIES_BESIDE_A_FORK: usize = 3;

/// A share of the limit that a table may keep as free room.
const SLACK: usize = 32;

impl Machine {
    /// Bytes in use: what was alive at the last collection, and everything made since.
    pub fn used_bytes(&self) -> usize {
        self.heap.live.saturating_add(self.heap.allocated)
    }

    /// The bytes a run may come to.
    fn allowed_bytes(&self) -> usize {
        self.limits.bytes - self.limits.bytes / RESERVE
    }

    /// Makes sure that `bytes` more bytes may be made while registers below `top` are in use.
    pub(crate) fn make_room(&mut self, top: usize, bytes: usize) -> Result<(), Raise> {
        if self.used_bytes().saturating_add(bytes) <= self.allowed_bytes() {
            return Ok(());
        }
        self.scratch.top = top;
        // A network under evaluation is not named by anything yet, nor is what it was called for.
        if self.current != SCRATCH_TASK && bytes <= self.allowed_bytes() {
            self.collect();
        }
        match self.used_bytes().saturating_add(bytes) <= self.allowed_bytes() {
            true => Ok(()),
            false => Err(self.out_of_memory()),
        }
    }

    /// Bytes of free room that a table may keep: what is given back has to be taken from the system again.
    pub(crate) fn slack(&self) -> usize {
        self.limits.bytes / SLACK
    }

    /// How many more bytes may be made.
    pub(crate) fn room(&self) -> usize {
        self.allowed_bytes().saturating_sub(self.used_bytes())
    }

    /// Whether `bytes` more bytes may be made without a collection.
    pub fn has_room(&self, bytes: usize) -> bool {
        self.used_bytes().saturating_add(bytes) <= self.allowed_bytes()
    }

    /// The limit of a fork in which plans are projected, if there is room for it: what it may make is what this
    /// run and all copies beside it leave of the limit.
    pub(crate) fn limit_of_fork(&self) -> Option<usize> {
        let is_asked = |task: &Task| task.waiting() == Some(Waiting::Answer);
        let asked = self.tasks.iter().filter(|(_, task)| !task.state().is_dead() && is_asked(task)).count();
        let others = self.used_bytes().saturating_mul(COPIES_BESIDE_A_FORK + asked);
        let left = self.limits.bytes.checked_sub(others)?;
        (self.used_bytes() <= left - left / RESERVE).then_some(left)
    }

    /// Makes sure that plans can be projected from here.
    pub(crate) fn make_room_for_forks(&self) -> Result<(), Raise> {
        // What is asked for leads to a collection, if it helps.
        let missing = self.allowed_bytes().saturating_sub(self.used_bytes()) + 1;
        self.limit_of_fork().map(|_| ()).ok_or(Raise::NoRoom(missing))
    }

    pub(crate) fn out_of_memory(&self) -> Raise {
        let limit = self.limits.bytes;
        let limit = if limit < 1 << 20 { format!("{limit} bytes") } else { format!("{} MiB", limit >> 20) };
        Raise::new(
            "out-of-memory",
            format!("this would pass the limit of {limit}; keep less, or build less of it at a time"),
        )
    }

    /// Sets when the next collection is due. `parts` are the bytes of what was found alive beside the
    /// tables' own.
    pub(crate) fn measure(&mut self, parts: usize) {
        let output: usize = self.output.iter().map(|line| size_of::<Output>() + block(line.text.len())).sum();
        let events: usize = self.trace.events.iter().map(Event::bytes).sum();
        self.heap.live = parts
            + self.heap.bytes()
            + self.tasks.bytes()
            + self.fluents.slots() * size_of::<Option<Fluent>>()
            + self.watches.slots() * size_of::<Option<Watch>>()
            + self.timers.iter().count() * TIMER
            + self.priorities.bytes()
            + self.symbols.bytes()
            + (self.globals.len() + self.constants.len()) * size_of::<Value>()
            + self.places.iter().map(|place| place.links.len() * LINK).sum::<usize>()
            + self.valves.iter().map(|valve| valve.waiters.len() * WAITER).sum::<usize>()
            + self.unit_bytes
            + output
            + events
            + self.scratch.top * size_of::<Value>()
            + self.scratch.frames.len() * size_of::<Frame>();
        self.heap.allocated_before += self.heap.allocated as u64;
        self.heap.allocated = 0;
        let room = self.allowed_bytes().saturating_sub(self.heap.live);
        let least = (self.limits.bytes / RESERVE).min(MIN_THRESHOLD);
        self.heap.threshold = self.heap.live.max(MIN_THRESHOLD).min(room.max(least));
    }

    /// Collects garbage, if it is due, in the midst of an instruction.
    #[inline]
    pub(crate) fn collect_if_full(&mut self) -> Result<(), Raise> {
        if self.heap.is_full() { self.collect_here(self.scratch.top) } else { Ok(()) }
    }

    /// Collects garbage, if it is due, while no task runs and the main task lives. If that might not make room, it is
    /// left to an instruction, which can fail.
    #[inline]
    pub(crate) fn collect_at_rest(&mut self) {
        if self.heap.is_full() && self.has_room(0) && self.tasks.get_alive(self.main).is_some() {
            self.scratch.top = 0;
            self.scratch.frames.clear();
            self.collect();
        }
    }

    /// Collects garbage while registers below `top` are in use.
    #[cold]
    #[inline(never)]
    pub(crate) fn collect_here(&mut self, top: usize) -> Result<(), Raise> {
        self.scratch.top = top;
        // A network under evaluation is not named by anything yet, nor is what it was called for.
        if self.current != SCRATCH_TASK {
            self.collect();
        }
        if self.has_room(0) { Ok(()) } else { Err(self.out_of_memory()) }
    }
}
