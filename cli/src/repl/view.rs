//! What stands where: tasks, fluents, valves, and the form a task stands before.

use super::living::standing;
use super::session::Session;
use crate::events;
use crate::mission::Robot;
use crate::why::{is_meant, shortened};
use rpl_lang::code::GlobalKind;
use rpl_lang::source::{self, Sources, Span, count_line_ends};
use rpl_lang::visible::pictured;
use rpl_runtime::run::stepping::Stop;
use rpl_runtime::run::system::System;
use rpl_runtime::state::value::Value;
use rpl_runtime::state::valve::Valve;
use std::collections::BTreeMap;

/// Lines of text shown around a form.
const LINES_AROUND: usize = 2;

/// The tree of the living tasks: state, what each waits for, and the valves it holds.
pub fn tasks(system: &System<Robot>) -> Vec<String> {
    let mut lines = Vec::new();
    subtree(system, &system.machine.wait_ends_us(), system.machine.main, 0, &mut lines);
    lines
}

type WaitEnds = BTreeMap<u32, u64>;

fn subtree(system: &System<Robot>, ends_us: &WaitEnds, task: u32, depth: usize, lines: &mut Vec<String>) {
    lines.push(format!("{}{}", "  ".repeat(depth), task_line(system, ends_us, task, depth == 0)));
    for child in system.machine.children(task) {
        if !system.machine.tasks[child].state().is_dead() {
            subtree(system, ends_us, child, depth + 1, lines);
        }
    }
}

fn task_line(system: &System<Robot>, ends_us: &WaitEnds, task: u32, whole_path: bool) -> String {
    let machine = &system.machine;
    let path = machine.path(task);
    let parent = machine.path(machine.tasks[task].parent.min(machine.tasks.slots() as u32));
    let name = match path.strip_prefix(&parent) {
        Some(own) if !whole_path => own.trim_start_matches('/').to_string(),
        _ => path,
    };
    let holder = |valve: &&Valve| valve.holders().next_back().and_then(|holder| machine.tasks.find(holder));
    let held: Vec<&str> = machine
        .valves
        .iter()
        .filter(|valve| holder(valve) == Some(task))
        .map(|valve| machine.symbols.name(valve.name))
        .collect();
    let holds = if held.is_empty() { String::new() } else { format!(", holds {}", held.join(" and ")) };
    format!("{name}  {}{holds}", standing(system, ends_us, task).condition(machine.now_us))
}

/// The living task that is meant by a path, by its end, or by nothing: the main task.
pub fn living(system: &System<Robot>, path: &str) -> Option<u32> {
    let machine = &system.machine;
    if path.is_empty() {
        return Some(machine.main);
    }
    machine.living_tasks().into_iter().find(|&task| is_meant(&machine.path(task), path))
}

/// One task: path, state, form, variables.
pub fn task(system: &System<Robot>, task: u32) -> Vec<String> {
    let machine = &system.machine;
    let condition = standing(system, &machine.wait_ends_us(), task).condition(machine.now_us);
    let mut lines = vec![format!("{}  {condition}", machine.path(task))];
    let priority = machine.priorities.list(machine.tasks[task].priority);
    if !priority.is_empty() {
        lines.push(format!("  priority {priority:?}"));
    }
    if let Some(span) = machine.form_of(&system.program, task) {
        let text = shortened(&one_line(system.program.sources.text_of(span)));
        lines.push(format!("  at {}: {text}", system.program.sources.place(span)));
    }
    for (name, variables) in machine.variables(&system.program, task) {
        let name = machine.symbols.name(name);
        let variables = variables
            .iter()
            .map(|&(name, value)| format!("{} = {}", machine.symbols.name(name), value_text(system, value)));
        let variables: Vec<String> = variables.collect();
        if !name.starts_with('%') && !variables.is_empty() {
            lines.push(format!("  {name}: {}", variables.join(", ")));
        }
    }
    lines
}

/// Fluents with a name and their values; all, or those whose name holds a word.
pub fn fluents(system: &System<Robot>, word: &str) -> Vec<String> {
    let named = system.program.globals.iter().zip(&system.machine.globals);
    let mut lines: Vec<String> = named
        .filter(|(global, _)| global.kind == GlobalKind::Fluent)
        .filter_map(|(global, value)| match value {
            Value::Fluent(fluent) => Some((system.machine.symbols.name(global.name), *fluent)),
            _ => None,
        })
        .filter(|(name, _)| !name.starts_with('%') && name.contains(word))
        .map(|(name, fluent)| format!("{name} = {}", value_text(system, system.machine.fluents[fluent].value)))
        .collect();
    lines.sort();
    lines
}

/// The value of a fluent that is defined as a global.
pub fn fluent_value(system: &System<Robot>, global: u32) -> Option<String> {
    match system.machine.globals.get(global as usize)? {
        Value::Fluent(fluent) => Some(value_text(system, system.machine.fluents.get(*fluent)?.value)),
        _ => None,
    }
}

/// Valves, who holds them and who waits for them.
pub fn valves(system: &System<Robot>) -> Vec<String> {
    let machine = &system.machine;
    let path = |task| machine.tasks.find(task).map_or_else(|| "a dead task".to_string(), |task| machine.path(task));
    let mut lines = Vec::new();
    for valve in &machine.valves {
        let name = machine.symbols.name(valve.name);
        let mut holders = valve.holders().rev();
        lines.push(match holders.next() {
            None => format!("{name}  free"),
            Some(holder) => format!("{name}  held by {}", path(holder)),
        });
        lines.extend(holders.map(|holder| format!("    before it: {}", path(holder))));
        lines.extend(valve.in_line().into_iter().map(|task| format!("    in line: {}", machine.path(task))));
    }
    lines
}

/// A value as it could be read, not too long.
pub fn value_text(system: &System<Robot>, value: Value) -> String {
    shortened(&system.machine.write(&system.program, value))
}

/// A text without line breaks.
pub fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The prompt's own text.
const HIDDEN: &str = "session";

/// Whether a stop counts as a step back.
pub fn is_shown(system: &System<Robot>, stop: &Stop) -> bool {
    is_own(system, stop.span)
}

/// Whether a place lies in a text that nobody steps through.
pub fn is_hidden(system: &System<Robot>, span: Span) -> bool {
    *system.program.sources.get(span.source).name == *HIDDEN
}

/// Whether a place lies in what was typed and loaded; the rest is the library.
pub fn is_own(system: &System<Robot>, span: Span) -> bool {
    span.source.0 >= system.program.library_sources && !is_hidden(system, span)
}

/// Where the stepper stands: time, task, the form in its text, and the variables around it. Lines
/// of the text are cut at a width.
pub fn stop(session: &Session, stop: &Stop, colour: bool, width: usize) -> Vec<String> {
    let system = &session.branch.system;
    let machine = &system.machine;
    let Some(task) = machine.tasks.find_alive(stop.task) else { return Vec::new() };
    let place = system.program.sources.place(stop.span);
    let (time, place) = (format!("{:.3} s", machine.now_s()), place.to_string());
    let room = width.saturating_sub(time.chars().count() + place.chars().count() + 4);
    let mut lines = vec![format!("{time}  {}  {place}", events::shortened(&machine.path(task), room))];
    lines.extend(marked(&system.program.sources, stop.span, colour, width));
    if let Some((_, variables)) = machine.variables(&system.program, task).first()
        && !variables.is_empty()
    {
        let shown = variables
            .iter()
            .map(|&(name, value)| format!("{} = {}", machine.symbols.name(name), value_text(system, value)));
        lines.push(format!("    {}", shown.collect::<Vec<_>>().join(", ")));
    }
    lines
}

/// Columns before the text of a line.
const MARGIN: usize = 8;

/// As much of a line as fits.
fn cut(line: &str, width: usize) -> &str {
    line.char_indices().nth(width).map_or(line, |(end, _)| &line[..end])
}

/// The lines around a form, with the form marked: in reverse with colours, else underlined.
fn marked(sources: &Sources, span: Span, colour: bool, width: usize) -> Vec<String> {
    let text = &sources.get(span.source).text;
    let (first, _) = sources.line_column(Span { end: span.start, ..span });
    let (start, end) = (span.start as usize, span.end as usize);
    let last = first + text.get(start..end).map_or(0, count_line_ends).min(LINES_AROUND);
    let mut lines = Vec::new();
    for (index, (line_start, line)) in source::lines(text).enumerate() {
        let number = index + 1;
        if number + LINES_AROUND < first || number > last + LINES_AROUND {
            continue;
        }
        let line = cut(line, width.saturating_sub(MARGIN));
        let clamp = |at: usize| at.clamp(line_start, line_start + line.len()) - line_start;
        let (from, to) = (line.floor_char_boundary(clamp(start)), line.floor_char_boundary(clamp(end)));
        let has_mark = from < to;
        let arrow = if has_mark && number == first { '▶' } else { ' ' };
        if has_mark && colour {
            let (before, form, after) = (pictured(&line[..from]), pictured(&line[from..to]), pictured(&line[to..]));
            lines.push(format!("{number:>5} {arrow} {before}\x1b[7m{form}\x1b[0m{after}"));
            continue;
        }
        lines.push(format!("{number:>5} {arrow} {}", pictured(line)));
        if has_mark && number == first {
            let indent = line[..from].chars().count();
            lines.push(format!("        {}{}", " ".repeat(indent), "^".repeat(line[from..to].chars().count())));
        }
    }
    lines
}
