//! Requests of valves, and what behaviours need.

use crate::source::Span;

/// A valve, as a function can see it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::check) enum SeenValve {
    Global(u32),
    /// The argument at this position.
    Parameter(usize),
}

/// A valve is asked for.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::check) struct ValveRequest {
    /// What is held then, in the order of taking, by the task or the ones around it.
    pub(in crate::check) held: Vec<SeenValve>,
    pub(in crate::check) valve: SeenValve,
    /// Where: in the text of the function that is looked at.
    pub(in crate::check) span: Span,
    /// Where exactly, if that is in a function it calls.
    pub(in crate::check) within: Option<Span>,
    /// Whether nothing can interrupt it: in a clean-up, or a hook of an interruption.
    pub(in crate::check) protected: bool,
    /// What is appended to the task's priority; none if that is not visible.
    pub(in crate::check) priority: Option<Vec<i64>>,
    /// Whether it is asked for by the task itself, not by one below.
    pub(super) same_task: bool,
    /// Whether the state of a task was waited for before.
    pub(in crate::check) after_task: bool,
}

/// A behaviour is activated without its valve.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::check) struct ValveNeed {
    pub(in crate::check) valve: u32,
    pub(in crate::check) behaviour: u32,
    pub(in crate::check) span: Span,
    pub(in crate::check) within: Option<Span>,
}

/// Two concurrent parts that can wait for each other.
#[derive(Clone, Debug)]
pub(in crate::check) struct ValveConflict {
    pub(in crate::check) first: ValveRequest,
    pub(in crate::check) second: ValveRequest,
}

/// What a function asks for.
#[derive(Clone, Debug, Default)]
pub(in crate::check) struct ValveSummary {
    pub(in crate::check) requests: Vec<ValveRequest>,
    pub(in crate::check) needs: Vec<ValveNeed>,
}
