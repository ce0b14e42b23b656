//! Tasks and valves in the words of the page, and what an event changes of them.

use crate::events::detail;
use crate::show::situation::{Situation, Standing, ValveStanding};
use rpl_page::series::{Ended, Reading, Seen, Task, TaskState, Valve};
use rpl_runtime::state::trace::{Event, EventKind};
use rpl_runtime::step::tasks::condition::FluentReading;
use std::collections::BTreeMap;

/// Values longer than this are cut.
const LONGEST_VALUE: usize = 400;

/// Arguments of a call longer than this are cut.
const LONGEST_ARGUMENTS: usize = 60;

/// Ended tasks that are remembered, for failures that are told after them.
const MOST_PAST: usize = 2_000;

/// The tasks and valves of a run, as far as the page has been told of them.
#[derive(Default)]
pub struct TaskView {
    situation: Situation,
    valves: BTreeMap<String, Valve>,
    /// The arguments of each plan call that a living task is in, by the path of the call.
    calls: BTreeMap<String, Vec<(String, String)>>,
}

impl TaskView {
    /// Takes an event in; tells what it changes. Cost: a look at each valve, and at the task it is about.
    pub fn take(&mut self, event: &Event) -> Vec<Seen> {
        let dying = (event.kind == EventKind::End)
            .then(|| self.situation.tasks.get(&event.path).map(|task| task.number))
            .flatten();
        self.situation.add(event);
        self.situation.forget_past(MOST_PAST);
        self.note_call(event);
        let mut seen = Vec::new();
        if matches!(event.kind, EventKind::Valve | EventKind::End) {
            self.note_valves(&mut seen);
        }
        match event.kind {
            EventKind::End => {
                let ended = self.situation.ended.last().filter(|ended| ended.path == event.path);
                let (state, result) =
                    ended.map_or(Default::default(), |ended| (ended.state.clone(), cut(&ended.result)));
                seen.extend(dying.map(|id| Seen::Ended(Ended { id, state, result })));
            }
            EventKind::Begin
            | EventKind::Call
            | EventKind::Blocked
            | EventKind::Return
            | EventKind::Woken
            | EventKind::Swapped
            | EventKind::Suspended
            | EventKind::Resumed => {
                let returned = (event.kind == EventKind::Return).then(|| detail(event, "state").to_string());
                seen.extend(self.task(&event.path).map(|task| Seen::Task(Task { returned, ..task })));
            }
            _ => {}
        }
        seen
    }

    /// Keeps the arguments of the calls that living tasks are in.
    fn note_call(&mut self, event: &Event) {
        match event.kind {
            EventKind::End => drop(self.calls.remove(&event.path)),
            EventKind::Call => {
                if let Some(owner) = self.situation.owner(&event.path) {
                    let call = (event.path.clone(), cut_to(detail(event, "arguments"), LONGEST_ARGUMENTS));
                    self.calls.entry(owner).or_default().push(call);
                }
            }
            EventKind::Return => {
                if let Some(calls) = self.situation.owner(&event.path).and_then(|owner| self.calls.get_mut(&owner)) {
                    calls.pop_if(|(path, _)| *path == event.path);
                }
            }
            _ => {}
        }
    }

    /// The plan calls that a task is in: names and arguments.
    fn calls(&self, own: &str, standing: &Standing) -> Vec<[String; 2]> {
        let known = self.calls.get(own).map_or(&[][..], Vec::as_slice);
        let names = standing.path.strip_prefix(own).unwrap_or_default().split('/').skip(1);
        let mut path = own.to_string();
        names
            .map(|name| {
                path.extend(["/", name]);
                let arguments = known.iter().find(|(call, _)| *call == path).map_or("", |(_, arguments)| arguments);
                [name.to_string(), arguments.to_string()]
            })
            .collect()
    }

    fn number(&self, path: &str) -> Option<usize> {
        self.situation.tasks.get(path).map(|task| task.number)
    }

    /// The living task that a path lies in.
    fn task(&self, path: &str) -> Option<Task> {
        let own = self.situation.owner(path)?;
        let standing = self.situation.tasks.get(&own)?;
        let parent = own.rsplit_once('/').and_then(|(parent, _)| self.situation.owner(parent));
        Some(Task {
            id: standing.number,
            parent: parent.and_then(|parent| self.number(&parent)),
            calls: self.calls(&own, standing),
            returned: None,
            path: own,
            state: state(standing),
            on: standing.on.clone(),
            until: standing.until_us,
            at: standing.at.clone(),
            by: standing.suspended_by.iter().filter_map(|by| self.number(by)).collect(),
            reads: standing.readings.iter().map(reading).collect(),
        })
    }

    fn note_valves(&mut self, seen: &mut Vec<Seen>) {
        for (name, standing) in &self.situation.valves {
            let valve = self.valve(name, standing);
            if self.valves.get(name) != Some(&valve) {
                seen.push(Seen::Valve(valve));
            }
        }
        for told in seen.iter() {
            if let Seen::Valve(valve) = told {
                self.valves.insert(valve.name.clone(), valve.clone());
            }
        }
    }

    fn valve(&self, name: &str, standing: &ValveStanding) -> Valve {
        let number = |path: &String| self.number(path);
        let holders = standing.having().into_iter().filter_map(number).collect();
        Valve { name: name.to_string(), holders, taken: standing.interrupted.iter().filter_map(number).collect() }
    }
}

fn state(standing: &Standing) -> TaskState {
    match standing {
        Standing { is_created: true, .. } => TaskState::Created,
        Standing { is_suspended: true, .. } => TaskState::Suspended,
        Standing { on: Some(_), .. } => TaskState::Waits,
        Standing { on: None, .. } => TaskState::Ready,
    }
}

fn reading(of: &FluentReading) -> Reading {
    Reading { fluent: of.fluent.clone(), value: cut(&of.value), from: of.from.iter().map(reading).collect() }
}

/// The beginning of a long text.
pub fn cut(text: &str) -> String {
    cut_to(text, LONGEST_VALUE)
}

fn cut_to(text: &str, characters: usize) -> String {
    match text.char_indices().nth(characters) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_string(),
    }
}
