//! Why a task waits or failed: the chain of causes.

use super::session::Session;
use super::timeline;
use super::view;
use crate::events::detail;
use rpl_runtime::task::{State, Waiting};
use rpl_runtime::trace::{Event, EventKind};
use rpl_runtime::value::Value;

/// Causes are followed down to this depth.
const MAX_DEPTH: usize = 8;

/// The chain of causes for a task's waiting or its end, by its path or the end of it.
pub fn why(session: &Session, path: &str) -> Vec<String> {
    match living(session, path) {
        Some(task) => {
            let mut lines = Vec::new();
            waits(session, task, 0, &mut lines);
            lines
        }
        None => ended(session, path),
    }
}

/// The living task that is meant by a path, by its end, or by nothing: the main task.
fn living(session: &Session, path: &str) -> Option<u32> {
    let machine = &session.branch.system.machine;
    if path.is_empty() || path == "main" {
        return Some(machine.main);
    }
    let mut alive = machine.tasks.iter().filter(|(_, task)| !task.state.is_dead()).map(|(index, _)| index);
    alive.find(|&index| index != 0 && is_meant(&machine.path(index), path))
}

fn is_meant(path: &str, wanted: &str) -> bool {
    path == wanted || path.strip_suffix(wanted).is_some_and(|before| before.ends_with('/'))
}

fn say(lines: &mut Vec<String>, depth: usize, text: &str) {
    lines.push(format!("{}{text}", "  ".repeat(depth)));
}

fn waits(session: &Session, task: u32, depth: usize, lines: &mut Vec<String>) {
    let system = &session.branch.system;
    let machine = &system.machine;
    say(lines, depth, &format!("{}  {}", machine.path(task), view::condition_of(system, task)));
    if depth >= MAX_DEPTH || task == machine.main && system.is_waiting_for_form() {
        return;
    }
    if let Some(span) = view::form_of(system, task).filter(|&span| !timeline::is_hidden(system, span)) {
        say(lines, depth + 1, &format!("at {}", system.program.sources.place(span)));
    }
    let record = &machine.tasks[task];
    if record.is_held() {
        preempted(session, task, depth + 1, lines);
    }
    match record.waiting {
        Waiting::Fluent { fluent, .. } => inputs(session, fluent, depth + 1, lines),
        Waiting::Watch(watch) => inputs(session, machine.watches[watch].fluent, depth + 1, lines),
        Waiting::Children | Waiting::Spawned => {
            let children = machine.children(task);
            for child in children.into_iter().filter(|&child| !machine.tasks[child].state.is_dead()) {
                waits(session, child, depth + 1, lines);
            }
        }
        Waiting::Valve(valve) => {
            let holder = machine.valves[valve as usize].holds.last().and_then(|hold| machine.tasks.find(hold.task));
            if let Some(holder) = holder.filter(|&holder| holder != task) {
                say(lines, depth + 1, "the valve is held by");
                waits(session, holder, depth + 2, lines);
            }
        }
        Waiting::Death(other) | Waiting::Rest(other) => {
            waits(session, other, depth + 1, lines);
        }
        Waiting::Nothing | Waiting::Time | Waiting::Signal(_) => {}
    }
}

/// The valve that was taken from a suspended task, if that is why it is suspended.
fn preempted(session: &Session, task: u32, depth: usize, lines: &mut Vec<String>) {
    let machine = &session.branch.system.machine;
    for valve in &machine.valves {
        for hold in &valve.holds {
            let root = hold.interrupted.and_then(|root| machine.tasks.find_alive(root));
            let Some(root) = root else { continue };
            let path = machine.path(root);
            if machine.path(task).starts_with(&path) {
                let holder = machine.tasks.find(hold.task).map_or_else(String::new, |holder| machine.path(holder));
                say(lines, depth, &format!("{} was taken from it by {holder}", machine.symbols.name(valve.name)));
            }
        }
    }
}

/// The fluents a condition reads: their values, and who changed them last.
fn inputs(session: &Session, fluent: u32, depth: usize, lines: &mut Vec<String>) {
    let system = &session.branch.system;
    let record = &system.machine.fluents[fluent];
    let Some(name) = record.name else {
        record.inputs.iter().for_each(|&input| inputs(session, input, depth, lines));
        return;
    };
    let name = system.machine.symbols.name(name);
    let changed =
        session.branch.log.iter().rev().find(|event| {
            matches!(event.kind, EventKind::Fluent | EventKind::Pulse) && detail(event, "fluent") == name
        });
    let last = match changed {
        Some(event) => format!(", since {:.3} s, by {}", event.time_us as f64 / 1e6, author(event)),
        None => String::new(),
    };
    say(lines, depth, &format!("{name} = {}{last}", view::value_text(system, record.value)));
    for &input in &record.inputs {
        inputs(session, input, depth + 1, lines);
    }
}

fn author(event: &Event) -> &str {
    if event.path.is_empty() { "the robot" } else { &event.path }
}

/// How a task that is no more came to its end.
fn ended(session: &Session, path: &str) -> Vec<String> {
    let log = &session.branch.log;
    let end = log.iter().rposition(|event| event.kind == EventKind::End && is_meant(&event.path, path));
    let Some(end) = end else { return missing(session, path) };
    let event = &log[end];
    let mut lines = vec![format!("{}  {} at {:.3} s", event.path, detail(event, "state"), event.time_us as f64 / 1e6)];
    let reason = ["failure", "value"].map(|name| detail(event, name)).into_iter().find(|text| !text.is_empty());
    lines.extend(reason.map(|reason| format!("  {}", view::shortened(reason))));
    let raised = log[..end]
        .iter()
        .rev()
        .find(|earlier| earlier.kind == EventKind::Failed && earlier.path.starts_with(&event.path));
    if detail(event, "state") == State::Failed.name()
        && let Some(raised) = raised
    {
        lines.push(format!(
            "  raised in {} at {:.3} s: {}",
            raised.path,
            raised.time_us as f64 / 1e6,
            detail(raised, "failure")
        ));
    }
    lines
}

fn missing(session: &Session, path: &str) -> Vec<String> {
    let system = &session.branch.system;
    let alive = system.machine.tasks.iter().filter(|&(index, task)| index != 0 && !task.state.is_dead());
    let paths: Vec<String> = alive.map(|(index, _)| system.machine.path(index)).collect();
    let near = rpl_lang::suggest::suggest(path, paths.iter().map(String::as_str));
    vec![match near {
        Some(near) => format!("no task has the path `{path}`; did you mean `{near}`?"),
        None => format!("no task has the path `{path}`; `:tasks` shows them all"),
    }]
}

/// Details of one task: path, state, form, variables.
pub fn task(session: &Session, path: &str) -> Vec<String> {
    let system = &session.branch.system;
    let machine = &system.machine;
    let Some(task) = living(session, path) else { return missing(session, path) };
    let mut lines = vec![format!("{}  {}", machine.path(task), view::condition_of(system, task))];
    let priority = machine.priorities.list(machine.tasks[task].priority);
    if !priority.is_empty() {
        lines.push(format!("  priority {priority:?}"));
    }
    if let Some(span) = view::form_of(system, task) {
        let text = view::shortened(&view::one_line(system.program.sources.text_of(span)));
        lines.push(format!("  at {}: {text}", system.program.sources.place(span)));
    }
    for (name, variables) in machine.variables(&system.program, task) {
        let name = machine.symbols.name(name);
        let variables = variables.iter().map(|&(name, value): &(_, Value)| {
            format!("{} = {}", machine.symbols.name(name), view::value_text(system, value))
        });
        let variables: Vec<String> = variables.collect();
        if !name.starts_with('%') && !variables.is_empty() {
            lines.push(format!("  {name}: {}", variables.join(", ")));
        }
    }
    lines
}
