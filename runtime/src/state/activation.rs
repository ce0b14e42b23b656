//! Activations: where behaviours stand, and what their tasks have not heard yet.

use crate::state::value::{TaskRef, Value};
use serde::{Deserialize, Serialize};

/// Where a behaviour stands, seen from the plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// Not activated.
    #[default]
    Inactive,
    /// At work.
    Active,
    /// It has lost its valve or its goals.
    Interrupted,
    /// It has ended by itself.
    Done,
}

/// Where the behaviours of a robot stand.
#[derive(Clone, Copy, Debug)]
pub struct Phases<'a>(pub(crate) &'a [Activation]);

impl Phases<'_> {
    /// Where a behaviour stands.
    pub fn of(self, behaviour: u16) -> Phase {
        self.0.get(usize::from(behaviour)).map_or(Phase::Inactive, |activation| activation.phase)
    }
}

/// One behaviour's activation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Activation {
    /// Where it stands.
    pub phase: Phase,
    /// Who activated it.
    pub task: Option<TaskRef>,
    /// A signal nobody has taken yet: the value of a success, or a failure.
    pub signal: Option<Result<Value, Value>>,
    /// Signals that activations before this one left to their tasks, which have not run since.
    pub kept: Vec<(TaskRef, Result<Value, Value>)>,
}

impl Activation {
    /// The signals nobody has taken yet.
    pub(crate) fn signals(&self) -> impl Iterator<Item = Result<Value, Value>> {
        self.signal.iter().chain(self.kept.iter().map(|(_, signal)| signal)).copied()
    }
}
