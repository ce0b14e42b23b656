//! What changes the records of [`crate::state`]: one step of a run.
//!
//! All of it is functions of the machine, sorted by their topics. `exec` runs the code of one task; an instruction
//! about plans hands over to the folder of its topic. Methods of the machine call each other across files, and no type
//! makes a circle of them. Nothing here knows of a whole run or of a library.

mod behaviours;
mod construct;
pub(crate) mod exec;
pub(crate) mod failures;
mod fluents;
pub mod memory;
pub mod native;
pub mod natives;
mod output;
pub mod print;
mod program;
mod stepping;
pub mod tasks;
pub(crate) mod time;
mod tracing;
mod valve;
