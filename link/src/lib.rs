//! Lines to other processes: pipes, sockets, and the threads and clocks that they take.
//!
//! Read `transcript` first, then `recording`.

pub mod recording;
pub mod transcript;
