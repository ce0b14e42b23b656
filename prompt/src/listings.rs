//! What stands where, as lines: tasks, fluents and valves.

use super::present::standing;
use rpl_drive::show::why::{is_meant, shortened};
use rpl_lang::code::GlobalKind;
use rpl_mission::robot::Robot;
use rpl_runtime::run::system::System;
use rpl_runtime::state::value::Value;
use rpl_runtime::state::valve_place::Place;
use std::collections::BTreeMap;

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
    let holder = |place: &&Place| place.holders().next_back().and_then(|holder| machine.tasks.find(holder));
    let held: Vec<&str> = machine
        .places
        .iter()
        .filter(|place| holder(place) == Some(task))
        .map(|place| machine.symbols.name(machine.valves[place.valve as usize].name))
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
        let places = valve.places().map(|place| &machine.places[place as usize]);
        if valve.places > 1 {
            let free = places.clone().filter(|place| place.holders().next().is_none()).count();
            lines.push(format!("{name}  {free} of {} places free", valve.places));
        }
        for place in places {
            let mut holders = place.holders().rev();
            match (holders.next(), valve.places) {
                (None, 1) => lines.push(format!("{name}  free")),
                (Some(holder), 1) => lines.push(format!("{name}  held by {}", path(holder))),
                (None, _) => {}
                (Some(holder), _) => lines.push(format!("    held by {}", path(holder))),
            }
            lines.extend(holders.map(|holder| format!("    before it: {}", path(holder))));
        }
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
