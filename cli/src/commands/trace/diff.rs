//! `rpl trace diff A B`: the first event that differs.

use anyhow::Result;
use rpl_drive::show::event_line::{ROBOT, event_line};
use rpl_drive::trace::{TraceLine, TraceReader};
use rpl_runtime::state::trace::Event;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use std::collections::VecDeque;

/// Events shown before the first that differs.
const COMMON: usize = 3;

/// Compares two traces. The status is that of `diff`: 0 the same, 1 not, 2 trouble.
///
/// # Errors
/// One of them is no trace, or standard output is closed.
pub fn diff(left: &str, right: &str, console: &mut Console) -> Result<Status> {
    let (mut left, mut right) = (TraceReader::open(left)?, TraceReader::open(right)?);
    let cautions = [left.caution(), right.caution()];
    cautions.into_iter().flatten().for_each(|caution| console.note(&format!("note: {caution}")));
    let mut common: VecDeque<Event> = VecDeque::new();
    let mut count = 0;
    let pair = loop {
        match (left.next(), right.next()) {
            (Some(left), Some(right)) if is_same(&left.event, &right.event) => {
                count += 1;
                common.push_back(left.event);
                common.drain(..common.len().saturating_sub(COMMON));
            }
            pair => break pair,
        }
    };
    let damages = [left.damage.clone(), right.damage.clone()];
    damages.iter().flatten().for_each(|damage| console.note(&format!("note: {damage}")));
    let is_damaged = damages.iter().any(Option::is_some);
    match pair {
        (None, None) if is_damaged => {
            console.explain(&format!("the same, as far as both can be read: {}", events(count)))?;
            Ok(Status::Wrong)
        }
        (None, None) => {
            console.explain(&format!("the same: {}", events(count)))?;
            Ok(Status::Succeeded)
        }
        // Where one ends because it is damaged, nothing can be said.
        (left_line, right_line) if is_damaged && (left_line.is_none() || right_line.is_none()) => {
            console.explain(&format!("the same, as far as both can be read: {}", events(count)))?;
            Ok(Status::Wrong)
        }
        (left_line, right_line) => {
            let sides = [(&left, left_line), (&right, right_line)];
            headline(&sides, console)?;
            let colour = console.out_colour();
            for event in &common {
                console.explain(&format!("  {}", event_line(event, false)))?;
            }
            for ((reader, line), (mark, code)) in sides.iter().zip([('<', "31"), ('>', "32")]) {
                let text = match line {
                    Some(line) => format!("{mark} {}", event_line(&line.event, false)),
                    None => format!("{mark} (here ends {})", reader.name),
                };
                console.explain(&if colour { format!("\x1b[{code}m{text}\x1b[0m") } else { text })?;
            }
            Ok(Status::Failed)
        }
    }
}

/// Numbers of events are left out: what a trace does not tell is counted too.
fn is_same(left: &Event, right: &Event) -> bool {
    (left.time_us, &left.path, left.kind, &left.details) == (right.time_us, &right.path, right.kind, &right.details)
}

fn headline(sides: &[(&TraceReader, Option<TraceLine>); 2], console: &mut Console) -> Result<()> {
    let [(left, _), (right, _)] = sides;
    if left.header != right.header {
        let [left, right] = [left, right].map(|reader| describe(reader));
        console.explain(&format!("the runs are not the same: {left}; {right}"))?;
    }
    let places = sides.each_ref().map(|(reader, line)| match line {
        Some(line) => format!("{}:{}", reader.name, line.number),
        None => format!("the end of {}", reader.name),
    });
    let first = sides.iter().find_map(|(_, line)| line.as_ref()).map(|line| &line.event);
    let (time_s, path) = first.map_or((0.0, ""), |event| (event.time_us as f64 / 1e6, event.path.as_str()));
    let path = if path.is_empty() { ROBOT } else { path };
    Ok(console.explain(&format!("they differ from {} and {} on, at {time_s:.3} s, in {path}", places[0], places[1]))?)
}

fn describe(reader: &TraceReader) -> String {
    let Some(header) = &reader.header else { return format!("{} without a header", reader.name) };
    let world = header.world.as_ref().map_or(String::new(), |world| format!(" in {world}"));
    let scenario = header.scenario.as_ref().map_or(String::new(), |scenario| format!(" with {scenario}"));
    format!("{}{world}{scenario}, seed {}", header.plan, header.seed)
}

fn events(count: usize) -> String {
    if count == 1 { "1 event".to_string() } else { format!("{count} events") }
}
