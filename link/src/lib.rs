//! Lines to other processes: pipes, sockets, and the threads and clocks that they take; and what a run leaves on the
//! disk to be heard, or gone on with, again.
//!
//! Read `transcript` first, then `recording`, `tcp_client` and `tcp_server`, then `process`, `process_module` and
//! `process_opener`; `thinker` and `journal` stand by themselves.

pub mod journal;
mod message_lines;
pub mod process;
pub mod process_module;
pub mod process_opener;
pub mod recording;
pub mod tcp_client;
pub mod tcp_server;
pub mod thinker;
pub mod transcript;
