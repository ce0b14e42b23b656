//! What a person wants to be told while a mission runs.

use crate::mission::{Robot, Sight};
use rpl_robot::office::{ACTIVE_LOCALIZATION, ReportKind};
use rpl_runtime::robot::Outside;
use rpl_runtime::state::activation::Phase;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::output::{Channel, Output};
use rpl_runtime::state::slab::NONE;
use rpl_runtime::state::task::State;
use rpl_runtime::state::trace::{Event, EventKind};

/// A detail of an event by its name; empty if it has none.
pub fn detail<'e>(event: &'e Event, name: &str) -> &'e str {
    event.details.iter().find(|(known, _)| known == name).map_or("", |(_, value)| value.as_str())
}

/// Whether active localization was started.
pub fn is_relocalization(event: &Event) -> bool {
    event.kind == EventKind::Behaviour
        && detail(event, "behaviour") == ACTIVE_LOCALIZATION
        && detail(event, "what") == "activated"
}

fn is_loss(event: &Event) -> bool {
    ReportKind::of(event) == Some(ReportKind::PositionLost)
}

/// A line that a run has for a person.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Told {
    /// What happened, with its time.
    Event(String),
    /// What the plan printed.
    Print(String),
    /// What the plan logged.
    Log(String),
}

/// What happened and what the plan wrote, in the order of happening; a line of the log has its time
/// as well. `is_lost` as for [`lines`].
pub fn in_order(events: &[Event], output: Vec<Output>, is_lost: bool) -> Vec<Told> {
    let mut lines = lines(events, is_lost).into_iter().peekable();
    let mut told = Vec::new();
    for Output { channel, text, time_us, sequence } in output {
        let is_before = |line: &(u64, String)| line.0 < sequence;
        while let Some((_, line)) = lines.next_if(is_before) {
            told.push(Told::Event(line));
        }
        told.push(match channel {
            Channel::Print => Told::Print(text),
            Channel::Log => Told::Log(timed(time_us, &text)),
        });
    }
    told.extend(lines.map(|(_, line)| Told::Event(line)));
    told
}

fn timed(time_us: u64, text: &str) -> String {
    format!("{:.1} s  {text}", time_us as f64 / 1e6)
}

/// A line for each event of an instant that matters, behind the event's number. `is_lost` tells
/// whether the robot does not know its position at the end of the instant; if it does, a
/// relocalization has nothing to do.
fn lines(events: &[Event], is_lost: bool) -> Vec<(u64, String)> {
    let relocalizes = is_lost && events.iter().any(is_relocalization);
    let has_loss = events.iter().any(is_loss);
    let text = |event: &Event| match event.kind {
        EventKind::Behaviour if is_relocalization(event) => {
            (relocalizes && !has_loss).then(|| "relocalizing".to_string())
        }
        EventKind::Robot if is_loss(event) && relocalizes => Some(report(event) + ", relocalizing"),
        EventKind::Robot => Some(report(event)),
        EventKind::Behaviour => behaviour(event),
        EventKind::Signal => signal(event),
        // A log line is written anyway, a failure at the end if it matters then.
        _ => None,
    };
    let numbered = |event: &Event| Some((event.sequence, timed(event.time_us, &text(event)?)));
    events.iter().filter_map(numbered).collect()
}

/// What the robot or the scenario reports: "certainty 0.31 – position lost".
pub fn report(event: &Event) -> String {
    let what = detail(event, "what");
    let details: Vec<String> = event.details.iter().skip(1).map(|(name, value)| format!("{name} {value}")).collect();
    match details.as_slice() {
        [] => what.to_string(),
        [certainty] if certainty.starts_with("certainty ") => format!("{certainty} – {what}"),
        details => format!("{what}: {}", details.join(", ")),
    }
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
        failure => Some(format!("{name} gives up: {failure}")),
    }
}

/// Time, what the robot does, how sure it is of its place, and where in the plan it is, in so many
/// columns if possible.
pub fn status_line(machine: &Machine, robot: &Robot, sight: Option<Sight>, room: usize) -> String {
    let active = machine.activations.iter().zip(&robot.tables().behaviours);
    // Position tracking never rests; what drives says more.
    let mut busy = active.filter(|(activation, spec)| activation.phase == Phase::Active && spec.valve.is_some());
    let (doing, task) = match busy.next_back() {
        Some((activation, spec)) => {
            (Some(&*spec.name), activation.task.and_then(|task| machine.tasks.find_alive(task)))
        }
        None => (None, None),
    };
    let mut parts = vec![format!("{:.1} s", machine.now_s())];
    parts.extend(doing.map(str::to_string));
    parts.extend(sight.map(|sight| format!("certainty {:.2}", sight.certainty)));
    let taken: usize = parts.iter().map(|part| part.chars().count() + GAP.len()).sum();
    let path = task.or_else(|| waiting_leaf(machine)).map(|task| machine.path(task));
    parts.extend(path.map(|path| shortened(&path, room.saturating_sub(taken))));
    parts.join(GAP)
}

/// What stands between the parts of the status line.
const GAP: &str = "  ";

/// The end of a path, which says most about where the plan is, in so many characters if possible.
pub fn shortened(path: &str, longest: usize) -> String {
    const LEFT_OUT: &str = "…/";
    if path.chars().count() <= longest {
        return path.to_string();
    }
    let tails = path.match_indices('/').map(|(slash, _)| &path[slash + 1..]);
    let fits = |tail: &&str| tail.chars().count() + LEFT_OUT.chars().count() <= longest;
    let last = path.rsplit('/').next().unwrap_or(path);
    format!("{LEFT_OUT}{}", tails.into_iter().find(fits).unwrap_or(last))
}

fn waiting_leaf(machine: &Machine) -> Option<u32> {
    let mut leaves =
        machine.tasks.iter().filter(|(_, task)| task.state() == State::Blocked && task.first_child == NONE);
    leaves.next().map(|(index, _)| index)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(kind: EventKind, details: &[(&str, &str)]) -> Event {
        let details = details.iter().map(|&(name, value)| (name.to_string(), value.to_string())).collect();
        Event { time_us: 12_400_000, sequence: 0, path: String::new(), kind, details }
    }

    fn told(events: &[Event], is_lost: bool) -> Vec<String> {
        lines(events, is_lost).into_iter().map(|(_, line)| line).collect()
    }

    #[test]
    fn what_is_logged_and_printed_stands_among_the_events_in_the_order_of_happening() {
        let reached = |sequence| Event { sequence, ..event(EventKind::Robot, &[("what", "here")]) };
        let output = |channel, sequence| Output { channel, text: "text".to_string(), time_us: 12_400_000, sequence };
        let output = vec![output(Channel::Log, 0), output(Channel::Print, 5), output(Channel::Log, 5)];
        let (line, log) = ("12.4 s  here".to_string(), "12.4 s  text".to_string());
        let told = in_order(&[reached(4), reached(5)], output, false);
        let print = Told::Print("text".to_string());
        assert_eq!(told, [Told::Log(log.clone()), Told::Event(line.clone()), print, Told::Log(log), Told::Event(line)]);
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
    fn a_long_path_keeps_its_end() {
        assert_eq!(shortened("main/tidy", 46), "main/tidy");
        let path = "main/with-policy[1]/bring/go-to/with-policy[1]/navigation";
        assert_eq!(shortened(path, 46), "…/bring/go-to/with-policy[1]/navigation");
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
