//! Why a task waits or failed: the chain of causes.

use crate::show::situation::{Ended, Revision, Situation, Standing, ValveStanding, is_within};
use rpl_lang::suggest::suggest;
use rpl_mission::modules;
use rpl_runtime::step::tasks::condition::FluentReading;
use std::borrow::Cow;

/// Causes are followed down to this depth.
const MAX_DEPTH: usize = 8;

/// Children of one task that are shown.
const MAX_CHILDREN: usize = 20;

/// Plans of one look ahead that were passed over and are told.
const MAX_PASSED_OVER: usize = 3;

/// Longest value shown.
const LONGEST_VALUE: usize = 60;

/// The chain of causes for a task's waiting or its end, by its path or the end of it.
///
/// # Errors
/// No task has the path; the near one is named.
pub fn why(situation: &Situation, path: &str) -> Result<Vec<String>, String> {
    let mut lines = Vec::new();
    if let Some(task) = living(situation, path) {
        waits(situation, task, "", 0, &mut lines);
        tell_revisions(situation, task, &mut lines);
    } else if let Some(ended) = situation.ended.iter().rev().find(|ended| is_meant(&ended.path, path)) {
        tell_end(ended, &mut lines);
        tell_revisions(situation, &ended.path, &mut lines);
    } else {
        return Err(missing(situation, path));
    }
    Ok(lines)
}

/// What was decided about the plan of a task, as a story. Of many plans that were passed over only some are told.
fn tell_revisions(situation: &Situation, task: &str, lines: &mut Vec<String>) {
    let told: Vec<&Revision> = situation.revisions.iter().filter(|revision| revision.task == task).collect();
    for together in told.chunk_by(|before, after| before.is_passed_over && after.is_passed_over) {
        let shown = if together.len() > MAX_PASSED_OVER { MAX_PASSED_OVER - 1 } else { together.len() };
        for revision in &together[..shown] {
            say_at(lines, revision.time_us, &revision.text);
        }
        if let Some(left) = together[shown..].first() {
            let count = together.len() - shown;
            say_at(lines, left.time_us, &format!("{count} more plans: not better"));
        }
    }
}

fn say_at(lines: &mut Vec<String>, time_us: u64, text: &str) {
    say(lines, 1, &format!("at {:.3} s: {text}", time_us as f64 / 1e6));
}

/// The living task that is meant by a path, by its end, by a plan call it is in, or by nothing: the
/// main task.
fn living<'s>(situation: &'s Situation, path: &str) -> Option<&'s str> {
    let path = if path.is_empty() { "main" } else { path };
    let mut tasks: Vec<(&str, &Standing)> = situation.tasks.iter().map(|(own, task)| (own.as_str(), task)).collect();
    tasks.sort_by_key(|(_, task)| task.number);
    let stands_at = |(own, task): &&(&str, &Standing)| is_meant(own, path) || is_meant(&task.path, path);
    // Its children are in the call too, and further down.
    let calls = |own: &str, task: &Standing| {
        let ends = task.path.match_indices('/').map(|(slash, _)| slash).filter(|&slash| slash >= own.len());
        ends.into_iter().any(|end| is_meant(&task.path[..end], path))
    };
    let exact = tasks.iter().find(|(own, task)| *own == path || task.path == path);
    let found = exact.or_else(|| tasks.iter().find(stands_at));
    found.or_else(|| tasks.iter().find(|(own, task)| calls(own, task))).map(|(own, _)| *own)
}

/// Whether a path is another, or ends with it.
pub fn is_meant(path: &str, wanted: &str) -> bool {
    path == wanted || path.strip_suffix(wanted).is_some_and(|before| before.ends_with('/'))
}

fn say(lines: &mut Vec<String>, depth: usize, text: &str) {
    lines.push(format!("{}{text}", "  ".repeat(depth)));
}

/// A path below another: what that one says already is left out.
fn below<'p>(path: &'p str, above: &str) -> Cow<'p, str> {
    match path.strip_prefix(above).filter(|rest| !above.is_empty() && rest.starts_with('/')) {
        Some(rest) => Cow::Owned(format!("…{rest}")),
        None => Cow::Borrowed(path),
    }
}

/// Why a task waits; the path `above` stands in the line that leads to it.
fn waits(situation: &Situation, task: &str, above: &str, depth: usize, lines: &mut Vec<String>) {
    let Some(standing) = situation.tasks.get(task) else { return };
    let path = standing.path.as_str();
    say(lines, depth, &format!("{}  {}", below(path, above), standing.condition(situation.now_us)));
    if depth >= MAX_DEPTH {
        return;
    }
    if let Some(place) = &standing.at {
        say(lines, depth + 1, &format!("at {place}"));
    }
    if standing.is_suspended {
        taken(situation, task, depth + 1, lines);
        suspended(situation, task, standing, depth + 1, lines);
        // Its hooks and clean-ups run on.
        let is_busy = |child: &&str| situation.tasks.get(*child).is_some_and(|child| !child.is_suspended);
        let children = situation.children(task);
        children.into_iter().filter(is_busy).for_each(|child| waits(situation, child, path, depth + 1, lines));
        if standing.on.as_deref() == Some("children") {
            return;
        }
    }
    standing.readings.iter().for_each(|reading| tell_reading(situation, standing, reading, depth + 1, lines));
    let on = standing.on.as_deref().unwrap_or_default();
    if on == "children" {
        let children = situation.children(task);
        children.iter().take(MAX_CHILDREN).for_each(|child| waits(situation, child, path, depth + 1, lines));
        if let Some(more) = children.len().checked_sub(MAX_CHILDREN).filter(|&more| more > 0) {
            say(lines, depth + 1, &format!("… and {more} more"));
        }
    } else if let Some(valve) = on.strip_prefix("valve ") {
        let holders = situation.valves.get(valve).map_or_else(Vec::new, ValveStanding::having);
        for holder in holders.into_iter().filter(|holder| *holder != task).take(MAX_CHILDREN) {
            say(lines, depth + 1, "the valve is held by");
            waits(situation, holder, path, depth + 2, lines);
        }
    } else if let Some(other) = on.strip_prefix("the end of ").or_else(|| on.strip_prefix("the clean-ups of "))
        && let Some(other) = living(situation, other)
    {
        waits(situation, other, path, depth + 1, lines);
    }
}

/// The valve that was taken from a suspended task, if that is why it is suspended.
fn taken(situation: &Situation, task: &str, depth: usize, lines: &mut Vec<String>) {
    for (name, valve) in &situation.valves {
        if !valve.interrupted.iter().any(|root| is_within(task, root)) {
            continue;
        }
        // While hooks run it is still its own.
        let others = valve.having().into_iter().filter(|holder| !is_within(holder, task));
        let others: Vec<&str> =
            others.map(|by| situation.tasks.get(by).map_or(by.as_str(), |holder| &holder.path)).collect();
        match others.as_slice() {
            [] => {}
            [by] => say(lines, depth, &format!("{name} was taken from it by {by}")),
            several => say(lines, depth, &format!("{name} was taken from it; {} have it now", several.join(" and "))),
        }
    }
}

/// The tasks that suspended a task, and what those wait for in turn.
fn suspended(situation: &Situation, task: &str, standing: &Standing, depth: usize, lines: &mut Vec<String>) {
    let by: Vec<&String> = standing.suspended_by.iter().filter(|by| situation.tasks.contains_key(*by)).collect();
    for by in &by {
        say(lines, depth, "it is suspended by");
        waits(situation, by, "", depth + 1, lines);
    }
    let mut interrupted = situation.valves.values().flat_map(|valve| &valve.interrupted);
    if by.is_empty() && !interrupted.any(|root| is_within(task, root)) {
        say(lines, depth, "it was suspended by `suspend`, or a task above it was; `resume` lets it go on");
    }
}

/// A fluent, its value, who changed it last, and what it is computed from.
fn tell_reading(
    situation: &Situation,
    standing: &Standing,
    reading: &FluentReading,
    depth: usize,
    lines: &mut Vec<String>,
) {
    let name = &reading.fluent;
    // The prompt's own.
    if name.starts_with('%') {
        return;
    }
    let change = situation.changes.get(name);
    let later = change.filter(|change| change.told > standing.told).and_then(|change| change.value.as_deref());
    let value = shortened(later.unwrap_or(&reading.value));
    let since = match change {
        Some(change) => format!(", since {:.3} s, by {}", change.time_us as f64 / 1e6, change.by),
        None if standing.told < u64::MAX && modules::tables().continuous_fluents().any(|known| known == name) => {
            " when the wait began; its changes are not in the trace".to_string()
        }
        None => String::new(),
    };
    say(lines, depth, &format!("{name} = {value}{since}"));
    reading.from.iter().for_each(|reading| tell_reading(situation, standing, reading, depth + 1, lines));
}

/// How a task that is no more came to its end.
fn tell_end(ended: &Ended, lines: &mut Vec<String>) {
    lines.push(format!("{}  {} at {:.3} s", ended.path, ended.state, ended.time_us as f64 / 1e6));
    if !ended.result.is_empty() {
        lines.push(format!("  {}", shortened(&ended.result)));
    }
    if let Some(raised) = &ended.raised {
        let time_s = raised.time_us as f64 / 1e6;
        let place = raised.at.as_ref().map_or(String::new(), |place| format!(", at {place}"));
        lines.push(format!("  raised in {} at {time_s:.3} s{place}: {}", raised.path, raised.text));
    }
}

/// What is said when no task has a path.
pub fn missing(situation: &Situation, path: &str) -> String {
    let ended = situation.ended.iter().map(|ended| ended.path.as_str());
    let paths: Vec<&str> = situation.tasks.values().map(|task| task.path.as_str()).chain(ended).collect();
    let names = paths.iter().filter_map(|path| path.rsplit('/').next());
    match suggest(path, paths.iter().copied()).or_else(|| suggest(path, names)) {
        Some(near) => format!("no task has the path `{path}`; did you mean `{near}`?"),
        None => format!("no task has the path `{path}`"),
    }
}

/// The beginning of a long text.
pub fn shortened(text: &str) -> String {
    match text.char_indices().nth(LONGEST_VALUE) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_string(),
    }
}
