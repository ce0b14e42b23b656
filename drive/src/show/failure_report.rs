//! A failure of the main task, for people and for programs.

use rpl_lang::code::Program;
use rpl_lang::diagnostic::{Diagnostic, render};
use rpl_lang::source::Span;
use rpl_lang::visible::{visible, visible_lines};
use rpl_runtime::state::failure::Failure;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use serde::Serialize;
use std::fmt::Write;

/// What stands before the failure of a run.
pub const PLAN_FAILED: &str = "the plan failed: ";

/// What stands before the failure of a scenario.
pub const SCENARIO_FAILED: &str = "the scenario failed: ";

/// Parts of parts are shown down to this depth.
const MAX_DEPTH: usize = 8;

/// A failure as `--json` shows it.
#[derive(Clone, Debug, Serialize)]
pub struct FailureRecord {
    /// The class of the failure.
    pub class: String,
    /// What it says.
    pub message: String,
    path: String,
    file: Option<String>,
    line: Option<usize>,
    column: Option<usize>,
    calls: Vec<CallRecord>,
    causes: Vec<FailureRecord>,
    while_cleaning_up: Vec<FailureRecord>,
}

impl FailureRecord {
    /// Whether it may have come about because there was no robot: one was missing, or what only a
    /// robot changes was waited for.
    pub fn may_miss_robot(&self) -> bool {
        matches!(self.class.as_str(), "no-robot" | "deadlock")
            || self.causes.iter().chain(&self.while_cleaning_up).any(Self::may_miss_robot)
    }
}

#[derive(Clone, Debug, Serialize)]
struct CallRecord {
    plan: String,
    file: Option<String>,
    line: Option<usize>,
}

impl FailureRecord {
    /// What kept a run from starting.
    pub fn of_set_up(message: &str) -> Self {
        Self {
            class: "set-up".to_string(),
            message: message.to_string(),
            path: String::new(),
            file: None,
            line: None,
            column: None,
            calls: Vec::new(),
            causes: Vec::new(),
            while_cleaning_up: Vec::new(),
        }
    }
}

/// What is needed to tell of a failure.
#[derive(Clone, Copy)]
pub struct Reporter<'a> {
    /// Where the failures are.
    pub machine: &'a Machine,
    /// Where their texts are.
    pub program: &'a Program,
    /// Whether to use the colours of a terminal.
    pub colour: bool,
}

/// A message whose further lines stand further in: none of them looks like one of ours.
fn told(message: &str) -> String {
    visible_lines(message).replace('\n', "\n    ")
}

impl<'a> Reporter<'a> {
    fn failure(&self, value: Value) -> Option<&'a Failure> {
        match value {
            Value::Failure(index) => self.machine.heap.failures.get(index),
            _ => None,
        }
    }

    fn place(&self, span: Option<Span>) -> (Option<String>, Option<usize>, Option<usize>) {
        let Some(span) = span else { return (None, None, None) };
        let (line, column) = self.program.sources.line_column(span);
        (Some(self.program.sources.get(span.source).name.to_string()), Some(line), Some(column))
    }

    /// The failure as data.
    pub fn record(&self, value: Value) -> Option<FailureRecord> {
        self.record_at(value, 0)
    }

    fn record_at(&self, value: Value, depth: usize) -> Option<FailureRecord> {
        let failure = self.failure(value)?;
        let (file, line, column) = self.place(failure.span);
        let records = |values: &[Value]| match depth < MAX_DEPTH {
            true => values.iter().filter_map(|&value| self.record_at(value, depth + 1)).collect(),
            false => Vec::new(),
        };
        let calls = failure.calls.iter().map(|&(plan, span)| {
            let (file, line, _) = self.place(span);
            CallRecord { plan: self.machine.symbols.name(plan).to_string(), file, line }
        });
        Some(FailureRecord {
            class: self.machine.symbols.name(failure.class).to_string(),
            message: failure.message.clone(),
            path: failure.path.clone(),
            file,
            line,
            column,
            calls: calls.collect(),
            causes: records(&failure.parts),
            while_cleaning_up: records(&failure.while_cleaning_up),
        })
    }

    /// The failure as text, behind a heading: class, message, the place marked, the plan calls, the
    /// path of the task, and what it is made of.
    pub fn text(&self, heading: &str, value: Value) -> String {
        let mut text = String::new();
        self.write(&mut text, value, heading, 0);
        text
    }

    fn write(&self, text: &mut String, value: Value, heading: &str, depth: usize) {
        let Some(failure) = self.failure(value) else { return };
        let class = visible(self.machine.symbols.name(failure.class));
        let margin = "  ".repeat(depth);
        let mut lines = format!("{heading}{}: {}\n", self.emphasised(&class), told(&failure.message));
        if let Some(span) = failure.span {
            lines += &self.marked(span);
        }
        for &(plan, span) in &failure.calls {
            let name = visible(self.machine.symbols.name(plan));
            let place = span.map_or(String::new(), |span| format!(", called at {}", self.program.sources.place(span)));
            lines += &format!("in {name}{place}\n");
        }
        if !failure.path.is_empty() {
            lines += &format!("task {}\n", failure.path);
        }
        for line in lines.lines() {
            // Writing into a string cannot fail.
            writeln!(text, "{margin}{line}").ok();
        }
        if depth >= MAX_DEPTH {
            return;
        }
        for (number, &part) in failure.parts.iter().enumerate() {
            self.write(text, part, &format!("cause {}: ", number + 1), depth + 1);
        }
        for &part in &failure.while_cleaning_up {
            self.write(text, part, "while cleaning up: ", depth + 1);
        }
    }

    fn emphasised(&self, class: &str) -> String {
        if self.colour { format!("\u{1b}[31m{class}\u{1b}[0m") } else { class.to_string() }
    }

    /// The lines of the text with the place marked.
    fn marked(&self, span: Span) -> String {
        let finding = Diagnostic::error("failure", span, "", "here");
        let drawn = render(&[finding], &self.program.sources, self.colour);
        // The heading above it already says what happened.
        drawn.split_once('\n').map_or(String::new(), |(_, body)| body.to_string())
    }
}
