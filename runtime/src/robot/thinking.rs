//! Questions that are thought about beside the run, while the world goes on, and what comes of them.
//!
//! A question about plans is put to the robot first (`Outside::think`), with a fork of the run in which it was asked. A
//! robot whose world stands still while the run computes gives it back, and it is answered at once. A robot with a host
//! in another process takes it. Then the task waits for the answer as for anything else, and the answer comes with a
//! step of the robot, as percepts do. So no clock and no thread is in this crate.
//!
//! A saved run has the number of a question and nothing else of it. The question is answered by what was heard. Where
//! nobody has the question any more, it is asked again.

use crate::state::figures::Foresight;
use crate::state::value::TaskRef;
use serde::{Deserialize, Serialize};
use std::fmt::Debug;

/// Which wait of which task an answer ends. An answer that comes when the task waits no more has no effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ticket {
    /// Who has asked.
    pub task: TaskRef,
    /// The number of its wait.
    pub wait: u32,
    /// When it asked, in virtual time.
    pub asked_us: u64,
}

/// What has come of thinking about a question.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Insight {
    /// How the plans would go.
    Found(Foresight),
    /// It cannot be told.
    Failed {
        /// The class of the failure.
        class: String,
        /// One sentence.
        message: String,
    },
}

/// A question as it was asked, with all that the answer depends on.
pub trait Thought: Debug + Send + Sync {
    /// Tells questions apart. Cost: the plans are written out.
    fn checksum(&self) -> u32;

    /// The answer, the same whenever and wherever it is thought about; none if it was given up, which is asked
    /// every few milliseconds.
    fn think(&self, is_given_up: &dyn Fn() -> bool) -> Option<Insight>;
}
