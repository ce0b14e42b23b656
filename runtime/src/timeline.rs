//! Earlier instants of a run: copies of its whole state now and then, and replay from the last one
//! before the instant that is asked for.

use crate::behaviour::Outside;
use crate::stepping::{Stepped, Stop};
use crate::system::System;
use std::time::Duration;

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
struct Copy<O> {
    segment: u64,
    system: System<O>,
}

/// The history of a run.
#[derive(Clone)]
pub struct Timeline<O> {
    /// Where the run is.
    pub position: Position,
    copies: Vec<Copy<O>>,
    /// Computing since the last copy.
    since: Duration,
}

/// An earlier state, and where the stepper stood then.
pub struct Past<O> {
    /// The state.
    pub system: System<O>,
    /// Its place.
    pub position: Position,
    /// The form a task stood before.
    pub stop: Option<Stop>,
}

impl<O: Outside + Clone> Timeline<O> {
    /// The history of a run that is at its start.
    pub fn new(system: &System<O>) -> Self {
        let start = Copy { segment: 0, system: system.clone() };
        let position = Position { segment: 0, step: Position::END };
        Self { position, copies: vec![start], since: Duration::ZERO }
    }

    /// Something from outside has changed the run: replay cannot go over it, so it is kept.
    pub fn handed_in(&mut self, system: &System<O>) {
        self.position = Position { segment: self.position.segment + 1, step: 0 };
        self.copy(system);
    }

    /// A new instant has begun, after so much computing since the last one began.
    pub fn next_instant(&mut self, system: &System<O>, computing: Duration) {
        self.position = Position { segment: self.position.segment + 1, step: 0 };
        self.since += computing;
        if self.since >= COPY_EVERY {
            self.copy(system);
        }
    }

    fn copy(&mut self, system: &System<O>) {
        self.copies.push(Copy { segment: self.position.segment, system: system.clone() });
        self.since = Duration::ZERO;
    }

    /// Forgets what came after a position, and goes on from there.
    pub fn go_back_to(&mut self, position: Position) {
        self.copies.retain(|copy| copy.segment <= position.segment);
        self.position = position;
        self.since = Duration::ZERO;
    }

    /// The state so many steps before a position, at most the start's; `is_shown` tells which stops
    /// count as steps.
    pub fn steps_before(
        &self,
        mut position: Position,
        mut steps: usize,
        is_shown: impl Fn(&System<O>, &Stop) -> bool,
    ) -> Past<O> {
        for (index, copy) in self.copies.iter().enumerate().rev() {
            if copy.segment > position.segment {
                continue;
            }
            let stops = stops_between(copy, position, &is_shown);
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
    pub fn at(&self, position: Position) -> Past<O> {
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
    pub fn at_time(&self, time_us: u64) -> Past<O> {
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

    /// How many copies are kept.
    pub fn copies(&self) -> usize {
        self.copies.len()
    }

    fn last_copy(&self, fits: impl Fn(&Copy<O>) -> bool) -> &Copy<O> {
        self.copies.iter().rev().find(|copy| fits(copy)).unwrap_or(&self.copies[0])
    }
}

/// Every position between a copy and a later position at which a stepper would stop.
fn stops_between<O: Outside + Clone>(
    copy: &Copy<O>,
    end: Position,
    is_shown: &impl Fn(&System<O>, &Stop) -> bool,
) -> Vec<Position> {
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
fn discard<O: Outside>(system: &mut System<O>) {
    system.machine.output.clear();
    system.machine.trace.take();
}
