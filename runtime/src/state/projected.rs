//! Projections as data: what is asked of one, and what is noted of a run that is projected.

use crate::state::value::{TaskRef, Value};
use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};

/// What a task asks of the whole run.
#[derive(Clone, Debug, PartialEq)]
pub enum Asked {
    /// To compile a datum; the task goes on in it.
    Code(Value),
    /// To compile a datum; the task goes on with it as a function.
    Function(Value),
    /// To project plans.
    Projection(Box<Question>),
}

/// What the whole run answers a task that has asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answered {
    /// The task goes on in this code.
    Code(u32),
    /// The task goes on with this value.
    Value(Value),
}

/// In which detail a robot is projected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Grain {
    /// In events: a drive is a duration and an outcome.
    #[default]
    Abstract,
    /// Step by step, by its own controller in a simulated world.
    Simulated,
}

impl Grain {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Abstract, Self::Simulated];

    /// Its name in plans, without the colon.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Abstract => "abstract",
            Self::Simulated => "simulated",
        }
    }
}

/// What is asked of a projection.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// Plans as data: each is run where it was asked, in runs of its own that draw the same as those of
    /// the others.
    pub plans: Vec<Value>,
    /// The task whose end counts; none for the end of the plan.
    pub task: Option<TaskRef>,
    /// Runs of each plan; at most, if plans are compared.
    pub runs: u32,
    /// How far the runs go from now.
    pub horizon_us: u64,
    /// In which detail the robot is projected.
    pub grain: Grain,
    /// By what the first plan is compared with the others, if it is.
    pub stake: Option<Stake>,
}

/// By what plans are compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stake {
    /// By how much another plan is to be better.
    pub margin: f64,
    /// How many standard errors the margin must lie away from the mean difference.
    pub standard_errors: f64,
    /// The fluent whose number at its end is what a run is worth, if they are compared by one.
    pub worth: Option<Symbol>,
}

/// More begun steps than this are not noted of a run.
pub const MOST_STEPS: usize = 256;

/// What is noted of a projected run while it goes on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProjectedRun {
    /// How the plan ended, once it has: nil, or its failure.
    pub ended: Option<Value>,
    /// Paths of the tagged steps that have begun, and when.
    pub begun: Vec<(String, u64)>,
}
