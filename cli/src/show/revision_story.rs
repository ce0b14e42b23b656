//! Why a task runs the plan it runs: what foresight has decided about it, and who gave it another plan.

use crate::show::events::detail;
use rpl_runtime::state::trace::{Event, EventKind};

/// What an event about the plan of a task tells, as a sentence; nothing if it is about something else.
pub fn sentence(event: &Event) -> Option<String> {
    let of = |name| detail(event, name);
    match event.kind {
        EventKind::Swapped => Some(match of("by") {
            "" => "begins another plan".to_string(),
            by => format!("begins another plan, given by {by}"),
        }),
        EventKind::Decided if of("would-succeed").is_empty() => {
            let what = of("what");
            Some(format!("{what}: {} of its runs would succeed; other plans: {}", percent(of("success")), of("plans")))
        }
        EventKind::Decided => Some(format!(
            "{} by {}: {} of the runs would succeed, and {} as it is; gain {} ± {} over {} runs",
            of("what"),
            of("rules"),
            percent(of("would-succeed")),
            percent(of("success")),
            rounded(of("gain")),
            rounded(of("error")),
            of("runs")
        )),
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
        | EventKind::Warning => None,
    }
}

/// A share as a percentage; as it stands if it is no number.
fn percent(share: &str) -> String {
    share.parse::<f64>().map_or_else(|_| share.to_string(), |share| format!("{:.0} %", share * 100.0))
}

fn rounded(number: &str) -> String {
    number.parse::<f64>().map_or_else(|_| number.to_string(), |number| format!("{number:.2}"))
}
