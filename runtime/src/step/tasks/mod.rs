//! Tasks: the tree they form, their states, how they wait, are suspended and end.

pub mod condition;
mod deadlock;
mod death;
mod evaporation;
pub(crate) mod path;
mod scheduling;
mod stall;
mod status;
mod suspension;
mod tree;
pub(crate) mod unwind;
mod waiting;
