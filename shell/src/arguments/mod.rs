//! What several commands take on their command lines: where a plan runs, times, names of plans, first
//! values of variables, tokens; and how a shell completes them.

pub mod completion;
pub mod duration;
pub mod journal;
pub mod numbers;
pub mod plan_files;
pub mod site;
pub mod token;
