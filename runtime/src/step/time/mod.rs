//! Time: the arguments of waits, the timers that end them, and waits that count time worked.

mod active_time;
mod arguments;
pub(crate) mod timers;
