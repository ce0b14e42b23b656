//! The children of a construct in progress.

use crate::state::active_time::ActiveTime;
use crate::state::value::{TaskRef, Value};
use rpl_lang::code::{Quorum, Reg, Successes};
use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// How a construct ends, decided when one of its children does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Decision {
    /// With a value.
    Succeed(Value),
    /// With a failure.
    Fail(Value),
}

/// A child that a partial order holds back.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Held {
    /// Its place among the children.
    pub position: u16,
    /// How many constraints keep it from starting.
    pub constraints: u32,
    /// The child.
    pub task: TaskRef,
}

/// The children of a construct in progress.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Children {
    /// How the outcome is decided.
    pub quorum: Quorum,
    /// The construct's name.
    pub name: Symbol,
    /// How many constructs of this name its surroundings had before, from 1.
    pub occurrence: u32,
    /// The register its value goes to.
    pub result: Reg,
    /// Children that are not dead.
    pub alive: u32,
    /// All children.
    pub total: u32,
    /// Once this is set, no child runs anything but clean-ups.
    pub decided: Option<Decision>,
    /// Value of the last child by position, once it has succeeded.
    pub last_value: Value,
    /// For a list: values of children, in its order.
    pub values: Vec<Value>,
    /// Failures of children, in the order in which they failed.
    pub failures: Vec<Value>,
    /// For a partial order: constraints between positions, sorted.
    pub order: Vec<(u16, u16)>,
    /// For a partial order: the children that cannot start at once, by position.
    pub held: Vec<Held>,
    /// For a map of which not all children begin at once: those that wait for their turn, by position.
    pub later: VecDeque<TaskRef>,
    /// For a timeout: seconds, and the number of its timer.
    pub seconds: f64,
    /// The timer of a timeout; 0 while there is none.
    pub timer: u64,
    /// For a timeout of time worked.
    pub active: Option<ActiveTime>,
    /// When the deadline came, if the task was suspended then; it takes effect at the resume.
    pub expired_us: Option<u64>,
}

impl Children {
    /// Whether no child can be done without.
    pub fn needs_all(&self) -> bool {
        let needs_all = match self.quorum.successes {
            Successes::All => true,
            // A deadline can come before the end of the one.
            Successes::Last => self.total == 1 && self.timer == 0 && self.active.is_none(),
            Successes::Count(_) => false,
        };
        self.decided.is_some() || needs_all
    }
}
