//! What a mission has told so far: what happened, where the robot was, what was printed. Forks share what came before
//! them.

use rpl_mission::robot::Robot;
use rpl_mission::sight::Sight;
use rpl_runtime::run::system::System;
use rpl_runtime::state::trace::Event;
use std::collections::VecDeque;
use std::sync::Arc;

/// How often the robot is looked at for the drawing of its path.
const TRACK_EVERY_US: u64 = 100_000;

/// How many events, sights and lines are kept of each, the last ones: a plan may go on without an end.
const MOST: usize = 1_000_000;

/// How many are forgotten at a time.
const STRETCH: usize = MOST / 16;

/// What a mission has told so far.
#[derive(Default)]
pub struct History {
    /// What was traced.
    pub events: Kept<Event>,
    /// Where the robot was, ten times a second.
    pub track: Kept<Sight>,
    /// What was printed.
    pub printed: Kept<String>,
    track_due_us: u64,
}

impl History {
    /// Takes out what a run has told since it was last asked.
    pub fn take_from(&mut self, system: &mut System<Robot>) {
        self.events.extend(system.machine.trace.take());
        self.printed.extend(system.machine.output.drain(..).map(|output| output.text));
        if system.machine.now_us >= self.track_due_us {
            self.track.extend(system.outside.sight());
            self.track_due_us = system.machine.now_us + TRACK_EVERY_US;
        }
    }

    /// The history of a fork, which costs what forks there were before, and not what was told.
    pub fn fork(&mut self) -> Self {
        Self {
            events: self.events.fork(),
            track: self.track.fork(),
            printed: self.printed.fork(),
            track_due_us: self.track_due_us,
        }
    }
}

/// The last [`MOST`] of what there was, and up to a stretch more.
pub struct Kept<T> {
    /// What came before, the first stretch first; forks share it.
    shared: VecDeque<Arc<[T]>>,
    shared_len: usize,
    /// From there on.
    own: Vec<T>,
    forgotten: usize,
}

impl<T> Default for Kept<T> {
    fn default() -> Self {
        Self { shared: VecDeque::new(), shared_len: 0, own: Vec::new(), forgotten: 0 }
    }
}

impl<T> Kept<T> {
    fn extend(&mut self, told: impl IntoIterator<Item = T>) {
        self.own.extend(told);
        if self.own.len() < STRETCH {
            return;
        }
        self.share();
        while let Some(first) = self.shared.front().filter(|first| self.shared_len - first.len() >= MOST) {
            self.shared_len -= first.len();
            self.forgotten += first.len();
            self.shared.pop_front();
        }
    }

    fn share(&mut self) {
        if !self.own.is_empty() {
            self.shared_len += self.own.len();
            self.shared.push_back(std::mem::take(&mut self.own).into());
        }
    }

    fn fork(&mut self) -> Self {
        self.share();
        Self { shared: self.shared.clone(), shared_len: self.shared_len, own: Vec::new(), forgotten: self.forgotten }
    }

    /// In order.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.shared.iter().flat_map(|stretch| stretch.iter()).chain(&self.own)
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.shared_len + self.own.len()
    }

    /// How many came before these, and are kept no longer.
    pub fn forgotten(&self) -> usize {
        self.forgotten
    }
}
