//! What a task waits for, in words: the condition as it stands in the text, and which fluents decide.

use crate::state::fluent::Origin;
use crate::state::machine::Machine;
use crate::state::task::{ScopeKind, Waiting};
use crate::state::timers::{Alarm, Timer};
use crate::step::time::timers::is_current;
use rpl_lang::code::Program;
use std::collections::BTreeMap;

/// The most fluents that a condition is told to read.
const MAX_READINGS: usize = 64;

/// Fluents computed from fluents are followed so deep.
const MAX_DEPTH: usize = 16;

/// A fluent with a name that a condition reads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FluentReading {
    /// Its name.
    pub fluent: String,
    /// Its value, as it could be read.
    pub value: String,
    /// What it is computed from, where it is named first.
    pub from: Vec<FluentReading>,
}

impl Machine {
    /// What a task waits for, in words.
    pub fn describe(&self, program: &Program, waiting: Option<Waiting>) -> String {
        let Some(waiting) = waiting else { return "nothing".into() };
        match waiting {
            Waiting::Fluent { fluent, .. } => self.describe_fluent(program, fluent),
            Waiting::Watch(watch) => self.describe_fluent(program, self.watches[watch].fluent),
            Waiting::Time => "time".into(),
            Waiting::Children | Waiting::Spawned => "children".into(),
            Waiting::Valve(valve) => format!("valve {}", self.valve_name(valve)),
            Waiting::Death(other) => format!("the end of {}", self.path(other)),
            Waiting::Swap(other) => format!("the new plan of {}", self.path(other)),
            Waiting::Rest(other) => format!("the clean-ups of {}", self.path(other)),
            Waiting::Signal(_) => "signal".into(),
            Waiting::Hooks(_) => "hooks of its interruption".into(),
            Waiting::Answer => "a projection".into(),
        }
    }

    /// When timers end the waits of tasks. Cost: a look at all timers.
    pub fn wait_ends_us(&self) -> BTreeMap<u32, u64> {
        let ends_wait = |timer: &Timer| matches!(timer.alarm, Alarm::Wake(_) | Alarm::Request { .. });
        let current = self.timers.iter().filter(|timer| ends_wait(timer) && is_current(&self.tasks, timer));
        current.map(|timer| (timer.task.index, timer.deadline_us)).collect()
    }

    /// The tasks that are suspended by `with-task-suspended`, each with those that keep it so. Cost:
    /// a look at all tasks.
    pub fn suspended_by(&self) -> BTreeMap<u32, Vec<u32>> {
        let mut suspended: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for by in self.living_tasks() {
            for scope in self.tasks[by].scopes.iter() {
                let ScopeKind::Suspended(root) = scope.kind else { continue };
                let mut reached: Vec<u32> = self.tasks.find_alive(root).into_iter().collect();
                while let Some(task) = reached.pop() {
                    suspended.entry(task).or_default().push(by);
                    reached.extend(self.suspended_with(task));
                }
            }
        }
        suspended
    }

    fn describe_fluent(&self, program: &Program, fluent: u32) -> String {
        match self.fluents[fluent].name {
            Some(name) => format!("fluent {}", self.symbols.name(name)),
            None => self.condition_text(program, fluent, 0),
        }
    }

    /// A fluent in fluent position: by its name, or as its condition stands in the text.
    fn condition_text(&self, program: &Program, fluent: u32, depth: usize) -> String {
        let record = &self.fluents[fluent];
        if let Some(name) = record.name {
            return self.symbols.name(name).to_string();
        }
        let input = || match record.inputs.first() {
            Some(&input) if depth < MAX_DEPTH => self.condition_text(program, input, depth + 1),
            _ => "…".to_string(),
        };
        match &record.origin {
            Origin::Network { code, .. } => match program.codes.get(*code as usize) {
                Some(code) => program.sources.text_of(code.span).split_whitespace().collect::<Vec<_>>().join(" "),
                None => "condition".to_string(),
            },
            Origin::Pulsed => format!("(pulsed {})", input()),
            Origin::Changed => format!("(changed {})", input()),
            Origin::Count => format!("(count-pulses {})", input()),
            Origin::Plan | Origin::System => "condition".to_string(),
        }
    }

    /// The fluents with names that decide what a task waits for; none if it waits for no fluent.
    pub fn readings(&self, program: &Program, waiting: Option<Waiting>) -> Vec<FluentReading> {
        let Some(waiting) = waiting else { return Vec::new() };
        let fluent = match waiting {
            Waiting::Fluent { fluent, .. } => fluent,
            Waiting::Watch(watch) => self.watches[watch].fluent,
            Waiting::Time
            | Waiting::Children
            | Waiting::Spawned
            | Waiting::Valve(_)
            | Waiting::Death(_)
            | Waiting::Rest(_)
            | Waiting::Swap(_)
            | Waiting::Signal(_)
            | Waiting::Hooks(_)
            | Waiting::Answer => return Vec::new(),
        };
        self.readings_of(program, fluent, 0, &mut Vec::new())
    }

    /// A fluent with a name, or the named ones that one without is computed from. `seen` are those
    /// that have been told of.
    fn readings_of(&self, program: &Program, fluent: u32, depth: usize, seen: &mut Vec<u32>) -> Vec<FluentReading> {
        let Some(record) = self.fluents.get(fluent).filter(|_| seen.len() < MAX_READINGS) else { return Vec::new() };
        let is_first = !seen.contains(&fluent);
        let from = match is_first && depth < MAX_DEPTH {
            true => {
                seen.push(fluent);
                record.inputs.iter().flat_map(|&input| self.readings_of(program, input, depth + 1, seen)).collect()
            }
            false => Vec::new(),
        };
        match record.name {
            Some(name) => {
                let (fluent, value) = (self.symbols.name(name).to_string(), self.write(program, record.value));
                vec![FluentReading { fluent, value, from }]
            }
            None => from,
        }
    }
}
