//! `rpl dap`: a debug adapter over the session that the prompt works on. A thread reads what the debugger says, and
//! lets a run that is under way stop for what cannot wait.
//!
//! Threads are the living tasks, a step is a step of the prompt, and going back is going back in the session's
//! timeline: what comes after is computed again, and comes out the same.

mod adapter;
mod heard;
mod places;
mod standing;

use adapter::Adapter;
use heard::{Requests, read_on};
use rpl_shell::interrupt;
use rpl_shell::status::Status;
use std::io;
use std::sync::mpsc::channel;
use std::thread;

/// Serves a debugger on standard input and output until it disconnects or is gone.
///
/// # Errors
/// Standard output is closed.
pub fn debug() -> io::Result<Status> {
    let (sender, heard) = channel();
    thread::spawn(move || read_on(&sender));
    let _meaning = interrupt::gives_prompt_back();
    let mut adapter = Adapter::new(Requests::new(heard));
    adapter.serve()
}
