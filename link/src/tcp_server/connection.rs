//! The threads of a connection: one reads, and one writes.

use crate::message_lines::{MessageLines, ReadLine, write_line};
use crossbeam::channel::{Receiver, Sender};
use rpl_protocol::host::{CommandsMessage, MissionHello, ToHost, read};
use std::net::{Shutdown, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// What comes from those who are connected.
pub(super) enum Event {
    Greeted(MissionHello, Instant),
    Commands(CommandsMessage, Instant),
    Closed(String),
}

/// Hands on what comes from a connection, until it ends; the greeting within a time.
pub(super) fn read_commands(
    mut lines: MessageLines,
    greeting: Duration,
    connection: u64,
    events: &Sender<(u64, Event)>,
) {
    // Once the greeting is there, the server looks at how long nothing comes.
    let mut until = Some(Instant::now() + greeting);
    let why = loop {
        let line = match lines.next(until) {
            ReadLine::Text(line) => line,
            ReadLine::End => break "it has closed the line".to_string(),
            ReadLine::Silence => break format!("it has not greeted within {:.1} s", greeting.as_secs_f64()),
            ReadLine::Fault(what) => break format!("it has sent {what}"),
        };
        let event = match read(&line) {
            Ok(ToHost::Commands(commands)) => Event::Commands(commands, Instant::now()),
            Ok(ToHost::Hello(hello)) => {
                until = None;
                Event::Greeted(hello, Instant::now())
            }
            Ok(ToHost::Bye(bye)) => break format!("it {}", bye.told()),
            Err(why) => break format!("it has sent what is no message: {why}"),
        };
        if events.send((connection, event)).is_err() {
            return;
        }
    };
    // A host that has ended asks no more.
    events.send((connection, Event::Closed(why))).ok();
}

/// Writes lines, each within a time; once the mission is leaving, all that are left within that time.
pub(super) fn write_percepts(stream: &TcpStream, within: Duration, lines: &Receiver<String>, is_leaving: &AtomicBool) {
    let mut end_by: Option<Instant> = None;
    for line in lines {
        if is_leaving.load(Ordering::Relaxed) {
            end_by.get_or_insert_with(|| Instant::now() + within);
        }
        let left = end_by.map_or(within, |by| by.saturating_duration_since(Instant::now()));
        // A line that cannot be written is the last: the reader of the mission sees that it is gone.
        if write_line(stream, &line, left).is_err() {
            break;
        }
    }
    stream.shutdown(Shutdown::Both).ok();
}
