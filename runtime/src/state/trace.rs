//! The trace as data: what happened, in order.

use crate::state::block::block;
use serde::{Deserialize, Serialize};

/// Kinds of event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EventKind {
    /// A task began.
    Begin,
    /// A task ended: `state`, `value` or `failure`.
    End,
    /// A plan was called: `arguments`, if it has any.
    Call,
    /// A plan call ended.
    Return,
    /// A task blocked: `on`, `at`; if a timer ends the wait, `until`, a time in seconds; if it waits
    /// for a condition, `reads`, and the value of each fluent named there. Written again when the
    /// condition comes to read other fluents.
    Blocked,
    /// A task was woken.
    Woken,
    /// A task was suspended: `by`, if a task did it and not a valve.
    Suspended,
    /// A suspended task may go on.
    Resumed,
    /// A fluent changed: `fluent`, `value`. Also one that is computed from others.
    Fluent,
    /// A fluent was pulsed: `fluent`.
    Pulse,
    /// A valve was requested, granted, pre-empted, released, returned: `valve`, `what`.
    Valve,
    /// A failure was raised: `failure`, `at`.
    Failed,
    /// A failure was handled.
    Handled,
    /// A behaviour was activated, deactivated, interrupted: `behaviour`, `what`.
    Behaviour,
    /// A behaviour gave its signal: `behaviour`, `signal`, and the `value` of a success that has one.
    Signal,
    /// The robot reports: `what` and its details.
    Robot,
    /// A task was given another plan: `by`, if a task did it; `at`, where the text of the plan begins.
    Swapped,
    /// Foresight has decided something about the plan of a task: `what`, and the figures it goes by.
    Decided,
    /// `(log …)`.
    Log,
    /// `(measure …)`: `measure`, `value`.
    Measured,
    /// Something a person should know.
    Warning,
}

impl EventKind {
    /// The name in traces.
    pub fn name(self) -> &'static str {
        match self {
            EventKind::Begin => "begin",
            EventKind::End => "end",
            EventKind::Call => "call",
            EventKind::Return => "return",
            EventKind::Blocked => "blocked",
            EventKind::Woken => "woken",
            EventKind::Suspended => "suspended",
            EventKind::Resumed => "resumed",
            EventKind::Fluent => "fluent",
            EventKind::Pulse => "pulse",
            EventKind::Valve => "valve",
            EventKind::Failed => "failed",
            EventKind::Handled => "handled",
            EventKind::Behaviour => "behaviour",
            EventKind::Signal => "signal",
            EventKind::Robot => "robot",
            EventKind::Swapped => "swapped",
            EventKind::Decided => "decided",
            EventKind::Log => "log",
            EventKind::Measured => "measured",
            EventKind::Warning => "warning",
        }
    }
}

/// One event.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Event {
    /// Virtual time.
    pub time_us: u64,
    /// Counts the events of a run.
    pub sequence: u64,
    /// The path of the task it happened to; empty for the world's events.
    pub path: String,
    /// What kind of event it is.
    pub kind: EventKind,
    /// Details by name.
    pub details: Vec<(String, String)>,
}

impl std::fmt::Display for Event {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{:10.3}  {:<9} {}", self.time_us as f64 / 1e6, self.kind.name(), self.path)?;
        for (name, value) in &self.details {
            write!(out, "  {name}={value}")?;
        }
        Ok(())
    }
}

impl Event {
    /// Bytes it takes.
    pub(crate) fn bytes(&self) -> usize {
        let details = self.details.iter().map(|(name, value)| block(name.len()) + block(value.len()));
        size_of::<Self>()
            + block(self.path.len())
            + block(std::mem::size_of_val(self.details.as_slice()))
            + details.sum::<usize>()
    }
}

/// Events not yet taken.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Trace {
    /// Whether events are written.
    pub enabled: bool,
    /// Events, oldest first.
    pub events: Vec<Event>,
    /// The number of the next event.
    pub next_sequence: u64,
    /// Fluents whose every change is too much to write: the robot's continuous ones.
    pub quiet: Vec<u32>,
}

impl Trace {
    /// Takes the events written so far.
    pub fn take(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.events)
    }
}
