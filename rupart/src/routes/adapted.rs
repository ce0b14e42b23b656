//! What came of adapting a route, and the work it was.

use crate::memory::CaseNumber;
use crate::places::Way;
use crate::route::Route;
use serde::{Deserialize, Serialize};

/// A route made from a case, and the work it was.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Adapted {
    /// From the start to the goal.
    pub route: Route,
    /// The case it was made from; none if it was made from scratch.
    pub case: Option<CaseNumber>,
    /// Whether the route was found poor and made anew.
    pub is_repaired: bool,
    /// Steps the supporting planner generated.
    pub generated_steps: usize,
    /// Steps of the route that the case does not have.
    pub new_steps: usize,
    /// Places the supporting planner expanded.
    pub expanded: usize,
}

/// The work of the supporting planner.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Work {
    pub(super) steps: usize,
    pub(super) expanded: usize,
}

impl Work {
    /// Notes a way that was searched.
    pub(super) fn note(&mut self, way: &Way) {
        self.steps += way.places.len() - 1;
        self.expanded += way.expanded;
    }
}
