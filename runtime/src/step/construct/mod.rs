//! Constructs of concurrent children: one primitive, and a rule that looks at how each child ends.
//! The rule is a quorum of successes and failures.

mod deadline;
pub(crate) mod outcome;
mod start;
