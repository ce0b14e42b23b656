//! `rpl dap`: a debug adapter over the session that the prompt works on. A thread reads what the debugger says, and
//! lets a run that is under way stop for what cannot wait.
//!
//! Threads are the living tasks, a step is a step of the prompt, and going back is going back in the session's
//! timeline: what comes after is computed again, and comes out the same.

mod adapter;
mod places;
mod standing;

use crate::interrupt;
use crate::status::Status;
use adapter::Adapter;
use rpl_editor::dap::messages::Request;
use rpl_editor::dap::wire;
use std::io::{self, BufReader};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

/// Serves a debugger on standard input and output until it disconnects or is gone.
///
/// # Errors
/// Standard output is closed.
pub fn debug() -> io::Result<Status> {
    let (sender, requests) = channel();
    thread::spawn(move || read_on(&sender));
    let _meaning = interrupt::gives_prompt_back();
    let mut adapter = Adapter::new(Requests { heard: requests, kept: Default::default() });
    adapter.serve()
}

/// Reads to the end of standard input.
fn read_on(requests: &Sender<Request>) {
    let mut from = BufReader::new(io::stdin());
    // What is no message ends the conversation: where the next one begins cannot be known.
    while let Ok(Some(message)) = wire::read(&mut from) {
        let Ok(request) = serde_json::from_value::<Request>(message) else { continue };
        let cannot_wait = stops_run(&request.command);
        if requests.send(request).is_err() {
            return;
        }
        if cannot_wait {
            interrupt::ask();
        }
    }
    interrupt::ask();
}

/// Whether a run under way stops for a request; it goes on afterwards, if that is meant.
fn stops_run(command: &str) -> bool {
    matches!(command, "pause" | "disconnect" | "terminate" | "setBreakpoints" | "setFunctionBreakpoints" | "threads")
}

/// What the debugger has said and was not answered yet.
struct Requests {
    heard: Receiver<Request>,
    /// What was looked at before its turn.
    kept: std::collections::VecDeque<Request>,
}

impl Requests {
    /// The next one; none if the debugger is gone.
    fn next(&mut self) -> Option<Request> {
        self.kept.pop_front().or_else(|| self.heard.recv().ok())
    }

    /// The next one that has come, if any has.
    fn next_now(&mut self) -> Option<Request> {
        self.kept.pop_front().or_else(|| self.heard.try_recv().ok())
    }
}
