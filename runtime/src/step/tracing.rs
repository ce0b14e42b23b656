//! Events written to the trace, while it is switched on.

use crate::robot::RobotEvent;
use crate::state::machine::Machine;
use crate::state::scratch::Cursor;
use crate::state::slab::NONE;
use crate::state::task::{Leaving, State, Swap, Waiting};
use crate::state::trace::{Event, EventKind};
use crate::state::value::Value;
use crate::step::native::Surroundings;
use crate::step::tasks::condition::FluentReading;
use rpl_lang::bars::written_keyword;
use rpl_lang::code::Program;
use rpl_lang::symbol::Symbol;
use rpl_lang::visible::visible;
use std::collections::BTreeSet;

/// Elements of a list that are written of an argument.
const MOST_ELEMENTS: usize = 8;

/// Of a longer text of an argument only the beginning is written.
const LONGEST_TEXT_BYTES: usize = 200;

/// A fluent's name, in parentheses with those it is computed from.
fn nested(reading: &FluentReading) -> String {
    if reading.from.is_empty() {
        return reading.fluent.clone();
    }
    let from: Vec<String> = reading.from.iter().map(nested).collect();
    format!("({} {})", reading.fluent, from.join(" "))
}

/// The value of each fluent, once.
fn collect_values<'r>(reading: &'r FluentReading, values: &mut Vec<(&'r str, String)>) {
    if values.iter().all(|&(name, _)| name != reading.fluent) {
        values.push((&reading.fluent, reading.value.clone()));
    }
    reading.from.iter().for_each(|reading| collect_values(reading, values));
}

impl Machine {
    fn event(&mut self, path: String, kind: EventKind, details: Vec<(&str, String)>) {
        let details = details.into_iter().map(|(name, value)| (name.to_string(), value)).collect();
        let sequence = self.trace.next_sequence;
        self.trace.next_sequence += 1;
        let event = Event { time_us: self.now_us, sequence, path, kind, details };
        self.heap.allocated += event.bytes();
        self.trace.events.push(event);
    }

    fn current_path(&self) -> String {
        if self.current == NONE { String::new() } else { self.path(self.current) }
    }

    pub(crate) fn trace_task_begin(&mut self, task: u32) {
        if self.projected.is_some() && self.tasks[task].exposed {
            self.note_step_of_projection(task);
        }
        if !self.trace.enabled {
            return;
        }
        let path = self.path(task);
        self.event(path, EventKind::Begin, Vec::new());
        if self.tasks[task].stop() > 0 {
            self.trace_suspended(task, NONE);
        }
    }

    pub(crate) fn trace_task_end(&mut self, program: &Program, task: u32) {
        if !self.trace.enabled {
            return;
        }
        let (state, result) = (self.tasks[task].state(), *self.tasks[task].value());
        let mut details = vec![("state", state.name().to_string())];
        match state {
            State::Succeeded => details.push(("value", self.write(program, result))),
            State::Failed => details.push(("failure", self.show(program, result))),
            _ => {}
        }
        let path = self.path(task);
        self.event(path, EventKind::End, details);
    }

    pub(crate) fn trace_call(&mut self, program: &Program, task: u32, place: &Cursor) {
        if self.trace.enabled {
            let arguments = self.arguments(program, place);
            let details = if arguments.is_empty() { Vec::new() } else { vec![("arguments", arguments)] };
            let path = self.path(task);
            self.event(path, EventKind::Call, details);
        }
    }

    /// The arguments of the function that a frame has just entered, as they would stand in a call of it.
    fn arguments(&self, program: &Program, place: &Cursor) -> String {
        let parameters = &program.codes[place.frame.code as usize].parameters;
        let base = place.frame.base as usize;
        let given = |at: usize| self.scratch.stack.get(base + at).copied().filter(|value| *value != Value::Unbound);
        let positional = usize::from(parameters.required) + usize::from(parameters.optional);
        let mut written: Vec<String> =
            (0..positional).filter_map(given).map(|value| self.argument(program, value)).collect();
        let rest = given(positional).filter(|_| parameters.rest).map(|rest| self.beginning(rest));
        for value in rest.into_iter().flatten() {
            written.push(value.map_or("…".to_string(), |value| self.argument(program, value)));
        }
        let keys = parameters.keys.iter().zip(positional + usize::from(parameters.rest)..);
        for (&key, value) in keys.filter_map(|(key, at)| Some((key, given(at)?))) {
            written.push(format!("{} {}", written_keyword(self.symbols.name(key)), self.argument(program, value)));
        }
        written.join(" ")
    }

    /// A value as it would stand in a call. Of what may be long only the beginning is written: a plan that calls itself
    /// with the rest of a list, or again and again with one vector, would else write a trace that grows with the square of
    /// its length.
    fn argument(&self, program: &Program, value: Value) -> String {
        match value {
            Value::Symbol(_) => format!("'{}", self.write(program, value)),
            Value::Cons(_) => {
                let element =
                    |value: Option<Value>| value.map_or("…".to_string(), |value| self.element(program, value));
                format!("'({})", self.beginning(value).into_iter().map(element).collect::<Vec<_>>().join(" "))
            }
            other => self.element(program, other),
        }
    }

    /// A value within a call, without what lies in it.
    fn element(&self, program: &Program, value: Value) -> String {
        match value {
            Value::Cons(_) => "(…)".to_string(),
            Value::Vector(_) => "#(…)".to_string(),
            Value::Str(text) if self.heap.strings[text].len() > LONGEST_TEXT_BYTES => {
                let text = &self.heap.strings[text];
                format!("\"{}…\"", visible(&text[..text.floor_char_boundary(LONGEST_TEXT_BYTES)]))
            }
            atom => self.brief(program, atom),
        }
    }

    /// The first elements of a list; nothing stands for those that follow.
    fn beginning(&self, list: Value) -> Vec<Option<Value>> {
        let (mut elements, mut left) = (Vec::new(), list);
        while let Value::Cons(pair) = left {
            if elements.len() == MOST_ELEMENTS {
                elements.push(None);
                break;
            }
            let (element, rest) = self.heap.pair(pair);
            elements.push(Some(element));
            left = rest;
        }
        elements
    }

    pub(crate) fn trace_call_end(&mut self, task: u32, leaving: &Leaving) {
        if self.trace.enabled {
            let path = self.path(task);
            let how = match leaving {
                Leaving::Evaporate => "evaporated",
                Leaving::Fail(_) | Leaving::FailCall { .. } => "failed",
                Leaving::Block { .. } | Leaving::Jump { .. } | Leaving::Swap(_) => "left",
            };
            self.event(path, EventKind::Return, vec![("state", how.to_string())]);
        }
    }

    pub(crate) fn trace_return(&mut self, program: &Program, task: u32, value: Value) {
        if self.trace.enabled {
            let path = self.path(task);
            let details = vec![("state", "succeeded".to_string()), ("value", self.write(program, value))];
            self.event(path, EventKind::Return, details);
        }
    }

    #[inline]
    pub(crate) fn trace_blocked(&mut self, program: &Program, task: u32) {
        if self.trace.enabled {
            self.write_blocked(program, task);
        }
    }

    fn write_blocked(&mut self, program: &Program, task: u32) {
        let waiting = self.tasks[task].waiting();
        let mut details = vec![("on", self.describe(program, waiting))];
        if let Some(span) = self.form_of(program, task).filter(|span| span.source.0 >= program.library_sources) {
            details.push(("at", program.sources.place(span)));
        }
        if let Some(time_us) = self.scratch.wake_at.take() {
            details.push(("until", format!("{:.3}", time_us as f64 / 1e6)));
        }
        let readings = self.readings(program, waiting);
        if !readings.is_empty() {
            details.push(("reads", readings.iter().map(nested).collect::<Vec<_>>().join(" ")));
        }
        let mut values = Vec::new();
        readings.iter().for_each(|reading| collect_values(reading, &mut values));
        details.extend(values);
        let path = self.path(task);
        self.event(path, EventKind::Blocked, details);
    }

    /// Conditions that tasks wait for have come to read other fluents.
    pub(crate) fn trace_rereading(&mut self, program: &Program, networks: &[u32]) {
        if !self.trace.enabled || networks.is_empty() {
            return;
        }
        let mut concerned = BTreeSet::new();
        let mut left = networks.to_vec();
        while let Some(fluent) = left.pop() {
            let Some(record) = self.fluents.get(fluent) else { continue };
            if concerned.insert(fluent) {
                left.extend(record.dependents.iter());
            }
        }
        for task in self.living_tasks() {
            let fluent = match self.tasks[task].waiting() {
                Some(Waiting::Fluent { fluent, .. }) => Some(fluent),
                Some(Waiting::Watch(watch)) => Some(self.watches[watch].fluent),
                _ => None,
            };
            if fluent.is_some_and(|fluent| concerned.contains(&fluent)) {
                self.write_blocked(program, task);
            }
        }
    }

    #[inline]
    pub(crate) fn trace_woken(&mut self, task: u32) {
        if self.trace.enabled {
            let path = self.path(task);
            self.event(path, EventKind::Woken, Vec::new());
        }
    }

    pub(crate) fn trace_swapped(&mut self, program: &Program, task: u32, swap: &Swap) {
        if self.trace.enabled {
            let path = self.path(task);
            let by = swap.by.and_then(|by| self.tasks.find_alive(by)).map(|by| ("by", self.path(by)));
            let first = program.codes[swap.code as usize].spans.first();
            let at = first.map(|&span| ("at", program.sources.place(span)));
            self.event(path, EventKind::Swapped, by.into_iter().chain(at).collect());
        }
    }

    /// A figure as a person reads it: functions by their names.
    fn figure(&mut self, program: &Program, value: Value) -> String {
        match value {
            Value::Function(code) => self.symbols.name(program.codes[code as usize].name).to_string(),
            Value::Cons(_) => {
                let parts = self.heap.elements(value).unwrap_or_default();
                parts.into_iter().map(|part| self.figure(program, part)).collect::<Vec<_>>().join(" ")
            }
            other => self.show(program, other),
        }
    }

    /// What foresight has decided about a task, with figures by name.
    pub(crate) fn trace_decided(&mut self, program: &Program, task: u32, what: &str, figures: &[(Symbol, Value)]) {
        if self.trace.enabled {
            let path = self.path(task);
            let told: Vec<(String, String)> = figures
                .iter()
                .map(|&(name, value)| (self.symbols.name(name).to_string(), self.figure(program, value)))
                .collect();
            let figures = told.iter().map(|(name, value)| (name.as_str(), value.clone()));
            let details = std::iter::once(("what", what.to_string())).chain(figures).collect();
            self.event(path, EventKind::Decided, details);
        }
    }

    pub(crate) fn trace_suspended(&mut self, task: u32, by: u32) {
        if self.trace.enabled {
            let path = self.path(task);
            let by = (by != NONE).then(|| ("by", self.path(by)));
            self.event(path, EventKind::Suspended, by.into_iter().collect());
        }
    }

    pub(crate) fn trace_resumed(&mut self, task: u32) {
        if self.trace.enabled {
            let path = self.path(task);
            self.event(path, EventKind::Resumed, Vec::new());
        }
    }

    #[inline]
    pub(crate) fn trace_fluent(&mut self, program: &Program, fluent: u32) {
        if self.trace.enabled {
            self.write_fluent(program, fluent);
        }
    }

    fn write_fluent(&mut self, program: &Program, fluent: u32) {
        if let Some(name) = self.fluents[fluent].name
            && !self.is_quiet(fluent)
        {
            let details = vec![
                ("fluent", self.symbols.name(name).to_string()),
                ("value", self.write(program, self.fluents[fluent].value)),
            ];
            let path = self.current_path();
            self.event(path, EventKind::Fluent, details);
        }
    }

    /// Whether a fluent changes with each step of the robot: one of the quiet ones, or a number that
    /// is computed from them through numbers.
    fn is_quiet(&self, fluent: u32) -> bool {
        let mut seen = BTreeSet::new();
        let mut waiting = vec![fluent];
        while let Some(fluent) = waiting.pop() {
            if self.trace.quiet.contains(&fluent) {
                return true;
            }
            let record = &self.fluents[fluent];
            if matches!(record.value, Value::Int(_) | Value::Float(_)) && seen.insert(fluent) {
                waiting.extend(&record.inputs);
            }
        }
        false
    }

    pub(crate) fn trace_pulse(&mut self, fluent: u32) {
        if self.trace.enabled {
            let name = self.fluent_name(fluent);
            let path = self.current_path();
            self.event(path, EventKind::Pulse, vec![("fluent", name)]);
        }
    }

    pub(crate) fn trace_valve(&mut self, task: u32, valve: u32, what: &str) {
        if self.trace.enabled {
            let name = self.symbols.name(self.valves[valve as usize].name).to_string();
            let path = self.path(task);
            self.event(path, EventKind::Valve, vec![("valve", name), ("what", what.to_string())]);
        }
    }

    pub(crate) fn trace_failed(&mut self, program: &Program, task: u32, failure: Value) {
        if self.trace.enabled {
            let mut details = vec![("failure", self.show(program, failure))];
            if let Value::Failure(index) = failure
                && let Some(span) = self.heap.failures[index].span
            {
                details.push(("at", program.sources.place(span)));
            }
            let path = self.path(task);
            self.event(path, EventKind::Failed, details);
        }
    }

    pub(crate) fn trace_handled(&mut self, task: u32, leaving: &Leaving) {
        if let (true, Leaving::Fail(_)) = (self.trace.enabled, leaving) {
            let path = self.path(task);
            self.event(path, EventKind::Handled, Vec::new());
        }
    }

    pub(crate) fn trace_behaviour(&mut self, around: &Surroundings<'_>, behaviour: u16, what: &str) {
        if self.trace.enabled {
            let name = around.outside.tables().behaviours[usize::from(behaviour)].name.to_string();
            let path = self.current_path();
            self.event(path, EventKind::Behaviour, vec![("behaviour", name), ("what", what.to_string())]);
        }
    }

    pub(crate) fn trace_signal(&mut self, around: &Surroundings<'_>, behaviour: u16, signal: &Result<Value, Value>) {
        if self.trace.enabled {
            let name = around.outside.tables().behaviours[usize::from(behaviour)].name.to_string();
            let (text, value) = match signal {
                Ok(Value::True) => ("success".to_string(), None),
                Ok(value) => ("success".to_string(), Some(self.show(around.program, *value))),
                Err(failure) => (self.show(around.program, *failure), None),
            };
            let details = [("behaviour", name), ("signal", text)].into_iter();
            let details = details.chain(value.map(|value| ("value", value))).collect();
            self.event(String::new(), EventKind::Signal, details);
        }
    }

    pub(crate) fn trace_robot(&mut self, event: &RobotEvent) {
        if self.trace.enabled {
            let mut details = vec![("what", event.what.to_string())];
            details.extend(event.details.iter().map(|(name, value)| (&**name, value.clone())));
            self.event(String::new(), EventKind::Robot, details);
        }
    }

    pub(crate) fn trace_log(&mut self, text: &str) {
        if self.trace.enabled {
            let path = self.current_path();
            self.event(path, EventKind::Log, vec![("text", text.to_string())]);
        }
    }

    pub(crate) fn trace_measured(&mut self, name: Symbol, number: f64) {
        if self.trace.enabled {
            let path = self.current_path();
            let name = self.symbols.name(name).to_string();
            self.event(path, EventKind::Measured, vec![("measure", name), ("value", number.to_string())]);
        }
    }

    pub(crate) fn trace_warning(&mut self, text: &str) {
        if self.trace.enabled {
            let path = self.current_path();
            self.event(path, EventKind::Warning, vec![("text", text.to_string())]);
        }
    }
}
