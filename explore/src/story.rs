//! What happens in a run under a schedule: the choices that deviate, and all that follows from the first of them on.

use rpl_lang::source::{SourceId, Span};
use rpl_runtime::robot::Outside;
use rpl_runtime::run::system::System;
use rpl_runtime::state::schedule::{Deviation, Schedule};
use rpl_runtime::state::task::{Frame, State};
use rpl_runtime::state::trace::Event;
use rpl_runtime::state::value::TaskRef;

/// A task where it stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Standing {
    /// Its path.
    pub path: String,
    /// The form of the plan's own text that it goes on in, if that is known.
    pub form: Option<Span>,
}

/// A choice that deviates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Turn {
    /// When.
    pub time_us: u64,
    /// What comes first, other than by itself.
    pub taken: Standing,
    /// What would have come before it by itself, in that order.
    pub before: Vec<Standing>,
    /// Whether it is timeouts that end in another order, and not tasks that run.
    pub is_timeout: bool,
    /// What happens from here to the next such choice, or to the end.
    pub events: Vec<Event>,
}

/// The story of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Story {
    /// Its deviations, in order.
    pub turns: Vec<Turn>,
    /// All that happens, where nothing deviates.
    pub usual: Vec<Event>,
}

/// Follows a run, which has not begun and writes its trace, under a schedule up to a time of the plan.
pub fn story<O: Outside>(mut system: System<O>, deviations: &[Deviation], own: SourceId, until_us: u64) -> Story {
    system.machine.schedule = Some(Box::new(Schedule::new(deviations.iter().copied())));
    let mut story = Story::default();
    let deviation = |system: &System<O>| {
        let schedule = system.machine.schedule.as_deref()?;
        schedule.left().next().filter(|next| next.turn == schedule.turns())
    };
    while system.outcome().is_none() {
        let tasks = system.eligible_tasks();
        let is_timeout = tasks.is_empty();
        let among = if is_timeout { system.eligible_timeouts() } else { tasks };
        if let Some(deviation) = deviation(&system).filter(|_| among.len() > 1) {
            take_events(&mut system, &mut story);
            let standing = |&task: &TaskRef| standing(&system, task, own);
            let (before, rest) = among.split_at((deviation.taken as usize).min(among.len() - 1));
            let Some(taken) = rest.first().map(standing) else { break };
            let before = before.iter().map(standing).collect();
            let time_us = if is_timeout { system.next_instant_us() } else { None };
            let time_us = time_us.unwrap_or(system.machine.now_us);
            story.turns.push(Turn { time_us, taken, before, is_timeout, events: Vec::new() });
        }
        if !is_timeout {
            system.step_task();
        } else if system.next_instant_us().is_some_and(|next_us| next_us > until_us) {
            break;
        } else {
            system.next_instant();
        }
        system.machine.output.clear();
    }
    take_events(&mut system, &mut story);
    story
}

fn take_events<O: Outside>(system: &mut System<O>, story: &mut Story) {
    let events = system.machine.trace.take();
    match story.turns.last_mut() {
        Some(turn) => turn.events.extend(events),
        None => story.usual.extend(events),
    }
}

/// Where a task goes on: the innermost of its frames in the plan's own text.
fn standing<O: Outside>(system: &System<O>, task: TaskRef, own: SourceId) -> Standing {
    let machine = &system.machine;
    let record = machine.tasks.find(task).map(|index| (index, &machine.tasks[index]));
    let Some((index, record)) = record else { return Standing { path: String::new(), form: None } };
    let place = |frame: &Frame, is_top: bool| {
        let code = system.program.codes.get(frame.code as usize)?;
        // A frame that has called, or waits, stands behind the instruction that it is in.
        let has_begun = !is_top || record.state() == State::Blocked;
        let at = match has_begun {
            true => frame.pc.saturating_sub(1) as usize,
            // What it does first that others can see.
            false => (frame.pc as usize..code.ops.len()).find(|&at| code.ops[at].is_step())?,
        };
        code.spans.get(at).copied().filter(|span| span.source == own)
    };
    let below = record.frames.iter().rev().map(|frame| (frame, false));
    let form = std::iter::once((&record.frame, true)).chain(below).find_map(|(frame, is_top)| place(frame, is_top));
    Standing { path: machine.path(index), form }
}
