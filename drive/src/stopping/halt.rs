//! How far a run is to go on, and why it stands still.

use super::breakpoint::Breakpoint;
use rpl_runtime::run::session::Answer;
use std::time::Instant;

/// How far to go on.
#[derive(Clone, Debug, PartialEq)]
pub enum Until {
    /// To the end of the form, or to a breakpoint.
    End,
    /// To the next form, in whatever task.
    Step,
    /// The same, also into the library, if the marked form calls it.
    Into,
    /// To the next form of the same task that is not deeper in calls.
    Next,
    /// To the next form of the function or plan that called this one.
    Out,
    /// To an instant of virtual time.
    Time(u64),
    /// To a place or condition, as for a breakpoint.
    Place(Breakpoint),
    /// By the clock on the wall, also while no form is under way.
    Clock {
        /// The instant of virtual time that has come.
        due_us: u64,
        /// When to stop in any case.
        before: Instant,
    },
}

/// Why the run stands still.
#[derive(Clone, Debug, PartialEq)]
pub enum Halt {
    /// The form has ended.
    Answered(Answer),
    /// Where the user wanted to go.
    Arrived,
    /// At a breakpoint, so described.
    Breakpoint(String),
    /// Ctrl-C.
    Interrupted,
}
