//! Departures from the ordinary course of a task.

use crate::state::value::{TaskRef, Value};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// A departure from the ordinary course of a task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Leaving {
    /// Ended from outside.
    Evaporate,
    /// A failure looks for its handler.
    Fail(Value),
    /// A spawned child failed, and so does the plan call it belongs to.
    FailCall {
        /// Index of the plan call's scope.
        scope: u32,
        /// The child's failure.
        failure: Value,
    },
    /// Out of a block.
    Block {
        /// The block.
        identity: u64,
        /// The block's value.
        value: Value,
    },
    /// To an instruction, once the scopes in between are left.
    Jump {
        /// Scopes that stay.
        scopes: u32,
        /// The instruction.
        target: u32,
        /// Frames below the one it is in.
        depth: u32,
    },
    /// Out of the plan it runs, into another.
    Swap(Box<Swap>),
}

/// A plan that takes the place of the one a task runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Swap {
    /// Its code.
    pub code: u32,
    /// Valves that the task goes on holding.
    pub kept: Vec<u32>,
    /// Who asked for it; none if that was nobody in the run.
    pub by: Option<TaskRef>,
    /// While it waits: tasks that were in its way when that was looked at or have come to be since. Those that are in
    /// its way no more leave it from the end; only when none is left are all tasks looked at again.
    pub in_the_way: BTreeSet<TaskRef>,
}

/// What follows a clean-up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Then {
    /// The next instruction: the protected part had ended by itself.
    Continue,
    /// What cut the protected part short.
    Leave(Leaving),
}
