//! The tasks and fluents a trace names, so that a filter which names another can be told so.

use super::filter::{Filter, concerns, lies_in};
use rpl_drive::events::detail;
use rpl_lang::suggest::suggest;
use rpl_mission::modules;
use rpl_runtime::state::trace::{Event, EventKind};
use std::collections::BTreeSet;

/// What the events read so far name.
#[derive(Clone, Debug, Default)]
pub struct Named {
    has_task: bool,
    has_fluent: bool,
    /// Names in the paths of tasks.
    tasks: BTreeSet<String>,
    fluents: BTreeSet<String>,
}

impl Named {
    /// Takes an event in.
    pub fn note(&mut self, event: &Event, filter: &Filter) {
        if let Some(task) = filter.task.as_deref().filter(|_| !self.has_task) {
            self.has_task = lies_in(&event.path, task);
            self.tasks.extend(event.path.split('/').map(str::to_string));
        }
        if let Some(fluent) = filter.fluent.as_deref().filter(|_| !self.has_fluent) {
            self.has_fluent = concerns(event, fluent);
            if matches!(event.kind, EventKind::Fluent | EventKind::Pulse) {
                self.fluents.insert(detail(event, "fluent").to_string());
            }
        }
    }

    /// Whether everything a filter names is there.
    pub fn has_all(&self, filter: &Filter) -> bool {
        (self.has_task || filter.task.is_none()) && (self.has_fluent || filter.fluent.is_none())
    }

    /// What a filter names that no event does, as an error.
    pub fn missing(&self, filter: &Filter) -> Option<String> {
        if let Some(task) = filter.task.as_deref().filter(|_| !self.has_task) {
            return Some(unknown("task or plan call", task, &self.tasks));
        }
        let fluent = filter.fluent.as_deref().filter(|_| !self.has_fluent)?;
        if modules::tables().continuous_fluents().any(|known| known == fluent) {
            return Some(format!(
                "`{fluent}` changes in every step and is not recorded; `rpl run --trace-poses 5` records where the robot is"
            ));
        }
        Some(unknown("fluent", fluent, &self.fluents))
    }
}

fn unknown(what: &str, name: &str, known: &BTreeSet<String>) -> String {
    let last = name.trim_matches('/').rsplit('/').next().unwrap_or(name);
    match suggest(last, known.iter().map(String::as_str)) {
        Some(meant) => format!("the trace tells of no {what} `{name}`; did you mean `{meant}`?"),
        None => format!("the trace tells of no {what} `{name}`"),
    }
}
