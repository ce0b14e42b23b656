//! Why a task runs the plan it runs: what foresight has decided about it, and who gave it another plan.

use crate::events::detail;
use rpl_runtime::state::trace::{Event, EventKind};

/// What an event about the plan of a task tells, as a sentence; nothing if it is about something else.
pub fn sentence(event: &Event) -> Option<String> {
    let of = |name| detail(event, name);
    match event.kind {
        EventKind::Swapped => Some(match of("by") {
            "" => "begins another plan".to_string(),
            by => format!("begins another plan, given by {by}"),
        }),
        EventKind::Decided => Some(decided(event)),
        EventKind::Begin
        | EventKind::End
        | EventKind::Call
        | EventKind::Return
        | EventKind::Blocked
        | EventKind::Woken
        | EventKind::Suspended
        | EventKind::Resumed
        | EventKind::Fluent
        | EventKind::Pulse
        | EventKind::Valve
        | EventKind::Failed
        | EventKind::Handled
        | EventKind::Behaviour
        | EventKind::Signal
        | EventKind::Robot
        | EventKind::Log
        | EventKind::Measured
        | EventKind::Warning => None,
    }
}

/// Whether an event tells of another plan that it is not better.
pub fn is_passed_over(event: &Event) -> bool {
    event.kind == EventKind::Decided && detail(event, "what") == "not better"
}

/// What foresight has found of a plan, of others beside it, and what it makes of that.
fn decided(event: &Event) -> String {
    let of = |name| detail(event, name);
    match of("what") {
        "looks ahead" => {
            let why = match of("fails-with") {
                "" | "nil" => String::new(),
                why => format!("; most that fail: {why}"),
            };
            format!(
                "looks ahead: success is probable to {}, by {} projected runs{why}",
                percent(of("success")),
                of("runs")
            )
        }
        "takes another plan" => format!("takes the plan of {}", of("rules")),
        "keeps its plan" => "keeps its plan".to_string(),
        what => format!(
            "with {}: success is probable to {} instead of {}, by {} runs; gain {} ± {}: {what}",
            of("rules"),
            percent(of("would-succeed")),
            percent(of("success")),
            of("runs"),
            rounded(of("gain")),
            rounded(of("error"))
        ),
    }
}

/// A share as a percentage; as it stands if it is no number.
fn percent(share: &str) -> String {
    share.parse::<f64>().map_or_else(|_| share.to_string(), |share| format!("{:.0} %", share * 100.0))
}

fn rounded(number: &str) -> String {
    number.parse::<f64>().map_or_else(|_| number.to_string(), |number| format!("{number:.2}"))
}
