//! What a run and its page tell each other.

use serde::{Deserialize, Serialize};
use std::io;
use thiserror::Error;

/// What becomes known of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum News {
    /// More lines of its series, each ended.
    Lines(String),
    /// How it goes on from now.
    Standing(Box<Standing>),
}

/// What somebody at the page asks for.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Asked {
    /// Stand still between two instants.
    Pause,
    /// Go on.
    Go,
    /// Keep pace with the clock, this many times as fast; none is as fast as possible.
    Pace(Option<f64>),
    /// Go to the next form, in whatever task.
    Step,
    /// Go to the next form of the same task that is not deeper in calls.
    Over,
    /// Go to the next form of the caller.
    Out,
    /// Stop at a line, a plan, or where a condition becomes true.
    Break(String),
    /// Stop there no more.
    Unbreak(String),
    /// End the run; its clean-ups run.
    Stop,
}

/// How a run goes on.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Standing {
    /// What it does.
    pub state: RunState,
    /// Times as fast as the clock; none is as fast as possible.
    pub pace: Option<f64>,
    /// The form it stands before: text, line and column.
    pub at: Option<String>,
    /// Why it stands still, or what was wrong with what was asked for.
    pub note: Option<String>,
    /// Where it stops.
    pub breakpoints: Vec<String>,
    /// Whether it can be steered.
    pub control: bool,
    /// Virtual time.
    pub time_us: u64,
}

/// What a run does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum RunState {
    /// It goes on.
    #[default]
    Running,
    /// It stands still.
    Paused,
    /// It is over.
    Ended,
}

/// Why a page does not answer.
#[derive(Debug, Error)]
pub enum Trouble {
    /// What is left of the limit of open files is for the run.
    #[error(
        "the page lets nobody in for now: nearly all of the {most} files are open that this process may have open, and \
         the rest is left to the run; `ulimit -n` before the start allows more"
    )]
    FewFiles {
        /// The limit.
        most: u64,
    },
    /// The system lets nobody in.
    #[error("the page lets nobody in for now: {0}; it does as soon as it can")]
    CannotAccept(io::Error),
    /// A fault of this program.
    #[error("the page has broken off by a fault of this program, and answers no more; the run goes on")]
    Ended,
}
