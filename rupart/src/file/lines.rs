//! The lines of a case file.

use crate::case::{Counts, Goal, MetaPlan};
use crate::control::BehaviourParameters;
use crate::situation::Situation;
use rpl_robot::geometry::Point;
use serde::{Deserialize, Serialize};

/// The version of case files that is written, and the only one that is read.
pub const VERSION: u32 = 1;

/// More cases are no memory of a robot.
pub const MOST_CASES: usize = 100_000;

/// The largest number of a case: a robot learns as many again before it runs out of them.
pub(super) const LARGEST_NUMBER: u32 = u32::MAX / 2;

/// The first line.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Head {
    /// The version.
    pub(super) rpl_cases: u32,
    /// The world it was learned in.
    pub(super) world: String,
    /// The number of the next case.
    pub(super) next: u32,
}

/// Any other line.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Line {
    pub(super) case: u32,
    #[serde(default)]
    pub(super) counts: Counts,
    pub(super) index: Situation,
    pub(super) content: LineContent,
}

/// What is to be done, with names in place of numbers.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum LineContent {
    Behaviour(BehaviourParameters),
    Route(LineRoute),
    Goal(Goal),
    MetaPlan(MetaPlan),
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LineRoute {
    pub(super) stops: Vec<LineStop>,
    /// One less than stops; none where it was never driven, and none at all if no part of it was.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) times_s: Vec<Option<f64>>,
}

#[derive(Serialize, Deserialize)]
#[serde(untagged)]
pub(super) enum LineStop {
    Known(String),
    At(Point),
}
