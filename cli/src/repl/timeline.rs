//! Earlier instants of a run: copies of its whole state now and then, and replay from the last one
//! before the instant that is asked for.

use crate::mission::Robot;
use rpl_lang::source::Span;
use rpl_runtime::stepping::{Stepped, Stop};
use rpl_runtime::system::System;
use std::time::{Duration, Instant};

/// A copy is kept when computing has gone on for so long since the last one, so that no replay
/// takes much longer.
const COPY_EVERY: Duration = Duration::from_millis(40);

/// A place in the history of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    /// Counts instants, and what was handed in from outside.
    pub segment: u64,
    /// Forms stopped before in that instant; [`Position::END`] when nothing is ready any more.
    pub step: u32,
}

impl Position {
    /// The step of an instant that is over.
    pub const END: u32 = u32::MAX;
}

#[derive(Clone)]
struct Copy {
    segment: u64,
    system: System<Robot>,
}

/// The history of a run.
#[derive(Clone)]
pub struct Timeline {
    /// Where the run is.
    pub position: Position,
    copies: Vec<Copy>,
    copied: Instant,
}

/// An earlier state, and where the stepper stood then.
pub struct Past {
    /// The state.
    pub system: System<Robot>,
    /// Its place.
    pub position: Position,
    /// The form a task stood before.
    pub stop: Option<Stop>,
}

impl Timeline {
    /// The history of a run that is at its start.
    pub fn new(system: &System<Robot>) -> Self {
        let start = Copy { segment: 0, system: system.clone() };
        let position = Position { segment: 0, step: Position::END };
        Self { position, copies: vec![start], copied: Instant::now() }
    }

    /// Something from outside has changed the run: replay cannot go over it, so it is kept.
    pub fn handed_in(&mut self, system: &System<Robot>) {
        self.position = Position { segment: self.position.segment + 1, step: 0 };
        self.copy(system);
    }

    /// A new instant has begun.
    pub fn next_instant(&mut self, system: &System<Robot>) {
        self.position = Position { segment: self.position.segment + 1, step: 0 };
        if self.copied.elapsed() >= COPY_EVERY {
            self.copy(system);
        }
    }

    fn copy(&mut self, system: &System<Robot>) {
        self.copies.push(Copy { segment: self.position.segment, system: system.clone() });
        self.copied = Instant::now();
    }

    /// Forgets what came after a position, and goes on from there.
    pub fn go_back_to(&mut self, position: Position) {
        self.copies.retain(|copy| copy.segment <= position.segment);
        self.position = position;
        self.copied = Instant::now();
    }

    /// The state so many steps before a position, at most the start's.
    pub fn steps_before(&self, mut position: Position, mut steps: usize) -> Past {
        for (index, copy) in self.copies.iter().enumerate().rev() {
            if copy.segment > position.segment {
                continue;
            }
            let stops = stops_between(copy, position);
            match stops.len().checked_sub(steps) {
                Some(kept) if kept < stops.len() => return self.at(stops[kept]),
                _ if index == 0 => return self.at(Position { segment: 0, step: 0 }),
                _ => {
                    steps -= stops.len();
                    position = Position { segment: copy.segment, step: 0 };
                }
            }
        }
        self.at(Position { segment: 0, step: 0 })
    }

    /// The state at a position.
    pub fn at(&self, position: Position) -> Past {
        let copy = self.last_copy(|copy| copy.segment <= position.segment);
        let mut system = copy.system.clone();
        for _ in copy.segment..position.segment {
            system.settle();
            system.next_instant();
        }
        let mut reached = Position { segment: position.segment, step: 0 };
        let mut stop = None;
        while reached.step < position.step {
            match system.step_form() {
                Stepped::Before(before) => {
                    stop = Some(before);
                    reached.step += 1;
                }
                Stepped::Ran => stop = None,
                Stepped::Settled => {
                    stop = None;
                    reached.step = Position::END;
                }
            }
        }
        discard(&mut system);
        Past { system, position: reached, stop }
    }

    /// The state when the last instant up to a time was over.
    pub fn at_time(&self, time_us: u64) -> Past {
        let copy = self.last_copy(|copy| copy.system.machine.now_us <= time_us);
        let end = self.copies.iter().map(|copy| copy.segment).find(|&segment| segment > copy.segment);
        let last = end.unwrap_or(self.position.segment + 1) - 1;
        let mut system = copy.system.clone();
        let mut segment = copy.segment;
        system.settle();
        while segment < last && system.next_instant_us().is_some_and(|next_us| next_us <= time_us) {
            system.next_instant();
            system.settle();
            segment += 1;
        }
        discard(&mut system);
        Past { system, position: Position { segment, step: Position::END }, stop: None }
    }

    fn last_copy(&self, fits: impl Fn(&Copy) -> bool) -> &Copy {
        self.copies.iter().rev().find(|copy| fits(copy)).unwrap_or(&self.copies[0])
    }
}

/// Texts a user does not step through: the prompt's own loop, and the macros of the library.
const HIDDEN: &[&str] = &["session", "prelude"];

/// Whether a user wants to see a stop.
pub fn is_shown(system: &System<Robot>, stop: &Stop) -> bool {
    !is_hidden(system, stop.span)
}

/// Whether a place lies in a text that users do not step through.
pub fn is_hidden(system: &System<Robot>, span: Span) -> bool {
    HIDDEN.contains(&&*system.program.sources.get(span.source).name)
}

/// Every position between a copy and a later position at which a stepper would stop.
fn stops_between(copy: &Copy, end: Position) -> Vec<Position> {
    let mut system = copy.system.clone();
    let mut position = Position { segment: copy.segment, step: 0 };
    let mut stops = Vec::new();
    while position < end {
        match system.step_form() {
            Stepped::Before(stop) => {
                position.step += 1;
                if position < end && is_shown(&system, &stop) {
                    stops.push(position);
                }
            }
            Stepped::Ran => {}
            Stepped::Settled if position.segment == end.segment => break,
            Stepped::Settled => {
                system.next_instant();
                position = Position { segment: position.segment + 1, step: 0 };
            }
        }
    }
    stops
}

/// What is replayed has been printed and traced before.
fn discard(system: &mut System<Robot>) {
    system.machine.output.clear();
    system.machine.trace.take();
}
