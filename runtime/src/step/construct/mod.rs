//! Constructs of concurrent children: one primitive, and a rule that looks at how each child ends.

mod deadline;
pub(crate) mod outcome;
mod start;
