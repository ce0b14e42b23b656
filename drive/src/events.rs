//! What a person wants to be told while a mission runs.

use rpl_lang::visible::visible;
use rpl_robot::office::{ACTIVE_LOCALIZATION, ReportKind};
use rpl_runtime::state::output::{Channel, Output};
use rpl_runtime::state::trace::{Event, EventKind};
use std::borrow::Cow;

/// A detail of an event by its name; empty if it has none.
pub fn detail<'e>(event: &'e Event, name: &str) -> &'e str {
    event.details.iter().find(|(known, _)| known == name).map_or("", |(_, value)| value.as_str())
}

/// Whether active localization was started.
pub(crate) fn is_relocalization(event: &Event) -> bool {
    event.kind == EventKind::Behaviour
        && detail(event, "behaviour") == ACTIVE_LOCALIZATION
        && detail(event, "what") == "activated"
}

fn is_loss(event: &Event) -> bool {
    ReportKind::of(event) == Some(ReportKind::PositionLost)
}

/// What a line tells of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineKind {
    /// What happened.
    Event,
    /// What the plan printed.
    Print,
    /// What the plan logged.
    Log,
}

/// A line that a run has for a person.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ToldLine {
    /// What it tells of.
    pub kind: LineKind,
    /// When that was.
    pub time_us: u64,
    /// What it says, without the time.
    pub text: String,
}

impl ToldLine {
    /// As it is written: what was printed as it is, all else behind its time.
    pub fn line(&self) -> Cow<'_, str> {
        match self.kind {
            LineKind::Print => Cow::Borrowed(&self.text),
            LineKind::Event | LineKind::Log => Cow::Owned(format!("{:.1} s  {}", self.time_us as f64 / 1e6, self.text)),
        }
    }
}

/// What happened and what the plan wrote, in the order of happening. `is_lost` as for [`lines`].
pub fn in_order(events: &[Event], output: Vec<Output>, is_lost: bool) -> Vec<ToldLine> {
    let mut lines = lines(events, is_lost).into_iter().peekable();
    let mut told = Vec::new();
    for Output { channel, text, time_us, sequence } in output {
        let is_before = |line: &(u64, ToldLine)| line.0 < sequence;
        while let Some((_, line)) = lines.next_if(is_before) {
            told.push(line);
        }
        let kind = match channel {
            Channel::Print => LineKind::Print,
            Channel::Log => LineKind::Log,
        };
        told.push(ToldLine { kind, time_us, text });
    }
    told.extend(lines.map(|(_, line)| line));
    told
}

/// A line for each event of an instant that matters, behind the event's number. `is_lost` tells
/// whether the robot does not know its position at the end of the instant; if it does, a
/// relocalization has nothing to do.
fn lines(events: &[Event], is_lost: bool) -> Vec<(u64, ToldLine)> {
    let relocalizes = is_lost && events.iter().any(is_relocalization);
    let has_loss = events.iter().any(is_loss);
    let text = |event: &Event| match event.kind {
        EventKind::Behaviour if is_relocalization(event) => {
            (relocalizes && !has_loss).then(|| "relocalizing".to_string())
        }
        // How a host keeps the pace is told once, at the end.
        EventKind::Robot if ReportKind::of(event).is_some_and(ReportKind::is_of_pace) => None,
        EventKind::Robot if is_loss(event) && relocalizes => Some(report(event) + ", relocalizing"),
        EventKind::Robot => Some(report(event)),
        EventKind::Behaviour => behaviour(event),
        EventKind::Signal => signal(event),
        EventKind::Measured => Some(measured(event)),
        // A log line is written anyway, a failure at the end if it matters then.
        _ => None,
    };
    let numbered = |event: &Event| {
        let line = ToldLine { kind: LineKind::Event, time_us: event.time_us, text: text(event)? };
        Some((event.sequence, line))
    };
    events.iter().filter_map(numbered).collect()
}

/// What the robot or the scenario reports: "certainty 0.31 – position lost".
pub(crate) fn report(event: &Event) -> String {
    let what = visible(detail(event, "what"));
    let told = |(name, value): &(String, String)| visible(&format!("{name} {value}")).into_owned();
    let details: Vec<String> = event.details.iter().skip(1).map(told).collect();
    match details.as_slice() {
        [] => what.to_string(),
        [certainty] if certainty.starts_with("certainty ") => format!("{certainty} – {what}"),
        details => format!("{what}: {}", details.join(", ")),
    }
}

/// What the plan has measured: "rooms inspected = 4".
pub fn measured(event: &Event) -> String {
    format!("{} = {}", visible(detail(event, "measure")), detail(event, "value"))
}

fn behaviour(event: &Event) -> Option<String> {
    let name = detail(event, "behaviour");
    match detail(event, "what") {
        "activated" => Some(format!("{name} begins")),
        "interrupted" => Some(format!("{name} is interrupted")),
        // Its end by itself is a signal, and a deactivation the plan's own doing.
        _ => None,
    }
}

fn signal(event: &Event) -> Option<String> {
    let name = detail(event, "behaviour");
    match detail(event, "signal") {
        "success" => Some(format!("{name} is done")),
        // Told when it happened; the signal only reports it to the task.
        interrupted if interrupted.starts_with("interrupted:") => None,
        failure => Some(format!("{name} gives up: {}", visible(failure))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(kind: EventKind, details: &[(&str, &str)]) -> Event {
        let details = details.iter().map(|&(name, value)| (name.to_string(), value.to_string())).collect();
        Event { time_us: 12_400_000, sequence: 0, path: String::new(), kind, details }
    }

    fn told(events: &[Event], is_lost: bool) -> Vec<String> {
        lines(events, is_lost).into_iter().map(|(_, line)| line.line().into_owned()).collect()
    }

    #[test]
    fn what_is_logged_and_printed_stands_among_the_events_in_the_order_of_happening() {
        let reached = |sequence| Event { sequence, ..event(EventKind::Robot, &[("what", "here")]) };
        let output = |channel, sequence| Output { channel, text: "text".to_string(), time_us: 12_400_000, sequence };
        let output = vec![output(Channel::Log, 0), output(Channel::Print, 5), output(Channel::Log, 5)];
        let told = in_order(&[reached(4), reached(5)], output, false);
        let lines: Vec<_> = told.iter().map(|told| (told.kind, told.line())).collect();
        let (event, log) = ((LineKind::Event, "12.4 s  here".into()), (LineKind::Log, "12.4 s  text".into()));
        assert_eq!(lines, [log.clone(), event.clone(), (LineKind::Print, "text".into()), log, event]);
    }

    #[test]
    fn a_loss_and_what_is_done_about_it_are_one_line() {
        let loss = event(EventKind::Robot, &[("what", ReportKind::PositionLost.name()), ("certainty", "0.31")]);
        let details = [("behaviour", ACTIVE_LOCALIZATION), ("what", "activated")];
        let relocalization = event(EventKind::Behaviour, &details);
        let both = [loss.clone(), relocalization.clone()];
        assert_eq!(told(&both, true), ["12.4 s  certainty 0.31 – position lost, relocalizing"]);
        assert_eq!(told(&[loss], true), ["12.4 s  certainty 0.31 – position lost"]);
        assert_eq!(told(&both[1..], true), ["12.4 s  relocalizing"]);
        assert!(told(&[relocalization], false).is_empty());
    }

    #[test]
    fn an_interruption_is_told_once() {
        let interrupted = [
            event(EventKind::Behaviour, &[("behaviour", "navigation"), ("what", "interrupted")]),
            event(EventKind::Signal, &[("behaviour", "navigation"), ("signal", "interrupted: it was interrupted")]),
        ];
        assert_eq!(told(&interrupted, false), ["12.4 s  navigation is interrupted"]);
    }
}
