//! Waiting: for fluents and for times.

mod fluents;
mod frozen;
mod time_worked;
mod times;
