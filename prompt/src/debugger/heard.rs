//! What a debugger says, read by a thread of its own.

use rpl_editor::dap::messages::{Request, Said};
use rpl_editor::frames::{Frames, Malformed};
use rpl_shell::interrupt;
use serde_json::{Value as Json, json};
use std::collections::VecDeque;
use std::io::{self, BufReader};
use std::sync::mpsc::{Receiver, Sender};

/// What was heard.
pub enum Heard {
    /// It asks.
    Request(Request),
    /// It says what is no request; what it is told then.
    Malformed(Said),
    /// It says nothing more, and why that is a fault.
    End(String),
}

/// Reads to the end of standard input, or as long as somebody wants to hear.
pub(super) fn read_on(heard: &Sender<Heard>) {
    let mut frames = Frames::new(BufReader::new(io::stdin()));
    loop {
        let said = match frames.read() {
            Ok(Some(Ok(message))) => match of(message) {
                Some(heard) => heard,
                None => continue,
            },
            Ok(Some(Err(Malformed(why)))) => Heard::Malformed(told(&why)),
            Ok(None) => Heard::End("the debugger is gone without having said `disconnect`".to_string()),
            Err(error) => Heard::End(format!("what the debugger says has broken off: {error}")),
        };
        let is_last = matches!(said, Heard::End(_));
        let cannot_wait = said.stops_run();
        if heard.send(said).is_err() {
            return;
        }
        if cannot_wait {
            interrupt::ask();
        }
        if is_last {
            return;
        }
    }
}

/// What a message says; none if it is an answer, since nothing was asked, or something that has happened there.
fn of(message: Json) -> Option<Heard> {
    match message["type"].as_str() {
        Some("request") => {}
        Some("response" | "event") => return None,
        Some(_) | None => return Some(Heard::Malformed(told("a message whose `type` is not `request`"))),
    }
    let number = message["seq"].as_i64();
    let command = message["command"].as_str().unwrap_or_default().to_string();
    match (serde_json::from_value(message), number) {
        (Ok(request), _) => Some(Heard::Request(request)),
        (Err(error), Some(request_seq)) => {
            let message = Some(format!("no request: {error}"));
            Some(Heard::Malformed(Said::Response { request_seq, success: false, command, message, body: None }))
        }
        (Err(error), None) => Some(Heard::Malformed(told(&format!("a request that cannot be answered: {error}")))),
    }
}

/// What cannot be answered is told to whoever debugs.
fn told(why: &str) -> Said {
    let output = format!("a message of the debugger is not understood: {why}\n");
    Said::Event { event: "output", body: Some(json!({ "category": "important", "output": output })) }
}

impl Heard {
    /// Whether a run under way stops for it; it goes on afterwards, if that is meant.
    fn stops_run(&self) -> bool {
        let Heard::Request(request) = self else { return true };
        matches!(
            request.command.as_str(),
            "pause" | "disconnect" | "terminate" | "setBreakpoints" | "setFunctionBreakpoints" | "threads"
        )
    }
}

/// What the debugger has said and was not answered yet.
pub struct Requests {
    heard: Receiver<Heard>,
    /// What was looked at before its turn.
    kept: VecDeque<Heard>,
}

impl Requests {
    pub(super) fn new(heard: Receiver<Heard>) -> Self {
        Self { heard, kept: VecDeque::new() }
    }

    /// The next one; none if nothing more can come.
    pub(super) fn next(&mut self) -> Option<Heard> {
        self.kept.pop_front().or_else(|| self.heard.recv().ok())
    }

    /// The next one that has come, if any has.
    pub(super) fn next_now(&mut self) -> Option<Heard> {
        self.kept.pop_front().or_else(|| self.heard.try_recv().ok())
    }

    /// What was looked at has its turn later.
    pub(super) fn keep(&mut self, heard: Heard) {
        self.kept.push_front(heard);
    }
}
