//! What stands where: tasks, fluents, valves, and the form a task stands before.

use super::session::Session;
use crate::events;
use crate::mission::Robot;
use rpl_lang::code::GlobalKind;
use rpl_lang::pretty::print;
use rpl_lang::reader::read;
use rpl_lang::source::{SourceId, Sources, Span};
use rpl_lang::symbol::Symbols;
use rpl_lang::syntax::Tree;
use rpl_runtime::stepping::Stop;
use rpl_runtime::system::System;
use rpl_runtime::task::State;
use rpl_runtime::value::Value;

/// Longest value shown in a list.
const LONGEST_VALUE: usize = 60;

/// Lines of text shown around a form.
const LINES_AROUND: usize = 2;

/// The tree of the living tasks: state, and what each waits for.
pub fn tasks(system: &System<Robot>) -> Vec<String> {
    let mut lines = Vec::new();
    subtree(system, system.machine.main, 0, &mut lines);
    lines
}

fn subtree(system: &System<Robot>, task: u32, depth: usize, lines: &mut Vec<String>) {
    lines.push(format!("{}{}", "  ".repeat(depth), task_line(system, task, depth == 0)));
    for child in system.machine.children(task) {
        if !system.machine.tasks[child].state.is_dead() {
            subtree(system, child, depth + 1, lines);
        }
    }
}

fn task_line(system: &System<Robot>, task: u32, whole_path: bool) -> String {
    let machine = &system.machine;
    let path = machine.path(task);
    let parent = machine.path(machine.tasks[task].parent.min(machine.tasks.slots() as u32));
    let name = match path.strip_prefix(&parent) {
        Some(own) if !whole_path => own.trim_start_matches('/').to_string(),
        _ => path,
    };
    format!("{name}  {}", condition_of(system, task))
}

/// A task's state, and what it waits for.
pub fn condition_of(system: &System<Robot>, task: u32) -> String {
    let machine = &system.machine;
    let record = &machine.tasks[task];
    match record.state {
        State::Blocked if record.is_held() => {
            format!("suspended (was waiting for {})", waiting(system, task))
        }
        State::Blocked => format!("waits for {}", waiting(system, task)),
        state if record.is_held() => format!("suspended ({})", state.name()),
        state => state.name().to_string(),
    }
}

/// What a blocked task waits for, with the text of its condition if there is one.
pub fn waiting(system: &System<Robot>, task: u32) -> String {
    let machine = &system.machine;
    if task == machine.main && system.is_waiting_for_form() {
        return "the next form".to_string();
    }
    let what = machine.describe(machine.tasks[task].waiting);
    match what.as_str() {
        "condition" => match form_of(system, task) {
            Some(span) => shortened(&condition_text(system.program.sources.text_of(span))),
            None => what,
        },
        _ => what,
    }
}

/// The condition of a `wait-for` or `whenever`, which stands first in it.
fn condition_text(form: &str) -> String {
    let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
    let (roots, _) = read(form, SourceId(0), &mut symbols, &mut tree);
    let condition = roots.first().and_then(|&root| tree.items(root).get(1).copied());
    condition.map_or_else(|| one_line(form), |condition| print(&tree, &symbols, condition))
}

/// The form a task is in.
pub fn form_of(system: &System<Robot>, task: u32) -> Option<Span> {
    let frame = system.machine.tasks[task].frame;
    let code = system.program.codes.get(frame.code as usize)?;
    code.spans.get((frame.pc as usize).saturating_sub(1)).copied()
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

/// Valves, who holds them and who waits for them.
pub fn valves(system: &System<Robot>) -> Vec<String> {
    let machine = &system.machine;
    let path = |task| machine.tasks.find(task).map_or_else(|| "a dead task".to_string(), |task| machine.path(task));
    let mut lines = Vec::new();
    for valve in &machine.valves {
        let name = machine.symbols.name(valve.name);
        match valve.holds.split_last() {
            None => lines.push(format!("{name}  free")),
            Some((current, below)) => {
                lines.push(format!("{name}  held by {}", path(current.task)));
                let kept = below.iter().rev().map(|hold| format!("    before it: {}", path(hold.task)));
                lines.extend(kept);
            }
        }
        lines.extend(valve.line.iter().map(|&task| format!("    in line: {}", path(task))));
    }
    lines
}

/// A value as it could be read, not too long.
pub fn value_text(system: &System<Robot>, value: Value) -> String {
    shortened(&system.machine.write(&system.program, value))
}

/// The beginning of a long text.
pub fn shortened(text: &str) -> String {
    match text.char_indices().nth(LONGEST_VALUE) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_string(),
    }
}

/// A text without line breaks.
pub fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
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
    let last = first + text.get(start..end).map_or(0, |form| form.matches('\n').count()).min(LINES_AROUND);
    let mut lines = Vec::new();
    let mut offset = 0;
    for (index, line) in text.split_inclusive('\n').enumerate() {
        let (number, line_start) = (index + 1, offset);
        offset += line.len();
        if number + LINES_AROUND < first || number > last + LINES_AROUND {
            continue;
        }
        let line = cut(line.trim_end_matches(['\n', '\r']), width.saturating_sub(MARGIN));
        let clamp = |at: usize| at.clamp(line_start, line_start + line.len()) - line_start;
        let (from, to) = (line.floor_char_boundary(clamp(start)), line.floor_char_boundary(clamp(end)));
        let has_mark = from < to;
        let arrow = if has_mark && number == first { '▶' } else { ' ' };
        if has_mark && colour {
            let (before, form, after) = (&line[..from], &line[from..to], &line[to..]);
            lines.push(format!("{number:>5} {arrow} {before}\x1b[7m{form}\x1b[0m{after}"));
            continue;
        }
        lines.push(format!("{number:>5} {arrow} {line}"));
        if has_mark && number == first {
            let indent = line[..from].chars().count();
            lines.push(format!("        {}{}", " ".repeat(indent), "^".repeat(line[from..to].chars().count())));
        }
    }
    lines
}
