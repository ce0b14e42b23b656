//! What stands where at one instant of a run: the living tasks and what each waits for, the valves,
//! who changed which fluent last, and how tasks ended. It is gathered from events; of the living,
//! the prompt asks its run instead.

use crate::events::detail;
use crate::show::event_line::ROBOT;
use crate::show::revision_story;
use rpl_runtime::state::trace::{Event, EventKind};
use rpl_runtime::step::tasks::condition::FluentReading;
use std::collections::{BTreeMap, BTreeSet};

/// How deep fluents that are computed from fluents are followed.
const MAX_DEPTH: usize = 32;

/// A living task. Tasks go by the path they began with.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Standing {
    /// The order of beginning.
    pub number: usize,
    /// Where it stands: its path with the plan calls it is in.
    pub path: String,
    /// What it waits for.
    pub on: Option<String>,
    /// It has not begun.
    pub is_created: bool,
    /// When a timer ends the wait.
    pub until_us: Option<u64>,
    /// A suspension keeps it from running.
    pub is_suspended: bool,
    /// The tasks that suspended it, where no valve did.
    pub suspended_by: Vec<String>,
    /// The form it waits in.
    pub at: Option<String>,
    /// The fluents its condition reads, as they were when it began to wait.
    pub readings: Vec<FluentReading>,
    /// The event that told so.
    pub told: u64,
}

impl Standing {
    /// What it does, or waits for, and until when at an instant.
    pub fn condition(&self, now_us: u64) -> String {
        let until = |on: &str| match self.until_us {
            Some(until_us) if on == TIME => format!(" until {}", instant_and_rest(until_us, now_us)),
            Some(until_us) => format!(", at most until {}", instant_and_rest(until_us, now_us)),
            None => String::new(),
        };
        match (&self.on, self.is_suspended) {
            _ if self.is_created => "created".to_string(),
            (Some(on), false) => format!("waits for {on}{}", until(on)),
            (Some(on), true) => format!("suspended (was waiting for {on}{})", until(on)),
            (None, false) => "ready".to_string(),
            (None, true) => "suspended (ready)".to_string(),
        }
    }
}

/// What a task waits for that waits for nothing else.
const TIME: &str = "time";

/// "12.500 s, in 3.500 s".
fn instant_and_rest(time_us: u64, now_us: u64) -> String {
    let time_s = time_us as f64 / 1e6;
    match time_us.checked_sub(now_us) {
        Some(0) | None => format!("{time_s:.3} s"),
        Some(left_us) => format!("{time_s:.3} s, in {:.3} s", left_us as f64 / 1e6),
    }
}

/// A valve.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ValveStanding {
    /// Tasks that hold it; the present holder of a place is the last of that place.
    pub holders: Vec<String>,
    /// Tasks it was taken away from and has not come back to; they and all below them are suspended.
    pub interrupted: Vec<String>,
}

impl ValveStanding {
    /// The tasks that have it now, one for each place that is not free. While hooks of an interruption run, who had it
    /// last.
    pub(crate) fn having(&self) -> Vec<&String> {
        let interrupted: BTreeSet<&str> = self.interrupted.iter().map(String::as_str).collect();
        let is_interrupted = |path: &str| paths_above(path).any(|above| interrupted.contains(above));
        let having: BTreeSet<&String> = self.holders.iter().filter(|holder| !is_interrupted(holder)).collect();
        let lending: BTreeSet<&str> = having.iter().flat_map(|holder| paths_above(holder).skip(1)).collect();
        let mut now: Vec<&String> = having.into_iter().filter(|holder| !lending.contains(holder.as_str())).collect();
        if now.is_empty() {
            now.extend(self.holders.last());
        }
        now
    }
}

/// The last change of a fluent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// When.
    pub time_us: u64,
    /// The event that told so.
    pub told: u64,
    /// Who changed it.
    pub by: String,
    /// Its value since then; none if it was only pulsed.
    pub value: Option<String>,
}

/// Something that ended, or failed on the way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ended {
    /// Its path.
    pub path: String,
    /// When.
    pub time_us: u64,
    /// How: `succeeded`, `failed`, `evaporated`.
    pub state: String,
    /// Its value or failure; empty without one.
    pub result: String,
    /// Where the failure it ended with was raised.
    pub raised: Option<Raised>,
}

/// A failure where it was raised.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Raised {
    /// The task.
    pub path: String,
    /// When.
    pub time_us: u64,
    /// The form.
    pub at: Option<String>,
    /// The failure.
    pub text: String,
}

/// Something that was decided about the plan of a task.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Revision {
    /// The path the task began with.
    pub task: String,
    /// When.
    pub time_us: u64,
    /// What, as a sentence.
    pub text: String,
    /// Another plan was looked at and is not better.
    pub is_passed_over: bool,
}

/// What stands where.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Situation {
    /// The living tasks.
    pub tasks: BTreeMap<String, Standing>,
    /// The valves: gathered from events, those that anybody has asked for; at the prompt, all.
    pub valves: BTreeMap<String, ValveStanding>,
    /// The last change of each fluent.
    pub changes: BTreeMap<String, Change>,
    /// Tasks and plan calls that have ended, in order.
    pub ended: Vec<Ended>,
    /// What was decided about the plans of tasks, in order.
    pub revisions: Vec<Revision>,
    /// The time of the last event.
    pub now_us: u64,
    /// Tasks among them, by path.
    dead: BTreeMap<String, usize>,
    raised: Vec<Raised>,
    begun: usize,
}

impl Situation {
    /// What stands where after some events.
    pub fn after<'e>(events: impl IntoIterator<Item = &'e Event>) -> Self {
        let mut situation = Self::default();
        events.into_iter().for_each(|event| situation.add(event));
        situation
    }

    /// Takes the next event in.
    pub fn add(&mut self, event: &Event) {
        self.now_us = event.time_us;
        self.note_revision(event);
        match event.kind {
            EventKind::Begin => self.begin(event),
            EventKind::End => self.end(event),
            EventKind::Call | EventKind::Blocked => self.stand(event),
            EventKind::Return => self.leave(event),
            EventKind::Woken | EventKind::Swapped => self.change_task(event, |task| {
                (task.on, task.at, task.until_us) = (None, None, None);
                task.readings.clear();
            }),
            EventKind::Suspended => {
                let by = named(event, "by").and_then(|by| self.owner(&by));
                self.change_task(event, |task| {
                    task.is_suspended = true;
                    task.suspended_by = by.into_iter().collect();
                });
            }
            EventKind::Resumed => self.change_task(event, |task| {
                task.is_suspended = false;
                task.suspended_by.clear();
            }),
            EventKind::Fluent | EventKind::Pulse => self.change_fluent(event),
            EventKind::Valve => self.change_valve(event),
            EventKind::Failed => self.raised.push(Raised {
                path: event.path.clone(),
                time_us: event.time_us,
                at: named(event, "at"),
                text: detail(event, "failure").to_string(),
            }),
            EventKind::Handled
            | EventKind::Behaviour
            | EventKind::Signal
            | EventKind::Robot
            | EventKind::Log
            | EventKind::Measured
            | EventKind::Decided
            | EventKind::Warning => {}
        }
    }

    /// Forgets what has ended and what was decided once it is more than this: who only follows what stands where need not
    /// keep all that has been.
    pub(crate) fn forget_past(&mut self, most: usize) {
        if self.ended.len() > 2 * most {
            let gone = self.ended.len() - most;
            self.ended.drain(..gone);
            self.dead.retain(|_, at| {
                let is_kept = *at >= gone;
                *at = at.saturating_sub(gone);
                is_kept
            });
        }
        keep_last(&mut self.raised, most);
        keep_last(&mut self.revisions, most);
    }

    fn note_revision(&mut self, event: &Event) {
        if let Some(text) = revision_story::sentence(event)
            && let Some(task) = self.owner(&event.path)
        {
            let is_passed_over = revision_story::is_passed_over(event);
            self.revisions.push(Revision { task, time_us: event.time_us, text, is_passed_over });
        }
    }

    fn begin(&mut self, event: &Event) {
        self.begun += 1;
        let task = Standing { number: self.begun, path: event.path.clone(), ..Standing::default() };
        self.dead.remove(&event.path);
        self.tasks.insert(event.path.clone(), task);
    }

    fn end(&mut self, event: &Event) {
        self.tasks.remove(&event.path);
        self.dead.insert(event.path.clone(), self.ended.len());
        self.note_end(event);
        for valve in self.valves.values_mut() {
            valve.holders.retain(|holder| *holder != event.path);
            valve.interrupted.retain(|root| *root != event.path);
        }
    }

    /// A task is in a plan call, or waits there.
    fn stand(&mut self, event: &Event) {
        let Some(task) = self.owner(&event.path).and_then(|owner| self.tasks.get_mut(&owner)) else { return };
        task.path.clone_from(&event.path);
        // What is being cleaned up runs on although it is suspended.
        task.is_suspended = false;
        task.suspended_by.clear();
        // Told again, because its condition reads other fluents: the timer is the same.
        let until_us = task.until_us.take_if(|_| event.kind == EventKind::Blocked && task.on.is_some());
        task.on = None;
        if event.kind == EventKind::Blocked {
            task.until_us = named(event, "until").and_then(|text| time_us(&text)).or(until_us);
            task.on = named(event, "on");
            task.at = named(event, "at");
            task.readings = readings(event);
            task.told = event.sequence;
        }
    }

    fn leave(&mut self, event: &Event) {
        self.note_end(event);
        let caller = event.path.rsplit_once('/').map_or("", |(caller, _)| caller).to_string();
        self.change_task(event, |task| task.path = caller);
    }

    fn note_end(&mut self, event: &Event) {
        let state = detail(event, "state");
        let result = [detail(event, "value"), detail(event, "failure")].concat();
        let raised = match state {
            "failed" => {
                let inside = || self.raised.iter().rev().filter(|raised| is_within(&raised.path, &event.path));
                inside().find(|raised| raised.text == result).or_else(|| inside().next()).cloned()
            }
            _ => None,
        };
        let (path, time_us, state) = (event.path.clone(), event.time_us, state.to_string());
        self.ended.push(Ended { path, time_us, state, result, raised });
    }

    fn change_task(&mut self, event: &Event, change: impl FnOnce(&mut Standing)) {
        if let Some(task) = self.owner(&event.path).and_then(|owner| self.tasks.get_mut(&owner)) {
            change(task);
        }
    }

    fn change_fluent(&mut self, event: &Event) {
        let by = if event.path.is_empty() { ROBOT } else { &event.path }.to_string();
        let change = Change { time_us: event.time_us, told: event.sequence, by, value: named(event, "value") };
        self.changes.insert(detail(event, "fluent").to_string(), change);
    }

    fn change_valve(&mut self, event: &Event) {
        // What a dead task held was given back when it died.
        let Some(task) = self.owner(&event.path).filter(|_| !self.dead.contains_key(&event.path)) else { return };
        let valve = self.valves.entry(detail(event, "valve").to_string()).or_default();
        match detail(event, "what") {
            "granted" => {
                valve.holders.push(task);
            }
            "released" => {
                if let Some(at) = valve.holders.iter().rposition(|holder| *holder == task) {
                    valve.holders.remove(at);
                }
            }
            "pre-empted" => valve.interrupted.push(task),
            "returned" => {
                if let Some(at) = valve.interrupted.iter().rposition(|root| *root == task) {
                    valve.interrupted.remove(at);
                }
            }
            _ => {}
        }
    }

    /// The living task a path lies in: the path itself, or what is left without its last calls.
    pub(crate) fn owner(&self, path: &str) -> Option<String> {
        let mut at = path;
        loop {
            if self.tasks.contains_key(at) {
                return Some(at.to_string());
            }
            at = at.rsplit_once('/')?.0;
        }
    }

    /// The living tasks whose next living ancestor is this one, in order of beginning.
    pub fn children(&self, task: &str) -> Vec<&str> {
        let below = self.tasks.iter().filter(|(path, _)| is_within(path, task) && *path != task);
        let mut children: Vec<(usize, &str)> = below
            .filter(|(path, _)| {
                let parent = path.rsplit_once('/').and_then(|(parent, _)| self.owner(parent));
                parent.as_deref() == Some(task)
            })
            .map(|(path, standing)| (standing.number, path.as_str()))
            .collect();
        children.sort_unstable();
        children.into_iter().map(|(_, path)| path).collect()
    }
}

/// Keeps the last of a list that has grown to twice as many.
fn keep_last<T>(list: &mut Vec<T>, most: usize) {
    if list.len() > 2 * most {
        list.drain(..list.len() - most);
    }
}

/// A path and those it lies below.
fn paths_above(path: &str) -> impl Iterator<Item = &str> {
    std::iter::once(path).chain(path.rmatch_indices('/').map(|(at, _)| &path[..at]))
}

/// Whether a path is another, or lies below it.
pub(crate) fn is_within(path: &str, above: &str) -> bool {
    path.strip_prefix(above).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

fn named(event: &Event, name: &str) -> Option<String> {
    Some(detail(event, name)).filter(|text| !text.is_empty()).map(str::to_string)
}

/// A time in seconds, as events have it.
fn time_us(text: &str) -> Option<u64> {
    let seconds: f64 = text.parse().ok()?;
    (seconds.is_finite() && seconds >= 0.0).then(|| (seconds * 1e6).round() as u64)
}

/// The fluents a condition reads: names, each in parentheses with those it is computed from.
fn readings(event: &Event) -> Vec<FluentReading> {
    let text = detail(event, "reads").replace('(', " ( ").replace(')', " ) ");
    // A file of unknown origin may hold any names and parentheses.
    let mut open: Vec<Vec<FluentReading>> = vec![Vec::new()];
    for word in text.split_whitespace() {
        match word {
            "(" if open.len() < MAX_DEPTH => open.push(Vec::new()),
            "(" => {}
            ")" if open.len() > 1 => close(&mut open),
            ")" => {}
            fluent => {
                let value = value_of(event, fluent);
                let reading = FluentReading { fluent: fluent.to_string(), value, from: Vec::new() };
                open.last_mut().into_iter().for_each(|list| list.push(reading.clone()));
            }
        }
    }
    while open.len() > 1 {
        close(&mut open);
    }
    open.pop().unwrap_or_default()
}

/// The innermost list is complete: its first fluent is computed from the others.
fn close(open: &mut Vec<Vec<FluentReading>>) {
    let Some(mut list) = open.pop() else { return };
    if list.is_empty() {
        return;
    }
    let from = list.split_off(1);
    let Some(mut first) = list.pop() else { return };
    first.from.extend(from);
    open.last_mut().into_iter().for_each(|outer| outer.push(first.clone()));
}

/// The value of a fluent among the details, where a name that was taken has an underscore more.
fn value_of(event: &Event, fluent: &str) -> String {
    let after = event.details.iter().skip_while(|(name, _)| name != "reads").skip(1);
    let is_it = |name: &str| name.strip_prefix(fluent).is_some_and(|rest| rest.is_empty() || rest == "_");
    after.into_iter().find(|(name, _)| is_it(name)).map_or_else(String::new, |(_, value)| value.clone())
}
