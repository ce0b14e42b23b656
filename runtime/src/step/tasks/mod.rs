//! Tasks: the tree they form, their states, how they wait, are suspended and end.

mod choice;
pub mod condition;
mod deadlock;
mod death;
mod evaporation;
mod finished;
mod needs;
pub(crate) mod path;
mod scheduling;
mod stall;
mod status;
mod suspension;
mod swap;
mod tree;
pub(crate) mod unwind;
mod waiting;
