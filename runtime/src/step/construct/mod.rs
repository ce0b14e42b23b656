//! Constructs.

pub mod deadline;
pub mod outcome;
pub mod start;
