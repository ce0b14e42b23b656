//! What a task waits for, and what it finds when it goes on.

use crate::state::value::Value;
use serde::{Deserialize, Serialize};

/// What a blocked task waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Waiting {
    /// A fluent to be true.
    Fluent {
        /// The fluent.
        fluent: u32,
        /// Whether it dies with the wait.
        owned: bool,
        /// Whether a timer ends the wait.
        timed: bool,
    },
    /// A watched fluent to become true.
    Watch(u32),
    /// A time.
    Time,
    /// The children of its innermost construct.
    Children,
    /// Children that it spawned in the plan call that is ending.
    Spawned,
    /// A valve.
    Valve(u32),
    /// The death of another task, which it has evaporated.
    Death(u32),
    /// Another task, which it has suspended, to have no clean-up running any more.
    Rest(u32),
    /// Another task, to which it has given a plan, to begin that.
    Swap(u32),
    /// Hooks of the interruption it is in to have run, before its clean-up.
    Hooks(u32),
    /// The signal of a behaviour.
    Signal(u16),
    /// The answer to a question that is thought about beside the run.
    Answer,
}

/// What a task waits for, or else what it finds or has come to: never both, so that they share a place in its record.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Prospect {
    /// It waits.
    Wait(Waiting),
    /// What it finds when it goes on, [`Value::Unbound`] if nothing; once dead, its value or failure.
    Value(Value),
}

/// What a task finds when it goes on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Wake {
    /// It was not woken.
    #[default]
    Nothing,
    /// A value for the register it waits with.
    Value(Value),
    /// A failure, raised where it waits.
    Raise(Value),
    /// The failure of the construct it waited for. It is fixed: an evaporation does not take its place.
    Outcome(Value),
}

/// Whether what a task finds when it goes on is a failure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Raises {
    /// No.
    #[default]
    Nothing,
    /// A failure.
    Failure,
    /// The failure of a construct.
    Outcome,
}
