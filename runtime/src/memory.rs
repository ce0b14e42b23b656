//! What a run takes of memory, and how much it may take.
//!
//! Whatever is made adds its bytes to a counter; a collection measures what is alive. Their sum is at
//! least what the run takes, whatever was given back meanwhile. All of it is a function of the state,
//! of lengths and never of capacities, so that a copy runs out of memory where the original does.

use crate::failure::{Failure, Raise};
use crate::fluent::{Fluent, Origin, Watch};
use crate::heap::{Key, KeyPart};
use crate::machine::{Machine, Output, SCRATCH_TASK};
use crate::scheduler::Timer;
use crate::task::{Call, Children, Frame, Rare, Scope, ScopeKind, Task};
use crate::value::Value;
use crate::valve::{Below, Link, Valve, Waiter};
use crate::valve_line::ValveLine;

/// Collections come at least so many bytes apart, where there is room.
pub const MIN_THRESHOLD: usize = 8 << 20;

/// A share of the limit that is not used up: collections never come closer.
const RESERVE: usize = 64;

/// A share of the limit that a table may keep as free room.
const SLACK: usize = 32;

/// What the allocator takes for a block of so many bytes.
pub(crate) fn block(bytes: usize) -> usize {
    if bytes == 0 { 0 } else { (bytes + 8).next_multiple_of(16).max(32) }
}

/// An entry of a tree of maps: its nodes are little more than half full when they are filled in order.
pub(crate) const fn entry<T>() -> usize {
    2 * size_of::<T>()
}

/// Bytes of an entry of a hash table.
pub fn table_entry(key: &Key) -> usize {
    let parts = match key {
        Key::Atom(_) => 0,
        Key::List(parts) => block(std::mem::size_of_val::<[KeyPart]>(parts)),
    };
    entry::<(Key, (Value, Value))>() + parts
}

/// Bytes of a new task, its registers not counted.
pub(crate) const TASK: usize = size_of::<Option<Task>>() + size_of::<u32>();

/// Bytes of a new fluent with so many captured values.
pub(crate) fn fluent(captured: usize) -> usize {
    size_of::<Option<Fluent>>() + block(captured * size_of::<Value>())
}

/// Bytes of an edge from a fluent to a network that reads it, or to a watch.
pub(crate) const EDGE: usize = block_of_edge();

const fn block_of_edge() -> usize {
    2 * size_of::<(u64, u32)>() + size_of::<u32>()
}

/// Bytes of a watch.
pub(crate) const WATCH: usize = size_of::<Option<Watch>>() + EDGE;

/// Bytes of a task that waits for a valve: its request, and its places in two lines.
pub(crate) const WAITER: usize =
    entry::<(u32, Waiter)>() + 2 * entry::<(u64, u32)>() + entry::<(u64, Below)>() + size_of::<ValveLine>();

/// Bytes of a hold or a mark of a valve, which the task knows of too.
pub(crate) const LINK: usize = size_of::<Link>() + 2 * size_of::<u32>();

/// Bytes of a timer.
pub(crate) const TIMER: usize = size_of::<Timer>();

/// Bytes of how often names were used: the first ones take a whole node of their map.
pub(crate) fn counters(names: usize) -> usize {
    if names == 0 { 0 } else { COUNTERS + names * entry::<(u32, u32)>() }
}

/// Bytes of the first name that is counted.
pub(crate) const COUNTERS: usize = 112;

/// Bytes of the stack of scopes of a task that has any: boxes, and room for the first ones.
pub(crate) const SCOPE_STACK: usize = 304;

/// Bytes of a scope.
pub(crate) fn scope(kind: &ScopeKind) -> usize {
    let inside = match kind {
        ScopeKind::Call(call) => {
            block(size_of::<Call>())
                + counters(call.counters.len())
                + block(std::mem::size_of_val(call.tags.as_slice()))
        }
        ScopeKind::Children(children) => {
            block(size_of::<Children>())
                + block(std::mem::size_of_val(children.failures.as_slice()))
                + block(std::mem::size_of_val(children.order.as_slice()))
                + block(std::mem::size_of_val(children.held.as_slice()))
        }
        ScopeKind::InCleanup(_) => block(size_of::<crate::task::Then>()),
        ScopeKind::Block { .. }
        | ScopeKind::Handler { .. }
        | ScopeKind::Cleanup { .. }
        | ScopeKind::Valve(_)
        | ScopeKind::OnInterrupt(_)
        | ScopeKind::OnResume(_)
        | ScopeKind::Suspended(_)
        | ScopeKind::Watch(_) => 0,
    };
    size_of::<Scope>() + size_of::<u32>() + inside
}

/// Bytes of what a failure holds.
pub(crate) fn failure(failure: &Failure) -> usize {
    block(failure.message.len())
        + block(failure.path.len())
        + block(std::mem::size_of_val(failure.slots.as_slice()))
        + block(std::mem::size_of_val(failure.calls.as_slice()))
        + block(std::mem::size_of_val(failure.parts.as_slice()))
        + block(std::mem::size_of_val(failure.while_cleaning_up.as_slice()))
}

/// Bytes of the stack of frames of a task that has any.
const FRAME_STACK: usize = 64;

/// Bytes of a task beside its record and registers.
pub(crate) fn task(task: &Task) -> usize {
    let frames = match task.frames.len() {
        0 => 0,
        count => FRAME_STACK + count * size_of::<Frame>(),
    };
    let scopes: usize = task.scopes.iter().map(|entered| scope(&entered.kind)).sum();
    let scopes = if scopes == 0 { 0 } else { SCOPE_STACK + scopes };
    let rare = task.rare.as_ref().map_or(0, |rare| block(size_of::<Rare>()) + counters(rare.counters.len()));
    frames + scopes + rare
}

/// Bytes of a fluent that is alive, beside its record.
pub(crate) fn fluent_parts(fluent: &Fluent) -> usize {
    let captured = match &fluent.origin {
        Origin::Network { captured, .. } => block(std::mem::size_of_val::<[Value]>(captured)),
        Origin::Plan | Origin::System | Origin::Pulsed | Origin::Changed | Origin::Count => 0,
    };
    captured + (fluent.dependents.len() + fluent.watches.len() + fluent.inputs.len()) * EDGE
}

impl Machine {
    /// Bytes in use: what was alive at the last collection, and everything made since.
    pub fn used_bytes(&self) -> usize {
        self.heap.live.saturating_add(self.heap.allocated)
    }

    /// The bytes a run may come to.
    fn allowed_bytes(&self) -> usize {
        self.limits.bytes - self.limits.bytes / RESERVE
    }

    /// Makes sure that so many more bytes may be made while registers below `top` are in use.
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

    /// Whether so many more bytes may be made without a collection.
    pub fn has_room(&self, bytes: usize) -> bool {
        self.used_bytes().saturating_add(bytes) <= self.allowed_bytes()
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
        let of_valve = |valve: &Valve| valve.links.len() * LINK + valve.waiters.len() * WAITER;
        let events: usize = self.trace.events.iter().map(crate::trace::Event::bytes).sum();
        self.heap.live = parts
            + self.heap.bytes()
            + self.tasks.bytes()
            + self.fluents.slots() * size_of::<Option<Fluent>>()
            + self.watches.slots() * size_of::<Option<Watch>>()
            + self.timers.iter().count() * TIMER
            + self.priorities.bytes()
            + self.symbols.bytes()
            + (self.globals.len() + self.constants.len()) * size_of::<Value>()
            + self.valves.iter().map(of_valve).sum::<usize>()
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
}
