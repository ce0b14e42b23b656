//! Whether a run that is looked at form by form has come to where it is to stop: for the prompt, for debuggers, and for the
//! page of a run.

pub mod breakpoint;
pub mod halt;
pub mod own_text;

use crate::show::situation::is_within;
use crate::stopping::breakpoint::Breakpoint;
use crate::stopping::halt::{Halt, Until};
use crate::stopping::own_text::{is_hidden, is_own};
use rpl_lang::source::Span;
use rpl_mission::robot::Robot;
use rpl_runtime::run::stepping::Stop;
use rpl_runtime::run::system::System;
use std::collections::BTreeMap;

/// Where a run is to stop.
#[derive(Clone, Copy)]
pub struct Places<'a> {
    /// How far it is to go.
    pub until: &'a Until,
    /// Where it stops in any case.
    pub breakpoints: &'a [Breakpoint],
    /// The text that a line without a name means.
    pub file: Option<&'a str>,
}

impl Places<'_> {
    /// Whether the run must be looked at form by form, which is slower.
    pub fn need_forms(&self) -> bool {
        match self.until {
            Until::Step | Until::Into | Until::Next | Until::Out => true,
            Until::Place(place) if place.is_place() => true,
            Until::End | Until::Time(_) | Until::Place(_) | Until::Clock { .. } => {
                self.breakpoints.iter().any(Breakpoint::is_place)
            }
        }
    }
}

/// A run on its way from one stop to the next.
#[derive(Default)]
pub struct Stopping {
    /// Where it stood.
    start: Option<Stop>,
    /// How deep in calls, and in which body, each task stood when it was looked at last.
    looked_at: BTreeMap<(u32, u32), (u32, Span)>,
}

impl Stopping {
    /// Of a run that stands before a form, or between two instants.
    pub fn from(start: Option<Stop>) -> Self {
        let mut stopping = Self { start: None, looked_at: BTreeMap::new() };
        if let Some(start) = &start {
            stopping.enters(start);
        }
        stopping.start = start;
        stopping
    }

    /// Whether a task has just come into the body it stands in: by a call, which is deeper, or by one
    /// in tail position, which is as deep. Which of its forms comes first depends on conditions.
    pub fn enters(&mut self, stop: &Stop) -> bool {
        let task = (stop.task.index, stop.task.generation);
        let before = self.looked_at.insert(task, (stop.depth, stop.body));
        let is_called = |(depth, body): (u32, Span)| depth < stop.depth || depth == stop.depth && body != stop.body;
        stop.is_entry || before.is_some_and(is_called)
    }

    /// Why the run stops before a form, if it does.
    pub fn halt_before(&self, system: &System<Robot>, stop: &Stop, places: Places<'_>) -> Option<Halt> {
        if is_hidden(system, stop.span) {
            return None;
        }
        let start = self.start.as_ref();
        let is_here = |place: &Breakpoint| place.is_at(system, stop, places.file);
        let same_task = start.is_none_or(|start| start.task == stop.task);
        let was_depth = start.map_or(u32::MAX, |start| start.depth);
        let is_asked_for = |start| is_asked_for(system, places.until, start, stop);
        let is_wanted = is_own(system, stop.span) || start.is_some_and(is_asked_for);
        let has_arrived = match places.until {
            Until::Place(place) => is_here(place),
            _ if !is_wanted => false,
            Until::Step | Until::Into => true,
            Until::Next => same_task && stop.depth <= was_depth,
            Until::Out => same_task && stop.depth < was_depth,
            Until::End | Until::Time(_) | Until::Clock { .. } => false,
        };
        if has_arrived {
            return Some(Halt::Arrived);
        }
        let breakpoint = places.breakpoints.iter().find(|place| is_here(place))?;
        Some(Halt::Breakpoint(breakpoint.to_string()))
    }
}

/// Whether the user wants to see a place in the library: somebody who went into it, goes on in
/// it.
fn is_asked_for(system: &System<Robot>, until: &Until, start: &Stop, stop: &Stop) -> bool {
    let is_called = stop.depth >= start.depth && stop.body != start.body && !is_own(system, stop.body);
    let goes_in = *until == Until::Into && start.task == stop.task && is_called;
    let path = |task| system.machine.tasks.find_alive(task).map(|task| system.machine.path(task));
    let was_in = !is_own(system, start.span)
        && match (path(start.task), path(stop.task)) {
            (Some(start), Some(stop)) => is_within(&stop, &start) || is_within(&start, &stop),
            _ => false,
        };
    goes_in || was_in
}

/// The first of the conditions to stop at that has become true since they were looked at last.
pub fn condition_met(system: &mut System<Robot>, breakpoints: &mut [Breakpoint]) -> Option<Halt> {
    let mut met = None;
    for breakpoint in breakpoints {
        let Some(condition) = breakpoint.condition() else { continue };
        let holds = system.holds(condition).unwrap_or(false);
        if breakpoint.becomes(holds) && met.is_none() {
            met = Some(Halt::Breakpoint(breakpoint.to_string()));
        }
    }
    met
}
