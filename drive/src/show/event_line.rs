//! An event as a line that a person reads.

use crate::events::{detail, measured, report};
use rpl_lang::visible::visible;
use rpl_runtime::state::trace::{Event, EventKind};

/// What a task's name is where an event belongs to none.
pub const ROBOT: &str = "the robot";

/// Time, kind, task, and what happened.
pub fn event_line(event: &Event, colour: bool) -> String {
    let kind = format!("{:<9}", event.kind.name());
    let kind = match colour_of(event).filter(|_| colour) {
        Some(code) => format!("\x1b[{code}m{kind}\x1b[0m"),
        None => kind,
    };
    let path = if event.path.is_empty() { ROBOT.into() } else { visible(&event.path) };
    let time_s = event.time_us as f64 / 1e6;
    match what(event) {
        what if what.is_empty() => format!("{time_s:10.3}  {kind}  {path}"),
        what => format!("{time_s:10.3}  {kind}  {path}  {}", visible(&what)),
    }
}

fn colour_of(event: &Event) -> Option<&'static str> {
    match event.kind {
        EventKind::Failed | EventKind::Warning => Some("31"),
        EventKind::End | EventKind::Return if detail(event, "state") == "failed" => Some("31"),
        EventKind::Fluent | EventKind::Pulse => Some("36"),
        EventKind::Valve | EventKind::Suspended | EventKind::Resumed | EventKind::Swapped | EventKind::Decided => {
            Some("33")
        }
        EventKind::Robot | EventKind::Behaviour | EventKind::Signal => Some("32"),
        EventKind::Begin
        | EventKind::End
        | EventKind::Call
        | EventKind::Return
        | EventKind::Blocked
        | EventKind::Woken
        | EventKind::Handled
        | EventKind::Log
        | EventKind::Measured => None,
    }
}

fn what(event: &Event) -> String {
    let of = |name| detail(event, name);
    let placed = |text: String| match of("at") {
        "" => text,
        place => format!("{text}  at {place}"),
    };
    match event.kind {
        EventKind::Begin | EventKind::Call | EventKind::Woken | EventKind::Resumed | EventKind::Handled => {
            String::new()
        }
        EventKind::Suspended => match of("by") {
            "" => String::new(),
            by => format!("by {by}"),
        },
        EventKind::Swapped => placed(match of("by") {
            "" => "has another plan".to_string(),
            by => format!("has another plan, by {by}"),
        }),
        EventKind::Decided => event.details.iter().fold(String::new(), |told, (name, value)| match name.as_str() {
            "what" => value.clone(),
            _ => format!("{told}  {name}={value}"),
        }),
        EventKind::End | EventKind::Return => {
            let result = [of("value"), of("failure")].concat();
            if result.is_empty() { of("state").to_string() } else { format!("{}: {result}", of("state")) }
        }
        EventKind::Blocked => placed(match of("until") {
            "" => format!("waits for {}", of("on")),
            until => format!("waits for {} until {until} s", of("on")),
        }),
        EventKind::Fluent => format!("{} = {}", of("fluent"), of("value")),
        EventKind::Pulse => of("fluent").to_string(),
        EventKind::Valve => format!("{} {}", of("valve"), of("what")),
        EventKind::Failed => placed(of("failure").to_string()),
        EventKind::Behaviour => format!("{} {}", of("behaviour"), of("what")),
        EventKind::Signal => format!("{}: {}", of("behaviour"), of("signal")),
        EventKind::Robot => report(event),
        EventKind::Measured => measured(event),
        EventKind::Log | EventKind::Warning => of("text").to_string(),
    }
}
