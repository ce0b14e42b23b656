//! What a person wants to be told while a mission runs.

use crate::mission::{Robot, Sight};
use rpl_runtime::behaviour::{Outside, Phase};
use rpl_runtime::machine::Machine;
use rpl_runtime::task::{NONE, State};
use rpl_runtime::trace::{Event, EventKind};

fn detail<'e>(event: &'e Event, name: &str) -> &'e str {
    event.details.iter().find(|(known, _)| known == name).map_or("", |(_, value)| value.as_str())
}

/// Whether active localization was started.
pub fn is_relocalization(event: &Event) -> bool {
    event.kind == EventKind::Behaviour
        && detail(event, "behaviour") == "active-localization"
        && detail(event, "what") == "activated"
}

/// One line for an event that matters; none for the others.
pub fn line(event: &Event, sight: Option<Sight>) -> Option<String> {
    let text = match event.kind {
        EventKind::Behaviour if is_relocalization(event) => match sight {
            Some(sight) => format!("certainty {:.2} – position lost, relocalizing", sight.certainty),
            None => "position lost, relocalizing".to_string(),
        },
        EventKind::Behaviour => match detail(event, "what") {
            "activated" => format!("{} begins", detail(event, "behaviour")),
            "interrupted" => format!("{} is interrupted", detail(event, "behaviour")),
            // Its end by itself is a signal, and a deactivation the plan's own doing.
            _ => return None,
        },
        EventKind::Signal => match detail(event, "signal") {
            // Told when it happened; the signal only reports it to the task.
            interrupted if interrupted.starts_with("interrupted:") => return None,
            "success" => format!("{} is done", detail(event, "behaviour")),
            failure => format!("{} gives up: {failure}", detail(event, "behaviour")),
        },
        EventKind::Robot => {
            let details: Vec<String> =
                event.details.iter().skip(1).map(|(name, value)| format!("{name} {value}")).collect();
            let gap = if details.is_empty() { "" } else { ": " };
            format!("{}{gap}{}", detail(event, "what"), details.join(", "))
        }
        // A log line is written anyway, a failure at the end if it matters then.
        _ => return None,
    };
    Some(format!("{:.1} s  {text}", event.time_us as f64 / 1e6))
}

/// Time, what the robot does, how sure it is of its place, and where in the plan it is.
pub fn status_line(machine: &Machine, robot: &Robot, sight: Option<Sight>) -> String {
    let active = machine.activations.iter().zip(robot.behaviours());
    // Position tracking never rests; what drives says more.
    let busy = active.filter(|(activation, spec)| activation.phase == Phase::Active && spec.valve.is_some());
    let (doing, task) = match busy.last() {
        Some((activation, spec)) => (Some(spec.name), activation.task.and_then(|task| machine.tasks.find_alive(task))),
        None => (None, None),
    };
    let mut parts = vec![format!("{:.1} s", machine.now_s())];
    parts.extend(doing.map(str::to_string));
    parts.extend(sight.map(|sight| format!("certainty {:.2}", sight.certainty)));
    parts.extend(task.or_else(|| waiting_leaf(machine)).map(|task| machine.path(task)));
    parts.join("  ")
}

fn waiting_leaf(machine: &Machine) -> Option<u32> {
    let mut leaves = machine.tasks.iter().filter(|(_, task)| task.state == State::Blocked && task.first_child == NONE);
    leaves.next().map(|(index, _)| index)
}
