//! Waiting: for fluents and for times.

mod fluents;
mod time_worked;
mod times;
