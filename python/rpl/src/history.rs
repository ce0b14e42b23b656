//! What a mission has told so far: what happened, where the robot was, what was printed. Forks share what came before
//! them.

use rpl_mission::robot::Robot;
use rpl_mission::sight::Sight;
use rpl_runtime::run::system::System;
use rpl_runtime::state::trace::Event;
use std::sync::Arc;

/// How often the robot is looked at for the drawing of its path.
const TRACK_EVERY_US: u64 = 100_000;

/// What was told in a stretch of a run.
#[derive(Default)]
struct Stretch {
    events: Vec<Event>,
    track: Vec<Sight>,
    printed: Vec<String>,
}

/// What a mission has told so far.
#[derive(Default)]
pub struct History {
    /// Up to the last fork, the first stretch first.
    shared: Vec<Arc<Stretch>>,
    /// From there on.
    own: Stretch,
    track_due_us: u64,
}

impl History {
    /// Takes out what a run has told since it was last asked.
    pub fn take_from(&mut self, system: &mut System<Robot>) {
        self.own.events.append(&mut system.machine.trace.take());
        self.own.printed.extend(system.machine.output.drain(..).map(|output| output.text));
        if system.machine.now_us >= self.track_due_us {
            self.own.track.extend(system.outside.sight());
            self.track_due_us = system.machine.now_us + TRACK_EVERY_US;
        }
    }

    /// The history of a fork, which costs what forks there were before, and not what was told.
    pub fn fork(&mut self) -> Self {
        let own = std::mem::take(&mut self.own);
        if !(own.events.is_empty() && own.track.is_empty() && own.printed.is_empty()) {
            self.shared.push(Arc::new(own));
        }
        Self { shared: self.shared.clone(), own: Stretch::default(), track_due_us: self.track_due_us }
    }

    fn stretches(&self) -> impl Iterator<Item = &Stretch> {
        self.shared.iter().map(Arc::as_ref).chain([&self.own])
    }

    /// What was traced.
    pub fn events(&self) -> Vec<&Event> {
        self.stretches().flat_map(|stretch| &stretch.events).collect()
    }

    /// Where the robot was, ten times a second.
    pub fn track(&self) -> Vec<Sight> {
        self.stretches().flat_map(|stretch| &stretch.track).copied().collect()
    }

    /// What was printed.
    pub fn printed(&self) -> Vec<&str> {
        self.stretches().flat_map(|stretch| &stretch.printed).map(String::as_str).collect()
    }
}
