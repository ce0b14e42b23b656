//! What a debugger is shown of a run that stands still: tasks, their calls, variables, fluents, valves.

use super::places::{Counting, source};
use crate::listings::value_text;
use crate::present::standing;
use rpl_drive::stopping::own_text::{is_hidden, is_own};
use rpl_editor::dap::messages::{StackFrame, Variable};
use rpl_editor::lines::Lines;
use rpl_lang::code::GlobalKind;
use rpl_lang::symbol::Symbol;
use rpl_mission::robot::Robot;
use rpl_runtime::run::stepping::Stop;
use rpl_runtime::run::system::System;
use rpl_runtime::run::variables::StandingCall;
use rpl_runtime::state::value::Value;
use serde_json::{Value as Json, json};
use std::collections::BTreeMap;

/// The scopes that are the same for every frame.
const FLUENTS: i64 = 1;
const VALVES: i64 = 2;

/// The variables of frames come behind these.
const FIRST_FRAME: i64 = 3;

/// The frames a debugger has been told of since the run stands: a task, and how deep the call lies.
#[derive(Default)]
pub struct Frames(Vec<(u32, usize)>);

/// The number of the thread that a task is.
pub fn thread_of(task: u32) -> i64 {
    i64::from(task) + 1
}

/// The living tasks by their paths, each with what it waits for.
pub fn threads(system: &System<Robot>) -> Vec<Json> {
    let machine = &system.machine;
    let ends_us = machine.wait_ends_us();
    let thread = |task: u32| {
        let condition = standing(system, &ends_us, task).condition(machine.now_us);
        json!({ "id": thread_of(task), "name": format!("{}  {condition}", machine.path(task)) })
    };
    machine.living_tasks().into_iter().map(thread).collect()
}

impl Frames {
    /// The calls of a task, innermost first; where the stepper stands before a form of it, that form.
    pub fn stack(
        &mut self,
        system: &System<Robot>,
        thread: i64,
        stop: Option<&Stop>,
        counting: Counting,
    ) -> Vec<StackFrame> {
        let machine = &system.machine;
        let Some(task) = machine.living_tasks().into_iter().find(|&task| thread_of(task) == thread) else {
            return Vec::new();
        };
        let stop = stop.filter(|stop| machine.tasks.find_alive(stop.task) == Some(task));
        let calls = machine.calls(&system.program, task).into_iter().enumerate();
        // Many calls stand in few texts.
        let mut texts = BTreeMap::new();
        let frames = calls.filter_map(|(depth, call)| {
            let span = stop.filter(|_| depth == 0).map_or(call.span, |stop| stop.span);
            if is_hidden(system, span) {
                return None;
            }
            self.0.push((task, depth));
            let text = &system.program.sources.get(span.source).text;
            let (lines, source) =
                texts.entry(span.source).or_insert_with(|| (Lines::of(text), source(system, span.source)));
            let [(line, column), (end_line, end_column)] = counting.of(lines, text, span);
            Some(StackFrame {
                id: self.0.len() as i64,
                name: machine.symbols.name(call.name).to_string(),
                source: source.clone(),
                line,
                column,
                end_line,
                end_column,
                presentation_hint: (!is_own(system, span)).then_some("subtle"),
            })
        });
        frames.collect()
    }

    /// The call of a frame.
    fn call(&self, system: &System<Robot>, frame: i64) -> Option<StandingCall> {
        let &(task, depth) = self.0.get(usize::try_from(frame.checked_sub(1)?).ok()?)?;
        system.machine.calls(&system.program, task).into_iter().nth(depth)
    }

    /// The variables that a frame sees, or none.
    pub fn variables_of(&self, system: &System<Robot>, frame: Option<i64>) -> Vec<(Symbol, Value)> {
        let call = frame.and_then(|frame| self.call(system, frame));
        call.map_or(Vec::new(), |call| call.variables)
    }

    /// What a scope holds.
    pub fn variables(&self, system: &System<Robot>, reference: i64) -> Vec<Variable> {
        match reference {
            FLUENTS => fluents(system),
            VALVES => valves(system),
            frame => {
                let seen = self.variables_of(system, frame.checked_sub(FIRST_FRAME));
                let shown = seen
                    .into_iter()
                    .map(|(name, value)| variable(system.machine.symbols.name(name), value_text(system, value)));
                shown.filter(|one| !one.name.starts_with(['%', '#'])).collect()
            }
        }
    }

    /// Forgets the frames: the run has gone on.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}

/// The scopes of a frame.
pub fn scopes(frame: i64) -> Json {
    let scope = |name: &str, reference: i64, hint: Option<&str>| json!({ "name": name, "variablesReference": reference, "expensive": false, "presentationHint": hint });
    json!([
        scope("Variables", FIRST_FRAME.saturating_add(frame), Some("locals")),
        scope("Fluents", FLUENTS, None),
        scope("Valves", VALVES, None)
    ])
}

fn variable(name: &str, value: String) -> Variable {
    Variable { name: name.to_string(), value, variables_reference: 0 }
}

fn fluents(system: &System<Robot>) -> Vec<Variable> {
    let named = system.program.globals.iter().zip(&system.machine.globals);
    let mut fluents: Vec<Variable> = named
        .filter(|(global, _)| global.kind == GlobalKind::Fluent)
        .filter_map(|(global, value)| match value {
            Value::Fluent(fluent) => {
                Some((system.machine.symbols.name(global.name), system.machine.fluents.get(*fluent)?))
            }
            _ => None,
        })
        .filter(|(name, _)| !name.starts_with('%'))
        .map(|(name, fluent)| variable(name, value_text(system, fluent.value)))
        .collect();
    fluents.sort_by(|left, right| left.name.cmp(&right.name));
    fluents
}

fn valves(system: &System<Robot>) -> Vec<Variable> {
    let machine = &system.machine;
    let holder = |valve: &rpl_runtime::state::valve::Valve| {
        let last = valve.places().filter_map(|place| machine.places[place as usize].holders().next_back());
        let holders: Vec<String> =
            last.filter_map(|holder| machine.tasks.find(holder)).map(|task| machine.path(task)).collect();
        match (holders.as_slice(), valve.places as usize - holders.len()) {
            ([], _) => "free".to_string(),
            (_, 0) => format!("held by {}", holders.join(" and ")),
            (_, free) => format!("held by {}, {free} of {} places free", holders.join(" and "), valve.places),
        }
    };
    machine.valves.iter().map(|valve| variable(machine.symbols.name(valve.name), holder(valve))).collect()
}
