//! What exists only while code runs.

use crate::state::task::Frame;
use crate::state::value::{TaskRef, Value};
use rpl_lang::code::Reg;
use std::collections::{BTreeMap, BTreeSet};

/// The place of execution; in local variables while the loop runs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cursor {
    pub(crate) frame: Frame,
    /// Steps until control goes back to the caller.
    pub(crate) fuel: u32,
    /// Steps that the task may take in this instant after those.
    pub(crate) reserve: u32,
}

impl Cursor {
    /// With `steps` steps, taken in slices.
    pub(crate) fn new(frame: Frame, steps: u32, slice: u32) -> Self {
        let fuel = steps.min(slice);
        Self { frame, fuel, reserve: steps - fuel }
    }

    /// Steps left of the budget.
    pub(crate) fn steps(&self) -> u32 {
        self.fuel + self.reserve
    }

    /// Takes steps, from the slice first.
    pub(crate) fn spend(&mut self, steps: usize) {
        let steps = u32::try_from(steps).unwrap_or(u32::MAX);
        *self = Self::new(self.frame, self.steps().saturating_sub(steps), self.fuel.saturating_sub(steps));
    }
}

/// What exists only while code runs; empty between two steps, and no part of the state.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// Registers of the running task, and of networks above them.
    pub(crate) stack: Vec<Value>,
    /// Frames below the current one.
    pub(crate) frames: Vec<Frame>,
    /// One past the registers in use, known before slow instructions.
    pub(crate) top: usize,
    /// Fluents that networks under evaluation have read.
    pub(crate) reads: Reads,
    /// Whether the innermost one has asked for a pulse or a change.
    pub(crate) reads_event: bool,
    /// Networks that asked for a pulse or a change in this propagation.
    pub(crate) event_readers: BTreeSet<u32>,
    /// Whether there is one of them, or one that tells of events by itself was reached or made meanwhile.
    pub(crate) are_events_read: bool,
    /// Networks that have come to read other fluents, while the trace is written.
    pub(crate) rereading: Vec<u32>,
    /// A more important task has become ready.
    pub(crate) switch: bool,
    /// Tasks whose status fluents are behind.
    pub(crate) status_changed: Vec<TaskRef>,
    /// Departures to be looked at, the next one last.
    pub(crate) departures: Vec<Departure>,
    /// Departures are being looked at: further ones wait.
    pub(crate) is_departing: bool,
    /// An empty text that natives write into, for the room it has.
    pub(crate) draft: String,
    /// When a timer ends the wait that the running task begins: until that is in the trace.
    pub(crate) wake_at: Option<u64>,
    /// Bytes of the output that was added since there was none.
    pub(crate) output_bytes: usize,
    /// Where the running task goes on when the datum it asked for is compiled.
    pub(crate) asked: Option<(Cursor, Reg)>,
    /// Turns of the runtime's own loops: how they grow with a plan is told by it, and not by time.
    pub(crate) work: u64,
    /// Evaluations of networks and macros that are under way, one inside the other.
    pub(crate) evaluations: u32,
    /// How often the outermost of them, and those inside it, spent their steps.
    pub(crate) overdrawn: u8,
    /// Valves about which something has changed.
    pub(crate) restless: BTreeSet<u32>,
    /// They are being served.
    pub(crate) is_serving: bool,
    /// How often boosts have changed meanwhile.
    pub(crate) boost_changes: BTreeMap<u32, u32>,
    /// Links and waiters that were looked at for valves.
    pub(crate) valve_looks: u64,
    /// Steps that networks took on behalf of the running task.
    pub(crate) burned: u32,
    /// The running task goes to the end of its line, and goes on there with this value.
    pub(crate) gives_way: Option<Value>,
    /// Somebody steps through the run, and how far.
    pub(crate) stepping: Stepping,
}

/// Scratch is no part of a state.
impl PartialEq for Scratch {
    fn eq(&self, _other: &Self) -> bool {
        true
    }
}

/// Fluents that networks under evaluation have read, those of the innermost one last.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reads {
    /// As often as they were read.
    pub(crate) fluents: Vec<u32>,
    /// Whether a network is under evaluation.
    pub(crate) are_noted: bool,
}

/// A departure to be looked at.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Departure {
    /// A task is ended from outside.
    Evaporate(TaskRef),
    /// A task that is leaving waits no longer.
    GoOn(TaskRef),
}

/// How far a stepper has come.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Stepping {
    /// Whether the run is stepped through now.
    pub(crate) is_on: bool,
    /// Whether it stops before every instruction.
    pub(crate) is_fine: bool,
    /// The task and the instruction it stopped before: the next time it goes on from there.
    pub(crate) stopped: Option<(TaskRef, Frame)>,
    /// It has stopped in this step.
    pub(crate) has_stopped: bool,
    /// Where a value will be found that somebody wants to see, and the register.
    pub(crate) wanted: Option<(TaskRef, Frame, Reg)>,
    /// That value, as it could be read.
    pub(crate) found: Option<String>,
}
